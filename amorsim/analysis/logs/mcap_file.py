"""A run as an MCAP file (https://mcap.dev), with Foxglove's schemas as JSON: it opens in Foxglove."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from amorsim.analysis.logs.message_shapes import VALUES
from amorsim.analysis.logs.message_values import beams_of, nanoseconds_of, quaternion
from amorsim.analysis.own_columns import own_commands, own_readings
from amorsim.analysis.run_files import RunFiles
from amorsim.core.errors import AnalysisError
from amorsim.core.files.atomic_files import replacing
from amorsim.scenario.spec import Robot
from amorsim.simulation.fleet.grouping import channels_of

__all__ = ["write_mcap"]

_TIME = {"type": "object", "properties": {"sec": {"type": "integer"}, "nsec": {"type": "integer"}}}


def _numbers(*names: str) -> dict[str, Any]:
    return {"type": "object", "properties": {name: {"type": "number"} for name in names}}


_POSE = {
    "type": "object",
    "properties": {"position": _numbers("x", "y", "z"), "orientation": _numbers("x", "y", "z", "w")},
}
_LIST = {"type": "array", "items": {"type": "number"}}
# Foxglove Studio refuses a schema whose items have several types, so that texts and null are in its description alone.
_VALUES = _LIST | {"description": 'Infinite numbers are "Infinity" or "-Infinity"; numbers that are none are null.'}
# What of Foxglove's schemas is used: https://docs.foxglove.dev/docs/sdk/schemas; and one of our own, for numbers.
_SCHEMAS: dict[str, dict[str, Any]] = {
    "foxglove.PoseInFrame": {"timestamp": _TIME, "frame_id": {"type": "string"}, "pose": _POSE},
    "foxglove.LaserScan": {
        "timestamp": _TIME,
        "frame_id": {"type": "string"},
        "pose": _POSE,
        "start_angle": {"type": "number"},
        "end_angle": {"type": "number"},
        "ranges": _LIST,
        "intensities": _LIST,
    },
    "foxglove.FrameTransform": {
        "timestamp": _TIME,
        "parent_frame_id": {"type": "string"},
        "child_frame_id": {"type": "string"},
        "translation": _numbers("x", "y", "z"),
        "rotation": _numbers("x", "y", "z", "w"),
    },
    "foxglove.Log": {
        "timestamp": _TIME,
        "level": {"type": "integer"},
        "message": {"type": "string"},
        "name": {"type": "string"},
        "file": {"type": "string"},
        "line": {"type": "integer"},
    },
    VALUES: {"timestamp": _TIME, "labels": {"type": "array", "items": {"type": "string"}}, "values": _VALUES},
}
Message = tuple[float, str, str, dict[str, Any]]  # time [s], topic, schema, content
_WARNING = 3


def write_mcap(files: RunFiles, path: Path, within: Path) -> None:
    """Write the first replica of a run: true and estimated poses, true frames, readings, commands, events.

    Topics are ``/ROBOT/true_pose``, ``/ROBOT/estimated_pose``, ``/ROBOT/SENSOR``, ``/ROBOT/command``, ``/tf/ROBOT`` and
    ``/events``. Ranges at even angles are scans; other readings are lists of numbers. Ranges without a return are left
    at 0; in lists they are ``"Infinity"``, and numbers that are none are null, because JSON has neither.

    Parameters
    ----------
    within
        The folder in which the file must stay, as of `amorsim.core.files.atomic_files.replacing`.

    Raises
    ------
    AnalysisError
        Without the library mcap.
    RunError
        If a file of the run is damaged, or the file cannot be written.
    """
    try:
        from mcap.writer import Writer
    except ModuleNotFoundError:
        raise AnalysisError('MCAP needs a library: python -m pip install "amorsim[mcap]"') from None
    messages = sorted(_messages(files), key=lambda message: message[:2])
    with replacing(path, within=within) as new, new.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="", library="amorsim")
        schemas, channels = {}, {}
        for number, (time, topic, schema, content) in enumerate(messages):
            if schema not in schemas:
                text = json.dumps({"title": schema, "type": "object", "properties": _SCHEMAS[schema]})
                schemas[schema] = writer.register_schema(name=schema, encoding="jsonschema", data=text.encode())
            if topic not in channels:
                channels[topic] = writer.register_channel(
                    topic=topic, message_encoding="json", schema_id=schemas[schema]
                )
            nanoseconds = nanoseconds_of(time)
            writer.add_message(
                channel_id=channels[topic],
                log_time=nanoseconds,
                publish_time=nanoseconds,
                sequence=number,
                data=json.dumps({"timestamp": _stamp(nanoseconds), **content}).encode(),
            )
        writer.finish()


def _messages(files: RunFiles) -> Iterator[Message]:
    replica = files.replicas[0]
    for robot in files.scenario.robots:
        table = files.table("poses", robot=robot.name, replica=replica)
        for what in ("true", "estimated"):
            rows = zip(
                table["time"].tolist(), *(table[f"{what}_{key}"].tolist() for key in ["x", "y", "heading"]), strict=True
            )
            for time, x, y, heading in rows:
                content = {"frame_id": "world", "pose": _pose(x, y, heading)}
                yield time, f"/{robot.name}/{what}_pose", "foxglove.PoseInFrame", content
                if what == "true":
                    pose = _pose(x, y, heading)
                    frames = {"parent_frame_id": "world", "child_frame_id": robot.name}
                    moved = {"translation": pose["position"], "rotation": pose["orientation"]}
                    yield time, f"/tf/{robot.name}", "foxglove.FrameTransform", frames | moved
        yield from _commands(files, robot, replica)
        for name in files.sensors:
            if name in robot.sensors:
                yield from _readings(files, robot, name, replica)
    events = files.table("events", replica=replica)
    for i, time in enumerate(events["time"].tolist()):
        text = f"{str(events['kind'][i]).replace('_', ' ')} {events['other'][i] or events['path'][i]}".strip()
        log = {"level": _WARNING, "message": text, "name": str(events["robot"][i]), "file": "", "line": 0}
        yield time, "/events", "foxglove.Log", log


def _commands(files: RunFiles, robot: Robot, replica: int) -> Iterator[Message]:
    table, values = own_commands(files, robot.name, replica)
    channels = list(channels_of(robot))
    # A line has the command of the step that ended then; it was given at the end of the step before.
    for time, row in zip(table["time"].tolist(), values[1:].tolist(), strict=False):
        yield time, f"/{robot.name}/command", VALUES, {"labels": channels, "values": row}


def _readings(files: RunFiles, robot: Robot, name: str, replica: int) -> Iterator[Message]:
    read, values = own_readings(files, robot.name, name, replica)
    unit, topic = robot.sensors[name], f"/{robot.name}/{name}"
    angles = beams_of(unit.sensor)
    mount = _pose(unit.mount.x, unit.mount.y, unit.mount.heading)
    for time, stamp, row in zip(read["time"].tolist(), read["stamp"].tolist(), values, strict=True):
        measured = {"timestamp": _stamp(nanoseconds_of(stamp))}
        if angles is None or len(angles) != values.shape[1]:
            content = {"labels": [unit.sensor.unit], "values": list(map(_number, row.tolist()))}
            yield time, topic, VALUES, measured | content
            continue
        scan = {
            **measured,
            "frame_id": robot.name,
            "pose": mount,
            "start_angle": float(angles[0]),
            "end_angle": float(angles[-1]),
            "ranges": np.where(np.isfinite(row), row, 0.0).tolist(),
            "intensities": [],
        }
        yield time, topic, "foxglove.LaserScan", scan


def _number(value: float) -> float | str | None:
    """A number for JSON: nan as null, an infinite one as the word that protobuf has for it."""
    if math.isinf(value):
        return "Infinity" if value > 0.0 else "-Infinity"
    return None if math.isnan(value) else value


def _stamp(nanoseconds: int) -> dict[str, int]:
    return {"sec": nanoseconds // 10**9, "nsec": nanoseconds % 10**9}


def _pose(x: float, y: float, heading: float) -> dict[str, dict[str, float]]:
    return {"position": {"x": x, "y": y, "z": 0.0}, "orientation": quaternion(heading)}
