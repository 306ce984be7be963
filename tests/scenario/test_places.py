"""Where an obstacle starts by its motion, and what is said of places that are none."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.core.errors import ComponentError
from amorsim.core.parameters import ParameterError
from amorsim.simulation.lint import advice
from tests.building import robot, room


@attrs.frozen(kw_only=True)
class Stands(am.Motion):
    """Stands, and says something of places."""

    first: Any = None
    goals: Any = ()

    def propose(self, view: am.View, dt: float, state: am.State, draws: am.Draws) -> np.ndarray:
        return np.zeros((view.rows, 3))

    def default_start(self) -> Any:
        if isinstance(self.first, Exception):
            raise self.first
        return self.first

    def goal_points(self) -> Any:
        if isinstance(self.goals, Exception):
            raise self.goals
        return self.goals


def obstacle(**said: Any) -> am.Obstacle:
    return am.Obstacle(name="post", shape=am.Shape.circle(0.1), motion=Stands(**said))


@pytest.mark.parametrize(("first", "pose"), [(None, (0.0, 0.0, 0.0)), ((1, 2.0, np.float64(3.0)), (1.0, 2.0, 3.0))])
def test_an_obstacle_starts_where_its_motion_says(first, pose):
    found = obstacle(first=first).pose
    assert (found.x, found.y, found.heading) == pose


@pytest.mark.parametrize("first", [(1.0, 2.0), [1.0, 2.0, 3.0], "here", (1.0, 2.0, "north"), (1.0, np.nan, 0.0)])
def test_a_start_that_is_no_place_is_refused_with_the_motions_name(first):
    with pytest.raises(ParameterError, match=r"motion: Stands: default_start\(\): expected None or a tuple .*, got"):
        obstacle(first=first)


def test_a_motion_that_raises_for_its_start_is_named():
    with pytest.raises(ParameterError, match=r"motion: Stands: default_start\(\) raised ValueError: lost"):
        obstacle(first=ValueError("lost"))


@pytest.mark.parametrize("goals", [[(1.0, 2.0)], [["way", 1.0, 2.0]], [(0, 1.0, 2.0)], [("way", 1.0, np.inf)]])
def test_goals_that_are_no_places_are_refused_with_the_motions_name(goals):
    scenario = am.Scenario(map=room(), robots=[robot()], obstacles=[obstacle(goals=goals)])
    words = r"obstacles.post.motion \(Stands\): goal_points\(\): expected tuples .*, got"
    with pytest.raises(ComponentError, match=words):
        advice(scenario)


def test_a_motion_that_raises_for_its_goals_is_named():
    scenario = am.Scenario(map=room(), robots=[robot()], obstacles=[obstacle(goals=ValueError("lost"))])
    with pytest.raises(ComponentError, match=r"\(Stands\): goal_points\(\) raised ValueError: lost"):
        advice(scenario)
