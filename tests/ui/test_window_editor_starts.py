"""The Editor in a real Chromium: starts that a run draws, walls of a generated world, and what a robot knows."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import amorsim as am
from tests.ui.test_window_editor import PAGE, Editor
from tests.ui.windows import add_thing

pytestmark = pytest.mark.long


@pytest.fixture
def editor(browser: Any, tmp_path: Path) -> Iterator[Editor]:
    opened = Editor(browser, tmp_path)
    yield opened
    opened.close()


def text_of(editor: Editor) -> str:
    return str(editor.page.evaluate(f"{PAGE}.connection.ask({{do: 'text'}})")["text"])


def test_a_fleet_at_random_is_drawn_where_a_run_starts_it_and_its_box_is_dragged(
    editor: Editor, tmp_path: Path
) -> None:
    page = editor.page
    editor.look_near(4.0, 3.0, 80.0)
    page.keyboard.press("r")
    editor.click(0.0, 0.0)
    page.fill("#typed-length", "8")
    page.fill("#typed-angle", "6")
    editor.step(lambda: page.press("#typed-angle", "Enter"))
    add_thing(page, "fleet of robots…")
    editor.drag((0.6, 0.5), (4.4, 3.5))
    page.fill("dialog input", "6")
    editor.step(lambda: page.click("dialog .main"))
    editor.until("stage.ghosts.size === 6", seconds=120.0)
    box = "stage.things.find(({path}) => path === 'robots.0').places[0].points"
    page.keyboard.press("Escape")
    editor.step(lambda: editor.drag((1.5, 0.5), (2.5, 1.5)))  # by an edge
    assert editor.see(box) == [[1.6, 1.5], [5.4, 4.5]]
    editor.step(lambda: editor.drag((5.4, 4.5), (6.4, 5.0)))  # by a corner
    assert editor.see(box) == [[1.6, 1.5], [6.4, 5.0]]
    editor.step(lambda: editor.drag((4.0, 3.25), (3.0, 3.25)))  # by its middle
    assert editor.see(box) == [[0.6, 1.5], [5.4, 5.0]]
    page.locator("canvas").first.focus()
    editor.step(lambda: page.keyboard.press("ArrowRight"))
    assert editor.see(box) == [[0.7, 1.5], [5.5, 5.0]]
    # A copy starts elsewhere, and is selected by a box.
    page.keyboard.press("Escape")
    editor.drag((0.2, 1.2), (6.0, 5.5))
    assert [one["title"] for one in editor.see("stage.selection.things")] == ["fleet"]
    editor.step(lambda: page.keyboard.press("Control+d"))
    assert editor.see("stage.things.find(({path}) => path === 'robots.1').places[0].points") == [[0.9, 1.3], [5.7, 4.8]]
    editor.step(lambda: page.keyboard.press("Control+z"))
    editor.until("!ghosts.isAsking")
    ghosts = page.evaluate(f"Object.fromEntries({PAGE}.stage.ghosts)")
    page.keyboard.press("Escape")
    editor.click(*ghosts["fleet3"][:2])
    assert editor.see("stage.selection.only.title") == "fleet"
    page.keyboard.press("Control+s")
    page.fill("#asked-name", "mine")
    editor.step(lambda: page.click("dialog .main"))
    simulation = am.Simulation(am.load(tmp_path / "mine.toml"))
    assert ghosts == {name: list(simulation.robot(name).true_pose) for name in simulation.names}


def test_walls_are_drawn_in_a_generated_world(editor: Editor) -> None:
    page = editor.page
    page.select_option("select[aria-label='file and world']", "world")
    page.select_option("dialog select", "generate maze")
    editor.step(lambda: page.click("dialog .main"))
    generated = text_of(editor)
    page.keyboard.press("w")
    page.wait_for_selector("dialog >> text=read back, the cells are the same", timeout=60_000)
    editor.step(lambda: page.click("dialog .main"))
    editor.until("toolName === 'line'")
    walls = len(editor.see("stage.walls.walls"))
    editor.click(1.0, 1.0)
    editor.step(lambda: editor.click(1.0, 2.0))
    assert len(editor.see("stage.walls.walls")) == walls + 1
    for _ in range(2):
        editor.step(lambda: editor.see("step('undo')"))
    assert text_of(editor) == generated
    assert editor.see("toolName") == "select"


def test_what_a_robot_knows_is_set_by_forms(editor: Editor, tmp_path: Path) -> None:
    page = editor.page
    add_thing(page, "pioneer2dx")
    editor.step(lambda: editor.click(2.0, 2.0))
    editor.step(lambda: editor.see("edit('wall', [{op: 'walls', add: [[1, 1, 5, 1]]}])"))
    editor.until("stage.selection.only?.path === 'robots.0'")
    page.wait_for_selector("[data-section='robots.0.knowledge']")
    for path in ("initial_belief", "kidnappings", "knowledge", "knowledge.landmarks"):
        page.evaluate("(path) => (document.querySelector(`[data-section='robots.0.${path}']`).open = true)", path)
    editor.step(lambda: page.select_option("[id='use-robots.0.knowledge']", "the world's"))
    editor.step(lambda: page.select_option("[id='use-robots.0.knowledge.landmarks']", "places of its own"))
    editor.step(lambda: page.click("text=carry it elsewhere"))
    editor.step(lambda: editor.drag((2.0, 2.0), (2.0, 3.0)))  # where it stands and is carried to: the robot is meant
    editor.step(lambda: editor.drag((2.0, 2.0), (4.0, 2.0)))
    editor.step(lambda: page.locator("[data-path='robots.0.initial_belief.kind'] select").select_option("gaussian"))
    page.locator("[data-path='robots.0.initial_belief.covariance'] summary").click()
    editor.step(lambda: page.locator("[data-path='robots.0.initial_belief.covariance'] >> text=add").click())
    editor.until("faults.length === 0")
    page.keyboard.press("Control+s")
    page.fill("#asked-name", "mine")
    editor.step(lambda: page.click("dialog .main"))
    scenario = am.load(tmp_path / "mine.toml")
    (robot,) = scenario.robots
    assert robot.knowledge.map is scenario.map
    assert robot.knowledge.landmarks == ((0.0, 0.0),)
    assert robot.initial_belief.covariance == (0.0,) * 6
    (one,) = robot.kidnappings
    assert (one.x, one.y, robot.pose.y) == (4.0, 2.0, 3.0)
