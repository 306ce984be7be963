"""Stage's robots, as a scenario has them."""

from __future__ import annotations

import math
from typing import Any

import attrs
import shapely

from amorsim.foreign.stage.entities import Model
from amorsim.foreign.stage.geometry import (
    Spot,
    colour_of,
    moved,
    neat,
    outline_of,
    polygons,
    pose_of,
    size_of,
    vertices,
)
from amorsim.foreign.stage.notes import Notes
from amorsim.foreign.stage.sensors import SensorOptions, read_sensors

__all__ = ["RADIUS", "STEERING", "TRACK", "RobotOptions", "read_robot"]

Table = dict[str, Any]

# Stage's robots have no wheels. These shares of the body are those of its Pioneer 2DX (0.44 m x 0.38 m), whose wheels
# have a radius of 0.0825 m and a track of 0.33 m.
RADIUS, TRACK = 0.1875, 0.33 / 0.38
_LEAST = 0.01  # [m] of wheels and tracks
_COUNTS = 4096.0
STEERING = 45.0  # [deg] at most
_WANDER = 0.4  # [m/s]

_OF_ROBOT = frozenset(
    {
        *("pose", "size", "origin", "drive", "localization", "localization_origin", "odom_error", "wheelbase"),
        *(
            "velocity_bounds",
            "acceleration_bounds",
            "fiducial_return",
            "obstacle_return",
            "ranger_return",
            "laser_return",
        ),
        *("boundary", "update_interval"),
    }
)


@attrs.frozen(kw_only=True)
class RobotOptions:
    """Which behaviour of Stage is kept, and what robots do whose programs are Stage's."""

    sensors: SensorOptions
    other_controllers: str


def read_robot(model: Model, interval: float, notes: Notes, options: RobotOptions) -> Table:
    """The table of a robot without its name and its pose; `interval` is the length of a step [s]."""
    notes.check_keys(model, _OF_ROBOT)
    table: Table = {"shape": _shape(model, notes), "on_collision": "continue"}
    if (colour := colour_of(model, notes)) is not None:
        table["colour"] = colour
    table["height"] = neat(size_of(model, notes)[2])
    if "fiducial_return" in model.values and (mark := notes.count(model.values, "fiducial_return", 0, 2**31 - 1)):
        table["fiducial"] = mark
    if not (
        notes.number(model.values, "obstacle_return", 1.0) and notes.number(model.values, "ranger_return", 1.0) >= 0
    ):
        notes.remark("ghost robot", "robots are touched and seen here, whatever obstacle_return and ranger_return say")
    table["drive"], speed, turn = _drive(model, notes)
    table["sensors"] = {
        "encoder": {"use": "encoder", "counts_per_revolution": _COUNTS},
        **read_sensors(model, interval, notes, options.sensors),
    }
    table["estimators"] = {"odometry": {"use": "dead_reckoning", "encoder": "encoder"}}
    if (controller := _controller(model, table, speed, turn, notes, options)) is not None:
        table["controller"] = controller
    if errors := _errors(model, table["drive"]["use"], notes):
        table["errors"] = errors
    return table


def _shape(model: Model, notes: Notes) -> Table:
    """The footprint: the body with all parts on it that have one; the hull if it is not in one piece."""
    areas = [area for area in (outline_of(model, notes), *_carried(model, Spot(), notes)) if area is not None]
    parts = polygons(shapely.unary_union(areas)) if areas else []
    if not parts:
        notes.fault(model.place, f"{model.called} covers no area; expected a size of two numbers > 0")
        return {"circle": 0.1}
    if len(parts) > 1:
        parts = [shapely.MultiPolygon(parts).convex_hull]
    return {"polygon": vertices(parts[0])}


def _carried(model: Model, at: Spot, notes: Notes) -> list[Any]:
    found = []
    for each in model.inner:
        if each.kind == "position":
            notes.remark("robot on robot", "a robot that another one carries is a part of its body here", each.place)
        if each.kind in ("model", "position"):
            spot = at.then(pose_of(each, notes))
            area = outline_of(each, notes)
            found += [] if area is None else [moved(area, spot)]
            found += _carried(each, spot, notes)
    return found


def _bounds(model: Model, key: str, notes: Notes) -> tuple[float, float, float]:
    """The larger bound of both directions, ahead, aside [m] and turning [deg]; Stage's defaults if there are none."""
    numbers = notes.numbers(model.values, key, 2)
    pairs = [numbers[at : at + 2] for at in (0, 2, 6)]
    ahead, aside, turn = (
        max(map(abs, pair)) if len(pair) == 2 else default
        for pair, default in zip(pairs, (1.0, 1.0, 90.0), strict=True)
    )
    return ahead, aside, turn


