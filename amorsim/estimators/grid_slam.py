"""Simultaneous localization and mapping by particles, each with a path and so a map of its own."""

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
    Draws,
    Estimate,
    Estimator,
    LazyBeliefs,
    Measurement,
    RobotModel,
    State,
    parameter,
)
from amorsim.core.parameters import own_first
from amorsim.core.poses import compose, wrap_angle
from amorsim.estimators.ages import check_fresh
from amorsim.estimators.initial_beliefs import refuse_lost, start_state, with_start
from amorsim.estimators.map_area import MapArea, area_of, area_origins, log_odds_evidence, map_beliefs
from amorsim.estimators.scan_tracking import empty_outlines, placed
from amorsim.estimators.scans import Beams, beams_of, check_laser
from amorsim.estimators.wheels import angles_of, check_encoder, check_keeps_up, is_current, reckon
from amorsim.kernels import elementary
from amorsim.kernels.kinematics.poses import directions
from amorsim.kernels.mapping import occupancy
from amorsim.kernels.mapping.nodes import add_nodes
from amorsim.kernels.mapping.scan_cells import window_for
from amorsim.kernels.matching import particles as kernels
from amorsim.kernels.matching.icp import Search
from amorsim.kernels.matching.outlines import outlines
from amorsim.kernels.matching.tracking import Outlines

__all__ = ["GridSlam"]


_REACH = 4.0  # [m] around a particle, in which scans are part of its map
_REFERENCES = 4  # scans that a scan is matched with
_POINTS = 60  # of a scan that are matched, about
_STEPS = 30
_FLOOR = np.diag((1e-6, 1e-6, 1e-7))  # of the covariance: particles may all be one


