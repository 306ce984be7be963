"""What is copied in one window of the Editor is pasted into another scenario's, in a real Chromium."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import amorsim as am
from tests.ui.test_window_editor import PAGE, Editor, Window

pytestmark = pytest.mark.long  # seconds each, in a browser and processes of its own

MODEL = 'format = 1\nmodel = "pioneer2dx"\n\n[drive]\ntrack = 0.4\n'
CONTROLLER = "import amorsim as am\n\n\ndef drive(readings, estimate, clock):\n    return am.Twist(0.1, 0.0)\n"
ROBOT = """
[[robots]]
name = "walker"
model = "../wide.toml"
pose = { x = 5.0, y = 8.3 }
controller = { use = "drive.py:drive" }
"""


class Page(Editor):
    """Another page of an Editor, in a tab of the same browser."""

    def __init__(self, editor: Editor, name: str) -> None:
        self.folder, self.server = editor.folder, editor.server
        said = editor.page.evaluate(f"{PAGE}.connection.ask({{do: 'open', name: {name!r}}})")
        assert said["ok"], said
        self.page = editor.page.context.new_page()
        self.window = Window(self.page)
        self.page.goto(editor.page.url.split("/edit/")[0] + said["path"])
        self.until("state && !state.is_behind && stage.still && isHolder", seconds=120.0)


def select(editor: Editor, expression: str) -> None:
    """Select what an expression gives, and let the drawing have the keyboard."""
    editor.page.evaluate(f"() => {{ const {{ stage }} = {PAGE}; stage.selection.set({expression}); }}")
    editor.page.focus("#pane")


def selected(editor: Editor) -> list[str]:
    return [str(key) for key in editor.see("stage.selection.things.map(({ key }) => key)")]


@pytest.fixture
def editor(browser: Any, tmp_path: Path) -> Iterator[Editor]:
    there = tmp_path / "there"
    there.mkdir()
    am.open_document("demo").save(there / "mine.toml", copy=True)
    (tmp_path / "wide.toml").write_text(MODEL)
    (there / "drive.py").write_text(CONTROLLER)
    with (there / "mine.toml").open("a") as file:
        file.write(ROBOT)
    am.open_document("doors").save(tmp_path / "other.toml", copy=True)
    opened = Editor(browser, tmp_path, "other.toml")
    yield opened
    opened.close()


def test_a_robot_and_walls_are_pasted_into_another_scenario(editor: Editor, tmp_path: Path) -> None:
    source = Page(editor, "there/mine.toml")
    before = (tmp_path / "there/mine.toml").read_bytes()
    walker = "stage.chosenOf(stage.things.find(({ name }) => name === 'walker'))"
    select(source, f"[{walker}, stage.chosenWall(0), stage.chosenWall(1)]")
    source.page.keyboard.press("Control+c")
    source.until("parts.hint.textContent === 'copied 3 things'")

    editor.page.bring_to_front()
    robots = editor.see("stage.things.filter(({ kind }) => kind === 'robot').length")
    walls = editor.see("stage.walls.walls.length")
    editor.look_near(6.0, 4.0, scale=200.0)  # where what was copied would be out of sight
    editor.page.focus("#pane")
    editor.step(lambda: editor.page.keyboard.press("Control+v"))
    editor.until(f"stage.selection.things.length === 3 && stage.walls.walls.length === {walls + 2}")
    assert selected(editor) == [f"robots.{robots}", f"wall {walls}", f"wall {walls + 1}"]
    ends = editor.see(f"stage.walls.walls.slice({walls})")
    left, low, right, high = editor.see("stage.camera.bounds()")
    pose = editor.see(f"stage.things.find(({{ path }}) => path === 'robots.{robots}').pose")
    xs, ys = ([pose[k], *(wall[k + n] for wall in ends for n in (0, 2))] for k in (0, 1))
    assert left < (min(xs) + max(xs)) / 2 < right
    assert low < (min(ys) + max(ys)) / 2 < high

    # It is of the same model and drives by the same program, by their names from here.
    editor.page.keyboard.press("Control+s")
    editor.until("state.is_saved")
    document = am.open_document(tmp_path / "other.toml")
    assert document.get("robots.walker.model") == "wide.toml"
    assert document.get("robots.walker.controller.use") == "there/drive.py:drive"
    assert document.get("robots.walker.drive.track") == 0.4

    editor.step(lambda: editor.page.keyboard.press("Control+z"))
    assert editor.see("stage.walls.walls.length") == walls
    assert (tmp_path / "there/mine.toml").read_bytes() == before
    assert source.window.problems == []


def test_a_text_with_carriage_returns_is_looked_at_and_changed_in_one_line(editor: Editor, tmp_path: Path) -> None:
    file = tmp_path / "lines.toml"
    am.open_document("demo").save(file, copy=True)
    file.write_bytes(file.read_bytes().replace(b"\n", b"\r\n"))
    before = file.read_bytes()
    page = Page(editor, "lines.toml")
    window = page.page
    window.click("text=text")
    window.wait_for_selector(".beside .cm-content")
    window.click(".beside .main")
    window.wait_for_selector(".beside", state="detached")
    page.step(lambda: page.see("edit('seed', [{op: 'set', path: 'simulation.seed', value: 77}])"))
    assert page.see("state.steps") == 1  # and none of the text, which was only looked at
    window.click("text=text")
    window.wait_for_selector(".beside .cm-content")
    window.locator(".cm-content").click()
    window.keyboard.press("Control+End")
    window.keyboard.type("# the end")
    page.until("state.steps === 2")
    window.click(".beside .main")
    window.keyboard.press("Control+s")
    page.until("state.is_saved")
    seed = next(line for line in before.splitlines(keepends=True) if line.startswith(b"seed"))
    assert file.read_bytes() == before.replace(seed, b"seed = 77\r\n") + b"# the end"
    assert page.window.problems == []
