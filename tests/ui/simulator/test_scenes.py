"""Scenes and forms: what a window gets of a simulation."""

from __future__ import annotations

import io
import json
import math
from pathlib import Path

import attrs
import numpy as np
import pytest
from PIL import Image

import amorsim as am
from amorsim.plugins.manager import default_registry
from amorsim.ui.forms.running_robot import forms_of, value_at
from amorsim.ui.simulator.frames.scenes import SceneBuilder
from tests import building

ROBOTS = sorted(default_registry().names("robot"))


@pytest.mark.parametrize("model", ROBOTS)
def test_every_robot_that_ships_has_a_scene_and_forms(model: str) -> None:
    Path("room.wld").write_text("0 0 9000 0\n9000 0 9000 9000\n9000 9000 0 9000\n0 9000 0 0\n")
    text = 'format = 1\n[world]\nmap = "room.wld"\n[[robots]]\nname = "rover"\ncontroller = { use = "manual" }\n'
    Path("one.toml").write_text(f'{text}model = "{model}"\n')
    simulation = am.Simulation(attrs.evolve(am.load("one.toml"), map=building.empty()))
    robot = simulation.robot("rover")
    scene = SceneBuilder(simulation).scene
    json.dumps(scene, allow_nan=False)
    kind = scene["kinds"][scene["robots"][0]["kind"]]
    assert kind["model"] == model
    assert [channel["name"] for channel in kind["channels"]] == list(robot.channels)
    frame = simulation.frames()[0]
    assert kind["joints"] == list(frame.joint_names)
    for sensor in kind["sensors"]:
        assert sensor["size"] == frame.readings[sensor["name"]][0].shape[1]
        assert len(sensor["mounts"]) in (1, sensor["size"])
        assert sensor["bearings"] is None or len(sensor["bearings"]) == sensor["size"]
    forward, left, turn = kind["twist"]
    assert 0.0 < forward < 10.0
    assert turn > 0.0
    # The fastest is what it gets to, and no more when more is commanded.
    robot.drive(forward=2.0 * forward)
    simulation.run(20.0)
    assert robot.true_twist[0] == pytest.approx(forward, rel=0.02)
    assert (left > 0.0) == (kind["drive"] == "mecanum")
    forms = forms_of(simulation, "rover")
    json.dumps(forms, allow_nan=False)
    assert len({form["path"] for form in forms}) == len(forms)
    assert {form["kind"] for form in forms} >= {"systematic", "nominal"}


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.mark.long
def test_every_form_leads_to_what_can_be_set_and_shows_it() -> None:
    simulation = am.Simulation(am.load("demo"))
    forms = [form for form in forms_of(simulation, "rover") if form["slider"]]
    assert len(forms) > 40
    for form in forms:
        low, high = form["slider"]
        assert form["value"] is not None
        assert low <= form["value"] <= high, form
        bottom = -math.inf if form["low"] is None else form["low"]
        top = math.inf if form["high"] is None else form["high"]
        assert bottom <= low
        assert high <= top
        # A value near the present one, within bounds, at the next step.
        value = min(max(form["value"] * 1.001 + 1e-6, bottom), top)
        if form["type"] == "int":
            value = int(form["value"])
        simulation.set("rover", form["path"], value)
        now = next(one for one in forms_of(simulation, "rover") if one["path"] == form["path"])
        assert now["value"] == value, form["path"]
        assert now["scenario"] == form["scenario"]
        if form["kind"] == "systematic":
            assert now["true"] is not None
            assert now["nominal"] is not None
            factor = now["path"].endswith(".scale")
            assert now["true"] == pytest.approx(now["nominal"] * value if factor else now["nominal"] + value)
        assert form["help"], form["path"]


def test_a_drawn_error_is_reported_in_words_with_the_true_value() -> None:
    robot = building.robot(
        errors={"drive.track": am.Deviation(scale=am.Distribution(kind="normal", values=(1.0, 0.02)))}
    )
    simulation = am.Simulation(building.scenario(robot))
    form = next(form for form in forms_of(simulation, "rover") if form["path"] == "errors.drive.track.scale")
    assert (form["value"], form["drawn"]) == (None, "normal(1, 0.02)")
    true = simulation.robot("rover").true.drive.track  # type: ignore[attr-defined]
    assert form["true"] == true != form["nominal"]
    assert value_at(simulation.robot("rover").true, "drive.track") == true


def test_a_map_without_lines_is_a_picture_in_its_place() -> None:
    cells = np.zeros((20, 30), dtype=np.uint8)
    cells[0, :] = cells[:, 0] = cells[-1, :] = cells[:, -1] = 1
    cells[5, 7] = 1
    world = am.Map.from_array(cells, resolution=0.25, origin=(1.0, 2.0, math.pi / 2.0))
    world = world if world.segments is None else attrs_without_segments(world)
    robot = building.robot(pose=am.Pose(x=-1.5, y=5.0))
    builder = SceneBuilder(am.Simulation(building.scenario(robot, map=world)))
    shape = builder.scene["maps"][0]
    assert shape["segments"] is None
    assert shape["image"] is not None
    assert shape["extent"] == pytest.approx([1.0 - 5.0, 2.0, 1.0, 2.0 + 7.5])
    with Image.open(io.BytesIO(builder.picture(shape["image"]["name"]))) as picture:
        opaque = np.array(picture)[..., -1] == 255
    np.testing.assert_array_equal(opaque[::-1], cells.astype(bool))
    with pytest.raises(LookupError, match="no picture 'x'"):
        builder.picture("x")


