"""What a scenario's file says arrives as it was meant: in SI units, with models and defaults filled in."""

import math
from pathlib import Path

import pytest

from amorsim.controllers.user import UserController
from amorsim.core.errors import ScenarioError
from amorsim.core.shapes import Shape
from amorsim.scenario.reading.read import load, loads, scenario_for_map
from amorsim.scenario.spec import Deviation, Distribution, Pose

ROVER = '[[robots]]\nname = "rover"\nmodel = "pioneer2dx"\n'
BARE = """
[[robots]]
name = "bare"
shape = { circle = 0.2 }
drive = { use = "differential", wheel_radius_left = 0.1, wheel_radius_right = 0.1, track = 0.4, rate_max_deg = 900 }
"""


def test_a_scenario_in_full(read, folder):
    (folder / "mine.py").write_text("def drive(readings, estimate, clock, speed=0.1):\n    return None\n")
    scenario = read(
        """
        format = 1
        description = "everything at once"
        [world]
        map = "room.wld"
        resolution = 0.05
        [simulation]
        dt = 0.05
        duration = 12
        seed = 7
        [recording]
        sensors = "none"
        picture = false
        [[robots]]
        name = "rover"
        model = "pioneer2dx"
        pose = { x = 1.0, y = 2.0, heading_deg = 90.0 }
        controller = { use = "mine.py:drive", speed = 0.25 }
        on_collision = "continue"
        drive = { track = 0.34 }
        ground = [{ use = "diffusion", variance_per_length = 1e-6 }]
        [robots.sensors]
        sonar = false
        [robots.sensors.laser]
        rate = 5.0
        latency = 0.1
        mount.heading_deg = 10.0
        noise = [
            { use = "gaussian", std = 0.01 },
            { use = "gaussian", std = 0.02 },
            { use = "bias", name = "b", value = 1 },
        ]
        [robots.sensors.front]
        use = "sonar"
        elements = [{ heading_deg = 45.0 }]
        [robots.errors]
        drive.track = { scale = { normal = [1.0, 0.02] }, per = "study" }
        drive.wheel_radius_left = 0.0826
        sensors.laser.mount.heading_deg = { add = 0.5, scale = 2.0 }
        sensors.front.elements.0.heading_deg = { add = { uniform = [-1.0, 1.0] } }
        pose.x.add = 0.1
        [robots.knowledge]
        map = "room.wld"
        landmarks = [[1, 2], [3.5, 0.25]]
        [[obstacles]]
        shape = { rectangle = [0.4, 0.2] }
        pose = { x = 3.0, y = 1.0, heading_deg = 45.0 }
        """
    )
    assert (scenario.dt, scenario.duration, scenario.seed) == (0.05, 12.0, 7)
    assert type(scenario.duration) is float
    assert (scenario.recording.sensors, scenario.recording.picture) == ("none", False)
    assert scenario.map.grid.resolution == 0.05
    (robot,) = scenario.robots
    assert (robot.name, robot.model, robot.on_collision) == ("rover", "pioneer2dx", "continue")
    assert robot.pose == Pose(x=1.0, y=2.0, heading=math.pi / 2)
    assert isinstance(robot.controller, UserController)
    assert robot.controller.options == (("speed", 0.25),)
    assert robot.drive.track == 0.34
    assert robot.drive.wheel_radius_left == 0.0825, "the rest of the drive is the model's"
    assert [element.name for element in robot.ground] == ["diffusion"]
    assert set(robot.sensors) == {"encoder", "laser", "compass", "gyro", "front"}
    laser = robot.sensors["laser"]
    assert (laser.rate, laser.latency, laser.sensor.beams) == (5.0, 0.1, 181)
    assert (laser.mount.x, laser.mount.heading) == (0.017, math.radians(10.0))
    assert [element.name for element in laser.noise] == ["gaussian", "gaussian_2", "b"]
    assert laser.noise[2].noise.value == 1.0
    assert type(laser.noise[2].noise.value) is float
    assert robot.sensors["front"].sensor.elements[0].heading == math.radians(45.0)
    assert robot.errors == {
        "drive.track": Deviation(scale=Distribution(kind="normal", values=(1.0, 0.02)), per="study"),
        "drive.wheel_radius_left": Deviation(value=0.0826),
        "sensors.laser.mount.heading": Deviation(add=math.radians(0.5), scale=2.0),
        "sensors.front.elements.0.heading": Deviation(
            add=Distribution(kind="uniform", values=(math.radians(-1.0), math.radians(1.0)))
        ),
        "pose.x": Deviation(add=0.1),
    }
    assert robot.knowledge.map is scenario.map, "the same file, given without options, is the same map"
    assert robot.knowledge.landmarks == ((1.0, 2.0), (3.5, 0.25))
    (obstacle,) = scenario.obstacles
    assert obstacle.name == "obstacle1"
    assert obstacle.shape == Shape.rectangle(0.4, 0.2)


