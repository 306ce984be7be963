"""What a finder of marks sees, against lines of sight that shapely draws."""

import math

import numpy as np
import pytest
import shapely

import amorsim as am
from amorsim.core.poses import wrap_angle
from amorsim.core.shapes import Shape
from amorsim.noise import Gaussian
from amorsim.scenario.spec import Landmark, MountedSensor, Obstacle, Pose
from amorsim.sensors import Fiducial
from tests.building import empty, robot, room, scenario
from tests.sensors.crowd import are_free, bearings_of, lines_of_sight, random_crowd
from tests.sensors.sight import HAIR, random_scene

EMPTY = [math.inf, math.inf, -1.0]


def table(sim, name="rover"):
    return sim.robot(name).readings["eye"].true.reshape(-1, 3)


def look(*things, pose=Pose(), world=None, sensor=None, **changes):  # noqa: B008 - frozen
    """What a robot at `pose` sees of landmarks and obstacles."""
    marks = [thing for thing in things if isinstance(thing, Landmark)]
    bodies = [thing for thing in things if isinstance(thing, Obstacle)]
    eye = sensor or Fiducial(**({"slots": 4} | changes))
    one = robot(shape=Shape.circle(0.2), pose=pose, sensors={"eye": eye}, estimators={})
    return am.Simulation(scenario(one, map=world or empty(50.0), obstacles=bodies, landmarks=marks))


def post(x, y, fiducial=0, name="post", radius=0.2):
    return Obstacle(name=name, shape=Shape.circle(radius), pose=Pose(x=x, y=y), fiducial=fiducial)


def test_marks_are_reported_nearest_first_and_slots_left_are_empty():
    sim = look(Landmark(id=5, x=3.0), Landmark(id=2, x=1.0, y=1.0), pose=Pose(heading=0.1))
    seen = table(sim)
    np.testing.assert_allclose(seen[:2], [[math.sqrt(2), math.pi / 4 - 0.1, 2], [3.0, -0.1, 5]], rtol=1e-14)
    assert seen[2:].tolist() == [EMPTY, EMPTY]


def test_of_more_marks_than_slots_the_nearest_are_reported():
    sim = look(*(Landmark(id=i, x=float(i)) for i in range(1, 9)), slots=3)
    assert table(sim)[:, 2].tolist() == [1.0, 2.0, 3.0]


def test_the_field_of_view_and_the_range_bound_what_is_seen():
    marks = [Landmark(id=1, x=2.0, y=2.1), Landmark(id=2, x=2.0, y=1.9), Landmark(id=3, x=8.1), Landmark(id=4, x=7.9)]
    sim = look(*marks, fov=math.pi / 2, range_max=8.0, range_max_id=5.0)
    assert table(sim)[:, 2].tolist() == [2.0, 0.0, -1.0, -1.0]  # the far one is seen, and not read


def test_a_body_hides_a_mark_and_is_seen_by_its_own():
    sim = look(Landmark(id=1, x=4.0), post(2.0, 0.0, fiducial=7), post(3.0, 1.0, name="plain"))
    assert table(sim)[0].tolist() == [2.0, 0.0, 7.0]
    assert table(sim)[1].tolist() == EMPTY


def test_a_wall_hides_a_mark_and_one_on_the_wall_is_seen():
    world = room()
    behind, on = Landmark(id=1, x=6.2, y=2.0), Landmark(id=2, x=6.0, y=3.0)
    sim = look(behind, on, pose=Pose(x=2.0, y=2.0), world=world)
    assert table(sim)[:, 2].tolist() == [2.0, -1.0, -1.0, -1.0]
    bare = Landmark(id=2, x=6.0005, y=3.0, radius=0.0)  # in the wall, and no larger than a point
    assert table(look(bare, pose=Pose(x=2.0, y=2.0), world=world))[:, 2].max() == -1.0


