"""Frames: moments as bytes, from the child to the session and on to each window.

The child packs a **bundle**: what all frames share, and in addition what belongs to one robot, for each robot that
a window looks at. Of that the session makes each window's **frame**, which is about one robot.
"""

from __future__ import annotations

import enum
import struct
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from amorsim.array_types import Array

__all__ = [
    "BLOCKS",
    "FRAME_HEADER",
    "HEADER",
    "MAGIC",
    "Bundle",
    "Dynamic",
    "FrameFlag",
    "RobotFlag",
    "Selected",
    "pack_bundle",
    "pack_frame",
    "unpack_frame",
]


MAGIC = b"amf1"

# What a frame begins with: names, and formats as `struct` has them. The script reads it by the same table (see
# tools/make_wire.py).
HEADER = (
    ("magic", "4s"),
    ("version", "I"),  # of the scene
    ("number", "I"),
    ("epoch", "I"),
    ("time", "d"),  # [s]
    ("speed", "f"),  # as asked; inf: as fast as possible
    ("achieved", "f"),
    ("tick", "I"),
    ("newest", "I"),  # tick
    ("states", "I"),  # a FrameFlag
    ("events", "I"),
    ("robot_count", "I"),
    ("obstacle_count", "I"),
    ("selected", "i"),  # robot; the counts that follow are of its values
    ("value_count", "I"),
    ("sensor_count", "I"),
    ("joint_count", "I"),
    ("channel_count", "I"),
    ("oldest", "I"),  # tick
    ("part_count", "I"),
    ("particle_count", "I"),
    ("hypothesis_count", "I"),
    ("", "4x"),  # so that what follows begins at a multiple of 8
)
FRAME_HEADER = struct.Struct("<" + "".join(form for _, form in HEADER))
# What follows: names, kinds of numbers (little endian), which number of the header counts it, and how many for each.
BLOCKS = (
    ("true_values", "f8", "value_count", 1),
    ("measured_values", "f8", "value_count", 1),
    ("ages", "f8", "sensor_count", 1),
    ("true_rates", "f8", "joint_count", 1),
    ("measured_rates", "f8", "joint_count", 1),
    ("true_twist", "f8", "", 3),
    ("estimated_twist", "f8", "", 3),
    ("command", "f8", "channel_count", 1),
    ("believed_parts", "f8", "part_count", 3),
    ("particles", "f8", "particle_count", 4),
    ("hypotheses", "f8", "hypothesis_count", 10),
    ("true_poses", "f4", "robot_count", 3),
    ("estimated_poses", "f4", "robot_count", 3),
    ("covariances", "f4", "robot_count", 6),
    ("obstacles", "f4", "obstacle_count", 3),
    ("flags", "u1", "robot_count", 1),
)


def _offset(name: str) -> int:
    """Where a number of the header begins."""
    before = HEADER[: [field for field, _ in HEADER].index(name)]
    return struct.calcsize("<" + "".join(form for _, form in before))


_NUMBER_AT, _FLAGS_AT = _offset("number"), _offset("states")
_ROBOT = [field for field, _ in HEADER].index("selected")  # sizes of its values follow


class FrameFlag(enum.IntFlag):
    """The state of the simulation in a frame."""

    RUNNING = 1
    ENDED = 2  # the scenario's duration is over
    SCRUBBED = 4  # this is the past
    FAULT = 8  # a controller raised an error; it waits
    HANG = 16  # no sign of life
    LOADING = 32  # compiling, replaying
    POSES_ONLY = 64  # of this moment of the past only poses are known; the readings are nan


class RobotFlag(enum.IntFlag):
    """The state of a robot in a frame."""

    TOUCHING = 1
    ENDED = 2  # its controller has ended
    BY_HAND = 4


class Selected(NamedTuple):
    """The part of a frame about the selected robot alone."""

    true: Array  # (V,) the sensors' true values, in the scene's order
    measured: Array  # (V,)
    age: Array  # (S,) [s]
    true_rates: Array  # (J,) [rad/s]
    measured_rates: Array  # (J,) nan where nothing measures them
    true_twist: Array  # (3,)
    estimated_twist: Array  # (3,)
    command: Array  # (C,)
    parts: Array = np.empty(0)  # (3 P,) where it believes its parts to be; nan where nothing measures their joints
    particles: Array = np.empty(0)  # (4 P,) poses and weights that an estimator holds
    hypotheses: Array = np.empty(0)  # (10 H,) poses, weights, and xx, xy, xh, yy, yh, hh of their covariances


class Dynamic(NamedTuple):
    """A moment, from which `pack_frame` makes a frame."""

    version: int
    number: int
    epoch: int
    time: float
    speed: float
    achieved: float
    tick: int
    newest: int
    oldest: int
    flags: int
    events: int
    selected_robot: int
    true_pose: Array  # (R, 3)
    estimated_pose: Array  # (R, 3)
    covariance: Array  # (R, 6) xx, xy, xh, yy, yh, hh
    obstacle_pose: Array  # (O, 3)
    robot_flags: npt.NDArray[np.uint8]  # (R,)
    selected: Selected


def pack_frame(moment: Dynamic) -> bytes:
    """The bytes of a frame: `HEADER`, then `BLOCKS`. A thousand robots are 49 kB."""
    return _head(moment) + _tail(moment)


def _head(moment: Dynamic) -> bytes:
    selected = moment.selected
    header = FRAME_HEADER.pack(
        MAGIC,
        moment.version,
        moment.number,
        moment.epoch,
        moment.time,
        moment.speed,
        moment.achieved,
        moment.tick,
        moment.newest,
        moment.flags,
        moment.events,
        len(moment.true_pose),
        len(moment.obstacle_pose),
        moment.selected_robot,
        len(selected.true),
        len(selected.age),
        len(selected.true_rates),
        len(selected.command),
        moment.oldest,
        len(selected.parts) // 3,
        len(selected.particles) // 4,
        len(selected.hypotheses) // 10,
    )
    return header + np.concatenate(selected).astype("<f8").tobytes()


