"""All drives, in all their forms, for tests that hold for each of them."""

from __future__ import annotations

from typing import Any

from amorsim.contracts import Drive
from amorsim.drives import Ackermann, Differential, Mecanum, Synchro, Tractor, Tricycle

__all__ = ["MAKERS", "make"]

_CAR: dict[str, Any] = {
    "wheel_radius": 0.1,
    "wheelbase": 0.5,
    "track": 0.3,
    "steering_max": 0.6,
    "steering_rate": 1.5,
    "rate_max": 20.0,
}
_PAIR: dict[str, Any] = {"wheel_radius_left": 0.08, "wheel_radius_right": 0.08, "track": 0.32, "rate_max": 20.0}

MAKERS: dict[str, tuple[type[Drive], dict[str, Any]]] = {
    "differential": (Differential, _PAIR),
    "ackermann rear": (Ackermann, _CAR),
    "ackermann front": (Ackermann, _CAR | {"counted": "front"}),
    "ackermann centre": (Ackermann, _CAR | {"counted": "centre"}),
    "synchro fixed": (Synchro, {"wheel_radius": 0.06, "rate_max": 20.0, "steering_rate_max": 2.0}),
    "synchro follows": (
        Synchro,
        {"wheel_radius": 0.06, "rate_max": 20.0, "steering_rate_max": 2.0, "turret": "follows"},
    ),
    "synchro driven": (Synchro, {"wheel_radius": 0.06, "rate_max": 20.0, "steering_rate_max": 2.0, "turret": "driven"}),
    "tricycle": (Tricycle, {"wheel_radius": 0.1, "wheelbase": 0.6, "steering_rate": 2.0, "rate_max": 20.0}),
    "mecanum": (
        Mecanum,
        {
            "wheel_radius_front_left": 0.05,
            "wheel_radius_front_right": 0.05,
            "wheel_radius_rear_left": 0.05,
            "wheel_radius_rear_right": 0.05,
            "wheelbase": 0.3,
            "track": 0.25,
            "rate_max": 20.0,
        },
    ),
    "tractor": (
        Tractor,
        _PAIR
        | {
            "trailer_length": 0.6,
            "hitch_offset": 0.1,
            "trailer_width": 0.3,
            "trailer_front": 0.2,
            "trailer_rear": 0.2,
        },
    ),
}


def make(name: str, **changes: Any) -> Drive:
    """A drive by name, with some fields changed."""
    cls, fields = MAKERS[name]
    return cls(**(fields | changes))
