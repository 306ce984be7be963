"""The sensors of a scenario's robot as models of a Stage world, and what Stage cannot hold of them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from amorsim.foreign.stage.geometry import Spot, neat

__all__ = ["list_of", "number_of", "written_sensors"]

Table = Mapping[str, Any]
Lose = Callable[[str], None]

_WIDEST = 170.0  # [deg] of a bumper's part: wider ones have no straight edge in front of the middle


def number_of(number: float) -> str:
    """A number as Stage reads it."""
    return repr(neat(float(number)))


def list_of(numbers: Iterable[float]) -> str:
    """Numbers in brackets."""
    return f"[{' '.join(map(number_of, numbers))}]"


def written_sensors(sensors: Mapping[str, Table], lose: Lose) -> list[str]:
    """The statements of rangers, fiducial finders and bumpers; `lose` is called with each loss."""
    found: list[str] = []
    for name, sensor in sensors.items():
        use = sensor["use"]
        if use == "encoder":
            if not (sensor.get("counts_per_revolution") == 4096.0 and not sensor.get("noise")):
                lose("its encoders are read back with 4096 counts per turn, and without errors")
            continue
        if use not in _WRITERS:
            lose(f"the sensor {name!r} ({use}) is left out: Stage has none like it")
            continue
        if sensor.get("latency"):
            lose(f"the latency of {name!r} is left out")
        found += _WRITERS[use](name, sensor, lose)
    return found


def _head(sensor: Table) -> list[str]:
    """Where a sensor is, and how often it reads."""
    lines = [f"pose {_pose(_spot(sensor.get('mount', {})))}"]
    if sensor.get("rate"):
        lines.append(f"update_interval {number_of(1000.0 / sensor['rate'])}")
    return lines


def _laser(name: str, sensor: Table, lose: Lose) -> list[str]:
    if sensor["beams"] < 2:
        lose(f"{name!r}, a laser of one beam, is read back as a sonar")
    if sensor.get("traversal", "exact") != "exact":
        lose(f"the rays of {name!r} are exact when read back")
    lines = [*_range(sensor), f"fov {number_of(sensor['fov_deg'])}", f"samples {sensor['beams']}"]
    return _block("ranger", [*_head(sensor), *_block("sensor", [*lines, *_noise(name, sensor, lose)])])


def _sonar(name: str, sensor: Table, lose: Lose) -> list[str]:
    noise = _noise(name, sensor, lose)
    if sensor.get("firing"):
        lose(f"the elements of {name!r} fire all at once")
    if sensor.get("beams_max") or sensor.get("acoustics"):
        lose(f"the acoustics of {name!r} are left out")
    shared = [*_range(sensor), f"fov {number_of(2.0 * sensor['half_angle_deg'])}", "samples 1", *noise]
    elements = [_block("sensor", [f"pose {_pose(_spot(element))}", *shared]) for element in sensor["elements"]]
    return _block("ranger", [*_head(sensor), *(line for element in elements for line in element)])


def _finder(name: str, sensor: Table, lose: Lose) -> list[str]:
    if sensor.get("noise"):
        lose(f"errors of {name!r} are left out")
    if sensor.get("slots", 8) != 8:
        lose(f"{name!r} is read back with room for 8 marks")
    numbers = (("range_max", "range_max"), ("range_max_id", "range_max_id"), ("fov", "fov_deg"))
    return _block("fiducial", [*_head(sensor), *(f"{key} {number_of(sensor[of])}" for key, of in numbers)])


def _bumper(name: str, sensor: Table, lose: Lose) -> list[str]:
    if sensor.get("noise"):
        lose(f"errors of {name!r} are left out")
    parts = [(one["start_deg"], (one["end_deg"] - one["start_deg"]) % 360.0) for one in sensor["segments"]]
    narrow = [(start, turn) for start, turn in parts if 0.0 < turn <= _WIDEST]
    if len(narrow) < len(parts):
        lose(f"parts of {name!r} that are wider than {_WIDEST:g} degrees are left out")
    lines = [*_head(sensor), f"bcount {len(narrow)}"]
    for k, (start, turn) in enumerate(narrow):
        middle = start + turn / 2.0
        at = Spot(degrees=middle).then(Spot(0.1, 0.0))
        lines.append(f"bpose[{k}] {_pose(at)}")
        lines.append(f"blength[{k}] {number_of(0.2 * math.tan(math.radians(turn / 2.0)))}")
    return _block("bumper", lines)


_WRITERS: dict[str, Callable[[str, Table, Lose], list[str]]] = {
    "laser": _laser,
    "sonar": _sonar,
    "fiducial": _finder,
    "bumper": _bumper,
}


def _range(sensor: Table) -> list[str]:
    return [f"range {list_of((sensor.get('range_min', 0.0), sensor['range_max']))}"]


def _noise(name: str, sensor: Table, lose: Lose) -> list[str]:
    """Stage's noise of a ranger: a constant, a proportional and an angular part."""
    constant = proportional = angular = 0.0
    for element in sensor.get("noise", ()):
        if element["use"] == "gaussian" and element.get("per", "sample") == "sample":
            constant, proportional = element["std"], element.get("proportional", 0.0) * math.sqrt(3.0)
        elif element["use"] == "aim_gaussian":
            angular = element["std_deg"] * math.sqrt(3.0)
        else:
            lose(f"the error {element['use']!r} of {name!r} is left out")
    return [f"noise {list_of((constant, proportional, angular))}"] if constant or proportional or angular else []


def _spot(table: Table) -> Spot:
    return Spot(table.get("x", 0.0), table.get("y", 0.0), table.get("heading_deg", 0.0))


def _pose(spot: Spot) -> str:
    return list_of((spot.x, spot.y, 0.0, spot.degrees))


def _block(kind: str, lines: Sequence[str]) -> list[str]:
    return [kind, "(", *(f"  {line}" for line in lines), ")"]
