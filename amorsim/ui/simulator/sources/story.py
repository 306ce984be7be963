"""The story of a simulation, line by line: its events, and remarks between them."""

from __future__ import annotations

from collections.abc import Sequence

from amorsim.simulation.events import Event
from amorsim.ui.simulator.frames.protocol import EventLine

__all__ = ["Story", "line_of"]


def line_of(
    tick: int, time: float, kind: str, text: str, robot: str, point: tuple[float, float] | None = None
) -> EventLine:
    """A line of the list of events, without its number: its time [s], its words, and its place [m] if it has one."""
    return {
        "number": 0,
        "tick": tick,
        "time": time,
        "kind": kind,
        "robot": robot,
        "text": text,
        "point": None if point is None else list(point),
    }


class Story:
    """The remarks, each with how many events there were before it; the events are the simulation's own."""

    def __init__(self) -> None:
        self._lines: list[tuple[int, EventLine]] = []

    def __len__(self) -> int:
        return len(self._lines)

    def add(
        self, events: int, tick: int, time: float, kind: str, text: str, *, robot: str = "", stack: str = ""
    ) -> None:
        """Keep a remark, made after `events` events, at a tick and its time [s]."""
        line = line_of(tick, time, kind, text, robot)
        if stack:
            line["stack"] = stack
        self._lines.append((events, line))

    @property
    def remarks(self) -> list[EventLine]:
        """The remarks in order."""
        return [line for _, line in self._lines]

    def copy(self) -> Story:
        """Another with the same remarks."""
        other = Story()
        other._lines = list(self._lines)
        return other

    def cut(self, tick: int, events: int) -> None:
        """Forget what came after `tick`, up to which there were `events` events."""
        self._lines = [(min(before, events), line) for before, line in self._lines if line["tick"] <= tick]

    def lines(self, events: Sequence[Event]) -> list[EventLine]:
        """Events and remarks in the order in which they became known, numbered from 1."""
        lines = [
            line_of(event.tick, event.time, event.kind, str(event).partition(": ")[2], event.name, event.point)
            for event in events
        ]
        for n in range(1, len(lines)):
            if _is_mirrored(events[n - 1], events[n]):
                lines[n - 1]["text"] += f", {events[n].name} {events[n].speed:.3f} m/s"
                lines[n]["is_told"] = True
        for before, remark in reversed(self._lines):
            lines.insert(before, remark)
        for number, line in enumerate(lines, 1):
            line["number"] = number
        return lines


def _is_mirrored(one: Event, next_one: Event) -> bool:
    """Whether two successive events are one contact of two bodies, seen from each of them."""
    here = (one.tick, one.point, one.name, one.part, one.other)
    there = (next_one.tick, next_one.point, next_one.other, next_one.other_part, next_one.name)
    return one.kind == next_one.kind == "collision" and here == there
