"""A simulation and its recorded past, as windows look at them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from amorsim.simulation.events import Event
from amorsim.simulation.simulation import Simulation
from amorsim.ui.simulator.frames.frames import Before, moments_of
from amorsim.ui.simulator.frames.intended import intended_of
from amorsim.ui.simulator.frames.mapped import mapped_of
from amorsim.ui.simulator.frames.packing import Dynamic, FrameFlag
from amorsim.ui.simulator.frames.protocol import Intended, Mapped
from amorsim.ui.simulator.sources.past import Pasts
from amorsim.ui.simulator.sources.source import Source, Track
from amorsim.ui.simulator.sources.timeline import Paths, Snapshots

__all__ = ["Simulated"]


class Simulated(Source):
    """A simulation with its past, at the moment that is shown. `Player` moves in its time.

    Attributes
    ----------
    simulation
        At the moment that is shown.
    poses_only
        The tick that is shown if only its poses are known, or None.
    paths, snapshots, pasts
        What is kept of the past.
    """

    paths: Paths
    snapshots: Snapshots
    pasts: Pasts

    def __init__(self, simulation: Simulation, epoch: int) -> None:
        super().__init__(epoch)
        self.simulation = simulation
        self.poses_only: int | None = None
        self._present: Any = None  # the snapshot of the present, while the past is shown
        self._newest = 0
        self._is_past = False
        self._before: Before | None = None
        self._obstacles = sorted(obstacle.name for obstacle in simulation.scenario.obstacles)

    @property
    def dt(self) -> float:
        """The time step [s]."""
        return self.simulation.dt

    @property
    def tick(self) -> int:
        """The tick that is shown."""
        return self.simulation.tick if self.poses_only is None else self.poses_only

    @property
    def newest(self) -> int:
        """The last tick that was simulated."""
        return self._newest

    @property
    def is_past(self) -> bool:
        """Whether a moment of the past is shown."""
        return self._is_past

    @property
    def last(self) -> int:
        """The tick at the end of the scenario's duration."""
        return self.simulation.steps_of(self.simulation.scenario.duration)

    @property
    def is_exact(self) -> bool:
        """Whether the shown past is exactly what happened; not if a controller acted in another way this time."""
        kept_at, kept = self.paths.at(self.tick)
        if not self._is_past or self.poses_only is not None or kept_at != self.tick:
            return True
        now = np.concatenate((self.simulation.true_pose, self.simulation.estimated_pose), axis=1).astype(np.float32)
        return bool(np.array_equal(now, kept))

    @property
    def reason(self) -> str:
        """Why the simulation cannot go on from the shown moment of the past; empty if it can."""
        if self.snapshots.reason:
            return self.snapshots.reason
        if not self.is_exact:
            return "a controller did something else when it was run again (a clock or randomness of its own?)"
        return ""

    @property
    def names(self) -> Sequence[str]:
        """The robots' names, in the order of their rows."""
        return self.simulation.names

    @property
    def by_hand(self) -> list[str]:
        """The robots that are driven by hand."""
        return [self.names[i] for i in np.flatnonzero(self.simulation.by_hand).tolist()]

    @property
    def happened(self) -> Sequence[Event]:
        """The simulation's events up to the present."""
        return self.simulation.events if self._present is None else self._present[0].events

    def moments(self) -> list[Dynamic]:
        """The moment that is shown, for each robot that is watched."""
        poses, flags = None, FrameFlag(0)
        if self.poses_only is not None:
            flags = FrameFlag.POSES_ONLY
            poses = self.paths.at(self.poses_only)[1].astype(float)
        found = moments_of(self.simulation, self.watched, self._before, self._obstacles, poses)
        return [moment._replace(flags=int(flags)) for moment in found]

    def track(self, robot: int, most: int) -> Track:
        """The past of a robot, at most `most` moments of it."""
        return Track(*self.paths.track(robot, most), self.pasts.of(robot, most))

    def mapped(self, robot: str) -> list[Mapped]:
        """The beliefs of each estimator of a robot that maps or matches, in their order."""
        return mapped_of(self.simulation, robot)

    def intended(self, robot: str) -> Intended:
        """The intentions of a robot's controller in the last step; None for a moment of which only poses are kept."""
        return intended_of(self.simulation, robot, is_known=self.poses_only is None)