def test_a_field_in_the_sensors_unit_is_spelt_in_degrees_where_that_is_an_angle(read):
    scenario = read(ROVER)
    compass = scenario.robots[0].sensors["compass"]
    laser = scenario.robots[0].sensors["laser"]
    assert compass.noise[0].noise.std == math.radians(0.5)
    assert laser.noise[0].noise.std == 0.005


def test_a_robot_without_pose_starts_where_the_map_says(read):
    assert read(ROVER).robots[0].pose == Pose(x=1.0, y=1.5, heading=math.radians(90.0))


def test_a_robot_without_pose_starts_at_the_freest_place_of_a_map_that_says_none(read, tmp_path):
    (tmp_path / "hall.wld").write_text(
        "width 4000\nheight 2000\n0 0 4000 0\n4000 0 4000 2000\n4000 2000 0 2000\n0 2000 0 0\n"
    )
    scenario = read(f'format = 1\n[world]\nmap = "hall.wld"\n{ROVER}', folder=tmp_path)
    pose = scenario.robots[0].pose
    assert not scenario.map.occupied([[pose.x, pose.y]])[0]
    assert 0.9 < pose.y < 1.1, "in the middle between the walls"
    assert pose.heading == 0.0


@pytest.mark.parametrize(
    ("text", "shape"),
    [
        ("{ circle = 0.25 }", Shape.circle(0.25)),
        ("{ circle = 1, x = 0.5, y = -0.5 }", Shape.circle(1.0, x=0.5, y=-0.5)),
        ("{ rectangle = [2, 1] }", Shape.rectangle(2.0, 1.0)),
        ("{ rectangle = [2, 1], x = 0.5 }", Shape.rectangle(2.0, 1.0, x=0.5)),
        ("{ polygon = [[0, 0], [1, 0], [0, 1]] }", Shape.polygon([[0, 0], [1, 0], [0, 1]])),
        (
            "{ polygon = [[0, 0], [1, 0], [0, 1]], rounding = 0.1 }",
            Shape.polygon([[0, 0], [1, 0], [0, 1]], rounding=0.1),
        ),
    ],
)
def test_shapes(read, text, shape):
    assert read(BARE.replace("{ circle = 0.2 }", text)).robots[0].shape == shape


def test_none_unsets_what_a_model_sets(read):
    scenario = read(f'{ROVER}drive = {{ acceleration_max_deg = "none" }}')
    assert scenario.robots[0].drive.acceleration_max is None


def test_another_use_replaces_the_models_component_whole(read):
    scenario = read(f'{ROVER}[robots.sensors.laser]\nuse = "compass"\n')
    laser = scenario.robots[0].sensors["laser"]
    assert type(laser.sensor).__name__ == "Compass"
    assert laser.noise == ()
    assert laser.mount.x == 0.0


def test_an_empty_map_of_errors_and_an_absent_controller_are_fine(read):
    scenario = read(f"{ROVER}[robots.errors]\n")
    assert scenario.robots[0].controller is None
    assert scenario.robots[0].errors == {}


def test_a_model_of_ones_own(read, folder):
    sub = folder / "robots"
    sub.mkdir(exist_ok=True)
    (sub / "mine.py").write_text("def drive(readings, estimate, clock):\n    return None\n")
    (sub / "cart.toml").write_text(
        'format = 1\ndescription = "a cart"\nshape = { circle = 0.3 }\ncontroller = { use = "mine.py:drive" }\n'
        'drive = { use = "differential", wheel_radius_left = 0.1, '
        "wheel_radius_right = 0.1, track = 0.4, rate_max_deg = 1 }\n"
    )
    scenario = read('[[robots]]\nmodel = "robots/cart.toml"\n')
    (robot,) = scenario.robots
    assert robot.name == "robot"
    assert robot.shape == Shape.circle(0.3)
    assert robot.controller.source == f"{(sub / 'mine.py').resolve()}:drive", "paths start at the model's own folder"


