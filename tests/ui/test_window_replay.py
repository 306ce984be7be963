"""A recorded run in the browser: played, dragged, looked at, and nothing else."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.analysis.run_files import RunFiles
from tests import building
from tests.ui.recorded_runs import folder as folder  # a fixture
from tests.ui.windows import Server, Window, axe_violations, expect

pytestmark = pytest.mark.long  # seconds each, in a browser and processes of its own


@pytest.fixture(scope="module")
def replayed(browser: Any, folder: Path) -> Iterator[Server]:
    server = Server(folder, words=["replay", folder.name])
    yield server
    server.close()


@pytest.fixture
def page(replayed: Server, open_window: Callable[[Server], Window]) -> Window:
    window = open_window(replayed)
    window.do(do="replica", number=0)
    window.do(do="select", robot="rover")
    window.do(do="speed", factor=1.0)
    window.do(do="scrub", tick=0)
    window.until("newest.tick === 0 && !(newest.states & 1) && robot.name === 'rover'")
    return window


def poses_of(folder: Path, replica: int) -> Any:
    return RunFiles(folder).table("poses", robot="rover", replica=replica)


def test_it_plays_and_what_is_drawn_is_what_was_recorded(page: Window, folder: Path) -> None:
    poses = poses_of(folder, 0)
    page.page.keyboard.press(" ")
    page.until("newest.tick > 3")
    page.page.keyboard.press(" ")
    page.until("!(newest.states & 1)")
    for tick in (17, 60, 3):
        page.do(do="scrub", tick=tick)
        page.until(f"newest.tick === {tick}")
        index = page.see("newest.selected")
        shown = page.see(f"newest.truePoses.slice({3 * index}, {3 * index + 3})")
        wanted = [poses[f"true_{key}"][tick] for key in ("x", "y", "heading")]
        assert [shown[str(i)] if isinstance(shown, dict) else shown[i] for i in range(3)] == [
            float(np.float32(value)) for value in wanted
        ]
    assert page.see("stage.trueTrail.end[0]") == 3
    page.page.keyboard.press(".")
    page.until("newest.tick === 4")
    page.page.keyboard.press(",")
    page.until("newest.tick === 3")
    page.page.keyboard.press("Shift+R")
    page.until("newest.tick === 0")


def test_what_was_made_of_a_log_is_shown_without_truth(
    browser: Any, open_window: Callable[[Server], Window], tmp_path: Path
) -> None:
    robot = am.load_robot("pioneer2dx-lms200", pose=am.Pose(x=1.5, y=1.5))
    robot = attrs.evolve(robot, controller=am.controllers.Square(side=1.5))
    am.run(building.scenario(robot), tmp_path / "monday", duration=8.0, progress=False)
    am.analysis.slam(tmp_path / "monday", robot, progress=False, out=tmp_path / "lab")
    server = Server(tmp_path / "lab", words=["replay", "lab"])
    try:
        page = open_window(server)
        page.do(do="scrub", tick=60)
        page.until("newest.tick === 60")
        assert page.see("stage.estimatedTrail.count") > 50
        assert page.see("newest.truePoses.every(Number.isNaN)")
        assert page.see("newest.estimatedPoses[0]") > 1.5
        expect(page.page.locator("#robot-title")).to_contain_text("Map")
        expect(page.page.locator(".lacks")).to_contain_text("no log has that")
        expect(page.page.locator(".facts")).to_contain_text("monday")
        x = page.see("stage.camera.x")
        page.page.keyboard.press("f")  # follows what is known
        page.until(f"stage.options.follow && Number.isFinite(stage.camera.x) && stage.camera.x !== {x}")
        with page.page.expect_download() as saved:
            page.save("page")
        saved.value.save_as(tmp_path / "lab.html")
        assert (tmp_path / "lab.html").stat().st_size > 100_000
    finally:
        server.close()


def test_it_ends_and_begins_again(page: Window) -> None:
    page.do(do="speed", factor=None)
    page.page.keyboard.press(" ")
    page.until("newest.tick === 60 && !(newest.states & 1)")
    page.page.wait_for_function("document.querySelector('.hint').textContent.includes('end of the recording')")
    page.do(do="speed", factor=1.0)
    page.page.keyboard.press(" ")
    page.until("newest.tick < 30 && newest.tick > 0")
    page.page.keyboard.press(" ")


def test_events_are_marked_and_lead_to_their_moment(page: Window) -> None:
    page.until("events.list.querySelectorAll('.event').length > 1")
    marks = page.page.locator(".marks .mark")
    expect(marks.nth(1)).to_be_attached()
    expect(marks.first).to_have_attribute("title", re.compile("handed over"))
    serious = page.page.locator(".marks .mark.serious").first
    expect(serious).to_have_attribute("title", re.compile("met wall"))
    serious.click()
    page.until("newest.tick > 20")
    at = page.see("newest.tick")
    page.do(do="scrub", tick=0)
    page.until("newest.tick === 0")
    page.page.locator(".events-list .event", has_text="met wall").last.click()
    page.until(f"newest.tick === {at}")


def test_nothing_that_changes_something_is_shown(page: Window) -> None:
    page.page.click("button:text-is('save ▾')")
    expect(page.page.get_by_role("button", name="picture")).to_be_visible()
    for name in (".driving", ".panel.errors", "#continue", "#newest", "text=save run", "text=save as…"):
        expect(page.page.locator(name).first).to_be_hidden()
    page.page.keyboard.press("m")
    page.page.keyboard.press("w")
    page.drawn()
    expect(page.page.locator(".hint")).to_have_text(re.compile(r"^(Press Space to run, \? for all keys\.)?$"))
    assert "cannot be changed" in page.ask(do="reset")["error"]
    assert "cannot be changed" in page.ask(do="save_run", name="mine")["error"]
    page.page.keyboard.press("?")
    page.page.wait_for_selector("dialog")
    expect(page.page.locator("dialog")).not_to_contain_text("drive")


def test_the_page_of_the_run_is_downloaded_and_plays(page: Window, tmp_path: Path) -> None:
    with page.page.expect_download() as saved:
        page.save("page")
    file = tmp_path / saved.value.suggested_filename
    saved.value.save_as(file)
    other = page.page.context.new_page()
    other.goto(file.as_uri())
    Window(other).until("newest?.tick === 0")
    assert Window(other).see("scene.recorded.replica") == page.see("scene.recorded.replica")
    other.close()


def test_another_replica_keeps_the_moment(page: Window, folder: Path) -> None:
    page.do(do="scrub", tick=40)
    page.until("newest.tick === 40")
    page.page.select_option("#replica", "5")
    page.until("scene && scene.recorded.replica === 5 && newest.version === scene.version && robot.name === 'rover'")
    index = page.see("newest.selected")
    assert page.see("newest.tick") == 40
    wanted = poses_of(folder, 5)["true_x"][40]
    assert page.see(f"newest.truePoses[{3 * index}]") == float(np.float32(wanted))
    page.page.select_option("#replica", "0")
    page.until("scene && scene.recorded.replica === 0")


def test_particles_are_shown(page: Window) -> None:
    page.do(do="scrub", tick=30)
    page.until("newest.particleCount > 50")
    expect(page.page.locator('.panel.control button[data-tool="particles"]')).to_be_visible()


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_axe_finds_nothing_and_all_is_in_sight(page: Window, theme: str) -> None:
    if page.page.evaluate("document.documentElement.dataset.theme") != theme:
        page.page.keyboard.press("l")
    page.do(do="scrub", tick=30)
    page.until("newest.tick === 30")
    assert axe_violations(page.page) == []
    outside = page.page.evaluate(
        """() => [...document.querySelectorAll(".bar *, .head *, .about > *, .panel")].filter(one => {
            const box = one.getBoundingClientRect();
            return box.width && (box.left < 0 || box.right > innerWidth + 1 || box.bottom > innerHeight + 1);
        }).map(one => one.outerHTML.slice(0, 80))"""
    )
    assert outside == []


def test_damage_and_what_is_missing_are_said(
    browser: Any, folder: Path, tmp_path: Path, open_window: Callable[[Server], Window]
) -> None:
    broken = Path(shutil.copytree(folder, tmp_path / "broken"))
    shutil.rmtree(broken / "sensors")
    text = (broken / "poses.csv").read_text().replace("\n0,3.000000,rover,", "\n0,3.000000,rover,abc")
    (broken / "poses.csv").write_text(text)
    server = Server(broken, words=["replay", "broken"])
    try:
        window = open_window(server)
        expect(window.page.locator(".panel.run .lacks")).to_contain_text("No readings were recorded")
        window.do(do="select", robot="rover")
        window.do(do="scrub", tick=30)
        window.page.wait_for_selector(".banner.damage:visible")
        expect(window.page.locator(".banner")).to_contain_text("poses.csv, at 3.000000 s, true_x")
        window.until("newest.tick === 30 && Number.isNaN(newest.truePoses[3 * newest.selected])")
    finally:
        server.close()
