"""Devices and models that build on one another: what lies over what, and whose fault it is."""

import math

import numpy as np
import pytest

import amorsim as am
from amorsim.core.errors import ScenarioError
from amorsim.scenario.files.devices import load_device

ROVER = '[[robots]]\nname = "rover"\nmodel = "pioneer2dx"\npose = { x = 1.0, y = 1.5 }\n'
PROBE = """format = 1
description = "a laser of three beams"
use = "laser"
beams = 3
fov_deg = 90.0
noise = [{ use = "gaussian", std = 0.01 }]
"""


def laser(scenario):
    return scenario.robots[0].sensors["laser"]


def test_a_device_takes_the_place_of_what_the_model_has(read):
    unit = laser(read(ROVER + '[robots.sensors.laser]\nmodel = "sick-lms200"\nmount = { x = 0.1 }\n'))
    assert unit.sensor.range_max == 8.192
    assert unit.rate == 10.0
    assert unit.mount.x == 0.1
    assert [element.name for element in unit.noise] == ["aim_gaussian", "gaussian", "systematic", "quantize"]


def test_what_the_scenario_says_lies_over_the_device(read):
    unit = laser(read(ROVER + 'sensors = { laser = { model = "sick-lms200", beams = 91, rate = 5.0, noise = [] } }\n'))
    assert (unit.sensor.beams, unit.rate, unit.noise) == (91, 5.0, ())
    assert unit.sensor.fov == pytest.approx(math.pi)


def test_a_device_may_be_a_new_sensor_or_a_file(read, folder):
    (folder / "probe.toml").write_text(PROBE)
    scenario = read(ROVER + 'sensors = { probe = { model = "probe.toml", mount = { heading_deg = 90.0 } } }\n')
    probe = scenario.robots[0].sensors["probe"]
    assert (probe.sensor.beams, probe.sensor.fov) == (3, pytest.approx(math.pi / 2.0))
    assert laser(scenario).sensor.beams == 181


def test_a_device_may_build_on_another(read, folder):
    (folder / "probe.toml").write_text(PROBE)
    (folder / "fine.toml").write_text('format = 1\nmodel = "probe.toml"\nbeams = 7\n')
    unit = read(ROVER + 'sensors = { laser = { model = "fine.toml" } }\n').robots[0].sensors["laser"]
    assert (unit.sensor.beams, len(unit.noise)) == (7, 1)


def test_a_setting_chooses_a_device_and_another_changes_it(read):
    settings = ["robots.rover.sensors.laser.model=sick-lms200", "robots.rover.sensors.laser.beams=19"]
    for order in (settings, settings[::-1]):
        unit = laser(read(ROVER, *order))
        assert (unit.sensor.beams, unit.sensor.range_max) == (19, 8.192)


def test_a_sensor_in_place_of_a_device(read, folder):
    (folder / "kin.toml").write_text(
        'format = 1\nmodel = "pioneer2dx"\n[sensors.laser]\nmodel = "sick-lms200"\nrate = 2.0\n'
    )
    rover = ROVER.replace("pioneer2dx", "kin.toml")
    assert laser(read(rover)).rate == 2.0
    assert laser(read(rover + "sensors = { laser = { rate = 3.0 } }\n")).rate == 3.0
    plain = laser(read(rover + 'sensors = { laser = { use = "laser", beams = 5 } }\n'))
    assert (plain.sensor.beams, plain.rate, plain.noise) == (5, None, ())


def test_a_model_builds_on_another_and_brings_errors(read, folder):
    (folder / "bent.toml").write_text(
        'format = 1\nmodel = "pioneer2dx"\n[errors.drive]\ntrack = { scale = 1.1, per = "study" }\n'
        "wheel_radius_left = { scale = 1.01 }\n[drive]\ntrack = 0.4\n"
    )
    bent = ROVER.replace("pioneer2dx", "bent.toml")
    robot = read(bent).robots[0]
    assert (robot.drive.track, robot.errors["drive.track"].scale) == (0.4, 1.1)
    # An error of the scenario takes the whole place of the model's, of which the others stay.
    robot = read(bent + "[robots.errors.drive]\ntrack = { add = 0.01 }\n").robots[0]
    assert robot.errors["drive.track"] == am.Deviation(add=0.01)
    assert robot.errors["drive.wheel_radius_left"] == am.Deviation(scale=1.01)


def test_faults_name_the_file_in_which_they_are(read, folder):
    (folder / "bad.toml").write_text(PROBE.replace("fov_deg = 90.0", "fov_deg = -1.0") + "colour = 1\n")
    with pytest.raises(ScenarioError) as caught:
        read(ROVER + 'sensors = { laser = { model = "bad.toml", rate = -1.0 } }\n')
    found = {fault.path: fault for fault in caught.value.faults}
    assert found["fov_deg"].file == str(folder / "bad.toml")
    assert "unknown key" in found["colour"].message
    assert found["robots.0.sensors.laser.rate"].file == "test.toml"


@pytest.mark.parametrize(
    ("text", "path", "problem"),
    [
        (
            'sensors = { laser = { model = "sick" } }',
            "robots.0.sensors.laser.model",
            "no device 'sick'",
        ),
        ('sensors = { laser = { model = "no.toml" } }', "robots.0.sensors.laser.model", "there is no such file"),
        ("sensors = { laser = { model = 3 } }", "robots.0.sensors.laser.model", "the name of a device, or the path"),
        ('sensors = { laser = { model = "noform.toml" } }', "format", "missing; expected format = 1"),
        ('sensors = { laser = { model = "loop.toml" } }', "model", "loop.toml builds on itself"),
    ],
)
def test_devices_that_are_none(faults, folder, text, path, problem):
    (folder / "noform.toml").write_text('use = "laser"\n')
    (folder / "loop.toml").write_text('format = 1\nmodel = "loop.toml"\n')
    found = faults(ROVER + text + "\n")
    assert problem in found[path]
    assert len(found) == 1


