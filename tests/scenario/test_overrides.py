"""Settings of the command line: what they reach, and how their faults are reported."""

import re

import pytest

from amorsim.core.errors import ScenarioError
from amorsim.core.parameters import ParameterError
from amorsim.scenario.reading.read import load
from amorsim.scenario.spec import Deviation, Pose

TWO = """
[[robots]]
name = "rover"
model = "pioneer2dx"
controller = { use = "wander" }
[[robots]]
name = "scout"
model = "pioneer2dx"
"""


def test_values_are_toml_or_else_plain_texts(read):
    scenario = read(
        TWO,
        "simulation.dt=0.05",
        "simulation.seed = 3",
        "recording.sensors=none",
        "recording.picture=false",
        'robots.scout.name="pathfinder"',
        "robots.rover.controller.speed=0.2",
        "robots.1.pose={x=3.0, y=2.0}",
        "robots.1.pose.heading_deg=90",
    )
    assert (scenario.dt, scenario.seed, scenario.recording.sensors, scenario.recording.picture) == (
        0.05,
        3,
        "none",
        False,
    )
    assert scenario.robots[1].name == "pathfinder"
    assert scenario.robots[0].controller.speed == 0.2
    assert (scenario.robots[1].pose.x, scenario.robots[1].pose.heading) == (3.0, pytest.approx(1.5707963267948966))


@pytest.mark.parametrize("setting", ["scale=true", "add=false"])
def test_an_error_that_is_no_number_is_refused_though_it_equals_the_neutral_one(read, setting):
    with pytest.raises(ScenarioError, match=r"errors\.drive\.track\.\w+: expected"):
        read(TWO + "errors.drive.track = { scale = 1.0 }\n", f"robots.scout.errors.drive.track.{setting}")


def test_tables_are_made_on_the_way(read):
    scenario = read(TWO, "robots.0.errors.drive.track.scale=1.02", "robots.0.errors.drive.wheel_radius_left=0.08")
    assert scenario.robots[0].errors == {
        "drive.track": Deviation(scale=1.02),
        "drive.wheel_radius_left": Deviation(value=0.08),
    }


@pytest.mark.parametrize("setting", ["x=0.0", "x=0", "y=0.0", "heading_deg=0"])
def test_a_robot_that_had_no_pose_can_be_set_to_the_origin(read, setting):
    # Without a pose it would stand at the map's start.
    assert read(TWO, f"robots.scout.pose.{setting}").robots[1].pose == Pose()


def test_what_the_model_says_can_be_reached_too(read):
    scenario = read(
        TWO,
        "robots.rover.sensors.laser.noise.gaussian.std=0.1",
        "robots.rover.sensors.laser.noise.1.step=0.5",
        "robots.rover.drive.track=0.4",
        "robots.rover.sensors.sonar=false",
        "robots.scout.sensors.sonar.elements.3.heading_deg=11",
    )
    rover, scout = scenario.robots
    assert rover.sensors["laser"].noise[0].noise.std == 0.1
    assert rover.sensors["laser"].noise[1].noise.step == 0.5
    assert rover.drive.track == 0.4
    assert "sonar" not in rover.sensors
    assert scout.sensors["sonar"].sensor.elements[3].heading == pytest.approx(0.19198621771937624)
    assert scout.drive.track == 0.33, "only the robot that was named changes"


def test_another_use_forgets_the_fields_of_the_one_before(read):
    scenario = read(TWO, "robots.rover.controller.speed=0.1", "robots.rover.controller.use=manual")
    assert type(scenario.robots[0].controller).__name__ == "Manual"


def test_a_model_can_be_chosen(read, folder):
    (folder / "cart.toml").write_text(
        "format = 1\nshape = { circle = 0.3 }\n"
        'drive = { use = "differential", wheel_radius_left = 0.1, '
        "wheel_radius_right = 0.1, track = 0.4, rate_max_deg = 1 }\n"
    )
    scenario = read(TWO, f"robots.rover.model={folder / 'cart.toml'}", "robots.rover.drive.track=0.5")
    assert scenario.robots[0].drive.wheel_radius_left == 0.1
    assert scenario.robots[0].drive.track == 0.5


def test_a_table_takes_the_place_of_the_models(read):
    """What it does not say has its default, whatever the model says of it."""
    (laser, other) = (
        robot.sensors["laser"] for robot in read(TWO, "robots.rover.sensors.laser={ use = 'laser', beams = 5 }").robots
    )
    assert (laser.sensor.beams, laser.noise, laser.mount.x) == (5, (), 0.0)
    assert other.noise
    assert other.mount.x == 0.017


def test_parts_of_errors_and_shapes_go_together(read, folder):
    (folder / "rounded.toml").write_text(
        "format = 1\nshape = { polygon = [[0.1, 0.1], [-0.1, 0.1], [0.0, -0.1]], rounding = 0.02 }\n"
        'drive = { use = "differential", wheel_radius_left = 0.1, '
        "wheel_radius_right = 0.1, track = 0.4, rate_max_deg = 1 }\nerrors = { drive = { track = { scale = 1.1 } } }\n"
    )
    model = f"robots.rover.model={folder / 'rounded.toml'}"
    text = TWO.replace('controller = { use = "wander" }\n', "")
    rover = read(text, "robots.rover.shape.rounding=0.05", "robots.rover.errors.drive.track.add=0.01", model).robots[0]
    assert rover.shape.radius == 0.05
    assert rover.errors == {"drive.track": Deviation(scale=1.1, add=0.01)}
    assert read(text, model, "robots.rover.shape.polygon.0.0=0.2").robots[0].shape.radius == 0.02
    assert read(text, model, "robots.rover.shape.circle=0.2").robots[0].shape.radius == 0.2


