"""What a component raises, or returns that is not finite, is reported with its owner and time."""

import math
import re
from typing import ClassVar

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.contracts import Controller, Emission, Estimate, Estimator, Motion, Noise, Sensor
from amorsim.core.error_text import explain
from amorsim.core.errors import ComponentError, ControllerError
from amorsim.core.shapes import Shape
from amorsim.drives.differential import Differential
from amorsim.scenario.spec import MountedSensor, NoiseElement, Obstacle
from tests import building

STEP = 3  # at which they fail


def fail(tick):
    if np.any(tick >= STEP):
        return {}["no such key"]
    return None


@attrs.frozen(kw_only=True)
class BadEstimator(Estimator):
    def start(self, context):
        return {"ticks": np.zeros((context.rows, 1))}

    def update(self, robot, readings, command, elapsed, state, draws):
        state["ticks"] = state["ticks"] + (elapsed > 0.0)
        fail(state["ticks"])
        return Estimate(np.zeros((robot.rows, 3)), np.zeros((robot.rows, 3, 3)))


@attrs.frozen(kw_only=True)
class BadStart(Estimator):
    def start(self, context):
        raise ValueError("it cannot begin")

    def update(self, robot, readings, command, elapsed, state, draws):
        raise NotImplementedError


@attrs.frozen(kw_only=True)
class BadSensor(Sensor):
    unit: ClassVar[str] = "m"
    channels: ClassVar[tuple[str, ...]] = ("pan",)
    at: str = am.parameter("sense", help="the method that fails", static=True)

    def size(self, drive):
        return fail(STEP if self.at == "size" else 0) or 2

    def start(self, context):
        fail(STEP if self.at == "start" else 0)
        return {}

    def sense(self, view, aim, state, draws):
        fail(view.tick if self.at == "sense" else 0)
        if self.at == "shape" and view.tick[0, 0] >= STEP:
            return [1.0, 2.0], {}
        return np.full((view.rows, 2), np.nan if self.at == "nan" and view.tick[0, 0] >= STEP else np.inf), {}

    def actuate(self, command, dt, state, draws):
        fail(STEP if self.at == "actuate" else 0)


@attrs.frozen(kw_only=True)
class BadEmitter(Sensor):
    unit: ClassVar[str] = "m"
    medium: ClassVar[str] = "ultrasound"

    def size(self, drive):
        return 1

    def sense(self, view, aim, state, draws):
        return np.zeros((view.rows, 1)), {}

    def emit(self, view, state):
        fail(view.tick)
        rows = view.rows
        return Emission(np.zeros((rows, 1, 3)), np.zeros((rows, 1)), np.zeros((rows, 1), dtype=bool))


@attrs.frozen(kw_only=True)
class BadNoise(Noise):
    def start(self, context):
        return {"ticks": np.zeros((context.rows, 1))}

    def corrupt(self, values, side, elapsed, state, draws):
        state["ticks"] = state["ticks"] + (elapsed > 0.0)
        fail(state["ticks"])
        return values


@attrs.frozen(kw_only=True)
class BadAim(BadNoise):
    def aim(self, aim, elapsed, state, draws):
        return fail(STEP)


@attrs.frozen(kw_only=True)
class BadDelay(BadNoise):
    def delay(self, elapsed, state, draws):
        return fail(STEP)

    def longest_delay(self):
        return np.full((1, 1), 0.1)


@attrs.frozen(kw_only=True)
class NanNoise(BadNoise):
    def corrupt(self, values, side, elapsed, state, draws):
        return values * np.nan


@attrs.frozen(kw_only=True)
class BadDrive(Differential):
    at: str = am.parameter("advance", help="the method that fails", static=True)

    def advance(self, joints, rates, command, dt, state, draws):
        fail(STEP if self.at == "advance" else 0)
        return super().advance(joints, rates, command, dt, state, draws)

    def twist(self, before, after):
        fail(STEP if self.at == "twist" else 0)
        found = super().twist(before, after)
        return found * np.nan if self.at == "nan" else found

    def travel(self, before, after):
        fail(STEP if self.at == "travel" else 0)
        return super().travel(before, after)

    def rolling_radius(self):
        fail(STEP if self.at == "rolling_radius" else 0)
        return super().rolling_radius()

    def displacement(self, before, after, fraction):
        return super().displacement(before, after, fraction)


@attrs.frozen(kw_only=True)
class BadController(Controller):
    answer: float = am.parameter(0.0, help="what it commands")

    def command(self, robot, readings, estimate, clock, state, draws):
        fail(clock.tick)
        return np.full((robot.rows, 2), 1.0)


