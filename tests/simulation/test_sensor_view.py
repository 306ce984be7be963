"""A wrong query of the view: the error speaks of the sensor's call, not of a compiler."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.simulation.world.directions import cone_bearings
from tests import building


@attrs.frozen(kw_only=True)
class Asks(am.Sensor):
    """Asks its view as a test says."""

    unit = "m"

    ask: Callable[[Any, Any], Any]

    def size(self, drive: am.Drive) -> int:
        return 1

    def sense(self, view: Any, aim: am.Aim, state: am.State, draws: am.Draws) -> Any:
        return np.min(self.ask(view, aim), axis=1, keepdims=True), {}


AHEAD = np.zeros((1, 1))
FAR = np.array([[5.0]])
NOBODY = np.full((1, 1), -1, dtype=np.int64)


def look(ask: Callable[[Any, Any], Any]) -> am.Simulation:
    sensors = {"encoder": building.encoder(), "asks": Asks(ask=ask)}
    return am.Simulation(building.scenario(building.robot(sensors=sensors)))


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda view, aim: view.cast(aim, AHEAD, FAR), r"view\.cast: origins: expected poses in the world, an array"),
        (lambda view, aim: view.cast(view.pose[0], AHEAD, FAR), r"such as view\.pose, got an array of shape \(3,\)"),
        (lambda view, aim: view.cast(view.pose[:, :2], AHEAD, FAR), r"got an array of shape \(1, 2\)"),
        (lambda view, aim: view.cast(view.pose, [0.0], FAR), r"view\.cast: bearings: .* \[rad\], got \[0\.0\]"),
        (lambda view, aim: view.cast(view.pose, np.zeros(3), FAR), r"bearings: .* got an array of shape \(3,\)"),
        (lambda view, aim: view.cast(view.pose, np.zeros((2, 3)), FAR), r"bearings: expected an array \(1, k\) or"),
        (lambda view, aim: view.look(aim, AHEAD, FAR), r"view\.look: origins: expected poses in the world, an array"),
        (lambda view, aim: view.look(view.pose, [0.0], FAR), r"view\.look: bearings: .* \[rad\], got \[0\.0\]"),
        (lambda view, aim: view.normals(aim, AHEAD, NOBODY), r"view\.normals: origins: expected poses in the world"),
        (
            lambda view, aim: view.normals(view.pose, AHEAD, np.full((1, 1), 10**7)),
            r"view\.normals: bodies: .* \(1, 1\) of numbers from -1 to 0, got an array of shape \(1, 1\)",
        ),
        (lambda view, aim: view.normals(view.pose, AHEAD, np.full((1, 1), -2)), r"normals: bodies: .* from -1 to 0"),
        (lambda view, aim: view.normals(view.pose, AHEAD, np.zeros((1, 2), int)), r"got an array of shape \(1, 2\)"),
        (lambda view, aim: view.normals(view.pose, AHEAD, np.zeros((1, 1))), r"normals: bodies: expected the body"),
        (
            lambda view, aim: view.cast(view.pose, AHEAD, FAR, row=[0]),
            r"view\.cast: row: .* array \(1,\) of numbers from",
        ),
        (
            lambda view, aim: view.look(view.pose, AHEAD, FAR, row=np.array([1])),
            r"view\.look: row: .* from 0 to 0, got",
        ),
        (
            lambda view, aim: view.look(view.pose, AHEAD, FAR, row=np.array([-1])),
            r"view\.look: row: expected the row of",
        ),
        (lambda view, aim: view.look(view.pose, AHEAD, FAR, row=np.array([0, 0])), r"got an array of shape \(2,\)"),
        (
            lambda view, aim: view.look(view.pose, AHEAD, 5.0, row=np.array([0])),
            r"range_max: .* \(1, 1\) \[m\], one for",
        ),
        (lambda view, aim: view.floor(np.zeros((1, 2))), r"view\.floor: places: .* array \(1, k, 2\) \[m\], got an"),
        (lambda view, aim: view.floor(view.pose[:, None]), r"got an array of shape \(1, 1, 3\)"),
        (lambda view, aim: view.cone((0.0, 0.0, 0.0), 0.1, FAR), r"view\.cone: origins: .* got \(0\.0, 0\.0, 0\.0\)"),
        (
            lambda view, aim: view.bind_cone(
                view.pose, 0.1, FAR, *np.empty((1, 1, 1)), "bresenham", np.empty((2, 1, 1))
            ),
            r"view\.cone: wall: expected None where the traversal is 'bresenham'",
        ),
        (lambda view, aim: view.neighbours([1.0, 2.0]), r"view\.neighbours: range_max: expected numbers >= 0, one or"),
        (lambda view, aim: view.neighbours(FAR, -1.0), r"view\.neighbours: ahead: .* \(1, 1\), got -1\.0"),
        (lambda view, aim: view.neighbours(np.array([[np.nan]])), r"range_max: .* got an array of shape \(1, 1\)"),
    ],
)
def test_a_wrong_question_is_reported(ask: Callable[[Any, Any], Any], message: str) -> None:
    with pytest.raises(am.ComponentError, match=message):
        look(ask)


def test_a_right_question_is_answered() -> None:
    sim = look(lambda view, aim: view.cast(view.pose, AHEAD, 50.0))
    assert 0.0 < sim.robot("rover").readings["asks"].true[0] < 50.0
    sim = look(lambda view, aim: view.cone(view.pose, 0.1, 50.0))
    assert 0.0 < sim.robot("rover").readings["asks"].true[0] < 50.0


def test_a_limit_for_each_origin_cuts_that_origins_beams_only() -> None:
    """Both questions about beams: the distances are those with one long limit, or inf beyond the origin's own."""

    def ask(view: Any, aim: Any) -> Any:
        origins = np.repeat(view.pose, 3, axis=0)
        far = view.cast(origins, AHEAD, np.full((view.rows, 1), 50.0))
        limits = far * np.array([[1.001], [0.999], [1.001]])
        expected = np.where(far <= limits, far, np.inf)
        assert np.isinf(expected).sum() == 1
        np.testing.assert_array_equal(view.cast(origins, AHEAD, limits), expected)
        np.testing.assert_array_equal(view.look(origins, AHEAD, limits)[0], expected)
        return far[:1]

    look(ask)


