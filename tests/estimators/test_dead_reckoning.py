import math

import attrs
import numpy as np
import pytest

from amorsim.contracts import Context, Draws, Measurement, Mount, RobotModel, SensorModel
from amorsim.core.errors import ComponentError
from amorsim.core.poses import compose, wrap_angle
from amorsim.core.rows import stack
from amorsim.core.shapes import Shape
from amorsim.drives import Differential
from amorsim.estimators import DeadReckoning
from amorsim.sensors import Encoder, Gyro

TRACK = 0.32
COUNTS = 39400.0


def make_drive(**changes):
    given = {"wheel_radius_left": 0.08, "wheel_radius_right": 0.08, "track": TRACK, "rate_max": 20.0}
    return Differential(**(given | changes))


def make_robot(drives, sensors=None):
    encoder = stack([Encoder(counts_per_revolution=COUNTS)] * len(drives))
    sensors = {"encoder": encoder} if sensors is None else sensors
    return RobotModel(
        rows=len(drives),
        dt=0.1,
        drive=stack(drives),
        channels=drives[0].channels,
        shape=Shape.circle(0.2),
        sensors={
            name: SensorModel(name=name, sensor=sensor, mount=stack([Mount()] * len(drives)), size=2, rate=None)
            for name, sensor in sensors.items()
        },
    )


class Reckoner:
    """Dead reckoning over rows, given joints [rad] as the engine gives counts."""

    def __init__(self, drives, start=None, variance=0.0, rows=None):
        rows = len(drives)
        self.robot = make_robot(drives)
        self.estimator = stack([DeadReckoning(wheel_variance=variance)] * rows)
        start = np.zeros((rows, 3)) if start is None else start
        self.state = dict(self.estimator.start(Context(rows=rows, dt=0.1, robot=self.robot, pose=start)))
        self.draws = Draws(np.zeros(rows, dtype=np.uint64), np.zeros((rows, 3), dtype=np.uint32))

    def tell(self, joints):
        rows = self.robot.rows
        reading = Measurement(
            measured=np.asarray(joints, dtype=float) / (2.0 * math.pi) * COUNTS,
            stamp=np.zeros((rows, 1), dtype=np.int64),
            age=np.zeros((rows, 1)),
            fresh=np.ones((rows, 1), dtype=bool),
        )
        return self.estimator.update(
            self.robot, {"encoder": reading}, np.zeros((rows, 2)), np.full((rows, 1), 0.1), self.state, self.draws
        )

    def follow(self, end, steps):
        """The estimate after `steps` equal steps from joints of 0 to `end` (2,)."""
        for share in np.linspace(0.0, 1.0, steps + 1):
            estimate = self.tell(np.tile(np.array(end) * share, (self.robot.rows, 1)))
        return estimate


def test_it_goes_where_the_wheels_went():
    rng = np.random.default_rng(8)
    drives = [make_drive(wheel_radius_left=0.08 + 0.001 * i, track=0.3 + 0.02 * i) for i in range(20)]
    start = rng.normal(size=(20, 3))
    reckoner, true_drive = Reckoner(drives, start), stack(drives)
    joints, true = rng.normal(size=(20, 2)) * 100.0, start
    estimate = reckoner.tell(joints)
    np.testing.assert_array_equal(estimate.pose, start)
    for _ in range(500):
        after = joints + rng.normal(size=(20, 2)) * 2.0
        true = compose(true, true_drive.displacement(joints, after, np.ones((20, 1))))
        joints = after
        estimate = reckoner.tell(joints)
    np.testing.assert_allclose(estimate.pose[:, :2], true[:, :2], atol=1e-9)
    assert np.abs(wrap_angle(estimate.pose[:, 2] - true[:, 2])).max() < 1e-11


@pytest.mark.parametrize("steps", [1, 2, 7, 400])
def test_on_a_straight_line_the_covariance_is_the_closed_form(steps):
    k, length = 1e-5, 10.0
    q = 2.0 * k / TRACK**2
    covariance = Reckoner([make_drive()], variance=k).follow([length / 0.08] * 2, steps).covariance[0]
    expected = [
        [k * length / 2.0, 0.0, 0.0],
        [0.0, q * length**3 / 3.0, q * length**2 / 2.0],
        [0.0, q * length**2 / 2.0, q * length],
    ]
    np.testing.assert_allclose(covariance, expected, rtol=1e-12, atol=1e-18)


def test_the_covariance_lies_along_the_heading():
    start = np.array([[1.0, 2.0, 0.7]])
    turned = Reckoner([make_drive()], start, variance=1e-5).follow([50.0, 50.0], 9).covariance[0]
    plain = Reckoner([make_drive()], variance=1e-5).follow([50.0, 50.0], 9).covariance[0]
    c, s = math.cos(0.7), math.sin(0.7)
    rotation = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    np.testing.assert_allclose(turned, rotation @ plain @ rotation.T, rtol=1e-12)
    np.testing.assert_array_equal(turned, turned.T)


