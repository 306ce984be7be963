import math

import numpy as np
import pytest

import amorsim as am
from amorsim.contracts import Clock, Context, Draws, Estimate, Measurement, RobotModel
from amorsim.controllers import Twist, UserController, WheelSpeeds
from amorsim.core.errors import ControllerError
from amorsim.core.rows import stack
from amorsim.core.shapes import Shape
from amorsim.drives import Differential


def make_robot(rows, devices=()):
    drives = [
        Differential(wheel_radius_left=0.08 + 0.01 * i, wheel_radius_right=0.1, track=0.4, rate_max=20.0)
        for i in range(rows)
    ]
    channels = drives[0].channels
    return RobotModel(
        rows=rows, dt=0.1, drive=stack(drives), shape=Shape.circle(0.2), sensors={}, channels=(*channels, *devices)
    )


class Runner:
    """A user's controller over rows, with a reading of each row's own."""

    def __init__(self, function, rows=1, source="mine.py:go", **options):
        self.rows = rows
        self.robot = make_robot(rows)
        self.controller = stack(
            [UserController(source=source, function=function, options=tuple(options.items()))] * rows
        )
        context = Context(rows=rows, dt=0.1, robot=self.robot, pose=np.zeros((rows, 3)))
        self.state = dict(self.controller.start(context))
        self.readings = {
            "laser": Measurement(
                measured=np.arange(3.0 * rows).reshape(rows, 3),
                stamp=np.full((rows, 1), 4, dtype=np.int64),
                age=np.full((rows, 1), 0.1),
                fresh=np.arange(rows).reshape(-1, 1) == 0,
            )
        }
        self.estimate = Estimate(
            pose=np.array([[1.0 + i, 2.0, 0.5] for i in range(rows)]), covariance=np.tile(np.eye(3), (rows, 1, 1))
        )

    def command(self):
        tick = np.full((self.rows, 1), 5, dtype=np.int64)
        draws = Draws(np.zeros(self.rows, dtype=np.uint64), np.zeros((self.rows, 3), dtype=np.uint32))
        clock = Clock(tick=tick, time=tick * 0.1, dt=0.1)
        return self.controller.command(self.robot, self.readings, self.estimate, clock, self.state, draws)


def test_a_function_sees_one_robot():
    seen = []

    def go(readings, estimate, clock, gain=1.0):
        reading = readings["laser"]
        seen.append((reading.measured.tolist(), reading.stamp, reading.age, reading.fresh))
        seen.append((estimate.x, estimate.pose.y, estimate.heading, estimate.pose.shape, estimate.covariance.shape))
        seen.append((clock.tick, clock.time, clock.dt, gain))
        return (reading.measured[0], estimate.x)

    assert Runner(go, rows=2, gain=3.0).command().tolist() == [[0.0, 1.0], [3.0, 2.0]]
    assert seen[:3] == [([0.0, 1.0, 2.0], 4, 0.1, True), (1.0, 2.0, 0.5, (3,), (3, 3)), (5, 0.5, 0.1, 3.0)]
    assert seen[3:] == [([3.0, 4.0, 5.0], 4, 0.1, False), (2.0, 2.0, 0.5, (3,), (3, 3)), (5, 0.5, 0.1, 3.0)]
    assert type(seen[0][3]) is bool


def test_what_it_sees_is_its_own_to_change():
    def spoil(readings, estimate, clock):
        readings["laser"].measured[:] = -1.0
        estimate.pose[:] = -1.0
        estimate.covariance[:] = -1.0

    runner = Runner(spoil)
    runner.command()
    assert runner.readings["laser"].measured.min() == 0.0
    assert runner.estimate.pose.min() == 0.5
    assert runner.estimate.covariance.min() == 0.0


def test_what_it_sees_is_a_reading_of_each_sensor_and_the_same_at_each_look():
    seen = []

    def look(readings, estimate, clock):
        readings["laser"].measured[0] = 7.0
        seen.append((dict(readings), readings["laser"].measured[0], len(readings), "lazer" in readings))

    runner = Runner(look)
    runner.command()
    for held, first, count, has_lazer in seen:
        assert held.keys() == runner.readings.keys()
        assert (first, count, has_lazer) == (7.0, len(runner.readings), False)


def test_readings_are_printed_as_the_readings_that_they_are():
    printed = []
    runner = Runner(lambda readings, estimate, clock: printed.append((repr(readings), repr(dict(readings)))))
    runner.command()
    ((words, of_a_dict),) = printed
    assert words == of_a_dict
    assert words.startswith("{'laser': RobotReading(measured=")


def test_readings_that_it_keeps_stay_those_of_their_step():
    kept = []

    def keep(readings, estimate, clock):
        kept.append(readings)

    robot = am.load_robot("pioneer2dx", controller=keep, pose=am.Pose(x=2.0, y=2.0))
    cells = np.zeros((80, 80), dtype=bool)
    cells[[0, -1]] = cells[:, [0, -1]] = True
    simulation = am.Simulation(am.Scenario(map=am.Map.from_array(cells, resolution=0.05), robots=[robot]))
    logged = []
    for _ in range(3):
        logged.append(simulation.readings["gyro"].measured[0].copy())
        simulation.step()
    assert [readings["gyro"].stamp for readings in kept] == [0, 1, 2]
    assert [readings["gyro"].measured.tolist() for readings in kept] == [row.tolist() for row in logged]
    assert len({readings["gyro"].measured.item() for readings in kept}) == 3


