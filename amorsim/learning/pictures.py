"""Pictures of environments, as learners record them: the true world from above, and the goal."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from amorsim.array_types import Array
from amorsim.contracts import State
from amorsim.core.errors import AmorsimError
from amorsim.core.shapes import Shape
from amorsim.render.animation import Animation, Shown
from amorsim.runs.film import bodies_in, poses_in
from amorsim.simulation.simulation import Simulation

__all__ = ["RENDER_MODES", "Pictures", "check_render_mode", "goals_in"]

RENDER_MODES = ["rgb_array", "human"]
_SIZE = 480  # [px] the longer side of a picture


_GOAL = Shown(outline=Shape.circle(0.12).outline, is_robot=False, colour="#d95f02")


class Pictures:
    """Draws environments, each with the trail of its present episode as far as it was drawn.

    Parameters
    ----------
    simulation
        Whose replicas are the environments.
    """

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._bodies = bodies_in(simulation)
        self._drawn: dict[int, tuple[int, Animation]] = {}  # by row: the episode and its frames

    def draw(self, row: int, goals: Array) -> npt.NDArray[np.uint8]:
        """The picture `(height, width, 3)` of an environment with its goals `(G, 2)` [m]."""
        simulation = self._simulation
        number = int(simulation.episodes[row])
        if self._drawn.get(row, (-1,))[0] != number:
            world = simulation.map_of(simulation.replicas[row])
            bodies = [*self._bodies, *([_GOAL] * len(goals))]
            self._drawn[row] = (
                number,
                Animation(world, bodies, patches=simulation.scenario.floor.patches, size=_SIZE),
            )
        animation = self._drawn[row][1]
        poses = np.concatenate((poses_in(simulation, row), np.column_stack((goals, np.zeros(len(goals))))))
        animation.add(float(simulation.ticks[row]) * simulation.dt, poses)
        return np.asarray(animation.frame(len(animation) - 1))


def check_render_mode(mode: str | None, count: int) -> None:
    """Raise `AmorsimError` if so many worlds cannot be rendered in a mode."""
    if mode not in (None, *RENDER_MODES):
        raise AmorsimError(f"render_mode: expected None or {' or '.join(map(repr, RENDER_MODES))}, got {mode!r}")
    if mode == "human" and count != 1:
        raise AmorsimError(f"render_mode: 'human' shows one environment, got {count}; 'rgb_array' shows all")


def goals_in(episode: State, rows: Any) -> Array:
    """The goals `(G, 2)` [m] of some rows of a task; none where it has none."""
    return np.array(episode["goal"][rows][:, :2]) if "goal" in episode else np.empty((0, 2))