def test_turning_in_place_makes_the_heading_doubtful():
    k, turn = 1e-5, 3.0
    arc = 0.5 * TRACK * turn / 0.08
    covariance = Reckoner([make_drive()], variance=k).follow([-arc, arc], 5).covariance[0]
    assert covariance[2, 2] == pytest.approx(k * turn / TRACK, rel=1e-12)


def test_the_covariance_on_an_arc_does_not_depend_on_the_number_of_steps():
    few = Reckoner([make_drive()], variance=1e-5).follow([40.0, 46.0], 3).covariance
    many = Reckoner([make_drive()], variance=1e-5).follow([40.0, 46.0], 300).covariance
    np.testing.assert_allclose(few, many, rtol=1e-8)


def test_wheels_with_that_noise_spread_as_the_covariance_says():
    rows, steps, k = 20_000, 40, 1e-6
    rng = np.random.default_rng(9)
    drive = stack([make_drive()] * rows)
    travel = np.array([3.0, 3.9]) / steps  # [m], an arc of 2.8 rad
    pose, one = np.zeros((rows, 3)), np.ones((rows, 1))
    for _ in range(steps):
        noisy = travel + rng.normal(size=(rows, 2)) * np.sqrt(k * travel)
        pose = compose(pose, drive.displacement(np.zeros((rows, 2)), noisy / 0.08, one))
    spread = np.cov(pose.T)
    expected = Reckoner([make_drive()], variance=k).follow([3.0 / 0.08, 3.9 / 0.08], 5).covariance[0]
    # The standard deviation of a covariance of n normal pairs, and lumped instead of spread noise: under 1/steps**2.
    bound = np.sqrt((expected**2 + np.outer(expected.diagonal(), expected.diagonal())) / rows)
    assert (np.abs(spread - expected) < 5.0 * bound + np.abs(expected) / steps**2).all()


class Plain(Differential):
    """A differential drive that offers no Jacobian."""

    jacobian = None


def test_a_drive_without_a_jacobian_is_turned_a_little():
    parameters = attrs.asdict(make_drive(wheel_radius_right=0.085))
    analytic = Reckoner([Differential(**parameters)], variance=1e-5).follow([30.0, 20.0], 20)
    numeric = Reckoner([Plain(**parameters)], variance=1e-5).follow([30.0, 20.0], 20)
    np.testing.assert_array_equal(numeric.pose, analytic.pose)
    np.testing.assert_allclose(numeric.covariance, analytic.covariance, rtol=1e-7)


def test_an_old_reading_moves_nothing():
    reckoner = Reckoner([make_drive()], variance=1e-5)
    reckoner.tell([[0.0, 0.0]])
    moved = reckoner.tell([[3.0, 4.0]])
    again = reckoner.tell([[3.0, 4.0]])
    assert again.pose.tobytes() == moved.pose.tobytes()
    assert again.covariance.tobytes() == moved.covariance.tobytes()


def test_rows_do_not_touch_one_another():
    rng = np.random.default_rng(10)
    drives = [make_drive(wheel_radius_right=0.08 + 0.0003 * i, track=0.3 + 0.01 * i) for i in range(64)]
    start, path = rng.normal(size=(64, 3)), np.cumsum(rng.normal(size=(5, 64, 2)), axis=0)
    together = Reckoner(drives, start, variance=1e-4)
    estimates = [together.tell(joints) for joints in path]
    for i, drive in enumerate(drives):
        alone = Reckoner([drive], start[i : i + 1], variance=1e-4)
        for joints, estimate in zip(path, estimates, strict=True):
            own = alone.tell(joints[i : i + 1])
            assert own.pose.tobytes() == estimate.pose[i : i + 1].tobytes()
            assert own.covariance.tobytes() == estimate.covariance[i : i + 1].tobytes()


def test_a_robot_without_the_encoder_gets_a_message_with_what_it_has():
    robot = make_robot([make_drive()])
    context = Context(rows=1, dt=0.1, robot=robot, pose=np.zeros((1, 3)))
    with pytest.raises(ComponentError, match=r"'encoders'.*its sensors: 'encoder'.*Did you mean 'encoder'\?"):
        stack([DeadReckoning(encoder="encoders")]).start(context)


def test_a_sensor_that_counts_no_joints_is_refused():
    robot = make_robot([make_drive()], {"encoder": stack([Gyro()])})
    context = Context(rows=1, dt=0.1, robot=robot, pose=np.zeros((1, 3)))
    with pytest.raises(ComponentError, match="a Gyro counts no joints"):
        stack([DeadReckoning()]).start(context)