@pytest.mark.parametrize(
    ("answer", "expected"),
    [
        (None, [0.0, 0.0]),
        (Twist(0.4, 0.5), [(0.4 - 0.1) / 0.08, (0.4 + 0.1) / 0.1]),
        (Twist(turn=1.0), [-0.2 / 0.08, 0.2 / 0.1]),
        (WheelSpeeds(0.4, -0.2), [0.4 / 0.08, -0.2 / 0.1]),
        ((1.0, 2), [1.0, 2.0]),
        (np.array([3.0, 4.0]), [3.0, 4.0]),
        ({"right": 2.0}, [0.0, 2.0]),
        ({"right": np.float64(2.0), "left": 1}, [1.0, 2.0]),
    ],
)
def test_answers_are_commands(answer, expected):
    np.testing.assert_allclose(Runner(lambda *_: answer).command(), [expected], rtol=1e-14)


def test_rows_may_answer_in_their_own_ways():
    answers = iter([Twist(0.4), None, WheelSpeeds(0.1, 0.2), (5.0, 6.0)])
    command = Runner(lambda *_: next(answers), rows=4).command()
    np.testing.assert_allclose(command, [[5.0, 4.0], [0.0, 0.0], [1.0, 2.0], [5.0, 6.0]], rtol=1e-14)


def test_devices_that_take_commands_have_channels_after_the_drives():
    answers = iter([Twist(0.4), (1.0, 2.0), (1.0, 2.0, 3.0), {"camera.pan": 0.5, "left": 1.0}])
    runner = Runner(lambda *_: next(answers), rows=4)
    runner.robot = make_robot(4, devices=("camera.pan",))
    expected = [[5.0, 4.0, 0.0], [1.0, 2.0, 0.0], [1.0, 2.0, 3.0], [1.0, 0.0, 0.5]]
    np.testing.assert_allclose(runner.command(), expected, rtol=1e-14)


class Counter:
    def __init__(self, first=0.0):
        self.count = first

    def command(self, readings, estimate, clock):
        self.count += 1.0
        return self.count, estimate.x


def test_each_row_has_an_object_of_its_own():
    runner = Runner(Counter, rows=3, first=10.0)
    assert runner.state["objects"].shape == (3,)
    assert len({id(thing) for thing in runner.state["objects"]}) == 3
    runner.command()
    assert runner.command().tolist() == [[12.0, 1.0], [12.0, 2.0], [12.0, 3.0]]
    runner.state["objects"][1] = Counter(first=0.0)  # as a restored snapshot does
    assert runner.command()[:, 0].tolist() == [13.0, 1.0, 13.0]


@pytest.mark.parametrize(
    ("answer", "problem"),
    [
        ((1.0,), "there are 2 channels"),
        ([[1.0, 2.0]], "there are 2 channels"),
        ((1.0, math.nan), "nan is not finite"),
        (Twist(math.inf, 0.0), "inf is not finite"),
        (Twist("fast"), "'fast' is not a number"),
        ((True, 1.0), "True is not a number"),
        ({"middle": 1.0}, "no channel 'middle'"),
        (3.0, "a float is not a command"),
        ("go", "a str is not a command"),
    ],
)
def test_what_is_no_command_is_refused_with_what_would_be(answer, problem):
    runner = Runner(lambda *_: answer, rows=2)
    with pytest.raises(ControllerError) as caught:
        runner.command()
    message = str(caught.value)
    assert "'mine.py:go' of row 0 returned" in message
    assert problem in message
    assert "am.Twist(forward, turn)" in message
    assert "(left, right)" in message


def test_what_a_function_raises_is_reported_with_its_traceback():
    def fails_hard(readings, estimate, clock):
        return readings["lidar"]

    runner = Runner(fails_hard)
    with pytest.raises(ControllerError, match=r"'mine.py:go' of row 0 at 0.5 s raised KeyError: ") as caught:
        runner.command()
    assert "no sensor 'lidar'; did you mean 'laser'?" in str(caught.value)
    assert isinstance(caught.value.__cause__, KeyError)
    assert caught.value.__cause__.__traceback__ is not None


def test_a_function_of_a_script_is_called_by_its_own_name_in_messages():
    def swerve(readings, estimate, clock):
        return 1 / 0

    class Lost:
        pass

    for function, message in (
        (swerve, "'swerve' of row 0 at 0.5 s raised Zero"),
        (lambda *_: 3, "'<lambda>' of row 0"),
    ):
        runner = Runner(function, source="")
        with pytest.raises(ControllerError, match=f"^controller {message}"):
            runner.command()
    with pytest.raises(ControllerError, match=r"^controller 'Lost': the class Lost has no method"):
        Runner(Lost, source="")


def test_a_function_that_leaves_python_is_reported_as_well():
    def leaves(readings, estimate, clock):
        raise SystemExit(3)

    with pytest.raises(ControllerError, match=r"'mine.py:go' of row 0 at 0.5 s raised SystemExit: 3"):
        Runner(leaves).command()


class Needy:
    def __init__(self, gain):
        self.gain = gain

    def command(self, readings, estimate, clock):
        return None


class Mute:
    pass


@pytest.mark.parametrize(
    ("function", "problem"),
    [
        (Needy, "raised TypeError"),
        (Mute, "the class Mute has no method command"),
        ("go", "expected a function or a class, got 'go'"),
    ],
)
def test_a_class_that_cannot_drive_is_refused_at_the_start(function, problem):
    with pytest.raises(ControllerError, match=problem):
        Runner(function)