def _drive(model: Model, notes: Notes) -> tuple[Table, float, float]:
    """The drive, and the top speed [m/s] and turn rate [deg/s]."""
    kind = notes.text(model.values, "drive", "diff")
    if kind not in ("diff", "omni", "car"):
        notes.fault(model.values["drive"].place, f"drive: expected diff, omni or car, got {kind!r}")
        kind = "diff"
    length, width, _ = size_of(model, notes)
    radius = neat(max(RADIUS * length, _LEAST))
    track = neat(max(TRACK * width, _LEAST))
    speed, aside, turn = _bounds(model, "velocity_bounds", notes)
    change, change_aside, change_turn = _bounds(model, "acceleration_bounds", notes)
    base = neat(max(TRACK * length, _LEAST))
    arm = {"diff": track / 2, "omni": (track + base) / 2, "car": 0.0}[kind]
    if kind != "omni":
        aside = change_aside = 0.0
    rim = max(speed, aside, math.radians(turn) * arm, 1e-3)
    push = max(change, change_aside, math.radians(change_turn) * arm, 1e-3)
    limits = {
        "rate_max_deg": neat(math.degrees(rim / radius)),
        "acceleration_max_deg": neat(math.degrees(push / radius)),
    }
    if kind == "diff":
        table: Table = {
            "use": "differential",
            "wheel_radius_left": radius,
            "wheel_radius_right": radius,
            "track": track,
        }
    elif kind == "omni":
        corners = [f"wheel_radius_{end}_{side}" for end in ("front", "rear") for side in ("left", "right")]
        table = {"use": "mecanum", **dict.fromkeys(corners, radius), "wheelbase": base, "track": track}
    else:
        wheelbase = notes.number(model.values, "wheelbase", 1.0)
        if not wheelbase > 0.0:
            notes.fault(model.values["wheelbase"].place, f"wheelbase: expected a number > 0, got {wheelbase:g}")
            wheelbase = 1.0
        most = neat(min(max(turn, 1.0), STEERING))
        table = {"use": "ackermann", "wheel_radius": radius, "wheelbase": neat(wheelbase), "track": track}
        table |= {"steering_max_deg": most, "steering_rate_deg": neat(2 * most)}
    return table | limits, speed, turn


def _controller(
    model: Model, table: Table, speed: float, turn: float, notes: Notes, options: RobotOptions
) -> Table | None:
    name = notes.text(model.values, "ctrl").partition(" ")[0]
    if not name:
        notes.remark("no ctrl", "robots without a ctrl stand still: Stage leaves them to a client", model.place)
        return None
    if name != "wander":
        does = "wander" if options.other_controllers == "wander" else "stand still"
        notes.remark(
            f"ctrl {name}",
            f"ctrl {name!r} is a program for Stage: here such robots {does}",
            model.values["ctrl"].place,
        )
        if does != "wander":
            return None
    rangers = [name for kind in ("laser", "sonar") for name in table["sensors"] if name.partition("_")[0] == kind]
    ranger = rangers[0] if rangers else None
    if ranger is None or (table["drive"]["use"] == "mecanum" and not _sees_all_round(table["sensors"][ranger])):
        text = "a robot without a ranger, or an omni without one that sees all round, cannot wander: it stands still"
        notes.remark("blind", text, model.place)
        return None
    quick = {"speed": neat(min(_WANDER, speed))} if speed > 0 else {}
    slow = {"turn_rate_deg": neat(min(math.degrees(1.0), turn))} if turn > 0 else {}
    return {"use": "wander", "sensor": ranger, **quick, **slow}


def _sees_all_round(sensor: Table) -> bool:
    if sensor["use"] == "laser":
        return bool(sensor["fov_deg"] * sensor["beams"] / max(sensor["beams"] - 1, 1) >= 360.0)
    looks = sorted(element["heading_deg"] for element in sensor["elements"])
    return len(looks) > 2 and max(b - a for a, b in zip(looks, [*looks[1:], looks[0] + 360.0], strict=True)) <= 90.0


def _errors(model: Model, drive: str, notes: Notes) -> Table:
    """Errors of odometry: as in Stage, of a share drawn evenly and kept for the whole run."""
    values = model.values
    how = notes.text(values, "localization", "gps")
    if any(notes.numbers(values, "localization_origin", 1)):
        notes.remark(
            "origin", "localization_origin is left out: estimates are in the world", values["localization_origin"].place
        )
    if how != "odom":
        return {}
    error = notes.numbers(values, "odom_error", 3) or [0.03, 0.03, 0.0, 0.05]
    ahead, turn = abs(error[0]) / 2, abs(error[-1]) / 2  # [x y z heading], or [x y heading] as in Stage 2
    if max(ahead, turn) >= 1.0:
        notes.fault(values["odom_error"].place, f"odom_error: expected shares below 2, got {2 * max(ahead, turn):g}")
        return {}
    table: Table = {}
    if ahead:
        table["sensors"] = {"encoder": {"counts_per_revolution": _share(ahead)}}
    if turn and drive == "differential":
        table["drive"] = {"track": _share(turn)}
    elif turn:
        notes.remark("odom_error", "the turn's odom_error is left out for robots that are not diff", model.place)
    return table


def _share(half: float) -> Table:
    return {"scale": {"uniform": [neat(1.0 - half), neat(1.0 + half)]}}