def _tail(moment: Dynamic) -> bytes:
    drawn = (moment.true_pose, moment.estimated_pose, moment.covariance, moment.obstacle_pose)
    poses = np.concatenate([part.reshape(-1) for part in drawn]).astype("<f4")
    return poses.tobytes() + moment.robot_flags.astype(np.uint8).tobytes()


def unpack_frame(data: bytes) -> Dynamic:
    """The content of a frame from `pack_frame`, as the window's script reads it.

    Raises
    ------
    ValueError
        If these are not the bytes of a frame.
    """
    if len(data) < FRAME_HEADER.size or data[:4] != MAGIC:
        raise ValueError(f"expected a frame, which begins with {MAGIC!r}, got {data[:4]!r}")
    names = [name for name, _ in HEADER if name]
    head = dict(zip(names, FRAME_HEADER.unpack_from(data), strict=True))
    at, blocks = FRAME_HEADER.size, {}
    for name, form, counted, each in BLOCKS:
        count = head.get(counted, 1) * each
        if len(data) < at + count * int(form[1]):
            raise ValueError(f"expected a frame with {count} {name}, got {len(data)} bytes")
        blocks[name] = np.frombuffer(data, f"<{form}", count, at)
        at += blocks[name].nbytes
    if len(data) != at:
        raise ValueError(f"expected a frame of {at} bytes, got {len(data)}")
    exact = [blocks[name].astype(float) for name, form, _, _ in BLOCKS if form == "f8"]
    drawn = {name: blocks[name].astype(float).reshape(-1, each) for name, form, _, each in BLOCKS if form == "f4"}
    shared = ("version", "number", "epoch", "time", "speed", "achieved", "tick", "newest", "oldest", "events")
    return Dynamic(
        **{name: head[name] for name in shared},
        flags=head["states"],
        selected_robot=head["selected"],
        true_pose=drawn["true_poses"],
        estimated_pose=drawn["estimated_poses"],
        covariance=drawn["covariances"],
        obstacle_pose=drawn["obstacles"],
        robot_flags=blocks["flags"].copy(),
        selected=Selected(*exact),
    )


# ---------------------------------------------------------------------------------------------------------- bundles

_BUNDLE_HEADER = struct.Struct("<4sI")  # magic, heads
_BUNDLE_MAGIC = b"amb1"
_HEAD = struct.Struct("<iI")  # robot, bytes of its head: a frame's header and that robot's values
_NOTHING = Selected(*(np.full(size, np.nan) for size in (0, 0, 0, 0, 0, 3, 3, 0, 0, 0, 0)))


def pack_bundle(moments: Sequence[Dynamic]) -> bytes:
    """The bytes of one moment for several selected robots; `moments` differ only in which robot is selected."""
    heads = [_head(moment) for moment in moments]
    index = b"".join(_HEAD.pack(moment.selected_robot, len(head)) for moment, head in zip(moments, heads, strict=True))
    return _BUNDLE_HEADER.pack(_BUNDLE_MAGIC, len(heads)) + index + b"".join(heads) + _tail(moments[0])


class Bundle:
    """The bytes of `pack_bundle`, from which frames are made without decoding them further.

    Raises
    ------
    ValueError
        If these are not the bytes of a bundle.

    Attributes
    ----------
    epoch, newest, flags
        As of all its frames.
    """

    def __init__(self, data: bytes) -> None:
        if len(data) < _BUNDLE_HEADER.size or data[:4] != _BUNDLE_MAGIC:
            raise ValueError(f"expected a bundle, which begins with {_BUNDLE_MAGIC!r}, got {data[:4]!r}")
        _, count = _BUNDLE_HEADER.unpack_from(data)
        at = _BUNDLE_HEADER.size
        start = at + count * _HEAD.size
        self._heads: dict[int, bytes] = {}
        for robot, size in _HEAD.iter_unpack(data[at:start]):
            self._heads[robot] = data[start : start + size]
            start += size
        self._tail = data[start:]
        (_, _, _, self.epoch, _, _, _, _, self.newest, self.flags, *_) = FRAME_HEADER.unpack_from(
            next(iter(self._heads.values()))
        )

    @property
    def robots(self) -> list[int]:
        """The robots that it contains completely."""
        return list(self._heads)

    def frame(self, robot: int, number: int, flags: int | None = None) -> bytes | None:
        """The frame with this number in which a robot is selected, with other flags if given; None if it has none."""
        head = self._heads.get(robot)
        if head is None:
            return None
        return _changed(head, number, self.flags if flags is None else flags) + self._tail

    def bare_frame(self, robot: int, number: int, flags: int) -> bytes:
        """A frame in which no robot is selected: each has what all have."""
        fields = list(FRAME_HEADER.unpack_from(next(iter(self._heads.values()))))
        fields[_ROBOT : _ROBOT + 5] = (robot, 0, 0, 0, 0)
        fields[-3:] = (0, 0, 0)  # parts, particles, hypotheses
        return _changed(FRAME_HEADER.pack(*fields) + np.concatenate(_NOTHING).tobytes(), number, flags) + self._tail


def _changed(head: bytes, number: int, flags: int) -> bytes:
    changed = bytearray(head)
    struct.pack_into("<I", changed, _NUMBER_AT, number)
    struct.pack_into("<I", changed, _FLAGS_AT, flags)
    return bytes(changed)