def test_one_map_is_read_once_for_all(read):
    text = "".join(
        f'{ROVER.replace("rover", name)}[robots.knowledge]\nmap = "room.wld"\nresolution = 0.1\n'
        for name in ("one", "two")
    )
    one, two = read(text).robots
    assert one.knowledge.map is two.knowledge.map
    assert one.knowledge.map.grid.resolution == 0.1


def test_the_bundled_demo_is_loaded_by_name(registry):
    scenario = load("demo", registry=registry)
    assert scenario.source == registry.file("scenario", "demo")
    assert scenario.robots[0].errors


def test_a_map_alone(registry, folder):
    scenario = scenario_for_map(folder / "room.wld", resolution=0.02, registry=registry)
    (robot,) = scenario.robots
    assert (robot.name, robot.model, scenario.duration) == ("rover", "pioneer2dx", 60.0)
    assert type(robot.controller).__name__ == "Wander"
    assert robot.pose == Pose(x=1.0, y=1.5, heading=math.radians(90.0))
    assert scenario.map.grid.resolution == 0.02
    faster = scenario_for_map(folder / "room.wld", ["robots.rover.controller.speed=0.2"], registry=registry)
    assert faster.robots[0].controller.speed == 0.2


@pytest.mark.parametrize(
    ("name", "options", "words"),
    [
        ("nowhere.wld", {}, "there is no such file"),
        ("room.wld", {"resolution": -1.0}, "expected a number \\[m\\] > 0, got -1.0"),
        ("room.wld", {"resolutoin": 0.1}, "Did you mean 'resolution'"),
    ],
)
def test_a_map_alone_that_is_wrong(registry, folder, name, options, words):
    with pytest.raises(ScenarioError, match=words):
        scenario_for_map(folder / name, registry=registry, **options)


def test_reading_does_not_change_the_document(registry, folder):
    document = {
        "format": 1,
        "world": {"map": "room.wld"},
        "robots": [{"model": "pioneer2dx", "sensors": {"laser": False}}],
    }
    loads(document, folder, ["robots.0.name=other"], registry=registry)
    assert document["robots"] == [{"model": "pioneer2dx", "sensors": {"laser": False}}]


def test_the_pioneer_is_as_its_sources_say(read):
    (robot,) = read(ROVER).robots
    outline = robot.shape.outline
    assert (outline.min(axis=0).tolist(), outline.max(axis=0).tolist()) == ([-0.301, -0.2125], [0.21, 0.2125])
    assert len(outline) == 8
    assert len(robot.shape.vertices) == 1, "convex"
    assert robot.shape.reach < 0.33
    drive = robot.drive
    assert drive.rate_max * drive.wheel_radius_left == pytest.approx(1.8, abs=1e-3)
    assert drive.acceleration_max * drive.wheel_radius_left == pytest.approx(0.6, abs=1e-3)
    sonar = robot.sensors["sonar"].sensor
    assert len(sonar.elements) == 16
    for left, right in zip(sonar.elements[:4], sonar.elements[7:3:-1], strict=True):
        assert (left.x, left.y, left.heading) == (right.x, -right.y, -right.heading)
    for right, left in zip(sonar.elements[8:12], sonar.elements[:11:-1], strict=True):
        assert (left.x, left.y, left.heading) == (right.x, -right.y, -right.heading)
    assert robot.sensors["encoder"].sensor.counts_per_revolution / (2 * math.pi * 0.0825) == pytest.approx(
        76.0e3, rel=1e-3
    )
    assert robot.sensors["laser"].sensor.beams == 181
    assert list(robot.estimators) == ["dead_reckoning"]


def test_paths_are_taken_as_they_are_given(registry, folder, monkeypatch):
    (folder / "short.toml").write_text(f'format = 1\n[world]\nmap = "room.wld"\n{ROVER}')
    monkeypatch.chdir(folder)
    scenario = load("short.toml", registry=registry)
    assert scenario.source == Path("short.toml")
    assert scenario.resolved["world"]["map"] == str(folder / "room.wld")
