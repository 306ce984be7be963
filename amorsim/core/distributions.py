"""Numbers drawn at random: as a file, a form or a script specifies them, and how they are drawn."""

from __future__ import annotations

import attrs
import numpy as np

from amorsim.core.draws import Draws, stream_key
from amorsim.core.parameters import ParameterError, parameter

__all__ = ["STUDY", "Distribution", "drawn"]

STUDY = 2**32 - 1
"""The replica's word in the counter of draws that a study makes once; replicas are numbered below it."""


@attrs.frozen(kw_only=True)
class Distribution:
    """A number drawn at random: normal (mean, standard deviation) or uniform (low, high)."""

    kind: str = parameter(choices=("normal", "uniform"), help="the distribution")
    values: tuple[float, float] = parameter(help="normal: mean and standard deviation; uniform: low and high")

    def __attrs_post_init__(self) -> None:
        first, second = self.values
        if self.kind == "normal" and second < 0:
            raise ParameterError("normal", f"expected a standard deviation >= 0, got {second!r}")
        if self.kind == "uniform" and second < first:
            raise ParameterError("uniform", f"expected low <= high, got {first!r} and {second!r}")

    def __str__(self) -> str:
        """As ``normal(1, 0.02)``."""
        first, second = self.values
        return f"{self.kind}({first:g}, {second:g})"


def drawn(distribution: Distribution, seed: int, names: tuple[str, ...], replica: int) -> float:
    """The number that a replica, or the study as `STUDY`, draws; `names` are those of the stream."""
    key = np.array([stream_key(seed, *names)], dtype=np.uint64)
    draws = Draws(key, np.array([[replica, 0, 0]], dtype=np.uint32))
    first, second = distribution.values
    if distribution.kind == "normal":
        return first + second * float(draws.normal()[0, 0])
    return first + (second - first) * float(draws.uniform()[0, 0])