@attrs.frozen(kw_only=True)
class BadMotion(Motion):
    at: str = am.parameter("propose", help="the method that fails", static=True)

    def start(self, context):
        fail(STEP if self.at == "start" else 0)
        return {}

    def propose(self, view, dt, state, draws):
        fail(view.tick if self.at == "propose" else 0)
        return np.full((view.rows, 3), np.nan if view.tick[0, 0] >= STEP else 0.0)


def simulate(*robots, **changes):
    simulation = am.Simulation(building.scenario(*robots, dt=0.1, **changes))
    simulation.run(1.0)


def error_of(*robots, **changes):
    with pytest.raises(am.AmorsimError) as caught:
        simulate(*robots, **changes)
    return caught.value


def with_sensor(sensor, *noise, name="eye"):
    return building.robot(
        sensors={
            "encoder": building.encoder(),
            name: MountedSensor(sensor=sensor, noise=tuple(NoiseElement(name="odd", noise=one) for one in noise)),
        }
    )


CASES = [
    (lambda: building.robot(estimators={"mine": BadEstimator()}), "estimator 'mine' (BadEstimator)", 0.3, "fail("),
    (lambda: building.robot(estimators={"mine": BadStart()}), "estimator 'mine' (BadStart)", 0.0, "cannot begin"),
    (lambda: with_sensor(BadSensor()), "sensor 'eye' (BadSensor)", 0.3, "fail(view.tick"),
    (lambda: with_sensor(BadSensor(at="start")), "sensor 'eye' (BadSensor)", 0.0, "in start"),
    (lambda: with_sensor(BadSensor(at="actuate")), "sensor 'eye' (BadSensor)", 0.0, "in actuate"),
    (lambda: with_sensor(BadEmitter()), "sensor 'eye' (BadEmitter)", 0.3, "in emit"),
    (
        lambda: with_sensor(building.ring(), BadNoise()),
        "noise element 'odd' of sensor 'eye' (BadNoise)",
        0.3,
        "corrupt",
    ),
    (lambda: with_sensor(building.ring(), BadAim()), "noise element 'odd' of sensor 'eye' (BadAim)", 0.0, "in aim"),
    (lambda: with_sensor(building.ring(), BadDelay()), "noise element 'odd' of sensor 'eye' (BadDelay)", 0.0, "delay"),
    (
        lambda: building.robot(ground=(NoiseElement(name="odd", noise=BadNoise()),)),
        "noise element 'odd' of ground (BadNoise)",
        0.2,
        "in corrupt",
    ),
    *(
        (
            lambda at=at: building.robot(
                estimators={},
                drive=BadDrive(wheel_radius_left=0.1, wheel_radius_right=0.1, track=0.3, rate_max=9.0, at=at),
            ),
            "drive (BadDrive)",
            0.0,
            f"in {at}",
        )
        for at in ("advance", "twist", "rolling_radius")
    ),
]


@pytest.mark.parametrize(("make", "who", "time", "line"), CASES)
def test_what_a_component_raises_names_robot_component_and_time(make, who, time, line):
    error = error_of(make())
    assert isinstance(error, ComponentError)
    assert str(error).startswith(f"{who} of robot 'rover' at {time:g} s raised ")
    assert line in explain(error)
    assert "test_failures.py" in explain(error)
    assert "site-packages/numpy" not in explain(error)


def test_a_size_that_raises_names_robot_and_sensor():
    error = error_of(with_sensor(BadSensor(at="size")))
    assert "sensor 'eye' (BadSensor) of robot 'rover': size() raised KeyError" in str(error)


@pytest.mark.parametrize(
    ("method", "answer", "shape"),
    [
        ("rolling_radius", None, "(1, 2) from rolling_radius(), got a NoneType"),
        ("twist", None, "(1, 3) from twist(), got a NoneType"),
        ("twist", np.zeros((1, 2)), "(1, 3) from twist(), got the shape (1, 2)"),
        ("displacement", None, "(1, 3) from displacement(), got a NoneType"),
        ("command_for", None, "(1, 2) from command_for(), got a NoneType"),
    ],
)
def test_a_drives_wrong_answer_is_said_of_the_drive(monkeypatch, method, answer, shape):
    monkeypatch.setattr(BadDrive, method, lambda self, *_: answer)
    drive = BadDrive(wheel_radius_left=0.1, wheel_radius_right=0.1, track=0.3, rate_max=20.0, at="")
    error = error_of(building.robot(drive=drive))
    assert str(error) == f"drive (BadDrive) of robot 'rover' at 0 s: expected numbers of the shape {shape}"


