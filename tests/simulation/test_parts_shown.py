"""The parts of robots in a run's files, its picture, a film, and a window."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import attrs
import numpy as np
import pytest
from PIL import Image

import amorsim as am
from amorsim.controllers import Manual
from amorsim.runs.film import Film
from amorsim.runs.traces import Traces
from tests import building
from tests.simulation.rigs import rig, stone, yard


def test_a_run_writes_where_the_trailers_were(tmp_path: Path) -> None:
    scenario = yard(rig("b", 5.0, 5.0), rig("a", 5.0, 8.0), rig("c", 2.0, 2.0, drive=building.drive()), duration=0.5)
    sim = am.Simulation(scenario, replicas=[3, 5])
    am.run(scenario, tmp_path / "run", replicas=[3, 5], simulation=sim)
    lines = (tmp_path / "run" / "parts.csv").read_text().splitlines()
    assert lines[0] == "replica,time,part,x,y,heading"
    assert lines[1] == "3,0.000000,a.trailer,3.900000,8.000000,0.000000"
    assert [line.split(",")[:3] for line in lines[1:5]] == [
        ["3", "0.000000", "a.trailer"], ["3", "0.000000", "b.trailer"],
        ["5", "0.000000", "a.trailer"], ["5", "0.000000", "b.trailer"],
    ]  # fmt: skip
    assert len(lines) == 1 + 4 * 6
    assert not (tmp_path / "run" / "obstacles.csv").exists()
    am.run(attrs.evolve(scenario, robots=scenario.robots[2:]), tmp_path / "none")
    assert not (tmp_path / "none" / "parts.csv").exists()


def test_frames_tell_recorders_of_parts() -> None:
    sim = am.Simulation(yard(rig("b", 5.0, 5.0), rig("a", 5.0, 8.0)), replicas=2)
    (frame,) = sim.frames()
    assert frame.parts == ("trailer",)
    np.testing.assert_array_equal(frame.part_pose.reshape(-1, 3), sim.part_pose)
    (plain,) = am.Simulation(building.scenario()).frames()
    assert plain.parts == ()
    assert plain.part_pose.shape == (1, 0, 3)


def test_a_runs_picture_has_the_trailer_where_it_is() -> None:
    sim = am.Simulation(yard(rig(x=5.0, y=5.0)))
    traces = Traces(sim)
    sim.set_pose("rig", (5.0, 5.0, math.pi / 2.0))
    (path,) = traces.paths()
    (outline,) = path.parts
    assert outline.min(axis=0) == pytest.approx([4.75, 3.5])
    assert outline.max(axis=0) == pytest.approx([5.25, 4.2])


def test_a_film_has_the_trailer_in_its_robots_colour(tmp_path: Path) -> None:
    sim = am.Simulation(yard(rig(x=5.0, y=5.0, colour="#ff0000"), obstacles=[stone("post", 2.0, 8.0, 0.5)]))
    film = Film(sim, tmp_path / "yard.gif", 1.0, size=434)  # 40 pixels a metre
    film.save()
    with Image.open(tmp_path / "yard.gif") as gif:
        pixels = np.asarray(gif.convert("RGB")).astype(int)
    red = (pixels[:, :, 0] > 200) & (pixels[:, :, 1] < 60)
    area = red.sum() / 40.0**2
    assert area == pytest.approx(0.5 * 0.5 + 0.7 * 0.5, rel=0.1)
    columns = np.nonzero(red.any(axis=0))[0]
    assert (columns[-1] - columns[0] + 1) / 40.0 == pytest.approx(5.25 - 3.5, abs=0.06)


def test_a_window_is_reported_parts_after_the_obstacles() -> None:
    pytest.importorskip("starlette")
    from amorsim.ui.simulator.frames.frames import obstacle_poses
    from amorsim.ui.simulator.frames.scenes import SceneBuilder

    sim = am.Simulation(yard(rig("b", 5.0, 5.0), rig("a", 5.0, 8.0), obstacles=[stone("post", 2.0, 8.0)]))
    scene = SceneBuilder(sim).scene
    json.dumps(scene, allow_nan=False)
    assert [(body["name"], body.get("part_of")) for body in scene["obstacles"]] == [
        ("post", None), ("a.trailer", "a"), ("b.trailer", "b"),
    ]  # fmt: skip
    assert "colour" not in scene["obstacles"][0]
    found = obstacle_poses(sim, ["post"])
    assert found == pytest.approx(np.array([[2.0, 8.0, 0.0], [3.9, 8.0, 0.0], [3.9, 5.0, 0.0]]))
    assert len(obstacle_poses(am.Simulation(building.scenario(building.robot(controller=Manual()))), [])) == 0


def test_a_window_knows_where_a_robot_believes_its_trailer_to_be() -> None:
    pytest.importorskip("starlette")
    from amorsim.ui.simulator.frames.frames import selected_of

    # The trailer is longer than the robot assumes, and the counts of the hitch are the true ones.
    sensors = {"encoder": am.sensors.Encoder(counts_per_revolution=1e6)}
    errors = {"drive.trailer_length": am.Deviation(add=0.2), "pose.y": am.Deviation(add=0.5)}
    hauler = rig("a", 5.0, 5.0, sensors=sensors, errors=errors, controller=Manual())
    sim = am.Simulation(yard(hauler, rig("b", 5.0, 2.0, sensors={})))
    sim.robot("a").drive(forward=0.3, turn=0.3)
    sim.run(2.0)
    ((x, y, heading),) = sim.robot("a").estimated_pose[None]
    hitch = sim.robot("a").joints[2]
    assert abs(hitch) > 0.05
    length = hauler.drive.trailer_length
    offset = hauler.drive.hitch_offset
    at = np.array([x, y]) - offset * np.array([math.cos(heading), math.sin(heading)])
    behind = heading - hitch
    expected = [*(at - length * np.array([math.cos(behind), math.sin(behind)])), behind]
    found = selected_of(sim, [0, 1], None)
    assert found[0].parts == pytest.approx(expected, abs=1e-4)
    assert np.isnan(found[1].parts).all()  # nobody measures its hitch


@pytest.mark.long
@pytest.mark.pictures
def test_a_robots_own_colour_is_the_same_in_all_pictures(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("starlette")
    pytest.importorskip("matplotlib")
    from amorsim.analysis.plots.figures import save_figure
    from amorsim.analysis.plots.plot import plot_run
    from amorsim.ui.simulator.frames.scenes import SceneBuilder

    def save_the_path(figure: Any, path: Path, *, dpi: int, within: Path) -> None:
        if path.stem.endswith("-path"):
            save_figure(figure, path, dpi=dpi, within=within)

    monkeypatch.setattr("amorsim.analysis.plots.plot.save_figure", save_the_path)

    scenario = yard(rig(x=5.0, y=5.0, colour="red"), obstacles=[stone("post", 2.0, 8.0, 0.5)], duration=0.2)
    sim = am.Simulation(scenario)
    scene = SceneBuilder(sim).scene
    assert scene["robots"][0]["colour"] == "#ff0000"
    assert [body.get("colour") for body in scene["obstacles"]] == [None, "#ff0000"]
    folder = am.run(scenario, tmp_path / "run", simulation=sim).folder
    plots = {path.stem.rpartition("-")[2]: path for path in plot_run(folder)}
    for path in (folder / "picture.png", plots["path"]):
        with Image.open(path) as opened:
            pixels = np.asarray(opened.convert("RGB")).astype(int)
        red = (pixels[:, :, 0] > 200) & (abs(pixels[:, :, 1] - 51) < 8) & (abs(pixels[:, :, 2] - 51) < 8)
        # Robot and trailer, at an opacity of 0.8 on white, and what lies over them.
        share = (0.5 * 0.5 + 0.7 * 0.5) / 100.0
        assert 0.3 * share < red.mean() < 1.2 * share, path  # the map is a part of the picture
