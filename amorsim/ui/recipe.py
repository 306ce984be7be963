"""How a scenario was asked for, so that another process makes the same simulation of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Self

import attrs

from amorsim.core.errors import AmorsimError
from amorsim.core.parameters import ParameterError
from amorsim.runs.asked import make_simulation, read_scenario
from amorsim.simulation.simulation import Simulation

__all__ = ["Recipe"]


@attrs.frozen(kw_only=True)
class Recipe:
    """What `amorsim view` was told: a scenario's name or file, and what is changed of it.

    `passing` is a folder that ends with the window, where the scenario and some of its maps lie; or nothing.
    """

    name: str
    resolution: float | None = None
    changes: Sequence[str] = ()
    seed: int | None = None
    duration: float | None = None
    passing: str = ""

    def simulation(self) -> tuple[Simulation, str]:
        """The simulation, at its start, and a remark for the user, or nothing.

        Raises
        ------
        AmorsimError
            As `amorsim.load` and `amorsim.Simulation` do.
        """
        scenario = read_scenario(self.name, resolution=self.resolution, changes=self.changes)
        try:
            if self.seed is not None:
                scenario = attrs.evolve(scenario, seed=self.seed)
            if self.duration is not None:
                scenario = attrs.evolve(scenario, duration=self.duration)
        except ParameterError as error:
            raise AmorsimError(f"--{error.name}: {error.problem}") from None
        return make_simulation(scenario)

    def to_json(self) -> dict[str, Any]:
        """As a table of plain values."""
        return attrs.asdict(self)

    @classmethod
    def from_json(cls, table: Mapping[str, Any]) -> Self:
        """What `to_json` gave."""
        return cls(**table)
