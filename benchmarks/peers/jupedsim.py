"""JuPedSim (C++): pedestrians on the way between goals, by its own social force model."""

from __future__ import annotations

import importlib
import importlib.metadata
from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = ["COMPUTES", "JuPedSim"]

Array = npt.NDArray[np.float64]

COMPUTES = (
    "moves circles by the social force model of D. Helbing, I. Farkas and T. Vicsek (2000), those within 2.5 m of each "
    "other, soft; goals changed when they are reached"
)


class JuPedSim:
    """A crowd in a square hall.

    Raises
    ------
    ImportError
        If it is not installed.
    """

    def __init__(self, side: float, starts: Array, goals: Array, speed: float, radius: float, dt: float) -> None:
        """`starts` `(N, 2)` are those of the pedestrians, `goals` `(N, 2, 2)` the two between which each goes."""
        jps: Any = importlib.import_module("jupedsim")
        self.dt = dt
        hall = [(0.0, 0.0), (side, 0.0), (side, side), (0.0, side)]
        self._simulation = jps.Simulation(model=jps.SocialForceModel(), geometry=hall, dt=dt)
        for start, (here, there) in zip(starts.tolist(), goals.tolist(), strict=True):
            first, second = (self._simulation.add_waypoint_stage(tuple(goal), 1.0) for goal in (here, there))
            journey = jps.JourneyDescription([first, second])
            journey.set_transition_for_stage(first, jps.Transition.create_fixed_transition(second))
            journey.set_transition_for_stage(second, jps.Transition.create_fixed_transition(first))
            self._simulation.add_agent(
                jps.SocialForceModelAgentParameters(
                    position=tuple(start),
                    journey_id=self._simulation.add_journey(journey),
                    stage_id=first,
                    desired_speed=speed,
                    radius=radius,
                )
            )

    @staticmethod
    def version() -> str:
        """The version that is installed."""
        return importlib.metadata.version("jupedsim")

    def step(self) -> None:
        """One step."""
        self._simulation.iterate()

    def places(self) -> Array:
        """Where the pedestrians are `(N, 2)` [m]."""
        return np.array([agent.position for agent in self._simulation.agents()])
