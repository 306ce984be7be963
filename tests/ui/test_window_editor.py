"""`amorsim edit` in a real Chromium: draw, move, undo, save and run."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import amorsim as am
from tests.ui.windows import SIMULATOR, Server, Window, add_thing, axe_violations, expect, new_user

pytestmark = pytest.mark.long  # seconds each, in a browser and processes of its own

PAGE = "document.querySelector('.amorsim')?.editor"


CODE = """import("/amorsim/web/vendor/codemirror/codemirror.js").then(({ EditorView }) =>
    EditorView.findFromDOM(document.querySelector(".beside .code-editor").shadowRoot.querySelector(".cm-editor")))"""


class Editor:
    """The Editor in a browser of its own."""

    def __init__(self, browser: Any, folder: Path, *words: str, **env: str) -> None:
        self.folder = folder
        self.server = Server(folder / "x", words=("edit", *words), env={"AMORSIM_STATE": str(folder / ".state"), **env})
        self.page = new_user(browser).new_page()
        self.window = Window(self.page)
        self.page.goto(self.server.address)
        self.until("state && !state.is_behind && stage.still && isHolder", seconds=120.0)

    def until(self, expression: str, *, seconds: float = 30.0) -> None:
        """Wait until something holds of the page; names in the expression are the page's."""
        self.page.wait_for_function(
            f"() => {{ const one = {PAGE}; if (!one) return false; with (one) return {expression}; }}",
            timeout=1000 * seconds,
        )

    def see(self, expression: str) -> Any:
        return self.page.evaluate(f"{PAGE}.{expression}")

    def text(self) -> str:
        """What stands in the editor of code."""
        return str(self.page.evaluate(f"{CODE}.then((view) => view.state.doc.toString())"))

    def rewrite(self, change: str) -> None:
        """Put what a function of JavaScript makes of the text into the editor of code."""
        self.page.evaluate(
            f"""{CODE}.then((view) => {{
                const text = view.state.doc.toString();
                view.dispatch({{ changes: {{ from: 0, to: text.length, insert: ({change})(text) }} }});
            }})"""
        )

    def at(self, x: float, y: float) -> tuple[float, float]:
        """Where a place of the world [m] is on the page."""
        left, top = self.page.evaluate(
            f"""([x, y]) => {{
                const {{ pane, camera }} = {PAGE}.stage;
                const box = pane.canvas.getBoundingClientRect();
                const [left, top] = camera.toScreen(x, y);
                return [box.left + left, box.top + top];
            }}""",
            [x, y],
        )
        return left, top

    def click(self, x: float, y: float) -> None:
        self.page.mouse.move(*self.at(x, y))
        self.page.mouse.down()
        self.page.mouse.up()

    def drag(self, start: tuple[float, float], end: tuple[float, float]) -> None:
        self.page.mouse.move(*self.at(*start))
        self.page.mouse.down()
        middle = [(a + b) / 2 for a, b in zip(start, end, strict=True)]
        self.page.mouse.move(*self.at(middle[0], middle[1]))
        self.page.mouse.move(*self.at(*end))
        self.page.mouse.up()

    def step(self, does: Any) -> None:
        """Do something that makes one step, and wait until all that it means is drawn."""
        number = self.see("state.number")
        does()
        self.until(f"state.number > {number} && !state.is_behind")

    def look_near(self, x: float, y: float, scale: float = 60.0) -> None:
        self.page.evaluate(
            f"([x, y, s]) => {{ const c = {PAGE}.stage.camera; c.scale = s; c.centre(x, y); }}", [x, y, scale]
        )

    def unfold(self, section: str) -> None:
        """Open a section of the inspector."""
        self.page.wait_for_selector(f'[data-section="{section}"]')
        self.page.evaluate("one => (document.querySelector(`[data-section='${one}']`).open = true)", section)

    def close(self) -> None:
        problems = self.window.problems
        self.page.context.close()
        self.server.close()
        assert problems == []


