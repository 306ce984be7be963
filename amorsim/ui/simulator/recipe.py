"""What a window was opened with: from it another process makes the same simulation, or opens the same run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Self

import attrs

from amorsim.runs.scenario_argument import make_simulation, read_scenario, with_options

if TYPE_CHECKING:
    from amorsim.simulation.simulation import Simulation

__all__ = ["Recipe"]


@attrs.frozen(kw_only=True)
class Recipe:
    """The request for a window: a scenario by its name or file, and its changes; or a recorded run.

    `passing` is a folder that ends with the window, where the scenario and some of its maps lie; or empty. With
    `is_recorded`, `name` is the folder of a run, and nothing else is used.
    """

    name: str
    resolution: float | None = None
    changes: Sequence[str] = ()
    seed: int | None = None
    duration: float | None = None
    passing: str = ""
    is_recorded: bool = False

    def simulation(self) -> tuple[Simulation, str]:
        """The simulation, at its start, and a remark for the user, or nothing.

        Raises
        ------
        AmorsimError
            As `amorsim.load` and `amorsim.Simulation` do.
        """
        scenario = read_scenario(self.name, resolution=self.resolution, changes=self.changes)
        return make_simulation(with_options(scenario, self.seed, self.duration))

    def to_json(self) -> dict[str, Any]:
        """As a table of plain values."""
        return attrs.asdict(self)

    @classmethod
    def from_json(cls, table: Mapping[str, Any]) -> Self:
        """The recipe in the result of `to_json`."""
        return cls(**table)