def test_a_file_that_cannot_be_read_takes_settings_all_the_same(folder, registry):
    """Both are reported at once."""
    path = folder / "broken.toml"
    path.write_text(f'format = 1\n[world]\nmap = "room.wld"\nx = = 3\n{TWO}')
    with pytest.raises(ScenarioError) as caught:
        load(path, ["robots.rover.drive.track=-1", "robots.nobody.name=x"], registry=registry)
    assert [(fault.file, fault.line, fault.path) for fault in caught.value.faults] == [
        (str(path), 4, ""),
        ("--set robots.nobody.name=x", None, "robots.nobody"),
        ("--set robots.rover.drive.track=-1", None, "robots.0.drive.track"),
    ]
    assert path.read_text().endswith(TWO)


def test_digits_beyond_those_of_a_double_count(read):
    text = "33.33333333333333333333"
    one, other = (
        read(f'[[robots]]\nname = "rover"\nmodel = "pioneer2dx"\npose = {{ x = 1.0, heading_deg = {value} }}\n', *more)
        for value, more in ((text, ()), (0.0, (f"robots.rover.pose.heading_deg={text}",)))
    )
    assert one.robots[0].pose == other.robots[0].pose


def test_a_path_of_the_command_line_starts_where_it_was_typed(read, tmp_path, monkeypatch):
    (tmp_path / "other.wld").write_text("width 2000\nheight 2000\n")
    monkeypatch.chdir(tmp_path)
    assert read(TWO, "world.map=other.wld").map.size == (2.0, 2.0)


@pytest.mark.parametrize(
    ("setting", "path", "words"),
    [
        ("simulation.dt", "", "expected PATH=VALUE"),
        ("=3", "", "expected PATH=VALUE"),
        ("simulation..dt=3", "", "expected PATH=VALUE"),
        ("simulation.dt=fast", "simulation.dt", "got 'fast'"),
        ("simulation.dt=inf", "simulation.dt", "got inf"),
        ("simulation.dt=1\nseed=3", "simulation.dt", "got '1\\nseed=3'"),
        ("robots.rovr.pose.x=1", "robots.rovr", "Did you mean 'rover'?"),
        ("robots.2.pose.x=1", "robots.2", "no robot '2'; known robots: rover, scout"),
        ("robots.0.name.first=x", "robots.0.name.first", "there is nothing under robots.0.name: it is 'rover'"),
        (
            "robots.0.sensors.laser.noise.3.std=1",
            "robots.0.sensors.laser.noise.3",
            "no element '3'; known elements: gaussian, quantize",
        ),
        ("robots.0.sensors.laser.rnage_max=1", "robots.0.sensors.laser.rnage_max", "Did you mean 'range_max'?"),
        (
            "robots.0.sensors.laserr.range_max=1",
            "robots.0.sensors.laserr.use",
            "missing; expected the name of a sensor",
        ),
        ("wrold.map=x", "wrold", "Did you mean 'world'?"),
        ("robots.0.contrller.speed=1", "robots.0.contrller", "Did you mean 'controller'?"),
        ("format=2", "format", "expected 1"),
    ],
)
def test_a_fault_of_a_setting_names_the_setting(read, setting, path, words):
    with pytest.raises(ScenarioError) as caught:
        read(TWO, setting)
    (fault,) = caught.value.faults
    assert fault.file == f"--set {setting}"
    assert fault.path == path
    assert words in fault.message


def test_faults_of_settings_and_files_come_together(read):
    with pytest.raises(ScenarioError) as caught:
        read(f"[simulation]\nseed = 'x'\n{TWO}", "simulation.dt=0", "nonsense", "robots.rover.drive.track=no")
    assert [fault.file for fault in caught.value.faults] == [
        "--set nonsense",
        "--set simulation.dt=0",
        "test.toml",
        "--set robots.rover.drive.track=no",
    ]


def test_one_setting_alone_is_not_taken_for_a_list_of_letters():
    with pytest.raises(ParameterError, match=r"expected a list of settings, as \['simulation.dt=0.2'\], got '"):
        load("demo", "simulation.dt=0.2")


@pytest.mark.parametrize("what", ["drive.trakc", "sensors.lazer.range_max", "sensors.laser.raneg", "wheels.track"])
def test_an_error_of_nothing_is_a_fault_even_if_it_changes_nothing(read, what):
    with pytest.raises(ScenarioError, match=re.escape(f"errors.{what}")):
        read(TWO, f"robots.rover.errors.{what}.scale=1.0")


def test_an_item_of_a_list_that_nobody_said_is_changed_in_its_default(read):
    khepera = '[[robots]]\nname = "khepera"\nmodel = "khepera"\n'
    values = read(khepera).robots[0].sensors["infrared"].sensor.values
    changed = read(khepera, "robots.0.sensors.infrared.values.1=700.0").robots[0].sensors["infrared"].sensor.values
    assert changed == (values[0], 700.0, *values[2:])
    with pytest.raises(ScenarioError, match=f"no value '99'; known values: 0 to {len(values) - 1}"):
        read(khepera, "robots.0.sensors.infrared.values.99=700.0")


def test_an_item_of_a_list_that_is_empty_is_a_fault(read):
    with pytest.raises(ScenarioError, match=r"obstacles.0: no obstacle '0'; known obstacles: none"):
        read(TWO, "obstacles.0.name=box")
