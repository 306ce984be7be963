"""The contract of noise: the elements of a chain."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from amorsim.array_types import Array
from amorsim.contracts.robot import Component
from amorsim.contracts.values import Aim, State
from amorsim.core.draws import Draws
from amorsim.core.noise_steps import NoiseProgram, NoiseStep

__all__ = ["Noise"]


class Noise(Component):
    """One element of a noise chain, which a device's values pass in order. Override at least one method.

    An element with `for_ground` acts between wheels and ground, in `Robot.ground` or in a zone: its values are travels,
    and sensors reject it.
    """

    for_ground: ClassVar[bool] = False

    def aim(self, aim: Aim, elapsed: Array, state: State, draws: Draws) -> Aim:
        """The device's true aim, before it senses."""
        return aim

    def steps(self) -> Sequence[NoiseStep]:
        """The element as steps for a kernel; empty if `corrupt` is written in Python.

        A chain runs the steps of neighbouring elements in one call, so an element made of steps costs next to
        nothing. Do not override `corrupt` then: it runs the same steps.
        """
        return ()

    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        """The corrupted values `(N, k)`; `elapsed` `(N, 1)` [s] since the previous sample (0 at the first)."""
        program = NoiseProgram([values.shape[1]], [[(step, draws) for step in self.steps()]])
        out = np.empty(values.shape)
        program.apply(np.ravel(values), out.reshape(-1))
        return out

    def slide(self, motion: Array, elapsed: Array, state: State, draws: Draws) -> Array:
        """The body's slide in a step `(N, 3)` [m, m, rad], in addition to the `motion` that its wheels make.

        Both are (forward, left, turn) in the body's frame, `(N, 3)`; the slide is spread evenly over the step. It is
        used in the `ground` of a robot or a zone, and called after `corrupt`. Encoders do not see it.
        """
        return np.zeros_like(motion)

    def delay(self, elapsed: Array, state: State, draws: Draws) -> Array:
        """Delay `(N, 1)` [s] of a reading in addition to its sensor's latency; negative: it arrives earlier.

        The delays of a chain add up. No reading arrives before it was taken or overtakes one taken earlier.
        """
        return np.zeros_like(elapsed)

    def longest_delay(self) -> Array:
        """Upper bound `(N, 1)` [s] of `delay`; override both together. It must not change during a run."""
        return np.zeros((1, 1))