def test_robots_see_one_another_as_they_move_and_never_themselves():
    eye = Fiducial(fov=2 * math.pi, slots=2)
    shared = {"shape": Shape.circle(0.2), "sensors": {"eye": eye}, "estimators": {}}
    robots = [
        robot(name="a", pose=Pose(), fiducial=11, **shared),
        robot(name="b", pose=Pose(x=2.0), fiducial=12, **shared),
    ]
    sim = am.Simulation(scenario(*robots, map=empty(50.0)), replicas=3)
    sim.robot("b", 1).drive(forward=0.5)
    for _ in range(10):
        sim.step()
    for replica, distance in ((0, 2.0), (1, sim.robot("b", 1).true_pose[0]), (2, 2.0)):
        mine = sim.robot("a", replica).readings["eye"].true.reshape(-1, 3)
        assert mine[0].tolist() == [distance, 0.0, 12.0]
        assert mine[1].tolist() == EMPTY
        theirs = sim.robot("b", replica).readings["eye"].true.reshape(-1, 3)
        assert theirs[0, 2] == 11.0
        assert abs(theirs[0, 1]) == pytest.approx(math.pi)
    assert sim.robot("b", 1).true_pose[0] > 2.3


def test_noise_is_of_one_column_and_leaves_the_others_and_the_empty_alone():
    noise = (
        am.NoiseElement(name="far", noise=Gaussian(std=0.1), column="range"),
        am.NoiseElement(name="aside", noise=Gaussian(std=0.02), column="bearing"),
    )
    sim = look(
        *(Landmark(id=i, x=float(i), y=0.3 * i * i) for i in range(1, 4)),
        sensor=MountedSensor(sensor=Fiducial(slots=5), noise=noise),
    )
    errors = []
    for _ in range(300):
        sim.step()
        reading = sim.robot("rover").readings["eye"]
        true, measured = reading.true.reshape(-1, 3), reading.measured.reshape(-1, 3)
        assert (measured[3:] == EMPTY).all()
        assert (measured[:, 2] == true[:, 2]).all()
        errors.append((measured[:3] - true[:3])[:, :2])
    spread = np.std(np.array(errors), axis=0)
    # 300 samples: the deviation of a standard deviation is 1/sqrt(600) of it; five of those.
    np.testing.assert_allclose(spread, np.tile([0.1, 0.02], (3, 1)), rtol=5 / math.sqrt(600))


def check_scene(seed):
    """One scene against shapely; the number of marks that were judged and of those that were seen."""
    fov, range_max = 1.5 * math.pi, 6.0
    scene = random_scene(seed, Fiducial(slots=30, fov=fov, range_max=range_max, range_max_id=range_max))
    x, y, heading = scene.pose
    seen = {int(i): (r, b) for r, b, i in table(scene.sim) if i > 0}
    assert 77 not in seen
    marks = [(m.id, m.x, m.y, m.radius, None) for m in scene.landmarks]
    marks += [(o.fiducial, o.pose.x, o.pose.y, 0.0, o.name) for o in scene.obstacles if o.fiducial]
    judged = 0
    for number, mx, my, radius, carrier in marks:
        away = math.hypot(mx - x, my - y)
        bearing = float(wrap_angle(np.array([math.atan2(my - y, mx - x) - heading]))[0])
        if abs(away - range_max) < HAIR or abs(abs(bearing) - fov / 2) < HAIR:
            continue
        line = shapely.LineString([(x, y), (mx, my)])
        if carrier:  # what is beyond its surface does not count
            into = line.intersection(scene.bodies[carrier])
            end = away if into.is_empty else min(away, shapely.distance(into, shapely.Point(x, y)))
        else:
            end = away - radius
        part = shapely.LineString([(x, y), line.interpolate(max(end, 0.0)).coords[0]])
        others = [scene.walls, *(body for name, body in scene.bodies.items() if name != carrier)]
        near = [part.distance(other) for other in others]
        deep = [part.intersection(other).length for other in others]
        if any(d < HAIR and length < HAIR for d, length in zip(near, deep, strict=True)):
            continue  # it grazes something
        wanted = away < range_max and abs(bearing) < fov / 2 and not any(length >= HAIR for length in deep)
        assert (number in seen) == wanted, (seed, number)
        judged += 1
        if wanted:
            assert seen[number] == (pytest.approx(away, rel=1e-12), pytest.approx(bearing, abs=1e-12))
    return judged, len(seen)


@pytest.mark.long
def test_twenty_random_scenes_agree_with_shapely():
    judged, seen = np.sum([check_scene(seed) for seed in range(20)], axis=0)
    assert judged > 150
    assert 30 < seen < judged


