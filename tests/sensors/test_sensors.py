import math

import numpy as np
import pytest

from amorsim.contracts import Aim, Draws, Mount
from amorsim.core.parameters import ParameterError
from amorsim.core.poses import compose
from amorsim.core.rows import stack
from amorsim.drives import Synchro
from amorsim.sensors import Compass, Encoder, Gyro, Laser, Sonar

NO_DRAWS = Draws(np.zeros(1, dtype=np.uint64), np.zeros((1, 3), dtype=np.uint32))


class FakeView:
    """A world that notes what it was asked, and in which every ray goes 2 m, less a bit for each."""

    def __init__(self, pose, twist=(0.0, 0.0, 0.0), joints=(0.0, 0.0)):
        self.pose = np.atleast_2d(np.array(pose, dtype=float))
        self.rows = len(self.pose)
        self.twist = np.broadcast_to(np.array(twist, dtype=float), (self.rows, 3)).copy()
        self.joints = np.broadcast_to(np.array(joints, dtype=float), (self.rows, len(joints))).copy()
        self.asked = None

    def cast(self, origins, bearings, range_max, traversal="exact"):
        self.asked = origins, bearings, range_max
        out = 2.0 - 0.01 * np.cos(origins[:, 2:] + bearings)
        return np.where(out > range_max, np.inf, out)

    def cone(self, origins, half_angle, range_max, traversal="exact"):
        self.asked = origins, half_angle, range_max
        out = (2.0 - 0.01 * np.cos(origins[:, 2])).reshape(self.rows, -1)
        out[:, 0] = 0.01
        return np.where(out > range_max, np.inf, out)


def sense(sensor, view, aim=Aim()):  # noqa: B008 - frozen
    return sensor.sense(view, aim, {}, NO_DRAWS)[0]


def test_an_encoder_counts_turns():
    values = sense(stack([Encoder(counts_per_revolution=500.0)]), FakeView([0, 0, 0], joints=(2 * math.pi, -math.pi)))
    np.testing.assert_allclose(values, [[500.0, -250.0]], rtol=1e-15)


def test_the_joints_come_back_from_the_counts():
    encoder = stack([Encoder(counts_per_revolution=39400.0)])
    joints = np.random.default_rng(1).uniform(-1e5, 1e5, 200)
    view = FakeView([0, 0, 0], joints=joints)
    np.testing.assert_allclose(encoder.angles(sense(encoder, view)), joints[None], rtol=1e-15)


def test_joints_may_be_counted_each_by_a_figure_of_its_own():
    encoder = stack([Encoder(counts_per_revolution=(500.0, 7200.0)), Encoder(counts_per_revolution=(100.0, 1.0))])
    joints = np.array([[2 * math.pi, -math.pi], [math.pi, 6 * math.pi]])
    view = FakeView(np.zeros((2, 3)), joints=(0.0, 0.0))
    view.joints = joints
    values = sense(encoder, view)
    np.testing.assert_allclose(values, [[500.0, -3600.0], [50.0, 3.0]], rtol=1e-15)
    np.testing.assert_allclose(encoder.angles(values), joints, rtol=1e-15)


def test_counts_for_another_number_of_joints_are_refused():
    drive = Synchro(wheel_radius=0.05, rate_max=1.0, steering_rate_max=1.0)
    assert Encoder(counts_per_revolution=(3.0, 4.0)).size(drive) == 2
    for counts in ((1.0, 2.0, 3.0), ()):
        with pytest.raises(ParameterError, match=r"2 joints \(steering, wheels\), got [30]"):
            Encoder(counts_per_revolution=counts).size(drive)
    with pytest.raises(ParameterError, match="counts_per_revolution"):
        Encoder(counts_per_revolution=(1.0, 0.0))


@pytest.mark.parametrize(
    ("beams", "fov", "expected"),
    [
        (1, math.pi, [0.0]),
        (2, 1.0, [-0.5, 0.5]),
        (5, math.pi, np.radians([-90.0, -45.0, 0.0, 45.0, 90.0])),
        (4, 2 * math.pi, np.radians([-180.0, -90.0, 0.0, 90.0])),
    ],
)
def test_beams_are_spread_evenly_over_the_field_of_view(beams, fov, expected):
    laser = Laser(beams=beams, fov=fov)
    np.testing.assert_allclose(laser.bearings(), [expected], atol=1e-15)
    np.testing.assert_array_equal(stack([laser]).bearings(), laser.bearings())


def test_rows_of_other_fields_of_view_have_other_bearings():
    lasers = [Laser(beams=7, fov=fov) for fov in (1.0, 2.0, 2 * math.pi)]
    bearings = stack(lasers).bearings()
    assert bearings.shape == (3, 7)
    for row, laser in zip(bearings, lasers, strict=True):
        assert row.tobytes() == laser.bearings().tobytes()
    assert stack([lasers[0], lasers[0]]).bearings().shape == (1, 7)  # one table serves them all


def test_a_laser_looks_from_its_mount_and_no_farther_than_its_range():
    laser, view = stack([Laser(beams=3, range_max=1.995)]), FakeView([1.0, 2.0, 0.0])
    values = sense(laser, view)
    np.testing.assert_array_equal(view.asked[0], view.pose)
    assert values.tolist() == [[math.inf, 1.99, math.inf]]