def test_a_device_in_a_script(tmp_path):
    unit = am.load_device("adxrs300")
    assert isinstance(unit.sensor, am.sensors.Gyro)
    (tmp_path / "probe.toml").write_text(PROBE)
    assert am.load_device(tmp_path / "probe.toml").sensor.beams == 3
    with pytest.raises(ScenarioError, match=r"no device 'adxrs30'; .*[Dd]id you mean 'adxrs300'"):
        am.load_device("adxrs30")


def test_a_plugin_brings_devices(registry, tmp_path):
    from amorsim.plugins.manager import make_registry

    mine = make_registry(entry_points=(), disabled="")
    (tmp_path / "probe.toml").write_text(PROBE)
    mine.device("probe", tmp_path / "probe.toml")
    assert load_device("probe", registry=mine).sensor.beams == 3
    with pytest.raises(am.PluginError, match="expected a TOML file"):
        mine.device("other", tmp_path / "none.toml")
    assert "probe" not in registry.names("device")


def test_all_that_ship_have_a_line_on_what_they_are(registry):
    from amorsim.analysis.reference import summary_of

    for entry in registry.entries("device"):
        assert len(summary_of(registry, entry)) > 30
        assert load_device(entry.name, registry=registry).noise
        text = registry.file("device", entry.name).read_text(encoding="utf-8")
        # Each figure has a source's letter, and each letter is said what it is.
        letters = {part[0] for part in text.split("[")[1:] if part[1:2] == "]" and part[0].isupper()}
        assert letters
        assert all(f"#   [{letter}] " in text for letter in letters)


@pytest.mark.long
def test_the_typical_robot_is_another_one_in_each_replica(read):
    scenario = read(ROVER.replace("pioneer2dx", "pioneer2dx-typical"))
    sim = am.Simulation(scenario, replicas=400)
    drives = [robot.drive for robot in sim._fleet.groups[0].true]
    ratio = np.array([drive.wheel_radius_right / drive.wheel_radius_left for drive in drives])
    track = np.array([drive.track / 0.33 for drive in drives])
    assert 0.995 < ratio.min() < 0.9965 < 1.0035 < ratio.max() < 1.0051
    assert 0.98 <= track.min() < 0.983 < 1.017 < track.max() <= 1.02
    # A uniform distribution of width w has the standard deviation w / sqrt(12); a ratio of two that of two.
    assert track.std() == pytest.approx(0.04 / math.sqrt(12.0), rel=5.0 * math.sqrt(0.2 / 400))
    assert ratio.std() == pytest.approx(0.005 * math.sqrt(2.0 / 12.0), rel=5.0 * math.sqrt(0.35 / 400))
    sim.run(0.5)
    assert {name: unit.measured.shape[1] for name, unit in sim.readings.items()}["sonar"] == 16


def test_devices_do_what_their_figures_say(read):
    text = ROVER + 'controller = { use = "manual" }\n[robots.sensors]\n'
    for name, device in (("laser", "sick-lms200"), ("compass", "tcm2"), ("gyro", "adxrs300")):
        text += f'{name} = {{ model = "{device}", rate = "none" }}\n'
    sim = am.Simulation(read(text), replicas=500)
    errors = {"laser": [], "compass": [], "gyro": []}
    for _ in range(20):
        sim.step()
        for name, found in errors.items():
            reading = sim.readings[name]
            found.append(reading.measured - reading.true)
    for name, expected, slack in (
        # White noise and steps of 1 mm; beams that are bent add what they slant, below 1 mm here for most.
        ("laser", math.hypot(0.005, 0.001 / math.sqrt(12.0)), 0.05),
        ("compass", math.radians(math.hypot(0.5, 0.1 / math.sqrt(12.0))), 0.05),
        # Angle random walk over 0.1 s, and the wandering bias.
        ("gyro", math.radians(math.hypot(0.0707 / math.sqrt(0.1), 0.02)), 0.05),
    ):
        values = np.array(errors[name])
        middle = values[..., 60:120] if name == "laser" else values
        assert middle.std() == pytest.approx(expected, rel=slack), name


def test_what_each_file_says_of_a_device_is_a_fault_of_that_file(registry, tmp_path, folder):
    (tmp_path / "cart.toml").write_text(
        'format = 1\nmodel = "pioneer2dx-typical"\n[sensors.compass]\nlatency = -1\nmount = { x = 0.1, z = 3 }\n'
    )
    path = tmp_path / "one.toml"
    path.write_text(
        f'format = 1\n[world]\nmap = "{folder / "room.wld"}"\n[[robots]]\nmodel = "cart.toml"\n'
        "[robots.sensors.compass]\nrate = -1\nmount.heading = 1\n"
    )
    with pytest.raises(ScenarioError) as caught:
        am.load(path)
    found = {(fault.file, fault.path, fault.line) for fault in caught.value.faults}
    cart = str(tmp_path / "cart.toml")
    assert found == {
        (str(path), "robots.0.sensors.compass.rate", 7),
        (str(path), "robots.0.sensors.compass.mount.heading", 8),
        (cart, "sensors.compass.latency", 4),
        (cart, "sensors.compass.mount.z", 5),
    }
