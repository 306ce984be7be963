"""The sensors of Stage's robots, as a scenario has them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

import attrs

from amorsim.foreign.stage.entities import Model
from amorsim.foreign.stage.geometry import Spot, neat, pose_of, spot_of
from amorsim.foreign.stage.notes import Notes

__all__ = ["SensorOptions", "read_sensors"]

Table = dict[str, Any]

_MOST_BEAMS = 100_000
_MOST_ELEMENTS = 1000
_RANGERS = ("ranger", "laser")
_LEFT_OUT = (
    *("blobfinder", "camera", "gripper", "actuator", "lightindicator", "blinkenlight", "speech", "wifi", "loadcell"),
    *("camera3d", "power_pack", "powerpack", "charger"),
)
_OF_BODY = frozenset(
    {"pose", "size", "origin", "obstacle_return", "ranger_return", "fiducial_return", "update_interval"}
)
_OF_SENSOR = frozenset({"pose", "size", "range", "fov", "samples", "noise", "view"})
_OF_RANGER = frozenset({"scount", "spose", "sview", "ssize", *_OF_SENSOR, *_OF_BODY})
_OF_LASER = frozenset({"range_min", "range_max", "resolution", *_OF_RANGER})
_OF_FIDUCIAL = frozenset({"range_min", "range_max", "range_max_id", "fov", *_OF_BODY})
_OF_BUMPER = frozenset({"bcount", "bpose", "blength", *_OF_BODY})


@attrs.frozen(kw_only=True)
class SensorOptions:
    """Which behaviour of Stage is kept."""

    noise_as_variance: bool
    sonar_as_ray: bool


class _Beam(NamedTuple):
    """One sensor of a ranger: samples over a field of view [deg] from a spot on the robot."""

    spot: Spot
    samples: int
    fov: float
    nearest: float
    farthest: float
    noise: tuple[float, float, float]
    rate: float | None

    @property
    def kind(self) -> tuple[Any, ...]:
        """The properties that elements of one ring share."""
        return self[2:]


def read_sensors(robot: Model, interval: float, notes: Notes, options: SensorOptions) -> dict[str, Table]:
    """The sensors that a robot carries, by name: ``laser``, ``sonar``, ``finder``, ``bumper``, then ``laser_2`` ...

    `interval` is the length of a step [s]: what is read less often has a rate.
    """
    found: dict[str, Table] = {}
    for model, spot in _carried(robot, Spot(), notes):
        if model.kind in _RANGERS:
            tables = _ranger(model, spot, interval, notes, options)
        elif model.kind in ("fiducial", "fiducialfinder"):
            tables = iter([("finder", _finder(model, spot, interval, notes))])
        else:
            tables = iter([("bumper", table)] if (table := _bumper(model, spot, notes)) else [])
        for name, table in tables:
            number = 1 + sum(other.rpartition("_")[0] == name or other == name for other in found)
            found[name if number == 1 else f"{name}_{number}"] = table
    return found


def _carried(model: Model, at: Spot, notes: Notes) -> Iterator[tuple[Model, Spot]]:
    """The sensors in a model, and where they are on it; a model that is not a sensor may carry some."""
    for each in model.inner:
        if each.kind in _LEFT_OUT:
            notes.remark(f"left out {each.kind}", f"a {each.kind} is left out: there is none here", each.place)
        elif each.kind in (*_RANGERS, "fiducial", "fiducialfinder", "bumper"):
            yield each, at.then(pose_of(each, notes))
        if each.kind not in ("block", "sensor", "position"):
            yield from _carried(each, at.then(pose_of(each, notes)), notes)


def _ranger(
    model: Model, spot: Spot, interval: float, notes: Notes, options: SensorOptions
) -> Iterator[tuple[str, Table]]:
    rings: dict[tuple[Any, ...], list[_Beam]] = {}
    for beam in _beams(model, spot, interval, notes):
        if beam.samples > 1:
            table: Table = {"use": "laser", "beams": beam.samples, "fov_deg": neat(beam.fov or 1.0)}
            yield "laser", table | _range_of(beam) | {"mount": beam.spot.table()} | _noise_of(beam, options)
        else:
            rings.setdefault(beam.kind, []).append(beam)
    for ring in rings.values():
        half = 0.0 if options.sonar_as_ray else min(ring[0].fov / 2, 90.0)
        table = {"use": "sonar", "elements": [beam.spot.table() for beam in ring], "half_angle_deg": neat(half)}
        yield "sonar", table | _range_of(ring[0]) | _noise_of(ring[0], options)


def _beams(model: Model, spot: Spot, interval: float, notes: Notes) -> Iterable[_Beam]:
    """The sensors of a ranger, or in Stage 2 and 3 the single one that it is."""
    notes.check_keys(model, _OF_LASER if model.kind == "laser" else _OF_RANGER)
    rate = _rate(model, interval, notes)
    sensors = [each for each in model.inner if each.kind == "sensor"]
    if sensors:
        for each in sensors:
            notes.check_keys(each, _OF_SENSOR)
            yield _beam(each, spot.then(pose_of(each, notes)), rate, notes)
    elif "scount" in model.values:
        own = _beam(model, spot, rate, notes, view="sview")
        for number in range(notes.count(model.values, "scount", 0, _MOST_ELEMENTS)):
            yield own._replace(spot=spot.then(spot_of(model, f"spose[{number}]", notes)))
    else:
        own = _beam(model, spot, rate, notes)
        if model.kind == "laser":
            far = notes.number(model.values, "range_max", 8.0)
            samples = own.samples if "samples" in model.values else 180
            fov = own.fov if "fov" in model.values else 180.0
            own = own._replace(farthest=far, samples=samples, fov=fov)
        yield own


def _beam(model: Model, spot: Spot, rate: float | None, notes: Notes, view: str = "view") -> _Beam:
    values = model.values
    nearest, farthest = (notes.numbers(values, "range", 2) or [0.0, 5.0])[:2]
    fov = notes.number(values, "fov", 5.7)
    if seen := notes.numbers(values, view, 3):  # as in Stage 3, in one key
        nearest, farthest, fov = seen[:3]
    if not 0.0 <= nearest < farthest:
        place = values[view if seen else "range"].place
        notes.fault(place, f"range: expected [MIN MAX], 0 <= MIN < MAX, got [{nearest:g} {farthest:g}]")
        nearest, farthest = 0.0, 5.0
    if not 0.0 <= fov <= 360.0:
        notes.fault(values["fov" if "fov" in values else view].place, f"fov: expected 0 to 360 degrees, got {fov:g}")
        fov = 30.0
    noise = [*notes.numbers(values, "noise", 1), 0.0, 0.0, 0.0][:3]
    if min(noise) < 0.0:
        notes.fault(values["noise"].place, f"noise: expected numbers of at least 0, got {min(noise):g}")
    samples = notes.count(values, "samples", 1, _MOST_BEAMS)
    return _Beam(spot, samples, fov, nearest, farthest, (noise[0], noise[1], noise[2]), rate)


def _rate(model: Model, interval: float, notes: Notes) -> float | None:
    """Readings a second [Hz], where they are fewer than steps."""
    period = notes.number(model.values, "update_interval", 0.0) / 1000.0
    return neat(1.0 / period) if period > interval * 1.000001 else None


def _range_of(beam: _Beam) -> Table:
    table: Table = {"range_min": neat(beam.nearest)} if beam.nearest or beam.samples == 1 else {}
    table["range_max"] = neat(beam.farthest)
    return table | ({} if beam.rate is None else {"rate": beam.rate})


def _noise_of(beam: _Beam, options: SensorOptions) -> Table:
    """Stage's noise: a constant, a proportional and an angular part; the last two are uniform."""
    constant, proportional, angular = beam.noise
    chain: list[Table] = []
    if angular:
        chain.append({"use": "aim_gaussian", "std_deg": neat(angular / math.sqrt(3.0))})
    if constant or proportional:
        std = math.sqrt(constant) if options.noise_as_variance else constant
        chain.append({"use": "gaussian", "std": neat(std), "proportional": neat(proportional / math.sqrt(3.0))})
    return {"noise": chain} if chain else {}


