from amorsim.metrics.consistency import Nees, Nis
from amorsim.metrics.driving import ArrivalTime, Collisions, PathLength, Spl, Success, Turning
from amorsim.metrics.errors import HeadingError, PositionError, RecoveryTime
from amorsim.metrics.mapping import MapAccuracy, MapCompleteness, MapIou
from amorsim.metrics.space import Clearance, Coverage

__all__ = [
    "ArrivalTime",
    "Clearance",
    "Collisions",
    "Coverage",
    "HeadingError",
    "MapAccuracy",
    "MapCompleteness",
    "MapIou",
    "Nees",
    "Nis",
    "PathLength",
    "PositionError",
    "RecoveryTime",
    "Spl",
    "Success",
    "Turning",
]
