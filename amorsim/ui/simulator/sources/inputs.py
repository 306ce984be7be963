"""A user's inputs to a simulation while it runs, kept so that they can be given again at the same ticks."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import attrs

from amorsim.core.errors import AmorsimError
from amorsim.runs.replay import revived
from amorsim.simulation.simulation import Simulation

__all__ = ["Input", "Inputs"]


@attrs.frozen(kw_only=True)
class Input:
    """One thing given before the step after `tick`: ``"command"``, ``"hand_over"`` or ``"set"`` (of `path`)."""

    tick: int
    do: str
    robot: str
    value: Any
    path: str = ""

    def give(self, simulation: Simulation) -> None:
        """Give it to a simulation, which must be at the tick.

        Raises
        ------
        AmorsimError
            If the simulation does not take it.
        """
        if self.do == "command":
            simulation.robot(self.robot).command(*self.value)
        elif self.do == "hand_over":
            simulation.hand_over(self.robot, self.value)
        elif self.do == "set":
            simulation.set(self.robot, self.path, self.value)
        else:
            raise AmorsimError(f"expected command, hand_over or set, got {self.do!r}")

    def to_json(self) -> dict[str, Any]:
        """As a table of plain values."""
        return attrs.asdict(self)

    @classmethod
    def from_json(cls, table: Mapping[str, Any]) -> Input:
        """The input that `to_json` made a table of."""
        return cls(**{**table, "value": revived(table["value"])})


class Inputs:
    """Inputs in the order in which they were given; their ticks never decrease."""

    def __init__(self, given: Iterable[Input] = ()) -> None:
        self._given = list(given)
        self._reported = 0  # how many of them `news` has returned

    def __iter__(self) -> Any:
        return iter(self._given)

    def __len__(self) -> int:
        return len(self._given)

    def add(self, new: Input) -> None:
        """Keep an input; a command takes the place of the same robot's before it at the same tick."""
        last = self._given[-1] if self._given else None
        if (
            last is not None
            and new.do == "command"
            and (last.do, last.robot, last.tick) == ("command", new.robot, new.tick)
        ):
            self._given[-1] = new
            self._reported = min(self._reported, len(self._given) - 1)
        else:
            self._given.append(new)

    def cut(self, tick: int) -> None:
        """Forget the inputs after `tick`."""
        self._given = [one for one in self._given if one.tick <= tick]
        self._reported = min(self._reported, len(self._given))

    def news(self) -> tuple[int, list[Input]]:
        """The changes since the last call: the first place that differs, and all inputs from there on."""
        first, self._reported = self._reported, len(self._given)
        return first, self._given[first:]

    def replay(self, simulation: Simulation, tick: int) -> Iterable[int]:
        """Step a simulation to `tick` with the inputs up to and at that tick; yields each tick that it reached.

        The simulation must not have been given anything at its present tick yet.
        """
        now = simulation.tick
        waiting = iter([one for one in self._given if now <= one.tick <= tick])
        following = next(waiting, None)
        while True:
            while following is not None and following.tick == now:
                following.give(simulation)
                following = next(waiting, None)
            if now >= tick:
                return
            simulation.step()
            now += 1
            yield now