def test_as_many_places_for_each_row() -> None:
    scenario = building.scenario(
        building.robot(
            sensors={
                "encoder": building.encoder(),
                "asks": Asks(ask=lambda view, aim: view.cast(np.repeat(view.pose, 3, axis=0)[:4], AHEAD, FAR)),
            }
        )
    )
    with pytest.raises(am.ComponentError, match=r"as many for each of 3 rows, got 4; `row` says which is whose"):
        am.Simulation(scenario, replicas=3)


def test_rows_may_look_from_different_numbers_of_places() -> None:
    """Two of one row, none of the next and three of the last, which read as when each row has as many."""

    def ask(view: Any, aim: Any) -> Any:
        origins = np.repeat(view.pose, 3, axis=0)
        origins[:, 2] += np.arange(9)
        fan, limits = np.linspace(-0.5, 0.5, 41)[None, :], np.linspace(3.0, 9.0, 9)[:, None]
        some = np.array([0, 2, 6, 7, 8])
        given = origins[some], fan, limits[some]
        row = some // 3
        every, bodies = view.look(origins, fan, limits)
        ranges, met = view.look(*given, row=row)
        np.testing.assert_array_equal(ranges, every[some])
        np.testing.assert_array_equal(met, bodies[some])
        np.testing.assert_array_equal(view.cast(*given, row=row), every[some])
        normals = view.normals(origins, np.repeat(fan, 9, axis=0), bodies)
        np.testing.assert_array_equal(view.normals(origins[some], np.repeat(fan, 5, axis=0), met, row), normals[some])
        none = np.zeros(0, dtype=np.int64)
        assert view.look(origins[none], fan, limits[none], row=none)[0].shape == (0, 41)
        assert (met >= 0).any()
        return every[::3, :1]

    sensors = {"encoder": building.encoder(), "asks": Asks(ask=ask)}
    robot = building.robot(sensors=sensors, pose=am.Pose(x=1.0, y=1.0))
    post = am.Obstacle(name="post", shape=am.Shape.circle(0.4), pose=am.Pose(x=2.5, y=1.0))
    scenario = attrs.evolve(building.scenario(robot, map=building.room(10.0, 10.0)), obstacles=[post])
    am.Simulation(scenario, replicas=3).step()


