"""The page of a run in the browser, from its file alone: it plays what was recorded."""

from __future__ import annotations

import gzip
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import amorsim as am
from amorsim.analysis.run_files import RunFiles
from tests import building
from tests.ui.recorded_runs import folder as folder  # a fixture
from tests.ui.windows import Window, expect, new_user

pytestmark = pytest.mark.long  # seconds each, in a browser


@pytest.fixture
def opened(browser: Any) -> Iterator[Any]:
    """Opens a page by its path, without a network; what it asks any address for is a problem."""
    user = new_user(browser)
    user.set_offline(True)
    windows = []

    def open_page(path: Path) -> Window:
        page = user.new_page()
        window = Window(page)
        page.on("request", lambda request: _note(window, request.url))
        windows.append(window)
        return window.open(path.as_uri())

    yield open_page
    for window in windows:
        assert window.problems == []
    user.close()


def _note(window: Window, address: str) -> None:
    if not address.startswith(("file:", "data:", "blob:")):
        window.problems.append(f"asked for {address}")


def test_each_moment_is_what_was_recorded(opened: Any, folder: Path, tmp_path: Path) -> None:
    page = opened(am.run_page(folder, tmp_path / "monday.html"))
    poses = RunFiles(folder).table("poses", robot="rover", replica=0)
    page.do(do="select", robot="rover")
    page.until("robot?.name === 'rover'")
    sonar = RunFiles(folder).table("sensors/sonar", robot="rover", replica=0)
    for tick in (0, 1, 37, 60):
        page.do(do="scrub", tick=tick)
        page.until(f"newest.tick === {tick}")
        wanted = [poses[f"{kind}_{part}"][tick] for kind in ("true", "estimated") for part in ("x", "y", "heading")]
        at = 3 * page.see("newest.selected")
        shown = [page.see(f"newest.{kind}Poses[{at} + {n}]") for kind in ("true", "estimated") for n in range(3)]
        np.testing.assert_allclose(shown, wanted, atol=6e-5)
        name = page.see("robot.sensors.findIndex(sensor => sensor.name === 'sonar')")
        line = np.flatnonzero(sonar["time"] <= poses["time"][tick] + 1e-9)[-1]
        measured = page.see(f"newest.sensors[{name}].measured.join().split(',')")
        recorded = [sonar[f"measured_{n}"][line] for n in range(len(measured))]
        np.testing.assert_allclose([float(one.replace("Infinity", "inf")) for one in measured], recorded, atol=6e-4)


def test_it_plays_to_its_end_and_again(opened: Any, folder: Path, tmp_path: Path) -> None:
    page = opened(am.run_page(folder, tmp_path / "monday.html", replica=5))
    expect(page.page.locator("dl.facts")).to_contain_text("seed")
    expect(page.page.locator("ul.lacks")).to_contain_text("This page has replica 5; the folder has 1 more.")
    expect(page.page.locator("ul.lacks")).not_to_contain_text(str(folder))
    page.do(do="speed", factor=None)
    page.page.keyboard.press(" ")
    page.until("newest.tick === 60 && !(newest.states & 1)")
    page.do(do="speed", factor=2.0)
    page.page.keyboard.press(" ")
    page.until("newest.tick > 3 && newest.tick < 50 && newest.states & 1")
    page.page.keyboard.press(" ")
    page.until("!(newest.states & 1)")
    tick = page.see("newest.tick")
    page.page.keyboard.press(".")
    page.until(f"newest.tick === {tick + 1}")
    page.page.click("button:text-is('save ▾')")
    expect(page.page.get_by_role("button", name="picture")).to_be_visible()
    expect(page.page.get_by_role("button", name="GIF")).to_be_hidden()  # a server makes it
    page.page.keyboard.press("Escape")
    page.do(do="select", robot="rover")
    page.until("newest.particleCount > 50")
    assert page.see("record.series.get('apart').times.length") > 50


def test_names_in_a_scenario_are_text(opened: Any, tmp_path: Path) -> None:
    odd = "</script><img src=x onerror=window.ran=1>"
    scenario = building.scenario(building.robot(name="rover"), building.robot(name="two", pose=am.Pose(x=3.0, y=3.0)))
    folder = tmp_path / "run"
    simulation = am.Simulation(scenario)
    with am.record(simulation, folder) as session:
        for _ in range(3):
            simulation.step()
            session.keep()
    text = (folder / "scenario.toml").read_text().replace('"two"', f"'{odd}'")
    (folder / "scenario.toml").write_text(text)
    for path in folder.rglob("*.csv"):
        path.write_text(re.sub(r"(?<=,)two(?=,|$)", odd, path.read_text(), flags=re.MULTILINE))
    file = am.run_page(folder, tmp_path / "odd.html")
    assert odd not in file.read_text()
    page = opened(file)
    page.do(do="select", robot=1)
    page.page.wait_for_timeout(300)
    assert page.page.evaluate("window.ran") is None


def test_a_page_is_the_same_each_time_and_small(folder: Path, tmp_path: Path) -> None:
    one, two = (am.run_page(folder, tmp_path / name).read_bytes() for name in ("one.html", "two.html"))
    assert one == two
    assert len(gzip.compress(one)) < len(one) < 1_500_000
