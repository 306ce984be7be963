"""The Editor in a real Chromium, from an empty page to a running simulation, with everything that a scenario has."""

from __future__ import annotations

import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import amorsim as am
from tests.ui.test_window_editor import PAGE, Editor
from tests.ui.windows import SIMULATOR, add_thing, eventually, expect

pytestmark = pytest.mark.long  # seconds each, in a browser and processes of its own


@pytest.fixture
def open_editor(browser: Any, tmp_path: Path) -> Iterator[Any]:
    opened: list[Editor] = []

    def open_one(*words: str) -> Editor:
        opened.append(Editor(browser, tmp_path, *words))
        return opened[-1]

    yield open_one
    for editor in opened:
        editor.close()


def add(editor: Editor, kind: str) -> None:
    add_thing(editor.page, kind)


def text_of(editor: Editor) -> str:
    return str(editor.page.evaluate(f"{PAGE}.connection.ask({{do: 'text'}})")["text"])


@pytest.mark.long
def test_from_nothing_to_a_run_and_back_to_nothing(open_editor: Any, tmp_path: Path) -> None:
    editor = open_editor()
    page = editor.page
    empty = text_of(editor)
    # A world: walls, a door in one of them, a room with an opening.
    editor.look_near(4.0, 3.0, 80.0)
    page.keyboard.press("r")
    editor.click(0.0, 0.0)
    editor.step(lambda: editor.click(8.0, 6.0))
    page.keyboard.press("w")
    editor.click(4.0, 0.0)
    editor.step(lambda: editor.click(4.0, 6.0))
    page.keyboard.press("d")
    editor.step(lambda: editor.click(4.05, 2.0))
    walls = editor.see("stage.walls.walls")
    assert walls[4:] == [[4.0, 0.0, 4.0, 1.55], [4.0, 2.45, 4.0, 6.0]]
    assert editor.see("stage.things.at(-1).note") == "swing_door"
    page.keyboard.press("o")
    editor.click(5.0, 4.0)
    editor.click(7.5, 5.5)
    editor.step(lambda: editor.click(6.0, 4.0))
    assert len(editor.see("stage.walls.walls")) == 11
    # A robot, one of whose sensors is mounted elsewhere by dragging.
    add(editor, "pioneer2dx")
    editor.step(lambda: editor.click(1.5, 1.5))
    editor.until("stage.selection.only?.path === 'robots.0'")
    page.select_option("#mounts", "laser")
    grip, _, *_ = editor.see("stage.grips().map(({x, y}) => [x, y])")
    editor.step(lambda: editor.drag(grip, (grip[0] + 0.1, grip[1])))
    assert editor.see("stage.things.find(({path}) => path === 'robots.0').mounts[1].pose[0]") == pytest.approx(0.12)
    _, turn, *_ = editor.see("stage.grips().map(({x, y}) => [x, y])")
    editor.step(lambda: editor.drag(turn, (grip[0] + 0.1, grip[1] + 0.8)))
    assert editor.see("stage.things.find(({path}) => path === 'robots.0').mounts[1].pose[2]") == pytest.approx(
        np.pi / 2
    )
    # A fleet, on a grid in a box.
    add(editor, "fleet of robots…")
    editor.drag((0.6, 0.5), (3.4, 0.5 + 0.7))
    page.fill("dialog input", "4")
    page.locator("dialog select").nth(1).select_option("grid")
    editor.step(lambda: page.click("dialog .main"))
    expect(page.locator(".status")).to_contain_text("5 robots")
    # An obstacle that goes round a path, which is drawn and dragged.
    add(editor, "post")
    editor.step(lambda: editor.click(1.0, 4.0))
    editor.until("stage.selection.only?.path === 'obstacles.1'")
    page.wait_for_selector("[id='use-obstacles.1.motion']")
    editor.step(lambda: page.select_option("[id='use-obstacles.1.motion']", "loop"))
    page.click("text=draw the waypoints")
    for point in ((1.0, 4.0), (3.0, 4.0), (3.0, 5.0)):
        editor.click(*point)
    editor.step(lambda: page.keyboard.press("Escape"))
    editor.step(lambda: editor.drag((3.0, 5.0), (3.2, 5.4)))
    editor.step(lambda: editor.drag((2.0, 4.0), (2.0, 3.5)))
    way = "stage.things.find(({path}) => path === 'obstacles.1').places[0].points"
    assert editor.see(way) == [[1, 4], [2, 3.5], [3, 4], [3.2, 5.4]]
    # A controller in code, whose fault stands at its line.
    page.click('[data-key="robots.0"]')
    page.click("text=write one in Python…")
    page.click("dialog .main")
    page.wait_for_selector(".beside .cm-content")
    page.locator(".cm-content").click()
    page.keyboard.press("Control+End")
    page.keyboard.type("raise RuntimeError('oh dear')\n")
    page.keyboard.press("Control+s")
    page.wait_for_selector(".code-fault-text:has-text('oh dear')", timeout=60_000)
    for _ in range(2):
        page.keyboard.press("Control+z")
    page.keyboard.press("Control+s")
    page.wait_for_selector(".code-fault-text", state="detached", timeout=60_000)
    page.click(".beside >> text=close")
    editor.until("!state.is_checking && !faults.length", seconds=60.0)
    # It runs, not saved yet, and the way back keeps everything.
    steps = editor.see("state.steps")
    page.click(".run")
    page.wait_for_url("**/run/untitled**", timeout=120_000)
    page.wait_for_function(f"() => {SIMULATOR}?.stage.frame", timeout=120_000)
    assert page.evaluate(f"{SIMULATOR}.stage.scene.robots.length") == 5
    page.click("text=← edit")
    editor.until("state && !state.is_behind && stage.still && isHolder")
    assert editor.see("state.steps") == steps
    # It is played in place; nothing can be changed meanwhile, and all stands where it was afterwards.
    there = editor.see("stage.still.robots")
    page.click("[aria-label='play here']")
    editor.until("playing?.tick > 5", seconds=120.0)
    assert editor.see("watching")
    expect(page.get_by_role("button", name="add …")).to_be_hidden()
    assert page.evaluate(f"Array.from({PAGE}.stage.carried.truePoses.slice(0, 2))") != pytest.approx(
        there[0][:2], abs=1e-4
    )
    page.click("[aria-label='stop']")
    editor.until("!playing && isHolder")
    assert page.evaluate(f"Array.from({PAGE}.stage.frame.truePoses.slice(0, 3))") == pytest.approx(there[0], abs=1e-4)
    assert editor.see("state.steps") == steps
    # Back to nothing, and all of it again.
    full = text_of(editor)
    page.evaluate("document.activeElement?.blur()")
    for _ in range(steps):
        editor.step(lambda: page.keyboard.press("Control+z"))
    assert text_of(editor) == empty
    assert editor.see("stage.walls.walls") == []
    for _ in range(steps):
        editor.step(lambda: page.keyboard.press("Control+y"))
    assert text_of(editor) == full
    page.keyboard.press("Control+s")
    page.fill("#asked-name", "mine")
    editor.step(lambda: page.click("dialog .main"))
    assert len(am.load(tmp_path / "mine.toml").robots) == 5