@pytest.fixture
def open_editor(browser: Any, tmp_path: Path) -> Iterator[Any]:
    opened: list[Editor] = []

    def open_one(*words: str) -> Editor:
        opened.append(Editor(browser, tmp_path, *words))
        return opened[-1]

    yield open_one
    for editor in opened:
        editor.close()


def test_demo_is_changed_undone_saved_and_run(open_editor: Any, tmp_path: Path) -> None:
    editor = open_editor("demo")
    page = editor.page
    assert page.url.endswith("/edit/demo")
    walls = len(editor.see("stage.walls.walls"))

    # A robot is moved by dragging, and turned by its handle.
    editor.look_near(1.4, 8.2)
    editor.step(lambda: editor.drag((1.4, 8.2), (2.4, 8.2)))
    assert editor.see("stage.still.robots[0]")[:2] == pytest.approx([2.4, 8.2])
    expect(page.locator("#inspector-title")).to_have_text("rover")
    handle = editor.page.evaluate(
        f"import('/amorsim/web/editor/grips.js').then(({{turnHandle}}) => turnHandle({PAGE}.stage))"
    )
    editor.step(lambda: editor.drag((handle["x"], handle["y"]), (2.4, 9.2)))
    assert editor.see("stage.still.robots[0][2]") == pytest.approx(1.5708, abs=1e-3)

    # A wall is drawn, by two clicks that snap to the grid.
    page.keyboard.press("w")
    editor.click(1.03, 6.98)
    editor.step(lambda: editor.click(2.52, 7.01))
    assert editor.see("stage.walls.walls.at(-1)") == pytest.approx([1.0, 7.0, 2.5, 7.0])
    assert len(editor.see("stage.walls.walls")) == walls + 1
    assert editor.see("state.steps") == 3

    # All of it is undone and done again.
    text = am.open_document("demo").text
    for _ in range(3):
        editor.step(lambda: page.keyboard.press("Control+z"))
    assert page.evaluate(f"{PAGE}.connection.ask({{do: 'text'}})")["text"] == text
    assert len(editor.see("stage.walls.walls")) == walls
    for _ in range(3):
        editor.step(lambda: page.keyboard.press("Control+y"))
    assert len(editor.see("stage.walls.walls")) == walls + 1

    # It is saved as the user's own, with its map.
    page.keyboard.press("Control+s")
    page.fill("#asked-name", "mine")
    editor.step(lambda: page.click("dialog .main"))
    scenario = am.load(tmp_path / "mine.toml")
    assert scenario.robots[0].pose is not None
    assert scenario.robots[0].pose.x == pytest.approx(2.4)
    assert scenario.map.segments is not None
    assert scenario.map.segments[-1].tolist() == [1.0, 7.0, 2.5, 7.0]
    expect(page.locator(".saved")).to_have_text("saved")

    # It runs, with a change that is not saved; coming back keeps everything.
    editor.step(lambda: editor.see("edit('seed', [{op: 'set', path: 'simulation.seed', value: 77}])"))
    page.click(".run")
    page.wait_for_url("**/run/mine**", timeout=120_000)
    page.wait_for_function(f"() => {SIMULATOR}?.stage.frame", timeout=60_000)
    assert page.evaluate(f"{SIMULATOR}.stage.scene.seed") == 77
    page.go_back()
    editor.until("state && !state.is_behind && stage.still")
    assert editor.see("state.steps") == 4
    assert am.load(tmp_path / "mine.toml").seed == 1


def test_an_empty_page_gets_walls_and_a_robot_and_runs(open_editor: Any) -> None:
    editor = open_editor()
    page = editor.page
    expect(page.locator(".status")).to_contain_text("not yet: walls, a robot")
    page.keyboard.press("r")
    editor.look_near(0.0, 0.0)
    editor.click(-3.0, -2.0)
    editor.step(lambda: editor.click(3.0, 2.0))
    assert len(editor.see("stage.walls.walls")) == 4
    editor.look_near(0.0, 0.0)
    add_thing(page, "pioneer2dx")
    editor.step(lambda: editor.click(1.0, 0.5))
    editor.until("stage.selection.only?.path === 'robots.0'")
    expect(page.locator(".status")).to_contain_text("no faults")
    page.click(".run")
    page.wait_for_url("**/run/untitled**", timeout=120_000)
    page.wait_for_function(f"() => {SIMULATOR}?.stage.frame", timeout=60_000)


