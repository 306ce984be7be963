"""Steps of a group of robots or obstacles as plain numbers, kept until they are worth writing."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from amorsim.array_types import AnyArray, Array, Ints
from amorsim.contracts import Frame
from amorsim.recorders.line_printer import Span

__all__ = ["BodySteps", "RobotSteps", "Steps", "small_beliefs"]


_NUMBERS = 1 << 17  # numbers of one group that are kept before they are written
_MOST_STEPS = 512
_LARGEST_BELIEF = 64  # numbers in a row


class Steps:
    """The last steps of one group, each a line of a table.

    Attributes
    ----------
    rows
        Number of rows.
    texts
        The rows' names, followed by the numbers of their replicas.
    count
        Number of steps kept.
    table
        `(most, w)`: each line holds the quantities one after the other, each with the values of row 0 first.
    """

    def __init__(self, names: Sequence[str], replicas: Ints, sizes: Sequence[tuple[str, int]]) -> None:
        self.rows = len(names)
        self.texts = [*names, *map(str, replicas.tolist())]
        self.count = 0
        self._places: dict[str, tuple[int, int]] = {}
        width = 0
        for name, size in sizes:
            self._places[name] = width, size
            width += size * self.rows
        self.most = max(1, min(_MOST_STEPS, _NUMBERS // max(width, 1)))
        self.table = np.empty((self.most, width))

    def __getitem__(self, name: str) -> Array:
        """A quantity of the kept steps, `(steps, rows, values)`; a view of the table."""
        first, size = self._places[name]
        return self.table[: self.count, first : first + self.rows * size].reshape(self.count, self.rows, size)

    def span(self, kind: int, name: str, of: int = 0, count: int | None = None) -> Span:
        """Columns of a quantity: all its values, or `count` of them from value `of` on."""
        first, size = self._places[name]
        return Span(kind, first + of, size, size - of if count is None else count)


class BodySteps(Steps):
    """Steps of bodies of which only poses are written."""

    def __init__(self, names: Sequence[str], replicas: Ints) -> None:
        super().__init__(names, replicas, [("time", 1), ("true_pose", 3)])

    def add(self, time: Array, poses: Array) -> bool:
        """Keep a step; returns whether there is no room for another."""
        line = self.table[self.count]
        line[: self.rows] = time
        line[self.rows :] = poses.reshape(-1)
        self.count += 1
        return self.count == self.most


def small_beliefs(frame: Frame) -> dict[str, dict[str, tuple[int, ...]]]:
    """By estimator, the shape in a row of each belief that is small enough for a text file."""
    found = {}
    for name, beliefs in frame.beliefs.items():
        shapes = {belief: array.shape[1:] for belief, array in beliefs.items()}
        found[name] = {belief: shape for belief, shape in shapes.items() if 0 < math.prod(shape) <= _LARGEST_BELIEF}
    return {name: shapes for name, shapes in found.items() if shapes}


class RobotSteps(Steps):
    """Steps of robots: the quantities of a frame, and room for those derived from it before it is written.

    The derived ones are `estimated_twist`, `measured_rates`, and by sensor the `seconds` at which a sample was taken.
    With `with_beliefs`, the estimators are asked for their small beliefs in each step.

    Attributes
    ----------
    beliefs
        By estimator, the name and the shape in a row of each belief that is kept.
    """

    def __init__(self, frame: Frame, with_beliefs: bool = False) -> None:
        self.first = frame  # the source of everything that does not change from step to step
        self.beliefs = small_beliefs(frame) if with_beliefs else {}
        joints = frame.joint_rates.shape[1]
        kept = [("time", 1), ("true_pose", 3), ("true_twist", 3), ("joint_rates", joints)]
        kept.append(("command", frame.command.shape[1]))
        for name in frame.estimates:
            kept += [(f"pose {name}", 3), (f"covariance {name}", 9)]
        for name, (true, _) in frame.readings.items():
            size = true.shape[1]
            kept += [(f"true {name}", size), (f"measured {name}", size), (f"stamp {name}", 1), (f"fresh {name}", 1)]
        for name, beliefs in self.beliefs.items():
            kept += [(f"belief {name} {belief}", math.prod(shape)) for belief, shape in beliefs.items()]
        self._end = len(frame.names) * sum(size for _, size in kept)  # end of the frame's quantities
        reckoned = [
            ("estimated_twist", 3),
            ("measured_rates", joints),
            *((f"seconds {name}", 1) for name in frame.readings),
        ]
        super().__init__(frame.names, frame.replica, kept + reckoned)

    def add(self, frame: Frame) -> bool:
        """Keep a copy of a step; returns whether there is no room for another."""
        whole: list[AnyArray] = [frame.time, frame.true_pose, frame.true_twist, frame.joint_rates]
        whole.append(frame.command)
        for estimate in frame.estimates.values():
            whole += estimate
        for true, reading in frame.readings.values():
            whole += (true, reading.measured, reading.stamp, reading.fresh)
        for name, beliefs in self.beliefs.items():
            found = frame.some_beliefs(name, beliefs)
            whole += [found[belief] for belief in beliefs]
        np.concatenate([array.ravel() for array in whole], out=self.table[self.count, : self._end])
        self.count += 1
        return self.count == self.most
