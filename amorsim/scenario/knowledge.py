"""What a robot knows of the world."""

from __future__ import annotations

import operator
from collections.abc import Iterable

import attrs
import numpy as np

from amorsim.core.maps.map import Map
from amorsim.core.parameters import ParameterError
from amorsim.scenario.kinds import is_a

__all__ = ["Knowledge"]


def _places(given: Iterable[Iterable[float]]) -> tuple[tuple[float, float], ...]:
    try:
        places = np.array([tuple(place) for place in given], dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        places = np.empty((1, 0))
    if len(places) and (places.ndim != 2 or places.shape[1] != 2 or not np.isfinite(places).all()):
        raise ParameterError("landmarks", f"expected points [(x, y), ...] of finite numbers [m], got {given!r}")
    return tuple((x, y) for x, y in places.tolist())


def _ids(given: Iterable[int]) -> tuple[int, ...]:
    try:
        return tuple(operator.index(number) for number in given)
    except TypeError:
        raise ParameterError("landmark_ids", f"expected whole numbers, got {given!r}") from None


@attrs.frozen(kw_only=True)
class Knowledge:
    """What a robot knows of the world; the world may differ.

    `landmark_ids` are those of the `landmarks`, 0 for a landmark that looks like others; they are empty if all do.
    """

    map: Map | None = attrs.field(default=None, validator=is_a(Map, "am.load_map('rooms.wld')", optional=True))
    landmarks: tuple[tuple[float, float], ...] = attrs.field(default=(), converter=_places)
    landmark_ids: tuple[int, ...] = attrs.field(default=(), converter=_ids)

    def __attrs_post_init__(self) -> None:
        if self.landmark_ids and len(self.landmark_ids) != len(self.landmarks):
            raise ParameterError(
                "landmark_ids", f"expected one for each of {len(self.landmarks)} landmarks, got {self.landmark_ids}"
            )
