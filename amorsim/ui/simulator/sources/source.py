"""The source of a window: a simulation that runs, or a recorded run. Both are moments that follow one another."""

from __future__ import annotations

import abc
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from amorsim.array_types import Array
from amorsim.simulation.events import Event
from amorsim.ui.simulator.frames.intended import NO_INTENTION
from amorsim.ui.simulator.frames.packing import Dynamic, FrameFlag
from amorsim.ui.simulator.frames.protocol import EventLine, Intended, Mapped, Past
from amorsim.ui.simulator.process.step_faults import Fault
from amorsim.ui.simulator.sources.story import Story

__all__ = ["Source", "Track"]


class Track(NamedTuple):
    """The past of a robot: ticks, true and estimated poses side by side `(n, 6)`, and other plotted values."""

    ticks: list[int]
    poses: Array
    past: Past


class Source(abc.ABC):
    """Moments, one for each tick from 0 to `newest`; one of them is shown.

    Attributes
    ----------
    epoch
        Rises whenever the past is no longer what it was.
    watched
        The robots that frames contain completely.
    fault
        Why no step can be made, or None.
    """

    def __init__(self, epoch: int) -> None:
        self.epoch = epoch
        self.watched: tuple[int, ...] = (0,)
        self.fault: Fault | None = None
        self._story = Story()

    # ------------------------------------------------------------------------------------------------------------ time

    @property
    @abc.abstractmethod
    def dt(self) -> float:
        """The time from one tick to the next [s]."""

    @property
    @abc.abstractmethod
    def tick(self) -> int:
        """The tick that is shown."""

    @property
    @abc.abstractmethod
    def newest(self) -> int:
        """The last tick that there is."""

    @property
    @abc.abstractmethod
    def last(self) -> int:
        """The tick at which playing ends."""

    @abc.abstractmethod
    def begin_playing(self) -> None:
        """Go to a moment from which steps can be made."""

    @abc.abstractmethod
    def step(self, *, watched: bool = True) -> bool:
        """Go to the next tick; returns whether there is one.

        Without `watched` no frame of this tick will be asked for.
        """

    @abc.abstractmethod
    def scrub(self, tick: int | None) -> int:
        """Show another moment, or with None the newest; returns the tick that is shown."""

    @property
    def is_past(self) -> bool:
        """Whether there is a present, and a moment before it is shown."""
        return False

    @property
    def is_exact(self) -> bool:
        """Whether the moment is shown as it was."""
        return True

    @property
    def reason(self) -> str:
        """Why no other future can begin at the shown moment; empty if one can."""
        return ""

    @property
    def folder(self) -> Path | None:
        """The folder that it is being written into; None if it is not."""
        return None

    @abc.abstractmethod
    def close(self) -> None:
        """End what is open."""

    # --------------------------------------------------------------------------------------------------------- looking

    @property
    @abc.abstractmethod
    def names(self) -> Sequence[str]:
        """The robots' names, in the order of their rows."""

    @property
    @abc.abstractmethod
    def by_hand(self) -> list[str]:
        """The robots that are driven by hand."""

    @abc.abstractmethod
    def moments(self) -> list[Dynamic]:
        """The moment that is shown, for each robot that is watched; `frames` fills in the rest."""

    @abc.abstractmethod
    def track(self, robot: int, most: int) -> Track:
        """The past of a robot, at most `most` moments of it."""

    @abc.abstractmethod
    def mapped(self, robot: str) -> list[Mapped]:
        """The beliefs of each estimator of a robot that maps or matches, in their order."""

    def intended(self, robot: str) -> Intended:
        """The intentions of a robot's controller at the moment that is shown; none where they are not known."""
        return NO_INTENTION

    @property
    @abc.abstractmethod
    def happened(self) -> Sequence[Event]:
        """The events, in the order in which they became known."""

    def frames(self, *, version: int, number: int, speed: float, achieved: float, flags: int) -> list[Dynamic]:
        """The moment that is shown, for each robot that is watched."""
        flags |= FrameFlag.SCRUBBED if self.is_past else 0
        flags |= FrameFlag.FAULT if self.fault is not None else 0
        return [
            moment._replace(
                version=version,
                number=number,
                epoch=self.epoch,
                time=self.tick * self.dt,
                speed=speed,
                achieved=achieved,
                tick=self.tick,
                newest=self.newest,
                flags=moment.flags | flags,
                events=self.event_count,
            )
            for moment in self.moments()
        ]

    # ---------------------------------------------------------------------------------------------------------- events

    def remark(self, kind: str, text: str, *, robot: str = "", stack: str = "") -> None:
        """Keep a line that is not an event of the simulation."""
        time = self.tick * self.dt
        self._story.add(len(self.happened), self.tick, time, kind, text, robot=robot, stack=stack)

    @property
    def remarks(self) -> list[EventLine]:
        """The lines that are not events of the simulation, in order."""
        return self._story.remarks

    @property
    def event_count(self) -> int:
        """How many lines `events` has."""
        return len(self.happened) + len(self._story)

    def events(self) -> list[EventLine]:
        """All events in the order in which they became known: new ones come last."""
        return self._story.lines(self.happened)
