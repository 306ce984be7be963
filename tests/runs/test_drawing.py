"""`am.draw`: maps, scenarios and simulations as pictures for notebooks."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from PIL import Image, ImageColor

import amorsim as am
from amorsim.render.marks import COLOURS
from tests.building import robot, scenario


def _share(picture: Image.Image, what: str) -> float:
    """The share of the pixels that have the colour of something."""
    pixels = np.asarray(picture).astype(int)
    return float((np.abs(pixels - ImageColor.getrgb(COLOURS[what])).max(axis=2) < 50).mean())


def _driven(replicas: int = 2) -> tuple[am.Simulation, dict[str, Any]]:
    def ahead(readings: Any, estimate: Any, clock: Any) -> am.Twist:
        return am.Twist(0.3, 0.0)

    rover = robot(pose=am.Pose(x=1.0, y=2.0), controller=ahead, errors={"drive.track": am.Deviation(scale=1.3)})
    made = am.Simulation(scenario(rover), replicas=replicas)
    return made, made.run(6.0, keep=("true_pose", "estimated_pose"))


def test_a_map_is_drawn_with_its_walls_and_nothing_else() -> None:
    cells = np.zeros((40, 40))
    cells[10:30, 10:30] = 1
    picture = am.draw(am.Map.from_array(cells, resolution=0.1), size=400)
    assert picture.mode == "RGB"
    assert max(picture.size) <= 400
    assert 0.1 < _share(picture, "wall") < 0.25  # a quarter of the map, which fills most of the sheet
    assert _share(picture, "true") == 0.0


def test_a_scenario_is_drawn_with_its_robots_at_their_starts() -> None:
    here, there = (_body_of(am.draw(scenario(robot(pose=am.Pose(x=x, y=2.0))), size=400)) for x in (1.0, 4.0))
    assert here < there


def _body_of(picture: Image.Image) -> float:
    """Where the robot's body lies across the picture [px]: all else is grey."""
    pixels = np.asarray(picture).astype(int)
    is_coloured = np.ptp(pixels, axis=2) > 20
    return float(np.flatnonzero(is_coloured.any(axis=0)).mean())


def test_what_a_run_kept_is_drawn_as_paths() -> None:
    made, kept = _driven()
    assert _share(am.draw(made, size=800), "estimated") == 0.0
    both = am.draw(made, kept, size=800)
    assert _share(both, "true") > 0.0004
    assert _share(both, "estimated") > 0.0001
    only = am.draw(made, {"estimated_pose": kept["estimated_pose"]}, size=800)
    assert _share(only, "true") < _share(both, "true")


def test_a_replica_is_drawn_by_its_number() -> None:
    made, kept = _driven()
    kept["true_pose"][:, 1, 1] += 1.5
    first, second = (np.asarray(am.draw(made, kept, replica=number, size=400)) for number in (0, 1))
    assert (first != second).any()
    assert (np.asarray(am.draw(made, kept, size=400)) == first).all()


@pytest.mark.parametrize(
    ("what", "options", "words"),
    [
        ("simulation", {"replica": 7}, "no replica 7; known replicas: 0, 1"),
        ("simulation", {"kept": {"covariance": np.zeros((3, 2, 3, 3))}}, "expected true_pose or estimated_pose in it"),
        ("simulation", {"kept": {"true_pose": np.zeros((2, 3))}}, "expected poses (T, 2, 3)"),
        ("simulation", {"kept": {"true_pose": np.zeros((9, 5, 3))}}, "expected poses (T, 2, 3)"),
        ("simulation", {"size": 10}, "expected at least 240 pixels"),
        ("simulation", {"size": 10**6}, "size: expected at least 240 pixels and at most 8192, got 1000000"),
        ("a text", {}, "expected a Map, a Scenario or a Simulation, got 'a text'"),
    ],
)
def test_what_cannot_be_drawn_is_named(what: Any, options: dict[str, Any], words: str) -> None:
    if what == "simulation":
        what, _ = _driven()
    with pytest.raises(am.AmorsimError) as raised:
        am.draw(what, **options)
    assert words in str(raised.value)


def test_what_is_shown_of_a_scenario_fits_on_a_line() -> None:
    demo = am.load("demo")
    assert repr(demo) == "<Scenario 'demo': 'rover' in 'office' (24 x 16 m), 300 s in steps of 0.1 s, seed 1>"
    assert repr(demo.robots[0]).startswith("<Robot 'rover': pioneer2dx, encoder, laser")
    assert len(repr(am.load("crowd"))) < 160


def test_the_version_is_there_and_the_names_are_the_public_ones() -> None:
    assert am.__version__[0].isdigit()
    assert set(dir(am)) == {*am.__all__, "__version__"}


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"world": "room.wld"}, r"world: expected a Map, as am\.load_map.*, got 'room\.wld'"),
        ({"plan": None}, r"plan: expected a Plan, as a planner's plan\(\) returns, got None"),
        ({"start": (1.0,)}, r"start: expected \(x, y\) or \(x, y, heading\), got \(1\.0,\)"),
        ({"goal": "there"}, r"goal: expected numbers of the shape \(N,\), got 'there'"),
        ({"footprint": 0.2}, r"footprint: expected a Shape, as am\.Shape\.circle\(0\.25\), got 0\.2"),
        ({"size": "large"}, r"size: expected at least 240 pixels and at most 8192, got 'large'"),
        ({"size": 8193}, "size: expected at least 240 pixels and at most 8192, got 8193"),
        ({"title": 3}, r"title: expected a text, got 3"),
    ],
)
def test_what_is_no_plan_or_map_of_one_is_refused(wrong: dict[str, Any], message: str) -> None:
    given: dict[str, Any] = {
        "world": scenario().map,
        "plan": am.Plan(status="unreachable"),
        "start": (1, 1),
        "goal": (2, 2),
    }
    given |= wrong
    with pytest.raises(am.ParameterError, match=message):
        am.draw_plan(given.pop("world"), given.pop("plan"), given.pop("start"), given.pop("goal"), **given)