def test_cones_of_different_widths_are_those_of_their_rays() -> None:
    def ask(view: Any, aim: Any) -> Any:
        origins = np.repeat(view.pose, 2, axis=0)
        origins[1::2, 2] += 1.0
        half = np.array([[0.1], [0.2], [0.1]])
        bearing, nearest = view.nearest_wall(origins, half, 50.0)
        for row, width in enumerate(half[:, 0]):
            fan = cone_bearings(width)
            every = view.cast(origins, fan, np.array([[50.0]]), bodies=False)[2 * row : 2 * row + 2]
            np.testing.assert_array_equal(bearing[row], fan[0, every.argmin(axis=1)])
            np.testing.assert_array_equal(nearest[row], every.min(axis=1))
            np.testing.assert_array_equal(nearest[row], view.cone(origins, half, 50.0)[row])
            alone = view.cone(origins, np.full((3, 1), width), 50.0)[row]
            np.testing.assert_array_equal(view.cone(origins, half, 50.0)[row], alone)
        return nearest[:, :1]

    sensors = {"encoder": building.encoder(), "asks": Asks(ask=ask)}
    robot = building.robot(sensors=sensors, pose=am.Pose(x=1.0, y=1.0))
    errors = {"pose.x": am.Deviation(add=am.Distribution(kind="uniform", values=(0.0, 3.0)))}
    scenario = building.scenario(attrs.evolve(robot, errors=errors), map=building.room(10.0, 10.0))
    am.Simulation(scenario, replicas=3).step()