def check_crowd(seed):
    """All who look in one room against shapely; how many cases were judged, seen, and in doubt."""
    fov, range_max = 1.5 * math.pi, 9.0
    crowd = random_crowd(seed, Fiducial(slots=100, fov=fov, range_max=range_max, range_max_id=range_max))
    viewer, mark = (index.ravel() for index in np.indices((crowd.viewers, len(crowd.places))))
    not_own = viewer != mark
    viewer, mark = viewer[not_own], mark[not_own]
    away = np.hypot(*(crowd.places[mark] - crowd.poses[viewer, :2]).T)
    bearing = bearings_of(crowd, viewer, crowd.places[mark])
    within = (away < range_max) & (np.abs(bearing) < fov / 2)
    reading = crowd.tables(3)
    reported = np.full((crowd.viewers, len(crowd.places), 2), np.nan)
    row, slot = np.nonzero(reading[:, :, 2] > 0)
    reported[row, reading[row, slot, 2].astype(int) - 1] = reading[row, slot, :2]
    seen = ~np.isnan(reported[viewer, mark, 0])
    assert not seen[~within].any()
    viewer, mark, away, bearing, seen = (column[within] for column in (viewer, mark, away, bearing, seen))
    free, certain = are_free(crowd, lines_of_sight(crowd, viewer, mark), viewer, mark)
    np.testing.assert_array_equal(seen[certain], free[certain], err_msg=str(seed))
    np.testing.assert_allclose(
        reported[viewer, mark][seen], np.stack((away, bearing), axis=1)[seen], rtol=0, atol=1e-12
    )
    return certain.sum(), seen.sum(), (~certain).sum()


def test_in_one_crowded_room_all_agrees_with_shapely():
    judged, seen, doubtful = check_crowd(0)
    assert judged > 2000
    assert 200 < seen < judged - 200
    assert doubtful < 10


@pytest.mark.long
def test_a_hundred_thousand_marks_are_seen_or_not_as_shapely_says():
    judged, seen, doubtful = np.sum([check_crowd(seed) for seed in range(1000, 1045)], axis=0)
    assert judged >= 100_000
    assert 10_000 < seen < judged - 10_000
    assert doubtful < 1e-3 * judged


@pytest.mark.parametrize("slots", [1, 3, 20])
def test_with_few_slots_the_first_of_those_are_reported_that_many_slots_hold(slots):
    many = random_crowd(7, Fiducial(slots=150, fov=2 * math.pi, range_max=9.0, range_max_id=9.0)).tables(3)
    few = random_crowd(7, Fiducial(slots=slots, fov=2 * math.pi, range_max=9.0, range_max_id=9.0)).tables(3)
    np.testing.assert_array_equal(few, many[:, :slots])
    assert (np.isfinite(many[:, :, 0]).sum(axis=1) > 3).any()


def test_results_do_not_depend_on_rows_replicas_or_threads():
    eye = MountedSensor(
        sensor=Fiducial(slots=6, fov=2 * math.pi),
        mount=am.Mount(x=0.1, heading=0.2),
        noise=(am.NoiseElement(name="far", noise=Gaussian(std=0.1), column="range"),),
    )
    robots = [
        robot(
            name=f"r{i}",
            pose=Pose(x=1.0 + i, y=1.0 + 0.3 * i),
            shape=Shape.circle(0.2),
            fiducial=50 + i,
            sensors={"eye": eye},
            estimators={},
            controller=lambda readings, estimate, clock: (3.0, 2.0 + clock.time),
        )
        for i in range(4)
    ]
    made = scenario(*robots, landmarks=[Landmark(id=i, x=0.7 * i, y=4.0) for i in range(1, 8)])
    sims = [am.Simulation(made, replicas=r, threads=t) for r, t in (((5,), 1), (range(8), 1), (range(8), 3))]
    for _ in range(15):
        for sim in sims:
            sim.step()
    alone = [sims[0].robot(f"r{i}", 5).readings["eye"].measured.tobytes() for i in range(4)]
    for sim in sims[1:]:
        assert [sim.robot(f"r{i}", 5).readings["eye"].measured.tobytes() for i in range(4)] == alone
        assert sim.digest(5) == sims[0].digest(5)
