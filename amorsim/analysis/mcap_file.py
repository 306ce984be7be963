"""A run as an MCAP file (https://mcap.dev), with Foxglove's schemas as JSON: it opens in Foxglove."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from amorsim.analysis.files import RunFiles
from amorsim.core.errors import AnalysisError
from amorsim.core.whole_files import replacing

__all__ = ["write_mcap"]

_TIME = {"type": "object", "properties": {"sec": {"type": "integer"}, "nsec": {"type": "integer"}}}


def _numbers(*names: str) -> dict[str, Any]:
    return {"type": "object", "properties": {name: {"type": "number"} for name in names}}


_POSE = {
    "type": "object",
    "properties": {"position": _numbers("x", "y", "z"), "orientation": _numbers("x", "y", "z", "w")},
}
_LIST = {"type": "array", "items": {"type": "number"}}
# What of Foxglove's schemas is used: https://docs.foxglove.dev/docs/sdk/schemas
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
}
Message = tuple[float, str, str, dict[str, Any]]  # time [s], topic, schema, content
_WARNING = 3


def write_mcap(files: RunFiles, path: Path) -> None:
    """Write the first replica of a run: true and estimated poses, true frames, lasers' ranges, events.

    Topics are ``/ROBOT/true_pose``, ``/ROBOT/estimated_pose``, ``/ROBOT/SENSOR``, ``/tf`` and ``/events``. Ranges
    without a return are left at 0, because JSON has no infinity.

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
    with replacing(path) as new, new.open("wb") as stream:
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
            nanoseconds = round(time * 1e9)
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
        for name in files.sensors:
            unit = robot.sensors.get(name)
            bearings = None if unit is None else unit.sensor.bearings()
            if unit is None or bearings is None or unit.sensor.unit != "m":
                continue
            angles = np.asarray(bearings)[0]
            read = files.table(f"sensors/{name}", robot=robot.name, replica=replica)
            ranges = np.stack([read[f"measured_{i}"] for i in range(len(angles))], axis=1)
            ranges = np.where(np.isfinite(ranges), ranges, 0.0)
            mount = _pose(unit.mount.x, unit.mount.y, unit.mount.heading)
            for time, row in zip(read["time"].tolist(), ranges.tolist(), strict=True):
                yield (
                    time,
                    f"/{robot.name}/{name}",
                    "foxglove.LaserScan",
                    {
                        "frame_id": robot.name,
                        "pose": mount,
                        "start_angle": float(angles[0]),
                        "end_angle": float(angles[-1]),
                        "ranges": row,
                        "intensities": [],
                    },
                )
    events = files.table("events", replica=replica)
    for i, time in enumerate(events["time"].tolist()):
        told = f"{str(events['kind'][i]).replace('_', ' ')} {events['other'][i] or events['path'][i]}".strip()
        log = {"level": _WARNING, "message": told, "name": str(events["robot"][i]), "file": "", "line": 0}
        yield time, "/events", "foxglove.Log", log


def _stamp(nanoseconds: int) -> dict[str, int]:
    return {"sec": nanoseconds // 10**9, "nsec": nanoseconds % 10**9}


def _pose(x: float, y: float, heading: float) -> dict[str, dict[str, float]]:
    turned = {"x": 0.0, "y": 0.0, "z": math.sin(0.5 * heading), "w": math.cos(0.5 * heading)}
    return {"position": {"x": x, "y": y, "z": 0.0}, "orientation": turned}