def test_a_bound_question_is_answered_from_arrays_as_they_are_now() -> None:
    def ask(view: Any, aim: Any) -> Any:
        origins, near_post = np.repeat(view.pose, 2, axis=0), False
        for beams in (2, 41):
            fan = np.linspace(-1.0, 1.0, beams)[None, :]
            towards = am.contracts.Directions(*np.full((2, 6, beams), np.inf))  # whatever they are before a call
            shape, limits = (6, beams), np.array([5.0, -1.0, 1.0, 8.0, 2.0, -1.0])
            ranges, thing = np.empty(shape), np.empty(shape, dtype=np.int64)
            far, far_thing, matters = np.empty(shape), np.empty(shape, dtype=np.int64), np.full(shape, 0.95)
            matters[:, 0] = np.inf
            cast, walls = np.empty(shape), np.empty(shape)
            bearing, nearest, aside, away, heard = np.empty((5, 3, 2))
            calls = (
                view.bind_look(origins, fan, limits, ranges, thing),
                view.bind_look(origins, fan, limits, far, far_thing, matters),
                view.bind_cast(origins, towards, 5.0, cast),
                view.bind_cast(origins, towards, 5.0, walls, bodies=False),
                view.bind_nearest_wall(origins, 0.3, 5.0, bearing, nearest),
                view.bind_cone(origins, 0.3, 5.0, heard, wall=(aside, away)),
            )
            for turn in (0.0, 0.9):
                origins[:, 2] += turn
                limits[:] = limits[::-1].copy()
                bearings = fan + turn * np.arange(6)[:, None]
                towards.cos[...], towards.sin[...] = np.cos(bearings), np.sin(bearings)
                for call in calls:
                    call()
                seen = limits >= 0.0
                expected = view.look(origins[seen], fan, limits[seen, None], False, row=np.arange(6)[seen] // 2)
                np.testing.assert_array_equal(ranges[seen], expected[0])
                np.testing.assert_array_equal(thing[seen], expected[1])
                assert beams == 2 or set(thing[seen].ravel()) == {-1, 1}
                counts = (ranges[seen] >= matters[seen]) & (matters[seen] < np.inf)
                np.testing.assert_array_equal(far[seen][counts], ranges[seen][counts])
                np.testing.assert_array_equal(far_thing[seen][counts], thing[seen][counts])
                assert (far[seen][~counts] < matters[seen][~counts]).all()
                assert beams == 2 or (counts.any() and (far[seen] == 0.0).any())
                np.testing.assert_array_equal(cast, view.cast(origins, bearings, 5.0))
                np.testing.assert_array_equal(walls, view.cast(origins, bearings, 5.0, bodies=False))
                assert beams == 2 or (cast < walls).any()
                for found in ((bearing, nearest), (aside, away)):
                    for mine, again in zip(found, view.nearest_wall(origins, 0.3, 5.0), strict=True):
                        np.testing.assert_array_equal(mine, again)
                np.testing.assert_array_equal(heard, view.cone(origins, 0.3, 5.0))
                near_post |= bool((heard < away).any())
        assert near_post  # which is no wall
        return nearest[:, :1]

    sensors = {"encoder": building.encoder(), "asks": Asks(ask=ask)}
    robot = building.robot(sensors=sensors, pose=am.Pose(x=1.0, y=1.0))
    post = am.Obstacle(name="post", shape=am.Shape.circle(0.4), pose=am.Pose(x=2.0, y=1.6))
    scenario = attrs.evolve(building.scenario(robot, map=building.room(6.0, 6.0)), obstacles=[post])
    am.Simulation(scenario, replicas=3).step()


@pytest.mark.parametrize("beams", [1, 41])
def test_nothing_is_looked_for_below_a_range_of_nought(beams: int) -> None:
    def ask(view: Any, aim: Any) -> Any:
        below = view.cast(view.pose, np.linspace(-1.0, 1.0, beams)[None, :], np.array([[-1.0]]), bodies=False)
        assert (below == np.inf).all()
        return below[:, :1]

    look(ask)


def test_neighbours_are_the_bodies_near_in_each_replica_by_itself() -> None:
    """A trailer of one's own is none; a fast one is, when asked ahead, from farther away."""
    asked: list[Any] = []

    def ask(view: Any, aim: Any) -> Any:
        asked.append((view.neighbours(FAR), view.neighbours(FAR, 10.0)))
        return np.zeros((view.rows, 1))

    sensors = {"encoder": building.encoder(), "asks": Asks(ask=ask)}
    post = am.Obstacle(name="near", shape=am.Shape.circle(0.1), pose=am.Pose(x=3.0, y=1.0))
    runs = am.Obstacle(
        name="runs",
        shape=am.Shape.circle(0.1),
        pose=am.Pose(x=1.0, y=9.0),
        motion=am.motions.Wander(speed=0.5, course_std=0.0),
    )
    robot = building.robot(sensors=sensors, pose=am.Pose(x=1.0, y=1.0))
    sim = am.Simulation(building.scenario(robot, map=building.room(10.0, 10.0), obstacles=[post, runs]), replicas=2)
    sim.step()
    near, ahead = asked[-1]
    names = np.array([sim._fleet.world.name(body) for body in range(6)])
    assert near.first.tolist() == [0, 1, 2]
    assert near.row.tolist() == [0, 1]
    assert near.body.tolist() == [1, 4]
    assert names[near.body].tolist() == ["near"] * 2
    np.testing.assert_array_equal(names[near.own], ["rover"] * 2)
    np.testing.assert_array_equal(near.poses[near.body, :2], [[3.0, 1.0]] * 2)
    assert names[ahead.body].tolist() == ["near", "runs"] * 2
    assert ahead.body.tolist() == [1, 2, 4, 5]
