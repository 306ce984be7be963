"""Drawing in the Editor in a real Chromium by mouse, keys and touch."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from tests.ui.test_window_editor import PAGE, Editor
from tests.ui.windows import add_thing, expect

pytestmark = pytest.mark.long  # seconds each, in a browser and processes of its own


@pytest.fixture(scope="module")
def editor(browser: Any, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Editor]:
    """An Editor with an empty page; all that a test draws is undone after it."""
    one = Editor(browser, tmp_path_factory.mktemp("drawing"))
    yield one
    one.close()


@pytest.fixture(autouse=True)
def as_before(editor: Editor) -> Iterator[None]:
    editor.look_near(3.0, 3.0)
    editor.page.mouse.move(0, 0)
    editor.page.evaluate("document.activeElement?.blur()")
    yield
    editor.page.evaluate(f"{PAGE}.take('select')")
    while editor.see("state.undo"):
        editor.step(lambda: editor.see("step('undo')"))


def last_wall(editor: Editor) -> Any:
    return editor.see("stage.walls.walls.at(-1)")


def test_an_empty_page_says_what_to_do_and_has_no_faults_yet(editor: Editor) -> None:
    expect(editor.page.locator(".inspector")).to_contain_text("press R and click two corners")
    expect(editor.page.locator(".reading")).to_be_hidden()
    expect(editor.page.locator(".objects")).not_to_contain_text("fault")
    expect(editor.page.locator(".status")).to_contain_text("not yet: walls, a robot")
    expect(editor.page.locator(".drawing .faults")).to_be_hidden()


def test_digits_are_the_length_of_the_wall_that_is_being_drawn(editor: Editor) -> None:
    page = editor.page
    page.keyboard.press("w")
    editor.click(2.0, 4.0)
    page.mouse.move(*editor.at(3.0, 4.0))
    scale = editor.see("stage.camera.scale")
    page.keyboard.type("2.50")
    assert editor.see("stage.preview.words") == "2.50 m, 0°"
    assert editor.see("stage.camera.scale") == scale  # 0 shows all, but not while one draws
    editor.step(lambda: page.keyboard.press("Enter"))
    assert last_wall(editor) == pytest.approx([2.0, 4.0, 4.5, 4.0])
    assert page.evaluate("document.activeElement.id") == "pane"


def test_a_length_and_an_angle_are_typed_and_escape_lets_them_go(editor: Editor) -> None:
    page = editor.page
    page.keyboard.press("w")
    editor.click(2.0, 4.0)
    page.keyboard.type("3")
    page.keyboard.press("Escape")
    assert editor.see("parts.length.value") == ""
    assert editor.see("tools.line.points.length") == 1  # what was drawn before is still there
    page.keyboard.type("1,5")
    page.keyboard.press("Tab")
    page.keyboard.type("90")
    editor.step(lambda: page.keyboard.press("Enter"))
    assert last_wall(editor) == pytest.approx([2.0, 4.0, 2.0, 5.5])


@pytest.mark.parametrize(
    ("key", "typed", "walls"),
    [("r", ["2", "Tab", "1"], 4), ("c", ["0.5"], 24), ("p", ["1"], 1), ("o", ["2", "Tab", "3"], 0)],
)
def test_each_drawing_tool_takes_typed_numbers(editor: Editor, key: str, typed: list[str], walls: int) -> None:
    page = editor.page
    page.keyboard.press(key)
    editor.click(2.0, 2.0)
    page.mouse.move(*editor.at(3.0, 3.0))
    for word in typed:
        page.keyboard.press("Tab") if word == "Tab" else page.keyboard.type(word)
    if walls:
        editor.step(lambda: page.keyboard.press("Enter"))
        assert len(editor.see("stage.walls.walls")) == walls
    else:  # a room waits for its opening
        page.keyboard.press("Enter")
        editor.until("tools.room.corner !== null")


@pytest.mark.parametrize("key", ["w", "p", "r", "c", "o"])
def test_a_corner_is_given_up_with_its_tool(editor: Editor, key: str) -> None:
    editor.page.keyboard.press(key)
    editor.click(2.0, 2.0)
    name = editor.see("toolName")
    assert editor.see(f"tools.{name}.points.length") == 1
    editor.page.keyboard.press("v")
    assert editor.see(f"tools.{name}.points.length") == 0
    editor.page.keyboard.press(key)
    editor.click(4.0, 4.0)
    assert editor.see(f"tools.{name}.points.length") == 1
    assert editor.see("stage.walls.walls.length") == 0


def test_a_wall_drawn_by_keys_is_seen_growing(editor: Editor) -> None:
    page = editor.page
    page.focus("#pane")
    page.keyboard.press("w")
    page.keyboard.press("Enter")
    for _ in range(3):
        page.keyboard.press("Shift+ArrowRight")
    assert editor.see("stage.preview.words").startswith("3.0")
    editor.step(lambda: page.keyboard.press("Enter"))
    assert last_wall(editor) == pytest.approx([3.0, 3.0, 6.0, 3.0])


def test_two_fingers_zoom_and_move_and_draw_nothing(editor: Editor) -> None:
    page = editor.page
    page.keyboard.press("w")
    touch = page.context.new_cdp_session(page)

    def fingers(kind: str, *places: tuple[float, float]) -> None:
        points = [{"x": x, "y": y, "id": n} for n, (x, y) in enumerate(places)]
        touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    before = editor.see("stage.camera.scale")
    left, right = editor.at(2.0, 3.0), editor.at(4.0, 3.0)
    fingers("touchStart", left)
    fingers("touchStart", left, right)
    for n in range(1, 11):
        fingers("touchMove", (left[0] - 6 * n, left[1] + 2 * n), (right[0] + 6 * n, right[1] + 2 * n))
    fingers("touchEnd")
    assert editor.see("stage.camera.scale") == pytest.approx(before * 2, rel=0.01)
    assert editor.at(3.0, 3.0)[1] == pytest.approx(left[1] + 20, abs=1.0)
    assert editor.see("tools.line.points.length") == 0
    fingers("touchStart", editor.at(3.0, 3.0))  # one finger draws
    fingers("touchEnd")
    assert editor.see("tools.line.points.length") == 1


def test_walls_of_a_new_page_are_saved_under_its_name(editor: Editor) -> None:
    page = editor.page
    page.keyboard.press("r")
    editor.click(0.0, 0.0)
    editor.step(lambda: editor.click(6.0, 6.0))
    page.keyboard.press("Control+s")
    page.fill("#asked-name", "rooms")
    editor.step(lambda: page.click("dialog .main"))
    assert (editor.folder / "rooms.wld").exists()
    assert sorted(path.name for path in editor.folder.glob("*.wld")) == ["rooms.wld"]
    assert editor.see("state.undo") == "name the walls rooms.wld"
    editor.step(lambda: editor.see("step('undo')"))
    editor.step(lambda: editor.see("step('redo')"))
    assert editor.see("stage.walls.walls.length") == 4


def test_a_copy_is_put_where_it_touches_nothing(editor: Editor) -> None:
    page = editor.page
    page.keyboard.press("r")
    editor.click(0.0, 0.0)
    editor.step(lambda: editor.click(6.0, 6.0))
    add_thing(page, "pioneer2dx")
    editor.step(lambda: editor.click(2.0, 2.0))
    editor.until("stage.selection.only?.path === 'robots.0'")
    page.focus("#pane")
    for _ in range(3):
        page.keyboard.press("Control+c")
        expect(page.locator(".status")).to_contain_text("copied 1 thing")
        editor.step(lambda: page.keyboard.press("Control+v"))
        expect(page.locator(".status")).to_contain_text("no faults")


def test_an_eye_is_struck_through_while_things_are_hidden(editor: Editor) -> None:
    page = editor.page
    page.keyboard.press("w")
    editor.click(0.0, 0.0)
    editor.step(lambda: editor.click(6.0, 6.0))
    eye = page.get_by_role("button", name="hide walls")
    before = eye.inner_html()
    eye.click()
    assert len(eye.inner_html()) > len(before)
    eye.click()
    assert eye.inner_html() == before


def test_reading_the_walls_can_be_given_up(editor: Editor) -> None:
    page = editor.page
    table = {"map": {"generate": "office", "seed": 3}}
    editor.step(
        lambda: page.evaluate(f"table => {PAGE}.edit('a world', [{{op: 'set', path: 'world', value: table}}])", table)
    )
    page.keyboard.press("w")
    expect(page.locator("dialog")).to_be_visible()
    page.click("dialog button:has-text('cancel')")
    page.wait_for_timeout(1000)
    expect(page.locator("dialog")).to_have_count(0)
    page.keyboard.press("w")
    editor.step(lambda: page.click("dialog .main:enabled"))
    editor.until("toolName === 'line'")