def attrs_without_segments(world: am.Map) -> am.Map:
    return attrs.evolve(world, segments=None)


def test_the_floor_has_its_markings_and_drops_the_lowest_first() -> None:
    floor = am.Floor(
        markings=[
            am.Marking(points=((1.0, 1.0), (2.0, 1.0), (2.0, 2.0)), closed=True, width=0.03, colour="navy"),
            am.Marking(shape=am.Shape.rectangle(1.0, 0.5), pose=am.Pose(x=3.0, y=2.0), colour="#ffee00"),
        ],
        drops=[am.Drop(shape=am.Shape.rectangle(0.5, 0.5))],
    )
    patches = SceneBuilder(am.Simulation(building.scenario(floor=floor))).scene["floor"]["patches"]
    line, area, drop = patches
    assert line == {"points": [[1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [1.0, 1.0]], "width": 0.03, "colour": "#000080"}
    assert area["points"] == [[2.5, 1.75], [3.5, 1.75], [3.5, 2.25], [2.5, 2.25]]
    assert (area["width"], area["colour"]) == (0.0, "#ffee00")
    assert drop["width"] == 0.0
    json.dumps(patches)


@pytest.mark.long
def test_a_thousand_robots_of_one_kind_are_one_kind() -> None:
    robots = [building.robot(name=f"r{i}", pose=am.Pose(x=1.0 + (i % 40), y=1.0 + (i // 40))) for i in range(1000)]
    scenario = building.scenario(*robots, map=building.empty(100.0))
    scene = SceneBuilder(am.Simulation(scenario)).scene
    assert len(scene["kinds"]) == 1
    assert len(json.dumps(scene)) < 200_000


def test_each_kind_of_reading_says_how_it_is_drawn() -> None:
    from amorsim.sensors.bumper import Bumper, Sector
    from amorsim.sensors.camera import Camera
    from amorsim.sensors.compass import Compass
    from amorsim.sensors.encoder import Encoder
    from amorsim.sensors.fiducial import Fiducial
    from amorsim.sensors.gps import Gps
    from amorsim.sensors.infrared import Infrared
    from amorsim.sensors.laser import Laser
    from amorsim.sensors.light import Light
    from amorsim.sensors.sonar import Sonar

    quarter = Sector(start=0.0, end=math.pi / 2.0)
    sensors = {
        "laser": Laser(),
        "sonar": Sonar(elements=(am.Mount(),)),
        "infrared": Infrared(saturation=900.0),
        "light": Light(),
        "lux": Light(bright=None, dark=0.0, gain=1.0),
        "bumper": Bumper(segments=(quarter,)),
        "marks": Fiducial(),
        "camera": Camera(colours=("lime", "#102030")),
        "gps": Gps(),
        "compass": Compass(),
        "encoder": Encoder(counts_per_revolution=500.0),
    }
    robot = building.robot(sensors={name: am.MountedSensor(sensor=one) for name, one in sensors.items()})
    scene = SceneBuilder(am.Simulation(building.scenario(robot))).scene
    drawings = {shape["name"]: shape["drawing"] for shape in scene["kinds"][0]["sensors"]}
    assert drawings.pop("encoder") is None
    lines = drawings["bumper"].pop("lines")
    assert drawings == {
        "laser": {"style": "beams"},
        "sonar": {"style": "cones"},
        "infrared": {"style": "glow", "half_angle": math.pi / 6.0, "reach": 0.058, "span": [0.0, 900.0]},
        "light": {"style": "sticks", "span": [500.0, 50.0]},
        "lux": {"style": "sticks", "span": [0.0]},
        "bumper": {"style": "contacts"},
        "marks": {"style": "things"},
        "camera": {"style": "things", "colours": ["#00ff00", "#102030"], "names": ["lime", "#102030"]},
        "gps": {"style": "fix"},
        "compass": {"style": "needle"},
    }
    # The footprint's part between ahead and the left.
    ends = np.array(lines).reshape(-1, 2)
    assert (ends >= -1e-9).all()
    np.testing.assert_allclose(ends.max(axis=1), robot.shape.outline.max())  # a square


def test_the_true_elements_of_a_ring_are_drawn_where_each_truly_is() -> None:
    from amorsim.ui.scene.drawn_robots import sensor_shapes

    changes = [
        "robots.0.errors.sensors.sonar.elements.3.heading_deg.add=5",
        "robots.0.errors.sensors.sonar.elements.3.x.add=0.02",
    ]
    handle = am.Simulation(am.load("demo", changes)).robot("rover")
    (nominal, true) = (
        next(shape for shape in sensor_shapes(robot) if shape["name"] == "sonar")
        for robot in (handle.nominal, handle.true)
    )
    apart = np.array(true["mounts"]) - np.array(nominal["mounts"])
    expected = np.zeros_like(apart)
    expected[3] = [0.02, 0.0, math.radians(5.0)]
    np.testing.assert_allclose(apart, expected, atol=1e-12)