def _finder(model: Model, spot: Spot, interval: float, notes: Notes) -> Table:
    notes.check_keys(model, _OF_FIDUCIAL)
    values = model.values
    farthest = notes.number(values, "range_max", 8.0)
    fov = notes.number(values, "fov", 180.0)
    if not (farthest > 0.0 and 0.0 < fov <= 360.0):
        notes.fault(model.place, f"expected range_max > 0 and a fov of 0 to 360 degrees, got {farthest:g} and {fov:g}")
    farthest_id = notes.number(values, "range_max_id", 5.0)
    table: Table = {"use": "fiducial", "range_max": neat(farthest), "range_max_id": neat(max(farthest_id, 0.0))}
    rate = _rate(model, interval, notes)
    table |= {"fov_deg": neat(fov), "mount": spot.table()}
    return table if rate is None else {**table, "rate": rate}


def _bumper(model: Model, spot: Spot, notes: Notes) -> Table | None:
    """A bumper: the directions from its middle that bound each of its parts."""
    notes.check_keys(model, _OF_BUMPER)
    segments = []
    common = notes.number(model.values, "blength", 0.1)
    for number in range(notes.count(model.values, "bcount", 0, _MOST_ELEMENTS)):
        half = notes.number(model.values, f"blength[{number}]", common) / 2
        part = spot_of(model, f"bpose[{number}]", notes)
        ends = [math.degrees(math.atan2(*reversed(part.point(0.0, side)))) for side in (-half, half)]
        turn = (ends[1] - ends[0]) % 360.0
        start, turn = (ends[0], turn) if turn <= 180.0 else (ends[1], 360.0 - turn)
        if turn > 1e-6:
            segments.append({"start_deg": neat(start), "end_deg": neat(start + turn)})
    if not segments:
        notes.remark("bumper", "a bumper without bcount and bpose has no parts, and is left out", model.place)
        return None
    return {"use": "bumper", "segments": segments, "mount": spot.table()}
