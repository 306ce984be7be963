"""The fields that messages of recordings must have, checked before anything is read from them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import attrs
import numpy as np

from amorsim.core.error_text import in_words
from amorsim.core.errors import AnalysisError

__all__ = ["VALUES", "check_message"]

VALUES = "amorsim.Values"
"""The schema of plain numbers in an MCAP file of ours."""

_MISSING = object()
_NOT_FINITE = ("Infinity", "-Infinity", "NaN")  # as JSON has them


@attrs.frozen
class _Leaf:
    """A value that is not a message: a test whether one fits, and words for what fits."""

    fits: Callable[[Any], bool]
    expected: str


@attrs.frozen
class _ListOf:
    """A list of messages."""

    each: Mapping[str, Any]


@attrs.frozen
class _Optional:
    """A message that may be left out."""

    shape: Mapping[str, Any]


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)


def _is_value(value: Any) -> bool:
    return value is None or _is_number(value) or value in _NOT_FINITE


def _are(fits: Callable[[Any], bool]) -> Callable[[Any], bool]:
    def check(value: Any) -> bool:
        if isinstance(value, np.ndarray):
            return value.ndim == 1 and value.dtype.kind in "iuf"
        return isinstance(value, (list, tuple)) and all(map(fits, value))

    return check


def _is_whole(value: Any) -> bool:
    return isinstance(value, (int, np.integer)) and not isinstance(value, bool) and abs(int(value)) < 2**62


_NUMBER = _Leaf(_is_number, "a number")
_NUMBERS = _Leaf(_are(_is_number), "a list of numbers")
_VALUES = _Leaf(_are(_is_value), f"a list of numbers, {', '.join(_NOT_FINITE)} or null")
_WHOLE = _Leaf(_is_whole, "a whole number")
_TEXT = _Leaf(lambda value: isinstance(value, str), "a text")
_TEXTS = _Leaf(lambda value: isinstance(value, (list, tuple)) and all(isinstance(one, str) for one in value), "texts")

_PLACE = {"x": _NUMBER, "y": _NUMBER}
_TURNED = {"x": _NUMBER, "y": _NUMBER, "z": _NUMBER, "w": _NUMBER}
_POSE = {"position": _PLACE, "orientation": _TURNED}
_MOVED = {"translation": _PLACE, "rotation": _TURNED}
_TWIST = {"linear": _PLACE, "angular": {"z": _NUMBER}}
_HEADER = {"header": _Optional({"stamp": {"sec": _WHOLE, "nanosec": _WHOLE}, "frame_id": _TEXT})}
_STAMP = {"timestamp": _Optional({"sec": _WHOLE, "nsec": _WHOLE})}
_TRANSFORM = {**_HEADER, "child_frame_id": _TEXT, "transform": _MOVED}

_SHAPES: Mapping[str, Mapping[str, Any]] = {
    VALUES: {**_STAMP, "values": _VALUES},
    "foxglove.FrameTransform": {**_STAMP, "child_frame_id": _TEXT, **_MOVED},
    "foxglove.LaserScan": {**_STAMP, "ranges": _NUMBERS, "start_angle": _NUMBER, "end_angle": _NUMBER},
    "foxglove.PoseInFrame": {**_STAMP, "pose": _POSE},
    "geometry_msgs/PointStamped": {**_HEADER, "point": _PLACE},
    "geometry_msgs/PoseStamped": {**_HEADER, "pose": _POSE},
    "geometry_msgs/PoseWithCovarianceStamped": {**_HEADER, "pose": {"pose": _POSE}},
    "geometry_msgs/TransformStamped": _TRANSFORM,
    "geometry_msgs/Twist": _TWIST,
    "geometry_msgs/TwistStamped": {**_HEADER, "twist": _TWIST},
    "nav_msgs/Odometry": {**_HEADER, "pose": {"pose": _POSE}},
    "sensor_msgs/Imu": {
        **_HEADER,
        "orientation": _TURNED,
        "angular_velocity": {"z": _NUMBER},
        "linear_acceleration": _PLACE,
    },
    "sensor_msgs/JointState": {**_HEADER, "name": _TEXTS, "position": _NUMBERS},
    "sensor_msgs/LaserScan": {
        **_HEADER,
        "ranges": _NUMBERS,
        **dict.fromkeys(("angle_min", "angle_increment", "range_min", "range_max"), _NUMBER),
    },
    "sensor_msgs/Range": {**_HEADER, "range": _NUMBER},
    "std_msgs/Float32MultiArray": {"data": _NUMBERS},
    "std_msgs/Float64MultiArray": {"data": _NUMBERS},
    "tf2_msgs/TFMessage": {"transforms": _ListOf(_TRANSFORM)},
}


def check_message(kind: str, content: Any, where: str) -> None:
    """Raise an `AnalysisError` for a message that lacks a field of its kind, or has another value in it.

    Messages of other kinds are not checked. `where` is the recording and the topic.
    """
    if kind in _SHAPES:
        _check(_SHAPES[kind], content, f"{where}: a message {kind}", "")


def _check(shape: Mapping[str, Any], content: Any, where: str, path: str) -> None:
    for name, wanted in shape.items():
        value, at = getattr(content, name, _MISSING), f"{path}{name}"
        if isinstance(wanted, _Optional):
            if value is not _MISSING and value is not None:
                _check(wanted.shape, value, where, f"{at}.")
        elif value is _MISSING:
            raise AnalysisError(f"{where} is damaged: it has no {at}")
        elif isinstance(wanted, _Leaf):
            if not wanted.fits(value):
                raise AnalysisError(f"{where} is damaged: expected {wanted.expected} under {at}, got {in_words(value)}")
        elif isinstance(wanted, _ListOf):
            if not isinstance(value, (list, tuple)):
                raise AnalysisError(f"{where} is damaged: expected a list under {at}, got {in_words(value)}")
            for number, each in enumerate(value):
                _check(wanted.each, each, where, f"{at}[{number}].")
        else:
            _check(wanted, value, where, f"{at}.")