def test_a_value_is_changed_in_the_inspector_and_its_fault_is_said_at_the_field(open_editor: Any) -> None:
    editor = open_editor("demo")
    page = editor.page
    page.click('[data-key="robots.0"]')
    page.wait_for_selector('[data-section="robots.0.sensors.laser"]')
    page.click('[data-section="robots.0.sensors.laser"] > summary')
    field = page.locator('[data-path="robots.0.sensors.laser.range_max"] input')
    expect(field).to_have_value("8")
    field.fill("-1")
    editor.step(lambda: field.press("Enter"))
    expect(page.locator(".status")).to_contain_text("1 fault")
    error = page.locator('[data-path="robots.0.sensors.laser.range_max"] .error')
    expect(error).to_contain_text("> 0")
    page.locator(".drawing .faults").get_by_role("button", name="what laser is").click()
    manual = page.get_by_role("dialog", name="sensor laser")
    expect(manual.get_by_role("rowheader", name="range_max")).to_be_visible()
    page.keyboard.press("Escape")
    page.click('[data-key="world"]')
    page.click(".drawing .fault")
    editor.until("stage.selection.only?.path === 'robots.0'")
    page.evaluate("document.activeElement.blur()")
    editor.step(lambda: page.keyboard.press("Control+z"))
    expect(page.locator(".status")).to_contain_text("no faults")


def test_all_can_be_done_by_the_keyboard(open_editor: Any) -> None:
    editor = open_editor("doors")
    page = editor.page
    walls = len(editor.see("stage.walls.walls"))
    page.focus("#pane")
    # A wall, from the middle of the canvas to where the middle is then.
    page.keyboard.press("w")
    editor.look_near(3.0, 6.0)
    page.keyboard.press("Enter")
    editor.look_near(4.0, 6.5)
    editor.step(lambda: page.keyboard.press("Enter"))
    assert editor.see("stage.walls.walls.at(-1)") == pytest.approx([3.0, 6.0, 4.0, 6.5])
    # Select what is in the middle, move it, turn it, copy it, delete it.
    page.keyboard.press("Escape")
    page.keyboard.press("v")
    editor.look_near(2.0, 4.0)
    page.keyboard.press("Enter")
    editor.until("stage.selection.only?.path === 'robots.0'")
    editor.step(lambda: page.keyboard.press("ArrowRight"))
    assert editor.see("stage.still.robots[0]")[:2] == pytest.approx([2.1, 4.0])
    editor.step(lambda: page.keyboard.press("["))
    assert editor.see("stage.still.robots[0][2]") == pytest.approx(0.0873, abs=1e-3)
    editor.step(lambda: page.keyboard.press("Control+d"))
    editor.until("stage.selection.only?.path === 'robots.2'")
    editor.step(lambda: page.keyboard.press("Delete"))
    page.keyboard.press("Control+a")
    editor.step(lambda: page.keyboard.press("Delete"))
    assert editor.see("stage.walls.walls") == []
    for _ in range(6):
        editor.step(lambda: page.keyboard.press("Control+z"))
    assert len(editor.see("stage.walls.walls")) == walls
    assert page.evaluate(f"{PAGE}.connection.ask({{do: 'text'}})")["text"] == am.open_document("doors").text


