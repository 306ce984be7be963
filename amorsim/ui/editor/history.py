"""The steps that can be undone: what each changed in which text."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

__all__ = ["MOST_STEPS", "History", "Patch", "Step", "difference"]

MOST_STEPS = 500


class Patch(NamedTuple):
    """A change of a text: at `start`, `old` was replaced by `new`."""

    start: int
    old: str
    new: str

    def apply(self, text: str, *, back: bool = False) -> str:
        """The text after the change, or before it."""
        old, new = (self.new, self.old) if back else (self.old, self.new)
        return text[: self.start] + new + text[self.start + len(old) :]


class Step(NamedTuple):
    """A gesture: its label, and the change of each text by the text's name."""

    label: str
    patches: Mapping[str, Patch]


def difference(old: str, new: str) -> Patch:
    """The shortest single change that turns one text into another."""
    start = _alike(old, new)
    tail = _alike(old[start:][::-1], new[start:][::-1])
    return Patch(start, old[start : len(old) - tail], new[start : len(new) - tail])


def _alike(one: str, other: str) -> int:
    """The length of the common beginning."""
    low, high = 0, min(len(one), len(other))
    while low < high:
        middle = (low + high + 1) // 2
        if one[low:middle] == other[low:middle]:
            low = middle
        else:
            high = middle - 1
    return low


class History:
    """The steps that were made, and those that were undone.

    Attributes
    ----------
    done, undone
        The steps, the newest last.
    """

    def __init__(self) -> None:
        self.done: list[Step] = []
        self.undone: list[Step] = []

    def add(self, step: Step) -> None:
        """Add a step. Undone steps are forgotten, and so are the oldest ones above `MOST_STEPS`."""
        self.done.append(step)
        self.undone.clear()
        del self.done[:-MOST_STEPS]

    def back(self) -> Step | None:
        """The step to undo, which can be redone afterwards; None if there is none."""
        if not self.done:
            return None
        self.undone.append(self.done.pop())
        return self.undone[-1]

    def forward(self) -> Step | None:
        """The step to redo; None if there is none."""
        if not self.undone:
            return None
        self.done.append(self.undone.pop())
        return self.done[-1]

    def rename(self, old: str, new: str) -> None:
        """Rename a text in all steps."""
        for steps in (self.done, self.undone):
            steps[:] = [
                Step(step.label, {new if name == old else name: patch for name, patch in step.patches.items()})
                for step in steps
            ]