def test_walls_are_split_joined_trimmed_offset_and_aligned(open_editor: Any) -> None:
    editor = open_editor()
    page = editor.page
    add_walls = "edit('walls', [{op: 'walls', add: [[0, 0, 4, 0], [1, -1, 1, 1], [3, 1, 3, 3]]}])"
    editor.step(lambda: editor.see(add_walls))
    editor.look_near(2.0, 1.0, 90.0)
    page.keyboard.press("t")
    editor.step(lambda: editor.click(0.5, 0.02))
    assert editor.see("stage.walls.walls") == [[1, 0, 4, 0], [1, -1, 1, 1], [3, 1, 3, 3]]
    page.keyboard.press("v")
    editor.click(1.0, 0.7)
    editor.step(lambda: page.click(".inspector >> text=split"))
    assert editor.see("stage.walls.walls.length") == 4
    editor.click(3.0, 2.0)
    page.keyboard.down("Shift")
    editor.click(2.5, 0.0)
    page.keyboard.up("Shift")
    editor.step(lambda: page.click(".inspector >> text=join"))
    assert [1, 0, 3, 0] in editor.see("stage.walls.walls")
    assert [3, 0, 3, 3] in editor.see("stage.walls.walls")
    editor.click(2.5, 0.0)
    page.click(".inspector >> text=offset…")
    page.fill("dialog input", "-0.5")
    editor.step(lambda: page.click("dialog .main"))
    assert editor.see("stage.walls.walls.at(-1)") == [1, -0.5, 3, -0.5]
    page.keyboard.press("Escape")
    for kind, place in (("box", (0.0, 2.0)), ("post", (2.0, 2.5))):
        add(editor, kind)
        editor.step(lambda place=place: editor.click(*place))
    editor.click(0.0, 2.0)
    page.keyboard.down("Shift")
    editor.click(2.0, 2.5)
    page.keyboard.up("Shift")
    editor.step(lambda: page.click("[title='align: top']"))
    assert [thing["pose"][1] for thing in editor.see("stage.things") if thing["pose"]] == [2.5, 2.5]


