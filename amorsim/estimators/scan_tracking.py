"""Shared by estimators that follow a robot by its scans: their fields, their state, and a step."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import attrs
import numpy as np

from amorsim.array_types import Array, Bools
from amorsim.contracts import (
    Beliefs,
    Context,
    Estimate,
    Estimator,
    LazyBeliefs,
    Measurement,
    RobotModel,
    State,
    parameter,
)
from amorsim.core.errors import ComponentError
from amorsim.core.poses import compose
from amorsim.estimators.ages import check_fresh
from amorsim.estimators.initial_beliefs import refuse_lost, start_state, with_start
from amorsim.estimators.scans import beams_of, check_laser, mounts_of
from amorsim.estimators.wheels import angles_of, check_encoder, is_current, reckon
from amorsim.kernels.matching import tracking, tracks
from amorsim.kernels.matching.correlative import Window
from amorsim.kernels.matching.icp import Search
from amorsim.kernels.matching.outlines import outlines

__all__ = ["ScanTracker", "empty_outlines", "placed"]


_PICTURE = 0.04  # [m] cells of the correlative stage
_BLUR = 0.06  # [m]
_ANGLE = math.radians(1.0)  # between headings of the correlative stage; the second stage does the rest
_FARTHEST = 20.0  # [m] from the robot that the correlative stage looks
_KEY_SHARE = 0.6  # of points on the key, below which the scan becomes the next one
_KEYS = 3  # scans' points that a key has room for
_PAIR = 0.3  # [m] that a point and its line may be apart
_MOST_STEPS = 60
_TOLERANCE = 1e-6  # [m, rad]


@attrs.frozen(kw_only=True)
class ScanTracker(Estimator):
    """Follows a robot by its wheels and by matching its scans with key scans; the base of scan matching and graph SLAM.

    Parameters
    ----------
    laser
        Name of the sensor of scans.
    encoder
        Name of the sensor that counts the joints. It must read in every step.
    wheel_variance
        Variance of the travel of each rolling joint per metre, as the robot assumes it [m^2/m].
    range_std
        Standard deviation of a range, as the robot assumes it [m].
    match_distance, match_angle
        A scan is matched when the robot has moved or turned this far since the last match [m, rad].
    key_distance, key_angle
        A matched scan becomes the next key when the robot has moved or turned this far since the last key [m, rad].
    window, window_angle
        How far around the wheels' pose the correlative stage looks [m, rad]; 0 leaves that stage out.
    least_fit
        How well a scan must fit, from 0 to 1: the share of its points that lie on the key, less 0.4 for each where the
        key's last scan saw through. A match that fits less is refused.
    sure_fit
        A scan that fits less is looked for in a window three times as large as well.
    degenerate
        A scan does not determine the pose if the least eigenvalue of its information is below this part of the largest.
    age_max
        The oldest scan, and reading of the encoder, [s] that is used as if it were taken now. An older one is an error.
    """

    laser: str = parameter("laser", refers="sensors", help="name of the sensor of scans")
    encoder: str = parameter("encoder", refers="sensors", help="name of the sensor that counts the joints")
    wheel_variance: float = parameter(
        unit="m", gt=0, help="variance of a rolling joint's travel [m^2] per metre of it, as the robot believes"
    )
    range_std: float = parameter(unit="m", gt=0, static=True, help="standard deviation of a range")
    match_distance: float = parameter(0.1, unit="m", ge=0, static=True, help="motion between two matches")
    match_angle: float = parameter(math.radians(5.0), unit="rad", ge=0, static=True, help="turn between two matches")
    key_distance: float = parameter(1.0, unit="m", ge=0, static=True, help="motion between two key scans")
    key_angle: float = parameter(math.radians(30.0), unit="rad", ge=0, static=True, help="turn between two key scans")
    window: float = parameter(0.2, unit="m", ge=0, le=5, static=True, help="how far the correlative stage looks")
    window_angle: float = parameter(
        math.radians(10.0), unit="rad", ge=0, le=math.pi, static=True, help="how far around it looks"
    )
    least_fit: float = parameter(0.25, ge=0, le=1, static=True, help="fit below which a match is refused")
    sure_fit: float = parameter(0.45, ge=0, le=1, static=True, help="fit below which a scan is looked for farther away")
    degenerate: float = parameter(0.01, ge=0, lt=1, static=True, help="ratio of eigenvalues that counts as degenerate")
    age_max: float = parameter(
        0.0, unit="s", ge=0, help="age at which a scan or encoder reading still counts as taken now"
    )

    def sources(self) -> Sequence[tuple[str, str, str]]:
        """The sources that predict the pose and correct it."""
        return [
            (f"sensor {self.encoder!r}", "predicts x, y, heading", f"{self.wheel_variance:g} m² of travel per m"),
            (f"sensor {self.laser!r}", "corrects x, y, heading", f"matched with key scans, range {self.range_std:g} m"),
        ]

    def _begin(self, who: str, context: Context) -> State:
        """The pose and covariance, the joints, and room for the last key scan.

        Raises
        ------
        ComponentError
            If a sensor is missing or of another kind, or the robot knows nothing of its start.
        """
        robot, rows = context.robot, context.rows
        check_laser(who, robot, self.laser)
        check_encoder(who, robot, self.encoder)
        rate = robot.sensors[self.encoder].rate
        if rate is not None and rate * context.dt < 1.0 - 1e-9:
            raise ComponentError(
                f"{who} follows the sensor {self.encoder!r} in every step of {context.dt:g} s, but it reads at "
                f"{rate:g} Hz; give it no rate"
            )
        refuse_lost(who, context)
        beams = robot.sensors[self.laser].size
        pose = np.array(context.pose, dtype=np.float64)
        state: State = {
            "pose": pose,
            "spread": np.zeros((rows, 3, 3)),
            "key_pose": pose.copy(),
            "key_covariance": np.zeros((rows, 3, 3)),
            "cross": np.zeros((rows, 3, 3)),
            "link": np.zeros((rows, 4, 3)),
            "last": np.full((rows, 3), np.nan),
            "last_points": np.full((rows, beams, 2), np.nan),
            "joints": np.full((rows, len(robot.drive.joints)), np.nan),
            "current": np.ones((rows, 1), dtype=bool),
            "match": np.full((rows, tracking.RECORD), np.nan),
            "scan": np.full((rows, beams, 2), np.nan),
            "scan_pose": pose.copy(),
            **start_state(context),
        }
        size = _KEYS * beams
        state["key_points"], state["key_lines"] = np.full((rows, size, 2), np.nan), np.full((rows, size, 4), np.nan)
        state["key_order"] = np.repeat(np.arange(size)[None], rows, axis=0)
        state["key_along"] = np.full((rows, size), np.inf)
        state["key_seen"] = np.full((rows, beams, 2), np.nan)
        return state

    def _rules(self) -> tracking.Rules:
        """The fields as kernels read them."""
        return tracking.Rules(
            float(self.match_distance),
            float(self.match_angle),
            float(self.key_distance),
            float(self.key_angle),
            _KEY_SHARE,
            float(self.least_fit),
            float(self.sure_fit),
            Window(float(self.window), float(self.window_angle), _ANGLE),
            Search(float(self.range_std), _PAIR, _MOST_STEPS, _TOLERANCE, float(self.degenerate)),
        )

    def _room(self, robot: RobotModel) -> tracking.Room:
        reach = float(self._reach(robot).max())
        return tracking.room(robot.sensors[self.laser].size, reach, _PICTURE, _BLUR)

    def _reach(self, robot: RobotModel) -> Array:
        """How far from the robot points are matched `(R, 1)`, R = 1 or N [m]."""
        return np.minimum(beams_of(robot, self.laser).range_max, _FARTHEST)

    def _follow(
        self, who: str, robot: RobotModel, readings: Mapping[str, Measurement], state: State
    ) -> tuple[Bools, tracking.Outlines | None]:
        """Move the poses by the wheels and correct them by new scans; returns which rows need a new key `(N, 2)`."""
        check_fresh(who, robot, self.encoder, readings[self.encoder], self.age_max)
        before, after = angles_of(robot, self.encoder, readings[self.encoder].measured, state["joints"])
        moved = reckon(robot.drive, state["pose"], state["spread"], before, after, self.wheel_variance)
        off = (moved.pose - state["pose"])[:, :2]
        cross = state["cross"]
        cross[:, 0] -= off[:, 1:] * cross[:, 2]
        cross[:, 1] += off[:, :1] * cross[:, 2]
        state["pose"], state["spread"], state["joints"] = moved.pose, moved.covariance, after
        state["current"] = is_current(robot, self.encoder, readings[self.encoder], after, state["current"])
        reading = readings[self.laser]
        fresh = check_fresh(who, robot, self.laser, reading, self.age_max) & state["current"]
        state["match"] = np.full_like(state["match"], np.nan)
        asked = np.zeros((robot.rows, 2), dtype=bool)
        if not fresh.any():
            return asked, None
        scans = self._outlines(robot, reading.measured)
        room = self._room(robot)
        fresh = np.ascontiguousarray(fresh)
        tracking.track(
            scans,
            fresh,
            _keys(state, mounts_of(robot, self.laser)),
            _tracks(state),
            self._rules(),
            room,
            state["match"],
            asked,
        )
        state["scan"] = np.where(fresh[:, :, None], scans.points, state["scan"])
        state["scan_pose"] = np.where(fresh, state["pose"], state["scan_pose"])
        return asked, scans

    def _outlines(self, robot: RobotModel, ranges: Array) -> tracking.Outlines:
        beams = beams_of(robot, self.laser)
        found = empty_outlines(robot.rows, ranges.shape[1])
        outlines(np.ascontiguousarray(ranges), beams.cos_b, beams.sin_b, beams.range_max, beams.mounts, *found)
        return found

    def _outlines_of(self, robot: RobotModel, row: int, ranges: Array) -> tracking.Outlines:
        """Outlines of several scans of one row's laser `(n, k)`."""
        beams = beams_of(robot, self.laser)
        b, r = row % len(beams.cos_b), row % len(beams.range_max)
        found = empty_outlines(*ranges.shape)
        mounts = np.repeat(beams.mounts[row : row + 1], len(ranges), axis=0)
        cos_b, sin_b, range_max = beams.cos_b[b : b + 1], beams.sin_b[b : b + 1], beams.range_max[r : r + 1]
        outlines(np.ascontiguousarray(ranges), cos_b, sin_b, range_max, mounts, *found)
        return found

    def _estimate(self, state: State) -> Estimate:
        covariance = np.empty_like(state["spread"])
        tracks.total_covariances(_tracks(state), covariance)
        return with_start(Estimate(state["pose"].copy(), covariance), state)

    def beliefs(self, state: State) -> Beliefs:
        """Of this step's match: ``match_correction`` [m, m, rad], ``match_used``, and measures of how good it is.

        ``match_share`` of points on the key, ``match_distance`` of these [m], ``match_fit`` of the scan,
        ``match_degenerate`` 1 or 0, ``match_weakest`` the ratio of eigenvalues, ``match_direction`` in which the scan
        determines least (x, y, and turn as a length); nan where nothing was matched. ``scan``: the points of the last
        scan in the world `(N, k, 2)` [m], as the robot believes them to be.
        """
        return LazyBeliefs(self._of_match(state))

    def _of_match(self, state: State) -> dict[str, Any]:
        """The beliefs of this step's match, as `LazyBeliefs` take them."""
        record = state["match"]
        return {
            "match_correction": record[:, :3].copy(),
            "match_used": record[:, tracking.USED].copy(),
            "match_share": record[:, tracking.SHARE].copy(),
            "match_distance": record[:, tracking.DISTANCE].copy(),
            "match_fit": record[:, tracking.FIT].copy(),
            "match_degenerate": record[:, tracking.DEGENERATE].copy(),
            "match_weakest": record[:, tracking.WEAKEST].copy(),
            "match_direction": record[:, tracking.DIRECTION :].copy(),
            "scan": lambda: placed(state["scan"], state["scan_pose"]),
        }


def empty_outlines(rows: int, beams: int) -> tracking.Outlines:
    """Room for outlines of scans with that many beams, nan."""
    return tracking.Outlines(
        np.full((rows, beams, 2), np.nan), np.full((rows, beams, 4), np.nan), np.full((rows, beams, 2), np.nan)
    )


def _keys(state: State, mounts: Array) -> tracking.Keys:
    return tracking.Keys(
        state["key_points"], state["key_lines"], state["key_order"], state["key_along"], state["key_seen"], mounts
    )


def _tracks(state: State) -> tracks.Tracks:
    return tracks.Tracks(
        state["pose"],
        state["spread"],
        state["key_pose"],
        state["key_covariance"],
        state["cross"],
        state["link"],
        state["last"],
        state["last_points"],
    )


def placed(points: Array, poses: Array) -> Array:
    """Points `(N, k, 2)` [m] in the world, of robots at `poses` `(N, 3)`."""
    rows, count, _ = points.shape
    there = np.zeros((rows * count, 3))
    there[:, :2] = points.reshape(-1, 2)
    return compose(np.repeat(poses, count, axis=0), there)[:, :2].reshape(rows, count, 2)
