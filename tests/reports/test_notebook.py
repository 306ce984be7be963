"""What values show of themselves in a notebook: pictures and tables, without running users' programs."""

from __future__ import annotations

import io
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import attrs
import numpy as np
import pytest
from PIL import Image

import amorsim as am
from amorsim.analysis.comparison import compare
from tests import building
from tests.studies import make_study
from tests.sweeps.studies import TRACK, tables


def bundle(value: Any) -> dict[str, Any]:
    """As IPython asks for it."""
    found = value._repr_mimebundle_(include=None, exclude=None)
    assert found["text/plain"]
    return found


def picture(value: Any) -> np.ndarray[Any, Any]:
    with Image.open(io.BytesIO(bundle(value)["image/png"])) as opened:
        return np.asarray(opened.convert("RGB"))


def table(value: Any) -> list[list[str]]:
    """The cells of the table, row by row."""
    tree = ET.fromstring(f"<div>{bundle(value)['text/html']}</div>")
    return [[cell.text or "" for cell in row] for row in tree.iter("tr")]


def test_a_scenario_shows_its_robots_on_its_map() -> None:
    scenario = building.scenario(building.robot(), map=building.room(6.0, 4.0, 0.01))
    assert max(picture(scenario).shape) == 720
    assert (picture(scenario) != picture(scenario.map)).any()
    moved = attrs.evolve(scenario, robots=[attrs.evolve(scenario.robots[0], pose=am.Pose(x=4.0, y=3.0))])
    assert (picture(scenario) != picture(moved)).any()


def test_a_scenario_shows_itself_without_running_the_programs_that_it_names(tmp_path: Path) -> None:
    code = "open('ran', 'w')\n\n\ndef drive(readings, estimate, clock, **_):\n    return 0.0, 0.0\n"
    scenario = am.load(make_study(tmp_path / "study", code))
    assert picture(scenario).size
    assert not list(tmp_path.rglob("ran"))


def test_a_simulation_shows_where_its_robots_are_now() -> None:
    sim = am.Simulation(building.scenario(building.robot(), map=building.room(6.0, 4.0, 0.01)))
    before = picture(sim)
    sim.robot("rover").drive(forward=0.5)
    sim.run(2.0)
    assert (before != picture(sim)).any()
    assert sim.time == pytest.approx(2.0)  # showing it does nothing to it


def test_a_robot_and_a_frame_are_tables() -> None:
    scenario = building.scenario(building.robot())
    rows = dict(table(scenario.robots[0]))
    assert rows["drive"] == "Differential"
    frame = am.Simulation(scenario, replicas=12).frames()[0]
    head, *shown = table(frame)
    assert head[:4] == ["robot", "replica", "time [s]", "true x, y, heading"]
    assert [row[1] for row in shown] == [str(number) for number in range(10)]
    assert "<p>2 more rows</p>" in bundle(frame)["text/html"]


def test_a_plan_shows_its_path_or_why_there_is_none() -> None:
    world = building.room(6.0, 4.0, 0.01)
    plan = am.planners.AStar(cell=0.1).plan(world, (1.0, 1.0), (5.0, 3.0))
    text = bundle(plan)["text/html"]
    path = ET.fromstring(text[text.index("<svg") :]).find("polyline")
    assert path is not None
    ends = [tuple(map(float, place.split(","))) for place in path.attrib["points"].split()]
    assert ends[-1][0] - ends[0][0] == pytest.approx(4.0, abs=2e-3)
    assert ends[-1][1] - ends[0][1] == pytest.approx(-2.0, abs=2e-3)  # SVG has y downwards
    blocked = am.planners.AStar(cell=0.1).plan(world, (1.0, 1.0), (50.0, 3.0))
    assert blocked.message in bundle(blocked)["text/html"]


def test_a_run_shows_how_far_off_it_ended(tmp_path: Path) -> None:
    scenario = building.scenario(building.robot(), map=building.room(6.0, 4.0, 0.01), duration=0.5)
    summary = am.run(scenario, tmp_path / "run")
    (_, row) = table(summary)
    assert row[0] == "rover"
    assert str(tmp_path / "run") in bundle(summary)["text/html"]


def test_a_study_and_a_comparison_are_tables(tmp_path: Path) -> None:
    study = am.sweep(tables(tmp_path / "s", replicas=8), tmp_path / "out")
    head, *rows = table(study)
    assert head[:2] == ["point", TRACK]
    assert "digest" not in head
    assert len(rows) == 10
    assert "<p>6 more rows</p>" in bundle(study)["text/html"]
    found = compare(study, axis=TRACK)
    assert len(table(found)) == 1 + 2 * 2  # two systems, two metrics
    assert str(found.differences[0]).split(":")[0] in bundle(found)["text/html"]


def test_names_are_shown_as_text(tmp_path: Path) -> None:
    robot = attrs.evolve(building.robot(), model="<script>alert(1)</script>")
    assert "<script>" not in bundle(robot)["text/html"]


def test_what_cannot_be_drawn_is_text(monkeypatch: pytest.MonkeyPatch) -> None:
    from amorsim.reports import notebook

    def refuse(*_: Any, **__: Any) -> Any:
        raise am.MapError("nothing to see")

    monkeypatch.setattr(notebook, "draw_map", refuse)
    assert "nothing to see" in bundle(building.room(6.0, 4.0, 0.01))["text/html"]
