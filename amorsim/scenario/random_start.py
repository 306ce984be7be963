"""A start that is drawn at random."""

from __future__ import annotations

import attrs

from amorsim.contracts import parameter
from amorsim.core.parameters import ParameterError

__all__ = ["RandomStart"]


@attrs.frozen(kw_only=True)
class RandomStart:
    """A start that is drawn from the seed, free of walls and of all other bodies."""

    random: str | tuple[float, float, float, float] = parameter(
        "anywhere",
        unit="m",
        choices=("anywhere",),
        help="'anywhere' that a way leads to from the map's roomiest place, or the box xmin, ymin, xmax, ymax",
    )
    heading: float | None = parameter(None, unit="rad", help="where it looks; none: drawn too")
    clearance: float = parameter(0.0, unit="m", ge=0, help="kept free about it, at the start")
    per: str = parameter("replica", choices=("replica", "study"), help="who draws: each replica, or the study once")

    def __attrs_post_init__(self) -> None:
        box = self.box
        if box is not None and not (box[0] <= box[2] and box[1] <= box[3]):
            raise ParameterError("random", f"expected xmin <= xmax and ymin <= ymax, got {list(box)}")

    @property
    def box(self) -> tuple[float, float, float, float] | None:
        """The box that it is drawn in, None for anywhere."""
        return None if isinstance(self.random, str) else self.random