def test_circles_arrays_mirrors_boxes_and_hidden_layers(open_editor: Any) -> None:
    editor = open_editor()
    page = editor.page
    page.keyboard.press("c")
    editor.look_near(0.0, 0.0)
    editor.click(0.0, 0.0)
    editor.step(lambda: editor.click(1.0, 0.0))
    circle = editor.see("stage.walls.walls")
    sagitta = 1.0 - min(((a + c) ** 2 + (b + d) ** 2) ** 0.5 / 2 for a, b, c, d in circle)
    assert 0.0 < sagitta <= 0.0051
    # A wall of a typed length and angle.
    page.keyboard.press("w")
    editor.look_near(3.0, 0.0)
    editor.click(3.0, 0.0)
    page.fill("#typed-length", "1.5")
    page.fill("#typed-angle", "90")
    editor.step(lambda: page.press("#typed-angle", "Enter"))
    assert editor.see("stage.walls.walls.at(-1)") == pytest.approx([3.0, 0.0, 3.0, 1.5])
    # A box takes the wall alone; copies of it in rows.
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press("v")
    editor.look_near(3.0, 0.0)
    editor.drag((2.5, -0.5), (3.5, 2.0))
    assert editor.see("stage.chosenWalls") == [len(circle)]
    page.click("text=array…")
    editor.step(lambda: page.click("dialog .main"))
    assert [wall[0] for wall in editor.see("stage.walls.walls")[len(circle) :]] == pytest.approx([3.0, 4.0, 5.0])
    editor.look_near(4.0, 0.0)
    editor.drag((2.5, -0.5), (6.5, 2.0))
    editor.step(lambda: page.click("text=mirror"))
    assert [wall[0] for wall in editor.see("stage.walls.walls")[len(circle) :]] == pytest.approx([5.0, 4.0, 3.0])
    page.click("[aria-label='hide walls']")
    assert editor.see("stage.scene.map ?? null") is None
    editor.look_near(4.0, 0.0)
    page.keyboard.press("Escape")
    editor.click(4.0, 0.5)
    assert editor.see("stage.selection.things") == []
    page.click("[aria-label='hide walls']")
    editor.click(4.0, 0.5)
    assert editor.see("stage.selection.only.kind") == "wall"
    # Measuring changes nothing.
    steps = editor.see("state.steps")
    page.keyboard.press("m")
    editor.click(3.0, 0.0)
    editor.click(5.0, 0.0)
    assert editor.see("stage.preview.words").startswith("2 m") or "2.00 m" in editor.see("stage.preview.words")
    assert editor.see("state.steps") == steps


def test_a_second_window_watches_until_it_gets_the_pen(open_editor: Any, browser: Any) -> None:
    editor = open_editor("demo")
    other = new_user(browser).new_page()
    other.goto(editor.server.address)
    other.wait_for_function(f"() => {PAGE}?.state && {PAGE}.stage.still")
    expect(other.locator(".run")).to_be_hidden()
    expect(other.locator(".pen")).to_contain_text("ask")
    said = other.evaluate(f"{PAGE}.edit('x', [{{op: 'set', path: 'simulation.seed', value: 3}}])")
    assert "pen" in said["error"]
    other.click("text=ask for the pen")
    editor.page.click("text=give the pen")
    other.wait_for_selector(".run")
    expect(editor.page.locator(".run")).to_be_hidden()
    other.context.close()


@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize("name", ["demo", "doors", ""])
def test_axe_finds_nothing_and_nothing_overlaps(open_editor: Any, theme: str, name: str) -> None:
    editor = open_editor(*([name] if name else []))
    page = editor.page
    if page.evaluate("document.documentElement.dataset.theme") != theme:
        page.keyboard.press("l")
    for key in ("simulation", "robots.0"):
        if page.locator(f'[data-key="{key}"]').count():
            page.click(f'[data-key="{key}"]')
            page.wait_for_selector(f'[data-section="{key}"]')
            page.evaluate("document.querySelectorAll('.inspector details').forEach(one => one.open = true)")
        assert axe_violations(page) == []
    outside = page.evaluate(
        """() => [...document.querySelectorAll(".bar *, .head *, .options *, .panel, .status *")].filter(one => {
            const box = one.getBoundingClientRect();
            return box.width && (box.left < 0 || box.right > innerWidth + 1 || box.bottom > innerHeight + 1);
        }).map(one => one.outerHTML.slice(0, 80))"""
    )
    assert outside == []
