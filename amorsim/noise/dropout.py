"""Values that get lost."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Context, Draws, Noise, NoiseStep, State, parameter
from amorsim.core.parameters import ParameterError

__all__ = ["Dropout"]


@attrs.frozen(kw_only=True)
class Dropout(Noise):
    """Loses each value with a probability, independently of the others and of earlier samples.

    Parameters
    ----------
    probability
        Probability that a value is lost.
    report
        What the device reports for a lost value. ``"inf"``: nothing returned, for range finders. ``"last"``: the
        previous report; the first sample has none before it and is never lost. ``"value"``: the number `value`,
        for devices that report their range for no return.
    value
        The report for a lost value with ``report = "value"``, in the sensor's unit.
    """

    probability: float = parameter(ge=0, le=1, help="that a value is lost")
    report: str = parameter(
        "inf",
        choices=("inf", "last", "value"),
        static=True,
        help="what is reported in its place: no return, what was reported before, or a number",
    )
    value: float | None = parameter(None, unit="sensor", help="what a lost value reads, with report = 'value'")

    def __attrs_post_init__(self) -> None:
        if (self.value is None) == (self.report == "value"):
            wanted = "a number with report = 'value'" if self.value is None else "none without report = 'value'"
            raise ParameterError("value", f"expected {wanted}, got {self.value!r}")

    def start(self, context: Context) -> State:
        """The last report `(N, k)`, nan before the first; only with ``report = "last"``."""
        return {"last": np.full((context.rows, context.size), np.nan)} if self.report == "last" else {}

    def steps(self) -> Sequence[NoiseStep]:
        """Replace lost values, unless by the last report."""
        if self.report == "last":
            return ()
        return [NoiseStep.replace(self.probability, math.inf if self.report == "inf" else self.value)]

    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        """The values `(N, k)`, lost ones replaced."""
        if self.report != "last":
            return super().corrupt(values, side, elapsed, state, draws)
        lost = draws.uniform(values.shape[1]) < self.probability
        last = state["last"]
        reported = np.where(lost & ~np.isnan(last), last, values)
        state["last"] = reported
        return reported