def test_what_is_nearer_to_a_laser_than_range_min_reads_minus_infinity():
    lasers = stack([Laser(beams=3, range_min=near) for near in (0.0, 1.99, 1.995, 2.5)])
    view = FakeView(np.zeros((4, 3)))
    scan = 2.0 - 0.01 * np.cos(lasers.bearings())
    expected = np.where(scan < lasers.range_min, -np.inf, scan)
    np.testing.assert_array_equal(sense(lasers, view), expected)
    assert np.isneginf(expected).sum(axis=1).tolist() == [0, 0, 1, 3]


def test_an_aim_bends_the_beams():
    laser, view = stack([Laser(beams=3)]), FakeView([0.0, 0.0, 0.0])
    sense(laser, view, Aim(bearing=np.array([[0.1, 0.2, -0.3]])))
    np.testing.assert_allclose(view.asked[1], np.add(laser.bearings(), [[0.1, 0.2, -0.3]]), rtol=1e-15)


def test_the_elements_of_a_ring_sit_on_its_mount():
    elements = (Mount(x=0.1, y=0.2, heading=0.5), Mount(x=-0.3, heading=3.0))
    view = FakeView([[1.0, 2.0, 0.7], [-1.0, 0.5, -2.5]])
    sense(stack([Sonar(elements=elements)] * 2), view)
    placed = [[e.x, e.y, e.heading] for e in elements]
    expected = compose(np.repeat(view.pose, 2, axis=0), np.array(placed * 2))
    np.testing.assert_allclose(view.asked[0], expected, atol=1e-15)


def test_an_aim_bends_the_cones():
    ring, view = stack([Sonar(elements=(Mount(), Mount(heading=1.0)))] * 2), FakeView([[0.0, 0.0, 0.2]] * 2)
    sense(ring, view, Aim(bearing=np.array([[0.1, 0.2], [0.3, 0.4]])))
    np.testing.assert_allclose(view.asked[0][:, 2], [0.3, 1.4, 0.5, 1.6], rtol=1e-15)


def test_what_is_too_near_reads_as_the_least_range():
    ring = stack([Sonar(elements=(Mount(), Mount()), range_min=0.15, range_max=1.9)])
    assert sense(ring, FakeView([0.0, 0.0, 0.0])).tolist() == [[0.15, math.inf]]


def test_a_ring_says_where_its_elements_look_and_how_many_there_are():
    ring = Sonar(elements=tuple(Mount(heading=0.1 * i) for i in range(5)))
    for made in (ring, stack([ring])):
        assert made.size(None) == 5
        np.testing.assert_array_equal(made.bearings(), [[0.1 * i for i in range(5)]])


@pytest.mark.parametrize(("heading", "expected"), [(3.0, 3.0), (math.pi, math.pi), (4.0, 4.0 - 2 * math.pi)])
def test_a_compass_reads_the_heading_in_the_world(heading, expected):
    assert sense(stack([Compass()]), FakeView([5.0, 6.0, heading])).tolist() == [[pytest.approx(expected, abs=1e-15)]]


def test_a_gyro_reads_the_rate_of_turn_and_keeps_no_hold_of_the_world():
    view = FakeView([0.0, 0.0, 0.0], twist=(0.4, 0.0, -0.3))
    values = sense(stack([Gyro()]), view)
    assert values.tolist() == [[-0.3]]
    values[0, 0] = 9.0
    assert view.twist[0, 2] == -0.3


def test_rows_do_not_touch_one_another():
    rng = np.random.default_rng(2)
    poses, joints = rng.normal(size=(64, 3)) * 3.0, rng.normal(size=(64, 2)) * 1e3
    rings = [
        Sonar(elements=tuple(Mount(x=rng.normal(), y=rng.normal(), heading=rng.normal()) for _ in range(5)))
        for _ in range(64)
    ]
    kinds = [
        [Encoder(counts_per_revolution=100.0 + i) for i in range(64)],
        [Laser(beams=11, fov=0.1 * (1 + i % 60)) for i in range(64)],
        rings,
        [Compass()] * 64,
        [Gyro()] * 64,
    ]
    for sensors in kinds:
        view = FakeView(poses)
        view.joints = joints
        together = sense(stack(sensors), view)
        for i, sensor in enumerate(sensors):
            view = FakeView(poses[i])
            view.joints = joints[i : i + 1]
            assert sense(stack([sensor]), view).tobytes() == together[i : i + 1].tobytes()


@pytest.mark.parametrize(
    ("make", "name"),
    [
        (lambda: Encoder(counts_per_revolution=0.0), "counts_per_revolution"),
        (lambda: Laser(beams=0), "beams"),
        (lambda: Laser(beams=10.0), "beams"),
        (lambda: Laser(fov=6.3), "fov"),
        (lambda: Laser(range_max=math.inf), "range_max"),
        (lambda: Laser(range_max=2.0, range_min=2.0), "range_min"),
        (lambda: Sonar(elements=()), "elements"),
        (lambda: Sonar(half_angle=2.0), "half_angle"),
        (lambda: Sonar(range_min=1.0, range_max=1.0), "range_min"),
    ],
)
def test_a_value_that_makes_no_sense_is_refused_by_name(make, name):
    with pytest.raises(ParameterError, match=name):
        make()