@pytest.mark.parametrize(
    ("columns", "words"),
    [
        (lambda self: {}["range"], "columns() raised KeyError: 'range'"),
        (lambda self: None, "columns(): expected a dict of names and units, as in {'range': 'm'}, got None"),
        (
            lambda self: ["a", "b"],
            "columns(): expected a dict of names and units, as in {'range': 'm'}, got ['a', 'b']",
        ),
        (lambda self: {"a, b": "m"}, "columns(): expected names in one line, without commas, got 'a, b'"),
        (lambda self: {"a": "m\n"}, "columns(): expected the unit of 'a' in one line, without commas, got 'm\\n'"),
        (lambda self: dict.fromkeys("abc", "m"), "divides the 2 values of a reading, got 3: 'a', 'b', 'c'"),
    ],
)
def test_wrong_columns_name_robot_and_sensor(monkeypatch, columns, words):
    monkeypatch.setattr(BadSensor, "columns", columns)
    for noise in ((), (am.noise.Gaussian(std=0.1),)):
        error = error_of(with_sensor(BadSensor(at=""), *noise))
        assert str(error).startswith("sensor 'eye' (BadSensor) of robot 'rover': columns()")
        assert words in str(error)


def test_a_plugins_controller_is_named_like_a_users():
    error = error_of(building.robot(controller=BadController()))
    assert isinstance(error, ControllerError)
    assert error.robot == "rover"
    assert str(error) == "controller (BadController) of robot 'rover' at 0.3 s raised KeyError: 'no such key'"


def obstacle(**changes):
    return Obstacle(name="cat", shape=Shape.circle(0.1), pose=am.Pose(x=4.0, y=4.0), motion=BadMotion(**changes))


def test_a_motion_is_named_with_its_obstacle():
    error = error_of(obstacles=(obstacle(),))
    assert str(error).startswith("motion (BadMotion) of obstacle 'cat' at 0.3 s raised KeyError")
    error = error_of(obstacles=(obstacle(at="start"),))
    assert str(error).startswith("motion (BadMotion) of obstacle 'cat' at 0 s raised KeyError")
    error = error_of(obstacles=(obstacle(at=""),))
    assert "motion (BadMotion) of obstacle 'cat' at tick 3 (0.3 s): expected finite" in str(error)


def test_of_many_robots_some_are_named():
    robots = [
        building.robot(name=f"r{i}", estimators={"mine": BadEstimator()}, pose=am.Pose(x=1.0 + i, y=1.0))
        for i in range(5)
    ]
    assert "of robots 'r0', 'r1', 'r2' and 2 more at 0.3 s" in str(error_of(*robots))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: with_sensor(BadSensor(at="nan")),
            "sensor 'eye' (BadSensor) of robot 'rover' at tick 3 (0.3 s): .*nan",
        ),
        (lambda: with_sensor(BadSensor(at="shape")), "at 0.3 s: expected values of the shape (1, 2).* a list"),
        (
            lambda: with_sensor(BadSensor(at=""), NanNoise()),
            "sensor 'eye' (BadSensor) of robot 'rover' at tick 0 (0 s): .*its chain of noise (odd).*nan",
        ),
    ],
)
def test_a_reading_that_is_no_number_ends_the_run(make, message):
    pattern = re.escape(message).replace(r"\.\*", ".*")
    assert re.search(pattern, str(error_of(make())))


@attrs.frozen(kw_only=True)
class OddNumbers(Noise, Estimator):
    """Returns numbers of another type than the engine's."""

    dtype: str = am.parameter("int64", help="of what it returns", static=True)

    def corrupt(self, values, side, elapsed, state, draws):
        return np.zeros_like(values, dtype=self.dtype)

    def update(self, robot, readings, command, elapsed, state, draws):
        return Estimate(np.zeros((robot.rows, 3), dtype=self.dtype), np.zeros((robot.rows, 3, 3)))


@attrs.frozen(kw_only=True)
class OddMotion(Motion):
    def propose(self, view, dt, state, draws):
        return np.zeros((view.rows, 3), dtype=np.float32)


@attrs.frozen(kw_only=True)
class OddCommand(Controller):
    dtype: str = am.parameter("int64", help="of what it returns", static=True)

    def command(self, robot, readings, estimate, clock, state, draws):
        return np.zeros((robot.rows, 2), dtype=self.dtype)


