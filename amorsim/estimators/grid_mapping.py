"""An occupancy grid drawn from scans at given poses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import attrs
import numpy as np

from amorsim.array_types import Array, Bools
from amorsim.contracts import (
    Beliefs,
    Context,
    Draws,
    Estimate,
    Estimator,
    LazyBeliefs,
    Measurement,
    RobotModel,
    State,
    parameter,
)
from amorsim.contracts.estimator import ESTIMATES
from amorsim.core.errors import ComponentError
from amorsim.core.parameters import own_first
from amorsim.core.poses import compose, relative
from amorsim.estimators.ages import check_fresh, is_late
from amorsim.estimators.initial_beliefs import covariance_at_start, refuse_lost
from amorsim.estimators.map_area import MapArea, area_of, area_origins, log_odds_evidence, map_beliefs
from amorsim.estimators.scans import Beams, beams_of, check_laser, mounts_of, scans_of
from amorsim.estimators.wheels import angles_of, check_encoder, check_keeps_up, is_current, reckon, sensor_of
from amorsim.kernels.mapping import occupancy
from amorsim.kernels.mapping.scan_cells import window_for

__all__ = ["GridMapping"]


_POSE = ("x", "y", "heading")


@attrs.frozen(kw_only=True, field_transformer=own_first)
class GridMapping(MapArea, Estimator):
    """Draws an occupancy grid from the scans of a laser, at poses that it takes as exact.

    The poses come from another estimator of the robot (``estimator``), from a tracking system (``place``), or from the
    wheels: dead reckoning. A tracking system without noise gives the true poses, and a map without distortion. Compare
    it with the map at estimated poses to see what their errors do to a map.

    A scan counts each cell at most once as hit, or else as missed. The map does not grow: it is
    `width` by `height`.

    Parameters
    ----------
    laser
        Name of the sensor of scans.
    estimator
        Name of the estimator whose poses it takes, such as a ``scan_matching`` or an ``ekf``. Empty: `place`. A scan
        that comes while the estimate is not current, since a reading of the wheels was lost, is not drawn.
    place
        Name of the sensor of x, y and heading, a ``gps`` with ``heading``. Empty: the wheels. Scans are drawn at places
        that are of their time, or older by `age_max`; those without one, where it is lost, are not drawn.
    encoder
        Name of the sensor that counts the joints, for the wheels.
    wheel_variance
        Variance of the travel of each rolling joint per metre, as the robot assumes it [m^2/m]; for the covariance.
    model
        ``"log_odds"`` adds evidence; ``"counting"`` gives the share of hits in all that was seen of a cell.
    hit, miss
        Probability that a cell is occupied if a beam ended in it, and if beams only crossed it. For ``"log_odds"``.
    certainty
        A cell's probability stays between 1 - certainty and certainty. For ``"log_odds"``.
    age_max
        The oldest scan, and reading of the encoder, [s] that is used as if it were taken now. An older one is an error.
    """

    laser: str = parameter("laser", refers="sensors", help="name of the sensor of scans")
    estimator: str = parameter(
        "", static=True, refers="estimators", help="name of the estimator that gives the poses; empty for `place`"
    )
    place: str = parameter("", help="name of the sensor of x, y and heading; empty for the wheels")
    encoder: str = parameter("encoder", help="name of the sensor that counts the joints, for the wheels")
    wheel_variance: float = parameter(
        0.0, unit="m", ge=0, help="variance of a rolling joint's travel [m^2] per metre of it, as the robot believes"
    )
    model: str = parameter(
        "log_odds", choices=("log_odds", "counting"), static=True, help="how evidence is put together"
    )
    hit: float = parameter(0.97, gt=0.5, lt=1, static=True, help="probability of a cell that a beam ended in")
    miss: float = parameter(0.4, gt=0, lt=0.5, static=True, help="probability of a cell that beams only crossed")
    certainty: float = parameter(0.9999, gt=0.5, lt=1, static=True, help="largest probability of a cell")
    age_max: float = parameter(
        0.0, unit="s", ge=0, help="age at which a scan or encoder reading still counts as taken now"
    )

    def sources(self) -> Sequence[tuple[str, str, str]]:
        """Where the poses come from, and what draws the map."""
        given = f"estimator {self.estimator!r}" if self.estimator else f"sensor {self.place or self.encoder!r}"
        trust = f"hit {self.hit:g}, miss {self.miss:g}" if self.model == "log_odds" else "hits and misses are counted"
        return [(given, "gives x, y, heading", "as exact"), (f"sensor {self.laser!r}", "draws the map", trust)]

    def start(self, context: Context) -> State:
        """The pose, the joints, and an empty map.

        Raises
        ------
        ComponentError
            If a sensor is missing or of another kind, two sources of poses are named, the robot knows nothing of its
            start, which the map or its wheels need, or the map would be too large.
        """
        robot, rows = context.robot, context.rows
        check_laser("grid_mapping", robot, self.laser)
        if self.estimator and self.place:
            raise ComponentError(
                f"grid_mapping takes its poses from one source, but both estimator = {self.estimator!r} and "
                f"place = {self.place!r} are given; leave one of them empty"
            )
        if self.place:
            _check_place(robot, self.place)
        elif not self.estimator:
            check_encoder("grid_mapping", robot, self.encoder)
            check_keeps_up("grid_mapping", robot, self.encoder, self.laser)
        if not (self.estimator or self.place) or None in (self.center_x, self.center_y):
            refuse_lost("grid_mapping", context)
        area = area_of("grid_mapping", self)
        cells = rows, area.rows * area.cols
        state: State = {
            "pose": np.nan_to_num(context.pose),
            "covariance": np.nan_to_num(covariance_at_start(context)),
            "origin": area_origins(self, context.pose, area),
        }
        if not self.place and not self.estimator:
            state["joints"] = np.full((rows, len(robot.drive.joints)), np.nan)
            state["current"] = np.ones((rows, 1), dtype=bool)
        if self.model == "log_odds":
            state["log_odds"] = np.full(cells, np.nan, dtype=np.float32)
        else:
            state["hits"], state["misses"] = np.zeros(cells, np.int32), np.zeros(cells, np.int32)
        return state

    def update(
        self,
        robot: RobotModel,
        readings: Mapping[str, Measurement],
        command: Array,
        elapsed: Array,
        state: State,
        draws: Draws,
    ) -> Estimate:
        """The pose, after this step's scan is in the map."""
        fresh = check_fresh("grid_mapping", robot, self.laser, readings[self.laser], self.age_max)
        if self.estimator:
            given = readings[ESTIMATES + self.estimator]
            state["pose"] = given.measured[:, :3].copy()
            state["covariance"] = given.measured[:, 3:].reshape(-1, 3, 3).copy()
            fresh = fresh & given.fresh  # no scan is laid at a place that the wheels have not told yet
        elif self.place:
            fresh = fresh & self._look_up(robot, readings[self.place], fresh, state)
        else:
            check_fresh("grid_mapping", robot, self.encoder, readings[self.encoder], self.age_max)
            before, after = angles_of(robot, self.encoder, readings[self.encoder].measured, state["joints"])
            moved = reckon(robot.drive, state["pose"], state["covariance"], before, after, self.wheel_variance)
            state["pose"], state["covariance"], state["joints"] = moved.pose, moved.covariance, after
            state["current"] = is_current(robot, self.encoder, readings[self.encoder], after, state["current"])
            fresh = fresh & state["current"]
        if fresh.any():
            beams = beams_of(robot, self.laser)
            self._add(beams, scans_of(beams, state["pose"], readings[self.laser].measured, fresh), state)
        return Estimate(state["pose"].copy(), state["covariance"].copy())

    def _look_up(self, robot: RobotModel, reading: Measurement, scanned: Bools, state: State) -> Bools:
        """Take the poses that a tracking system gives of its mount; returns which rows have one now `(N, 1)`.

        Raises
        ------
        ComponentError
            If one is too old when it arrives, or where a row has `scanned` `(N, 1)`.
        """
        check_fresh("grid_mapping", robot, self.place, reading, self.age_max)
        late = scanned & is_late(reading, self.age_max)
        if late.any():
            row = int(np.flatnonzero(late[:, 0])[0])
            raise ComponentError(
                f"{robot.who(row)}, estimator grid_mapping: a scan came in, and the place that {self.place!r} gave is "
                f"{reading.age[row, 0]:g} s old; let it read whenever the laser does, or set age_max to use places up "
                "to that age as if they were taken now"
            )
        there = np.ascontiguousarray(reading.measured[:, :3])
        mounts = mounts_of(robot, self.place)
        is_known = np.isfinite(there).all(axis=1, keepdims=True)
        base = compose(there, relative(mounts, np.zeros_like(mounts)))
        state["pose"] = np.where(reading.fresh & is_known, base, state["pose"])
        return np.asarray(is_known)

    def _add(self, beams: Beams, scans: occupancy.Scans, state: State) -> None:
        area = area_of("grid_mapping", self)
        room = window_for(area, float(beams.range_max.max()))
        if self.model == "counting":
            occupancy.add_counts(area, state["origin"], scans, room, state["hits"], state["misses"])
            return
        evidence = log_odds_evidence(self.hit, self.miss, self.certainty)
        occupancy.add_log_odds(area, state["origin"], scans, evidence, room, state["log_odds"])

    def beliefs(self, state: State) -> Beliefs:
        """The map: ``occupancy`` (N, rows, cols), ``occupancy_origin`` [m] and ``occupancy_resolution`` [m]."""

        def probability(out: Array) -> None:
            if self.model == "log_odds":
                occupancy.probabilities_of_log_odds(state["log_odds"], out)
            else:
                occupancy.probabilities_of_counts(state["hits"], state["misses"], out)

        return LazyBeliefs(map_beliefs(probability, state["origin"], area_of("grid_mapping", self)))


def _check_place(robot: RobotModel, name: str) -> None:
    """Raise unless a sensor gives x, y and heading."""
    sensor: Any = sensor_of("grid_mapping", robot, name, "place", "tracking system")
    if tuple(sensor.columns())[:3] != _POSE:
        raise ComponentError(
            f"grid_mapping takes poses from the sensor {name!r}, but a {type(sensor).__name__} does not measure x, y "
            "and heading, as a gps with heading = true does; name such a sensor in the field 'place', or leave it empty"
        )
