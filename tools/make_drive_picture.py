"""Draws docs/pictures/drives.png: what each drive does under one command, as amorsim moves it.

Run it where the picture should look different::

    python tools/make_drive_picture.py
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("agg")
import matplotlib.pyplot as plt
import numpy as np

from amorsim.contracts import Draws, Drive
from amorsim.core.poses import compose
from amorsim.core.rows import stack
from amorsim.drives import Ackermann, Differential, Mecanum, Synchro, Tractor, Tricycle

__all__ = ["make"]

PICTURE = Path(__file__).resolve().parents[1] / "docs" / "pictures" / "drives.png"
_NO_DRAWS = Draws(np.zeros(1, dtype=np.uint64), np.zeros((1, 3), dtype=np.uint32))
_ONE = np.ones((1, 1))
_BODY, _WHEEL, _PATH, _GREY = "#cdeadd", "#1b2a33", "#12805c", "#9aa7ad"

_PAIR: dict[str, Any] = {"wheel_radius_left": 0.1, "wheel_radius_right": 0.1, "track": 0.36, "rate_max": 50.0}
_STEERED: dict[str, Any] = {"wheel_radius": 0.1, "wheelbase": 0.5, "steering_rate": 0.5, "rate_max": 50.0}
_FOUR = {f"wheel_radius_{end}_{side}": 0.1 for end in ("front", "rear") for side in ("left", "right")}


def _cases() -> list[tuple[str, Drive, list[float], str]]:
    return [
        ("differential: left 6, right 9 rad/s", Differential(**_PAIR), [6.0, 9.0], "pair"),
        (
            "ackermann: steering to 30° at its rate, wheels 8 rad/s",
            Ackermann(**_STEERED, track=0.34, steering_max=0.6),
            [0.5236, 8.0],
            "car",
        ),
        ("tricycle: steering to 50°, front wheel 8 rad/s", Tricycle(**_STEERED), [0.8727, 8.0], "tricycle"),
        (
            "synchro, turret fixed: steering 0.55, wheels 8 rad/s",
            Synchro(wheel_radius=0.1, rate_max=50.0, steering_rate_max=5.0),
            [0.55, 8.0],
            "synchro",
        ),
        (
            "mecanum: ahead 0.5, left 0.4 m/s, turn 0.35 rad/s",
            Mecanum(**_FOUR, wheelbase=0.4, track=0.36, rate_max=50.0),
            [],  # by `command_for`
            "mecanum",
        ),
        (
            "tractor: left 6, right 9 rad/s",
            Tractor(
                **_PAIR,
                trailer_length=0.55,
                hitch_offset=0.12,
                trailer_width=0.4,
                trailer_front=0.36,
                trailer_rear=0.2,
            ),
            [6.0, 9.0],
            "pair",
        ),
    ]


def _outline(pose: Any, points: Any) -> Any:
    c, s = np.cos(pose[2]), np.sin(pose[2])
    points = np.asarray(points, dtype=float)
    return np.stack((pose[0] + c * points[:, 0] - s * points[:, 1], pose[1] + s * points[:, 0] + c * points[:, 1]), 1)


def _fill(axes: Any, pose: Any, points: Any, face: str, edge: str, order: int) -> None:
    axes.fill(*_outline(pose, points).T, facecolor=face, edgecolor=edge, linewidth=1.0, zorder=order)


def _wheel(axes: Any, pose: Any, x: float, y: float, angle: float = 0.0) -> None:
    at = compose(np.array([pose]), np.array([[x, y, angle]]))[0]
    _fill(axes, at, [(-0.1, -0.028), (0.1, -0.028), (0.1, 0.028), (-0.1, 0.028)], _WHEEL, _WHEEL, 4)


def _body(axes: Any, kind: str, drive: Any, pose: Any, joints: Any) -> None:
    circle = [(0.3 * np.cos(a), 0.3 * np.sin(a)) for a in np.linspace(0.0, 2.0 * np.pi, 48)]
    if kind == "pair":
        _fill(axes, pose, [(-0.2, -0.22), (0.26, -0.22), (0.26, 0.22), (-0.2, 0.22)], _BODY, _PATH, 3)
        for y in (-0.18, 0.18):
            _wheel(axes, pose, 0.0, y)
        if isinstance(drive, Tractor):
            rows: Any = stack([drive])
            trailer = compose(np.array([pose]), rows.part_poses(joints)[:, 0])[0]
            _fill(axes, trailer, drive.parts[0].shape.outline, "#dfe5e8", _GREY, 2)
            hitch = compose(np.array([pose]), np.array([[-drive.hitch_offset, 0.0, 0.0]]))[0]
            axes.plot(*np.array([trailer[:2], hitch[:2], pose[:2]]).T, color=_GREY, linewidth=1.5, zorder=5)
            for y in (-0.18, 0.18):
                _wheel(axes, trailer, 0.0, y)
    elif kind in ("car", "tricycle"):
        _fill(axes, pose, [(-0.15, -0.22), (0.65, -0.22), (0.65, 0.22), (-0.15, 0.22)], _BODY, _PATH, 3)
        for y in (-0.17, 0.17):
            _wheel(axes, pose, 0.0, y)
        if kind == "car":
            rows = stack([drive])
            left, right = rows.front_wheel_angles(joints[:, :1])[0]
            _wheel(axes, pose, 0.5, 0.17, left)
            _wheel(axes, pose, 0.5, -0.17, right)
        else:
            _wheel(axes, pose, 0.5, 0.0, joints[0, 0])
    elif kind == "synchro":
        _fill(axes, pose, circle, _BODY, _PATH, 3)
        for angle in (0.0, 2.1, 4.2):
            _wheel(axes, pose, 0.18 * np.cos(angle), 0.18 * np.sin(angle), joints[0, 0])
        axes.plot(*_outline(pose, [(0.0, 0.0), (0.3, 0.0)]).T, color=_PATH, linewidth=1.5, zorder=5)
    else:
        _fill(axes, pose, [(-0.33, -0.24), (0.33, -0.24), (0.33, 0.24), (-0.33, 0.24)], _BODY, _PATH, 3)
        for x in (-0.2, 0.2):
            for y in (-0.18, 0.18):
                _wheel(axes, pose, x, y)
        axes.plot(*_outline(pose, [(0.0, 0.0), (0.33, 0.0)]).T, color=_PATH, linewidth=1.5, zorder=5)


def make(path: Path) -> None:
    """Write the picture."""
    figure, grid = plt.subplots(2, 3, figsize=(12.0, 7.6), layout="constrained")
    for axes, (title, drive, command, kind) in zip(grid.flat, _cases(), strict=True):
        rows = stack([drive])
        if kind == "mecanum":
            command = rows.command_for(np.array([[0.5, 0.4, 0.35]]), np.zeros((1, 4)))[0].tolist()
        joints = rates = np.zeros((1, len(drive.joints)))
        pose, path_ = np.zeros((1, 3)), [np.zeros(3)]
        _body(axes, kind, drive, pose[0], joints)
        for step in range(1, 241):
            before = joints
            joints, rates = rows.advance(joints, rates, np.array([command]), 0.02, {}, _NO_DRAWS)
            moved = rows.displacement(before, joints, _ONE)
            pose, joints = compose(pose, moved), rows.follow(joints, moved)
            path_.append(pose[0])
            if step % 80 == 0:
                _body(axes, kind, drive, pose[0], joints)
        axes.plot(*np.array(path_)[:, :2].T, color="#d1483a", linewidth=1.8, zorder=6)
        axes.plot(*path_[0][:2], "o", color="#d1483a", markersize=4, zorder=7)
        axes.set_title(title.replace(": ", ":\n", 1), fontsize=10, loc="left")
        axes.set_aspect("equal")
        axes.margins(0.06)
        axes.tick_params(labelsize=8)
    figure.supxlabel("x [m]", fontsize=9)
    figure.supylabel("y [m]", fontsize=9)
    figure.savefig(path, dpi=110)


if __name__ == "__main__":
    make(PICTURE)