@pytest.mark.parametrize("dtype", ["int64", "float32", "object", "U3"])
def test_numbers_of_another_type_are_refused_and_not_left_to_the_kernels(dtype):
    odd = OddNumbers(dtype=dtype)
    says = rf"of the type float64.*, got .*{'<U3' if dtype == 'U3' else dtype}; .astype\(np.float64\) makes it so"
    for robot in (with_sensor(BadSensor(at=""), odd), building.robot(estimators={"mine": odd})):
        assert re.search(says, str(error_of(robot)))


def test_displacements_of_another_type_are_refused():
    cat = Obstacle(name="cat", shape=Shape.circle(0.1), pose=am.Pose(x=4.0, y=4.0), motion=OddMotion())
    assert "expected displacements of the type float64, got float32" in str(error_of(obstacles=(cat,)))


def test_a_command_is_of_numbers_of_any_type():
    simulate(building.robot(controller=OddCommand(dtype="int64")))
    message = str(error_of(building.robot(controller=OddCommand(dtype="U3"))))
    assert "expected a command of the shape (1, 2), got a <U3 array" in message


def test_a_reading_may_be_inf():
    simulate(with_sensor(BadSensor(at="")))


@attrs.frozen(kw_only=True)
class Lost(Estimator):
    def update(self, robot, readings, command, elapsed, state, draws):
        pose = np.zeros((robot.rows, 3))
        pose[1, 2] = np.nan
        return Estimate(pose, np.zeros((robot.rows, 3, 3)))


@attrs.frozen(kw_only=True)
class Exploded(Estimator):
    value: float = math.nan

    def update(self, robot, readings, command, elapsed, state, draws):
        covariance = np.zeros((robot.rows, 3, 3))
        covariance[0, 2, 2] = self.value[0, 0]
        return Estimate(np.zeros((robot.rows, 3)), covariance)


@attrs.frozen(kw_only=True)
class Nothing(Estimator):
    def update(self, robot, readings, command, elapsed, state, draws):
        return None


def test_an_estimate_that_is_not_finite_names_the_row():
    robots = [
        building.robot(name=name, estimators={"mine": Lost()}, pose=am.Pose(x=x, y=1.0))
        for name, x in (("a", 1.0), ("b", 3.0))
    ]
    assert str(error_of(*robots)) == (
        "estimator 'mine' (Lost) of robot 'b' at tick 0 (0 s): expected finite numbers for the estimated pose, got "
        "[0.0, 0.0, nan]"
    )
    with pytest.raises(ComponentError, match=r"expected an Estimate\(pose, covariance\), got a NoneType"):
        am.Simulation(building.scenario(building.robot(estimators={"mine": Nothing()})))


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_a_covariance_that_is_not_finite_names_the_row(value):
    message = str(error_of(building.robot(estimators={"mine": Exploded(value=value)})))
    assert message == (
        "estimator 'mine' (Exploded) of robot 'rover' at tick 0 (0 s): expected finite numbers for the covariance, got "
        f"[[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, {value}]]"
    )


def test_a_path_that_is_not_finite_ends_the_run():
    drive = BadDrive(wheel_radius_left=0.1, wheel_radius_right=0.1, track=0.3, rate_max=9.0, at="nan")
    assert re.match(
        r"drive \(BadDrive\) of robot 'rover' at tick 0 \(0 s\): expected finite numbers for the displacement",
        str(error_of(building.robot(estimators={}, drive=drive))),
    )


CHOOSY = "there is nothing to go by; name a sensor"


def choosy(self, context):
    raise ComponentError(CHOOSY)


@attrs.frozen(kw_only=True)
class Choosy(BadEstimator):
    start = choosy


@attrs.frozen(kw_only=True)
class ChoosyController(OddCommand):
    start = choosy


@attrs.frozen(kw_only=True)
class ChoosySensor(BadSensor):
    start = choosy


@attrs.frozen(kw_only=True)
class ChoosyNoise(BadNoise):
    start = choosy


@pytest.mark.parametrize(
    ("make", "whose"),
    [
        (lambda: building.robot(estimators={"mine": Choosy()}), "estimator 'mine'"),
        (lambda: building.robot(controller=ChoosyController()), "controller"),
        (lambda: with_sensor(ChoosySensor()), "sensor 'eye'"),
        (lambda: with_sensor(building.ring(), ChoosyNoise()), "noise element 'odd' of sensor 'eye'"),
    ],
)
def test_what_a_component_refuses_at_the_start_is_reported_with_whose_it_is(make, whose):
    assert str(error_of(make())) == f"robot 'rover', {whose}: {CHOOSY}"