@attrs.frozen(kw_only=True, field_transformer=own_first)
class GridSlam(MapArea, Estimator):
    """Maps and localizes at once by particles: each follows a path of its own, which makes a map of its own.

    When the robot has moved far enough, every particle moves by the wheels and a draw of their noise, lays the scan
    onto its map, and is weighed by how well it fits. Where few particles carry most of the weight, all are drawn again
    by weight. After a loop, those remain whose maps fit. The pose and the map are those of the particle with the most
    weight. The draws are amorsim's, so a run gives the same bits each time.

    Parameters
    ----------
    laser, encoder
        Names of the sensors of scans and of the joints.
    wheel_variance
        Variance of the travel of each rolling joint per metre, as the robot assumes it [m^2/m].
    range_std
        Standard deviation of a range, as the robot assumes it [m].
    particles
        How many.
    match_distance, match_angle
        A scan is used when the robot has moved or turned this far since the last one used [m, rad].
    node_distance, node_angle
        A scan becomes part of the maps when the robot has moved or turned this far since the last that did [m, rad].
    weighing_std
        Standard deviation of a point's distance from its map, for the weights [m].
    weighing_points
        How many independent points a scan counts as; beams next to each other share errors.
    resampling
        Particles are drawn again when their effective number falls below this share of them.
    nodes
        The most scans in a map. Maps that have that many stop growing.
    age_max
        The oldest scan, and reading of the encoder, [s] that is used as if it were taken now. An older one is an error.
    """

    laser: str = parameter("laser", refers="sensors", help="name of the sensor of scans")
    encoder: str = parameter("encoder", refers="sensors", help="name of the sensor that counts the joints")
    wheel_variance: float = parameter(
        unit="m", gt=0, help="variance of a rolling joint's travel [m^2] per metre of it, as the robot believes"
    )
    range_std: float = parameter(unit="m", gt=0, static=True, help="standard deviation of a range")
    particles: int = parameter(30, ge=1, le=10_000, static=True, help="how many particles")
    match_distance: float = parameter(0.3, unit="m", gt=0, static=True, help="motion between two scans that are used")
    match_angle: float = parameter(math.radians(15.0), unit="rad", gt=0, static=True, help="turn between two of them")
    node_distance: float = parameter(0.6, unit="m", ge=0, static=True, help="motion between two scans of a map")
    node_angle: float = parameter(math.radians(30.0), unit="rad", ge=0, static=True, help="turn between two of them")
    weighing_std: float = parameter(0.05, unit="m", gt=0, static=True, help="of a point's distance from its map")
    weighing_points: float = parameter(10.0, gt=0, static=True, help="how many independent points a scan counts as")
    resampling: float = parameter(0.5, ge=0, le=1, static=True, help="effective share below which it resamples")
    nodes: int = parameter(500, ge=2, le=20_000, static=True, help="the most scans in a map")
    age_max: float = parameter(
        0.0, unit="s", ge=0, help="age at which a scan or encoder reading still counts as taken now"
    )

    def sources(self) -> Sequence[tuple[str, str, str]]:
        """The sources that move the particles and those that weigh them."""
        seen = f"{self.particles} particles, range {self.range_std:g} m"
        return [
            (f"sensor {self.encoder!r}", "moves the particles", f"{self.wheel_variance:g} m² of travel per m"),
            (f"sensor {self.laser!r}", "weighs them, draws maps", seen),
        ]

    def start(self, context: Context) -> State:
        """Particles that are all at the start, without a scan, and an empty map.

        Raises
        ------
        ComponentError
            If a sensor is missing or of another kind, the robot knows nothing of its start, or the map
            would be too large.
        """
        robot, rows = context.robot, context.rows
        check_laser("grid_slam", robot, self.laser)
        check_encoder("grid_slam", robot, self.encoder)
        check_keeps_up("grid_slam", robot, self.encoder, self.laser)
        refuse_lost("grid_slam", context)
        area = area_of("grid_slam", self)
        beams = robot.sensors[self.laser].size
        pose = np.array(context.pose, dtype=np.float64)
        return {
            "joints": np.full((rows, len(robot.drive.joints)), np.nan),
            "current": np.ones((rows, 1), dtype=bool),
            "moved": np.zeros((rows, 3)),
            "spread": np.zeros((rows, 3, 3)),
            "particles": np.repeat(pose[:, None], self.particles, axis=1),
            "weights": np.full((rows, self.particles), -math.log(self.particles)),
            "paths": np.full((rows, self.particles, self.nodes, 3), np.nan),
            "nodes": np.zeros(rows, np.int64),
            "drift": np.zeros((rows, 3, 3)),
            "node_drift": np.zeros((rows, self.nodes, 3, 3)),
            "node_ranges": np.full((rows, self.nodes, beams), np.nan),
            "node_lines": np.full((rows, self.nodes, beams, 4), np.nan),
            "scan": np.full((rows, beams, 2), np.nan),
            "drawn": np.full((rows, self.nodes, 3), np.nan),
            "origin": area_origins(self, context.pose, area),
            "log_odds": np.full((rows, area.rows * area.cols), np.nan, dtype=np.float32),
            **start_state(context),
        }

    def update(
        self,
        robot: RobotModel,
        readings: Mapping[str, Measurement],
        command: Array,
        elapsed: Array,
        state: State,
        draws: Draws,
    ) -> Estimate:
        """The best particle's pose after this step's motion and scan."""
        check_fresh("grid_slam", robot, self.encoder, readings[self.encoder], self.age_max)
        before, after = angles_of(robot, self.encoder, readings[self.encoder].measured, state["joints"])
        moved = reckon(robot.drive, state["moved"], state["spread"], before, after, self.wheel_variance)
        state["moved"], state["spread"], state["joints"] = moved.pose, moved.covariance, after
        state["current"] = is_current(robot, self.encoder, readings[self.encoder], after, state["current"])
        fresh = check_fresh("grid_slam", robot, self.laser, readings[self.laser], self.age_max) & state["current"]
        way = np.sqrt(moved.pose[:, :1] ** 2 + moved.pose[:, 1:2] ** 2)
        is_far = (way >= self.match_distance) | (np.abs(moved.pose[:, 2:]) >= self.match_angle)
        due = np.ascontiguousarray(fresh & (is_far | (state["nodes"] == 0)[:, None]))
        if due.any():
            self._use(robot, np.ascontiguousarray(readings[self.laser].measured), due, state, draws)
        return _estimate_of(state)

    def _use(self, robot: RobotModel, ranges: Array, due: Bools, state: State, draws: Draws) -> None:
        """Move, match, weigh and resample the particles of some rows, and let their maps grow."""
        beams = beams_of(robot, self.laser)
        scans = empty_outlines(*ranges.shape)
        outlines(ranges, beams.cos_b, beams.sin_b, beams.range_max, beams.mounts, *scans)
        every = max(1, ranges.shape[1] // _POINTS)
        search = Search(float(self.range_std), 0.5, _STEPS, 1e-4)
        weighing = kernels.Weighing(
            float(self.weighing_std), float(self.weighing_points), _REFERENCES, _REACH, every, search
        )
        believed = kernels.Particles(
            state["particles"], state["weights"], state["paths"], state["nodes"], state["drift"], state["node_drift"]
        )
        room = kernels.workshop(ranges.shape[1], _REFERENCES, every)
        normals = draws.normal(3 * self.particles)
        uniforms = draws.uniform(1)
        kernels.move_and_match(
            believed, due, state["moved"], state["spread"], normals, scans, state["node_lines"], weighing, room
        )
        copies = np.empty((self.particles, 3)), np.empty((self.particles, self.nodes, 3))
        kernels.resample(believed, due, float(self.resampling), uniforms, *copies)
        state["moved"] = np.where(due, 0.0, state["moved"])
        state["spread"] = np.where(due[:, :, None], 0.0, state["spread"])
        state["scan"] = np.where(due[:, :, None], scans.points, state["scan"])
        for row in np.flatnonzero(due[:, 0]).tolist():
            if self._grow(row, ranges[row], scans, state):
                self._draw(row, beams, state)

    def _grow(self, row: int, ranges: Array, scans: Outlines, state: State) -> bool:
        """Let a row's scan be part of its maps, if it is far enough from the last that is; whether it is."""
        count = int(state["nodes"][row])
        best = int(np.argmax(state["weights"][row]))
        pose = state["particles"][row, best]
        if count == self.nodes:
            return False
        if count:
            last = state["paths"][row, best, count - 1]
            way = math.hypot(pose[0] - last[0], pose[1] - last[1])
            turn = abs(float(wrap_angle(pose[2:] - last[2:])[0]))
            if way < self.node_distance and turn < self.node_angle:
                return False
        state["paths"][row, :, count] = state["particles"][row]
        state["node_ranges"][row, count] = ranges
        state["node_lines"][row, count] = scans.lines[row]
        state["node_drift"][row, count] = state["drift"][row]
        state["nodes"][row] = count + 1
        return True

    def _draw(self, row: int, beams: Beams, state: State) -> None:
        """Add the newest scan of the best particle to the drawn map; if another one is best, draw all its scans."""
        count = int(state["nodes"][row])
        path = state["paths"][row, int(np.argmax(state["weights"][row])), :count]
        drawn = state["drawn"][row]
        first = count - 1
        if not np.array_equal(path[:first], drawn[:first]):
            state["log_odds"][row] = np.nan
            first = 0
        drawn[:count] = path
        area = area_of("grid_slam", self)
        b, r = row % len(beams.cos_b), row % len(beams.range_max)
        reach = float(beams.range_max[r, 0])
        add_nodes(
            area,
            state["origin"][row],
            np.ascontiguousarray(path[first:]),
            state["node_ranges"][row, first:count],
            beams.mounts[row],
            beams.cos_b[b],
            beams.sin_b[b],
            reach,
            log_odds_evidence(),
            window_for(area, reach),
            np.empty(3),
            state["log_odds"][row],
        )

    def beliefs(self, state: State) -> Beliefs:
        """The particles, and the map of the one with the most weight.

        ``particles`` (N, P, 3) and their ``weights`` (N, P), which sum to 1; ``path`` (N, nodes, 3) of the best one,
        nan beyond the last node; ``effective_particles`` (N,); ``occupancy`` (N, rows, cols), nan where nothing was
        seen, ``occupancy_origin`` [m] and ``occupancy_resolution`` [m]; ``scan``, the last scan's points in the world.
        """
        weights = _weights_of(state)
        best = np.argmax(weights, axis=1)
        every = np.arange(len(best))

        def probability(out: Array) -> None:
            occupancy.probabilities_of_log_odds(state["log_odds"], out)

        return LazyBeliefs(
            {
                "particles": state["particles"].copy(),
                "weights": weights,
                "effective_particles": _effective(weights),
                "path": lambda: state["paths"][every, best].copy(),
                **map_beliefs(probability, state["origin"], area_of("grid_slam", self)),
                "scan": lambda: placed(state["scan"], np.ascontiguousarray(state["particles"][every, best])),
            }
        )


def _weights_of(state: State) -> Array:
    """Weights `(N, P)` with the sum 1 in each row; summed in order, so that rows keep their bits."""
    logarithms: Any = state["weights"]
    weights = elementary.exp(logarithms - logarithms.max(axis=1, keepdims=True))
    return np.asarray(weights / np.cumsum(weights, axis=1)[:, -1:])


def _effective(weights: Array) -> Array:
    return np.asarray(1.0 / np.cumsum(weights**2, axis=1)[:, -1])


def _estimate_of(state: State) -> Estimate:
    """The best particle, moved by the wheels since the last scan, and the spread of the others about it, with drift."""
    weights = _weights_of(state)
    best = np.argmax(weights, axis=1)
    pose = state["particles"][np.arange(len(best)), best]
    off = state["particles"] - pose[:, None]
    off[:, :, 2] = wrap_angle(off[:, :, 2])
    covariance = np.zeros((len(best), 3, 3))
    for p in range(weights.shape[1]):
        covariance += weights[:, p, None, None] * off[:, p, :, None] * off[:, p, None, :]
    c, s = np.empty((2, len(best), 1))
    directions(np.ascontiguousarray(pose[:, 2:]), c, s)
    turn = np.zeros((len(best), 3, 3))
    turn[:, 0, 0], turn[:, 0, 1], turn[:, 1, 0], turn[:, 1, 1], turn[:, 2, 2] = c[:, 0], -s[:, 0], s[:, 0], c[:, 0], 1.0
    spread = np.zeros_like(covariance)
    for j in range(3):
        for k in range(3):
            spread += turn[:, :, j, None] * turn[:, None, :, k] * state["spread"][:, None, None, j, k]
    return with_start(Estimate(compose(pose, state["moved"]), covariance + spread + state["drift"] + _FLOOR), state)