def test_a_bitmap_world_is_painted(open_editor: Any, tmp_path: Path) -> None:
    levels = np.full((60, 80), 255, dtype=np.uint8)
    levels[0], levels[-1], levels[:, 0], levels[:, -1] = 0, 0, 0, 0
    Image.fromarray(levels).save(tmp_path / "room.png")
    (tmp_path / "mine.toml").write_text('format = 1\n[world]\nmap = "room.png"\nresolution = 0.1\n')
    editor = open_editor("mine.toml")
    page = editor.page
    expect(page.locator("[data-tool='room']")).to_be_hidden()
    page.keyboard.press("b")
    page.fill("#typed-brush", "0.3")
    page.keyboard.press("Enter")
    page.evaluate("document.activeElement?.blur()")
    editor.step(lambda: editor.drag((2.05, 3.05), (5.05, 3.05)))
    page.keyboard.press("e")
    editor.step(lambda: editor.drag((3.05, 2.55), (3.05, 3.55)))
    page.keyboard.press("f")
    editor.step(lambda: editor.click(1.0, 1.0))
    editor.step(lambda: page.keyboard.press("Control+z"))
    page.keyboard.press("Control+s")

    def saved() -> bool:
        found = np.asarray(Image.open(io.BytesIO((tmp_path / "room.png").read_bytes())).convert("L"))
        # Row 29 has its middle at 3.05 m.
        return bool((found[28:31, 21:28] == 0).all() and (found[24:35, 29:32] == 255).all() and found[40, 40] == 255)

    assert eventually(saved)


def test_another_scenario_is_opened_on_a_page_of_its_own(open_editor: Any, tmp_path: Path) -> None:
    am.open_document("doors").save(tmp_path / "mine.toml", copy=True)
    editor = open_editor("mine.toml")
    page = editor.page
    page.select_option("select[aria-label='file and world']", "open")
    page.locator("dialog .card-choice", has_text="demo").first.click()
    page.wait_for_url("**/edit/demo")
    editor.until("state && !state.is_behind && stage.still && isHolder")
    page.select_option("select[aria-label='file and world']", "open")
    page.locator("dialog button", has_text="mine.toml").first.click()
    page.wait_for_url("**/edit/mine")
    editor.until("state && !state.is_behind && stage.still && isHolder")
