"""The Editor in a real Chromium: handles of shapes and views, numbers that are typed at them, the menu, the gallery."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import amorsim as am
from tests.ui.test_window_editor import CODE, PAGE, Editor
from tests.ui.windows import add_thing, axe_violations, eventually, expect

pytestmark = pytest.mark.long  # seconds each, in a browser and processes of its own

SCENARIO = """format = 1

[world]
map = "room.wld"

[[robots]]
name = "rover"
model = "pioneer2dx"
pose = { x = 2.0, y = 6.0, heading_deg = 0.0 }

[[obstacles]]
name = "box"
shape = { rectangle = [1.0, 0.6] }
pose = { x = 4.0, y = 3.0, heading_deg = 0.0 }

[[obstacles]]
name = "post"
shape = { circle = 0.3 }
pose = { x = 6.0, y = 3.0, heading_deg = 0.0 }

[[obstacles]]
name = "wedge"
shape = { polygon = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]] }
pose = { x = 8.0, y = 3.0, heading_deg = 90.0 }
"""


@pytest.fixture
def editor(browser: Any, tmp_path: Path) -> Iterator[Editor]:
    (tmp_path / "room.wld").write_text("0 0 12000 0\n12000 0 12000 8000\n12000 8000 0 8000\n0 8000 0 0\n")
    (tmp_path / "room.toml").write_text(SCENARIO)
    opened = Editor(browser, tmp_path, "room.toml")
    opened.look_near(6.0, 3.5, 80.0)
    yield opened
    opened.close()


def value(editor: Editor, path: str) -> Any:
    text = editor.page.evaluate(f"{PAGE}.connection.ask({{do: 'text'}})")["text"]
    (editor.folder / "now.toml").write_text(text)
    return am.open_document(editor.folder / "now.toml").get(path)


def choose(editor: Editor, name: str) -> None:
    editor.page.evaluate(
        f"name => {{ const {{ stage }} = {PAGE}; "
        "stage.selection.set([stage.chosenOf(stage.things.find((one) => one.name === name))]); }",
        name,
    )


@pytest.mark.parametrize(
    ("key", "to", "sides", "middle"),
    [
        ("", (5.0, 3.6), [1.5, 0.9], (4.25, 3.15)),  # the opposite corner stays
        ("Control", (5.0, 3.6), [2.0, 1.2], (4.0, 3.0)),  # the middle stays
        ("Shift", (5.5, 3.5), [2.0, 1.2], (4.5, 3.3)),  # in proportion
    ],
)
def test_a_rectangle_is_resized_at_its_corners(
    editor: Editor, key: str, to: tuple[float, float], sides: list[float], middle: tuple[float, float]
) -> None:
    choose(editor, "box")
    if key:
        editor.page.keyboard.down(key)
    editor.step(lambda: editor.drag((4.5, 3.3), to))
    if key:
        editor.page.keyboard.up(key)
    assert value(editor, "obstacles.0.shape.rectangle") == pytest.approx(sides)
    assert (value(editor, "obstacles.0.pose.x"), value(editor, "obstacles.0.pose.y")) == pytest.approx(middle)
    editor.step(lambda: editor.page.keyboard.press("Control+z"))  # one step
    assert value(editor, "obstacles.0.shape.rectangle") == [1.0, 0.6]


def test_a_circle_has_a_radius_and_a_polygon_vertices(editor: Editor) -> None:
    choose(editor, "post")
    editor.step(lambda: editor.drag((6.0, 2.7), (6.0, 2.5)))
    assert value(editor, "obstacles.1.shape.circle") == pytest.approx(0.5)
    # The wedge is turned by 90°: its own (0.5, -0.5) lies at (8.5, 3.5).
    choose(editor, "wedge")
    editor.step(lambda: editor.drag((8.5, 3.5), (9.0, 4.0)))
    assert value(editor, "obstacles.2.shape.polygon.1") == pytest.approx([1.0, -1.0])
    count = len(value(editor, "obstacles.2.shape.polygon"))
    editor.step(lambda: editor.drag((8.0, 2.5), (8.0, 2.2)))  # the middle of a side
    assert len(value(editor, "obstacles.2.shape.polygon")) == count + 1
    editor.page.keyboard.down("Control")
    editor.step(lambda: editor.click(8.0, 2.2))
    editor.page.keyboard.up("Control")
    assert len(value(editor, "obstacles.2.shape.polygon")) == count


def test_numbers_are_typed_at_a_grip(editor: Editor) -> None:
    page = editor.page
    choose(editor, "box")
    page.mouse.dblclick(*editor.at(4.5, 3.3))
    first, second = page.locator("dialog .asked input").all()
    assert (first.input_value(), second.input_value()) == ("1", "0.6")
    first.fill("-2")
    page.keyboard.press("Enter")
    expect(page.locator("dialog .error")).to_contain_text("above zero")
    assert axe_violations(page) == []
    first.fill("2.5")
    editor.step(lambda: page.keyboard.press("Enter"))
    expect(page.locator("dialog")).to_have_count(0)
    assert value(editor, "obstacles.0.shape.rectangle") == [2.5, 0.6]


def test_what_a_sensor_sees_is_stretched_on_the_robot(editor: Editor) -> None:
    page = editor.page
    choose(editor, "rover")
    page.locator("#mounts").select_option("laser")
    mount = editor.see("stage.things.find((one) => one.name === 'rover').mounts.find((one) => one.sensor === 'laser')")
    assert mount["range_max"] == pytest.approx(8.0)
    assert mount["opening"] == pytest.approx(3.14159, abs=1e-4)
    x, y = 2.0 + mount["pose"][0], 6.0 + mount["pose"][1]
    editor.look_near(6.0, 4.0, 50.0)
    editor.step(lambda: editor.drag((x + 8.0, y), (x + 4.0, y)))
    assert value(editor, "robots.0.sensors.laser.range_max") == pytest.approx(4.0, abs=0.02)
    # An edge of what it sees lies at 90°; drawn to 45°, the field of view is 90°.
    editor.step(lambda: editor.drag((x, y - 0.6 * 4.0), (x + 1.7, y - 1.7)))
    assert value(editor, "robots.0.sensors.laser.fov_deg") == pytest.approx(90.0, abs=2.0)
    assert am.load(editor.folder / "now.toml").robots[0].sensors["laser"].sensor.range_max == pytest.approx(
        4.0, abs=0.02
    )  # type: ignore[attr-defined]


def test_a_box_is_dragged_out_in_the_size_that_is_meant(editor: Editor) -> None:
    add_thing(editor.page, "box")
    editor.step(lambda: editor.drag((4.0, 5.0), (5.2, 5.8)))
    assert value(editor, "obstacles.3.shape.rectangle") == pytest.approx([1.2, 0.8])
    assert (value(editor, "obstacles.3.pose.x"), value(editor, "obstacles.3.pose.y")) == pytest.approx((4.6, 5.4))
    add_thing(editor.page, "desk")
    editor.step(lambda: editor.click(8.0, 5.0))
    assert value(editor, "obstacles.4.shape.rectangle") == [1.6, 0.8]
    assert value(editor, "obstacles.4.name") == "desk"


def test_everything_has_a_menu(editor: Editor) -> None:
    page = editor.page
    page.mouse.click(*editor.at(4.0, 3.0), button="right")
    menu = page.locator(".context-menu")
    expect(menu).to_have_attribute("aria-label", "box")
    assert axe_violations(page) == []
    editor.step(lambda: menu.get_by_role("menuitem", name="duplicate").click())
    assert editor.see("stage.things.filter((one) => one.kind === 'obstacle').length") == 4
    # By keys: it opens at what is selected, arrows move, Escape closes it.
    choose(editor, "box")
    page.locator("#pane").focus()
    page.keyboard.press("Shift+F10")
    expect(menu).to_be_visible()
    page.keyboard.press("End")
    expect(menu.get_by_role("menuitem", name="delete")).to_be_focused()
    page.keyboard.press("Escape")
    expect(menu).to_have_count(0)
    # Of a wall, and of nothing: there something is added or pasted.
    page.mouse.click(*editor.at(6.0, 0.0), button="right")
    expect(menu.get_by_role("menuitem", name="split")).to_be_visible()
    page.mouse.click(*editor.at(6.0, 5.0), button="right")
    expect(menu.get_by_role("menuitem", name="delete")).to_have_count(0)
    menu.get_by_role("menuitem", name="add here").click()
    page.get_by_label("search").fill("turtle")
    editor.step(lambda: page.keyboard.press("Enter"))
    assert value(editor, "robots.1.model") == "turtlebot3_burger"
    assert (value(editor, "robots.1.pose.x"), value(editor, "robots.1.pose.y")) == pytest.approx((6.0, 5.0))


def test_galleries_show_pictures_and_find_by_words(editor: Editor) -> None:
    page = editor.page
    page.keyboard.press("a")
    cards = page.locator("dialog .card-choice:visible")
    expect(cards.filter(has_text="pioneer2dx").first).to_contain_text("two driven wheels")
    drawn = "canvas => new Set(canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data).size"
    picture = cards.filter(has_text="khepera").locator("canvas")
    assert eventually(lambda: picture.evaluate(drawn) > 3)
    assert axe_violations(page) == []
    page.get_by_label("search").fill("maze of square cells")
    page.get_by_label("search").fill("maze")
    expect(cards).to_have_count(1)
    editor.step(lambda: cards.first.click())
    assert value(editor, "world.map.generate") == "maze"
    # Scenarios, with what each is about.
    page.locator("select[aria-label='file and world']").select_option("open")
    demo = page.locator("dialog .card-choice", has=page.locator("strong", has_text="demo"))
    demo.scroll_into_view_if_needed()
    expect(demo).to_contain_text("loses its way")
    assert eventually(lambda: demo.locator("canvas").evaluate(drawn) > 3)
    page.get_by_label("search").fill("no such scenario")
    expect(page.locator("dialog .note")).to_have_text("nothing of that name")
    page.get_by_label("search").fill("demo")
    demo.click()
    page.wait_for_url("**/edit/demo")


def test_the_text_lies_beside_the_drawing_which_follows_it(editor: Editor) -> None:
    page = editor.page
    page.click("text=text")
    page.wait_for_selector(".beside .cm-content")
    drawing, text = page.locator(".panel.drawing").bounding_box(), page.locator(".beside").bounding_box()
    assert drawing["x"] + drawing["width"] <= text["x"]
    editor.rewrite("(text) => text.replace('x = 4.0', 'x = 9.0')")
    editor.until("stage.still.obstacles.some((pose) => pose && pose[0] === 9)")
    # And the text follows the drawing.
    editor.step(lambda: editor.drag((6.0, 3.0), (6.0, 4.0)))
    assert eventually(lambda: "x = 6.0, y = 4," in editor.text())
    assert axe_violations(page) == []
    page.click("text=text")
    expect(page.locator(".beside")).to_have_count(0)
    expect(page.locator(".panel.inspector")).to_be_visible()


def test_keys_and_values_are_completed(editor: Editor) -> None:
    page = editor.page
    page.click("text=text")
    page.wait_for_selector(".beside .cm-content")

    def put(after: str, words: str) -> None:
        """Begin a line after another one, and type."""
        page.evaluate(
            f"""after => {CODE}.then((view) => {{
                const end = view.state.doc.toString().indexOf(`${{after}}\\n`) + after.length;
                view.dispatch({{ changes: {{ from: end, insert: "\\n" }}, selection: {{ anchor: end + 1 }} }});
                view.focus();
            }})""",
            after,
        )
        page.keyboard.type(words)

    options = page.locator(".cm-tooltip-autocomplete li")
    put('model = "pioneer2dx"', "on_")
    expect(options.first).to_contain_text("on_collision")
    page.keyboard.press("Tab")
    page.keyboard.type(' = "e')
    expect(options.first).to_contain_text('"end"')
    page.keyboard.press("Enter")
    assert eventually(lambda: value(editor, "robots.0.on_collision") == "end")
    # In a table of a sensor: its own parameters, with help, and none that is there already.
    put("pose = { x = 2.0, y = 6.0, heading_deg = 0.0 }", "[robots.sensors.laser]")
    page.keyboard.press("Enter")
    page.keyboard.type("range")
    expect(options).to_have_count(2)
    expect(options.first).to_contain_text("longest range that is seen")
    page.keyboard.press("Escape")
    expect(options).to_have_count(0)
    # A robot that is only being written has the keys of the first one.
    page.keyboard.press("Control+End")
    page.keyboard.type('\n[[robots]]\nname = "second"\nmod')
    expect(options.first).to_contain_text("model")


@pytest.mark.parametrize(
    ("line", "path", "keys"),
    [
        (0, "", {"format"}),
        (4, "robots.0", {"name", "model"}),
        (7, "robots.0.sensors.laser", {"beams"}),
        (9, "robots.0.sensors.laser.noise.0", {"use"}),
        (11, "robots.0.sensors.laser.noise.1", {"use"}),
        (13, "robots.1", {"name"}),
        (16, "robots.1.sensors.laser.noise.0", {"use", "std"}),
    ],
)
def test_the_table_of_a_line_is_found(editor: Editor, line: int, path: str, keys: set[str]) -> None:
    text = """format = 1

[[robots]]
name = "a"

model = "pioneer2dx"
[robots.sensors.laser]

beams = 3
[[robots.sensors.laser.noise]]
use = "gaussian"
[[robots.sensors.laser.noise]]
use = "quantize"
[[robots]]
name = "b"
[[robots.sensors.laser.noise]]
use = "gaussian"
std = 0.1
"""
    lines = text.split("\n")
    found = editor.page.evaluate(
        """async ([lines, line]) => {
            const { tableAt } = await import("/amorsim/web/editor/table_at.js");
            const { path, keys } = tableAt(lines, line);
            return [path, [...keys]];
        }""",
        [lines, line],
    )
    expected = keys - ({lines[line].split(" =")[0]} if " =" in lines[line] else set())
    assert (found[0], set(found[1])) == (path, expected)
