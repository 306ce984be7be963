"""Names of a robot's sensors, estimators and joints that it does not have are faults in their places."""

import re

import pytest

from amorsim.core.errors import ScenarioError
from amorsim.scenario.reading.read import load

ROBOT = """
[[robots]]
name = "rover"
model = "pioneer2dx"
controller = {controller}
estimators = {estimators}
ground = {ground}
"""
FINE = {"controller": '{ use = "wander" }', "estimators": "{}", "ground": "[]"}
SLIP = '{ use = "slip", at = 1.0, duration = 1.0, factor = 0.5, joint = "%s" }'
EKF = '{ pose = { use = "ekf", wheel_variance = 1e-5, compass = "%s" } }'
AVOIDER = '{ use = "dwa", sensor = "lazer" }'
PLANNED = f'{{ use = "navigate", goals = [[1.0, 1.0]], planner = {{ use = "a_star" }}, avoider = {AVOIDER} }}'


@pytest.mark.parametrize(
    ("given", "path", "words"),
    [
        (
            {"controller": '{ use = "wander", sensor = "lazer" }'},
            "robots.0.controller.sensor",
            "no sensor 'lazer'.* Did you mean 'laser'?",
        ),
        ({"controller": PLANNED}, "robots.0.controller.avoider.sensor", "no sensor 'lazer'"),
        ({"estimators": EKF % "kompass"}, "robots.0.estimators.pose.compass", "no sensor 'kompass'.* mean 'compass'"),
        (
            {"estimators": '{ chart = { use = "grid_mapping", estimator = "pose" } }'},
            "robots.0.estimators.chart.estimator",
            "no estimator 'pose'; known estimators: dead_reckoning, chart",
        ),
        (
            {"ground": f"[{SLIP % 'left_wheel'}, {SLIP % 'middle'}]"},
            "robots.0.ground.1.joint",
            "no joint 'middle'; known joints: left_wheel",
        ),
    ],
)
def test_a_name_that_the_robot_does_not_have_is_a_fault(faults, given, path, words):
    found = faults(ROBOT.format(**FINE | given))
    assert list(found) == [path]
    assert re.search(words, found[path])


def test_the_fault_has_its_line(folder):
    path = folder / "refers.toml"
    text = ROBOT.format(**FINE | {"controller": '{ use = "wander", sensor = "lazer" }'})
    path.write_text(f'format = 1\n[world]\nmap = "room.wld"\n{text}')
    with pytest.raises(
        ScenarioError, match=r"refers.toml:8: robots.rover.controller.sensor: the robot has no sensor 'lazer'"
    ):
        load(path)


def test_a_name_that_is_a_default_may_be_of_nothing(read):
    # A scenario with all defaults filled in says it too.
    text = ROBOT.format(**FINE | {"controller": '{ use = "wander", sensor = "laser" }'})
    robot = read(text + "sensors = { laser = false }").robots[0]
    assert (robot.controller.sensor, "laser" in robot.sensors) == ("laser", False)


def test_all_such_faults_come_together(faults):
    given = {"controller": '{ use = "wander", sensor = "a" }', "estimators": EKF % "b", "ground": f"[{SLIP % 'c'}]"}
    assert len(faults(ROBOT.format(**FINE | given))) == 3
