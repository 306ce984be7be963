"""The content of a run's page, in few bytes: the scene, and the run's moments, events and beliefs."""

from __future__ import annotations

import base64
import json
import struct
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from amorsim.array_types import Array
from amorsim.ui.run_page.packed_tables import SeriesWriter
from amorsim.ui.simulator.frames.packing import Dynamic
from amorsim.ui.simulator.sources.past import Places
from amorsim.ui.simulator.sources.recording import Recording

__all__ = ["contents_of"]


RATE = 20.0  # moments a second that are kept
MOST_MOMENTS = 6000
MOST_ROBOTS = 8  # whose readings and beliefs are kept; of the others, poses
MOST_PARTICLES = 400  # of a moment
MOST_BELIEFS = 400  # moments of which maps and intentions are kept
MOST_OF_PAST = 500  # moments that plots have

_OF_ROBOT = ("true_rates", "measured_rates", "true_twist", "estimated_twist", "command")


def contents_of(recording: Recording, *, rate: float = RATE) -> bytes:
    """The replica that a recording shows, as the page's script reads it.

    Four bytes hold the length of a JSON text (little endian), which follows; after it come the bytes of its `Series`.

    Parameters
    ----------
    rate
        Moments a second of the run that are kept; fewer of a long run.
    """
    last, dt = recording.newest, recording.dt
    ticks = _ticks(last, max(1, round(1.0 / (rate * dt)), -(-last // MOST_MOMENTS)))
    recording.watched = tuple(range(min(MOST_ROBOTS, len(recording.names))))
    beliefs = {recording.names[robot]: (_Interned(), _Interned()) for robot in recording.watched}
    every = -(-len(ticks) // MOST_BELIEFS)
    kept: list[list[Dynamic]] = []
    for place, tick in enumerate(ticks):
        recording.scrub(tick)
        kept.append(recording.moments())
        if place % every == 0:
            for name, (mapped, intended) in beliefs.items():
                mapped.add(tick, recording.mapped(name))
                intended.add(tick, [recording.intended(name)])
    writer = SeriesWriter()
    shared = [moments[0] for moments in kept]
    robots = [
        {
            **_robot(recording, writer, robot, ticks, [moments[robot] for moments in kept]),
            "mapped": mapped.kept,
            "intended": intended.kept,
        }
        for robot, (mapped, intended) in enumerate(beliefs.values())
    ]
    head = {
        "scene": _scene(recording, robots),
        "images": _images(recording),
        "epoch": recording.epoch,
        "newest": last,
        "ticks": ticks,
        "bodies": {
            "true_poses": writer.add(_rows(moment.true_pose for moment in shared)),
            "estimated_poses": writer.add(_rows(moment.estimated_pose for moment in shared)),
            "covariances": writer.add(_rows(moment.covariance for moment in shared), finest=-9),
            "obstacles": writer.add(_rows(moment.obstacle_pose for moment in shared)),
            "flags": writer.add(_rows(moment.robot_flags for moment in shared)),
        },
        "robots": robots,
        "events": recording.events(),
        "damage": recording.damage,
    }
    text = json.dumps(head, separators=(",", ":")).encode()
    return struct.pack("<I", len(text)) + text + bytes(writer.data)


def _ticks(last: int, every: int) -> list[int]:
    ticks = list(range(0, last + 1, every))
    return ticks if ticks[-1] == last else [*ticks, last]


def _rows(arrays: Any) -> Array:
    """Arrays of one length, as the rows of a table."""
    rows = [np.asarray(array, dtype=float).reshape(-1) for array in arrays]
    return np.array(rows).reshape(len(rows), -1)


def _robot(
    recording: Recording, writer: SeriesWriter, robot: int, ticks: Sequence[int], moments: Sequence[Dynamic]
) -> dict[str, Any]:
    """A robot's past: readings, rates, particles and other plotted values."""
    selected = [moment.selected for moment in moments]
    sensors = recording.scene["kinds"][recording.scene["robots"][robot]["kind"]]["sensors"]
    places = Places((one["size"], len(one["columns"])) for one in sensors)
    plotted = range(0, len(ticks), -(-len(ticks) // MOST_OF_PAST))
    return {
        "true_values": writer.add(_rows(one.true for one in selected)),
        "measured_values": writer.add(_rows(one.measured for one in selected)),
        "ages": writer.add(_rows(one.age for one in selected), finest=-3),
        "believed_parts": writer.add(_rows(one.parts for one in selected)),
        **{name: writer.add(_rows(getattr(one, name) for one in selected)) for name in _OF_ROBOT},
        "particles": _clouds(writer, [one.particles.reshape(-1, 4) for one in selected], MOST_PARTICLES),
        "hypotheses": _clouds(writer, [one.hypotheses.reshape(-1, 10) for one in selected], MOST_PARTICLES),
        "past": {
            "ticks": [ticks[place] for place in plotted],
            "values": writer.add(_rows(_line(places, moments[place], robot) for place in plotted), finest=-9),
        },
    }


def _line(places: Places, moment: Dynamic, robot: int) -> Array:
    """The numbers of a moment that plots show."""
    poses = (moment.true_pose[robot], moment.estimated_pose[robot], moment.covariance[robot])
    return places.line(np.concatenate(poses), moment.selected)


def _clouds(writer: SeriesWriter, clouds: Sequence[Array], most: int) -> dict[str, Any]:
    """Tables of any number of rows, one for each moment: those that are the same are kept once."""
    places: dict[bytes, int] = {}
    tables: list[Array] = []
    of_moment = []
    for cloud in clouds:
        table = cloud[:: max(1, -(-len(cloud) // most))]
        table = table[np.argsort(table[:, 0], kind="stable")]  # neighbours differ little; their order shows nowhere
        place = places.setdefault(table.tobytes(), len(tables))
        if place == len(tables):
            tables.append(table)
        of_moment.append(place)
    width = clouds[0].shape[1]
    rows = writer.add(np.concatenate([np.empty((0, width)), *tables]), digits=4, finest=-6)
    thinned = max(map(len, clouds), default=0) > most
    return {"of_moment": of_moment, "counts": [len(table) for table in tables], "rows": rows, "is_thinned": thinned}


class _Interned:
    """Tables of values by tick; each value is stored once, and ticks without a change are left out.

    Attributes
    ----------
    kept
        ``values``, and ``moments``: of each its tick, and of each table the places in ``values`` by key.
    """

    def __init__(self) -> None:
        self.kept: dict[str, list[Any]] = {"values": [], "moments": []}
        self._places: dict[str, int] = {}

    def add(self, tick: int, tables: Sequence[Mapping[str, Any]]) -> None:
        """Take the tables of a tick."""
        places = [{key: self._place(value) for key, value in table.items()} for table in tables]
        moments = self.kept["moments"]
        if not moments or moments[-1][1] != places:
            moments.append([tick, places])

    def _place(self, value: Any) -> int:
        text = json.dumps(value)
        if text not in self._places:
            self._places[text] = len(self._places)
            self.kept["values"].append(value)
        return self._places[text]


def _images(recording: Recording) -> dict[str, str]:
    """The pictures that the scene's maps name, in base64."""
    names = [shape["image"]["name"] for shape in recording.scene["maps"] if shape["image"]]
    return {name: base64.b64encode(recording.picture(name)).decode() for name in names}


def _scene(recording: Recording, robots: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """The scene; what the page leaves out is listed beside what the folder lacks."""
    scene = recording.scene
    about = scene["recorded"]
    lacks = [*about["lacks"]]
    if len(recording.names) > len(robots):
        lacks.append(f"This page has readings and beliefs of the first {len(robots)} robots, and paths of all.")
    if any(robot["particles"]["is_thinned"] for robot in robots):
        lacks.append(f"This page has at most {MOST_PARTICLES} particles of each moment; the folder has all.")
    if len(about["replicas"]) > 1:
        others = len(about["replicas"]) - 1
        lacks.append(f"This page has replica {about['replica']}; the folder has {others} more.")
    facts = [fact for fact in about["facts"] if fact[0] != "folder"]  # a path of the machine that made the page
    return {**scene, "recorded": {**about, "replicas": [about["replica"]], "facts": facts, "lacks": lacks}}
