"""What controllers report becomes events, and what they believe is in frames."""

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.core.errors import ComponentError
from tests.building import drive, encoder


@attrs.frozen(kw_only=True)
class Counting(am.Controller):
    """Counts its steps, and reports every third."""

    every: int = am.parameter(3, ge=1, help="steps from one report to the next")

    def start(self, context):
        return {"steps": np.zeros((context.rows, 1), dtype=np.int64)}

    def command(self, robot, readings, estimate, clock, state, draws):
        state["steps"] = state["steps"] + 1
        return np.zeros((robot.rows, 2))

    def reports(self, state):
        steps = state["steps"][:, 0]
        return [(row, "counted", int(steps[row])) for row in np.flatnonzero(steps % self.every[:, 0] == 0).tolist()]

    def beliefs(self, state):
        return {"steps": state["steps"].copy()}


@attrs.frozen(kw_only=True)
class Odd(Counting):
    """Reports what is not a report."""

    def reports(self, state):
        return [(0, "two words", 1)]


def robot(name, controller, y=0.0):
    return am.Robot(
        name=name,
        shape=am.Shape.circle(0.2),
        drive=drive(),
        sensors={"encoder": am.MountedSensor(sensor=encoder())},
        controller=controller,
        pose=am.Pose(x=1.0, y=y),
    )


def simulate(*robots, **options):
    room = am.Map.from_segments([(-5, -5, 5, -5), (5, -5, 5, 5), (5, 5, -5, 5), (-5, 5, -5, -5)], resolution=0.01)
    return am.Simulation(am.Scenario(map=room, robots=robots, dt=0.1), **options)


def test_a_report_is_an_event():
    simulation = simulate(robot("a", Counting()), robot("b", Counting(every=4), 1.0), replicas=2)
    simulation.run(0.5)
    found = [
        (event.time, event.replica, event.name, event.kind, event.path, event.value) for event in simulation.events
    ]
    assert found == [
        (pytest.approx(0.2), 0, "a", "report", "counted", 3),
        (pytest.approx(0.2), 1, "a", "report", "counted", 3),
        (pytest.approx(0.3), 0, "b", "report", "counted", 4),
        (pytest.approx(0.3), 1, "b", "report", "counted", 4),
    ]
    assert str(simulation.events[0]) == "0.200 s: a reports: counted, 3"


def test_a_robot_that_is_driven_by_hand_reports_nothing():
    simulation = simulate(robot("a", Counting(every=1)), robot("b", Counting(every=1), 1.0))
    simulation.hand_over("a")
    simulation.run(0.3)
    assert {event.name for event in simulation.events if event.kind == "report"} == {"b"}
    simulation.hand_over("a", "controller")
    simulation.step()
    assert [(event.name, event.value) for event in simulation.events[-2:]] == [("a", 1), ("b", 4)]


def test_a_report_that_is_none_is_an_error():
    with pytest.raises(ComponentError, match="expected a report to be a word such as 'goal_reached', got 'two words'"):
        simulate(robot("a", Odd())).step()


def test_beliefs_of_a_controller_are_in_frames():
    simulation = simulate(robot("a", Counting()))
    simulation.run(0.2)
    frame = simulation.frames()[0]
    assert frame.beliefs["controller"]["steps"].tolist() == [[2]]
    assert list(frame.beliefs) == ["controller"]
