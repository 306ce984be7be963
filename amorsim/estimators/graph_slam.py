"""Simultaneous localization and mapping by a graph of poses: scans are matched, loops closed, and the graph solved."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import (
    Beliefs,
    Context,
    Draws,
    Estimate,
    LazyBeliefs,
    Measurement,
    RobotModel,
    State,
    parameter,
)
from amorsim.estimators.map_area import MapArea, area_of, area_origins, log_odds_evidence, map_beliefs
from amorsim.estimators.node_graph import NodeGraph, empty_nodes, loops_of
from amorsim.estimators.scan_tracking import ScanTracker
from amorsim.estimators.scans import beams_of, mounts_of
from amorsim.kernels.mapping import occupancy
from amorsim.kernels.mapping.nodes import add_nodes
from amorsim.kernels.mapping.scan_cells import window_for
from amorsim.kernels.matching import icp, submaps
from amorsim.kernels.matching.correlative import Window, weigh
from amorsim.kernels.matching.tracking import Room

__all__ = ["GraphSlam"]


_ANGLE = math.radians(1.0)
_AMBIGUOUS = 0.9  # of a match's fit, above which another place fits as well
_SLIDES = 0.25 * np.arange(2, 13)  # [m] to either side, where the other places are


@attrs.frozen(kw_only=True)
class GraphSlam(MapArea, ScanTracker):
    """Maps and localizes at once: key scans are the nodes of a pose graph, which is solved when a loop closes.

    It follows the robot as `scan_matching` does. Each key scan is a node, linked to the one before by what wheels and
    matches gave. A new node near an old one, at least `loop_gap` nodes ago, is matched with a submap: the key scans
    around the old one. If the match is good, and no other place along its least certain direction fits as well, it
    becomes an edge; if it moves the robot far, only once a second one agrees. All poses are solved for again, where
    edges that the others contradict count little. Where that moves old nodes to others, these are matched too. The map
    is drawn from the key scans at the poses of their nodes, and drawn again when these have moved by more than half a
    cell.

    Parameters
    ----------
    loop_distance
        A node is looked for around a new one as far as this [m].
    loop_gap
        Nodes between the two ends of a loop, at least.
    loop_scans
        Key scans before the old node, and after it, that are in its submap as well.
    loop_window, loop_window_angle
        How far around the present guess a loop's match is looked for [m, rad].
    loop_fit, loop_share
        How well a scan must fit the submap, and the share of its points with a line there, for a loop, from 0 to 1.
    nodes
        The most nodes. When the graph has that many it stops growing, and the robot is followed from the last key.
    """

    loop_distance: float = parameter(6.0, unit="m", gt=0, static=True, help="how far a loop's other end is looked for")
    loop_gap: int = parameter(10, ge=2, static=True, help="nodes between the ends of a loop, at least")
    loop_scans: int = parameter(4, ge=0, le=50, static=True, help="key scans to either side in a loop's submap")
    loop_window: float = parameter(3.0, unit="m", gt=0, le=20, static=True, help="how far a loop's match is looked for")
    loop_window_angle: float = parameter(
        math.radians(30.0), unit="rad", ge=0, le=math.pi, static=True, help="how far around it is looked for"
    )
    loop_fit: float = parameter(0.6, ge=0, le=1, static=True, help="least fit of a loop's match")
    loop_share: float = parameter(0.5, ge=0, le=1, static=True, help="least share of points on a loop's other end")
    nodes: int = parameter(1000, ge=2, le=20_000, static=True, help="the most nodes of the graph")

    def sources(self) -> Sequence[tuple[str, str, str]]:
        """The sources that predict the pose and correct it, and the loops that it accepts."""
        trust = f"of {self.loop_gap} nodes and more, fit {self.loop_fit:g}, share {self.loop_share:g}"
        return [*super().sources(), ("loops", "correct all poses", trust)]

    def start(self, context: Context) -> State:
        """The state of scan matching, an empty graph and an empty map.

        Raises
        ------
        ComponentError
            If a sensor is missing or of another kind, or the map would be too large.
        """
        state = self._begin("graph_slam", context)
        area = area_of("graph_slam", self)
        beams = context.robot.sensors[self.laser].size
        state |= empty_nodes(context.rows, self.nodes, beams)
        state["origin"] = area_origins(self, context.pose, area)
        state["log_odds"] = np.full((context.rows, area.rows * area.cols), np.nan, dtype=np.float32)
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
        """The estimate after this step's motion and scan, and after solving the graph if the scan closed a loop."""
        asked, scans = self._follow("graph_slam", robot, readings, state)
        if scans is not None and asked[:, 0].any():
            ranges = readings[self.laser].measured
            for i in np.flatnonzero(asked[:, 0]).tolist():
                if NodeGraph(state, i).grow(ranges[i]):
                    self._extend(robot, state, i)
        return self._estimate(state)

    def _extend(self, robot: RobotModel, state: State, row: int) -> None:
        """Draw a row's new node into its map, or all of them if it closes a loop."""
        graph = NodeGraph(state, row)
        first = graph.count - 1
        pairs = graph.nodes_to_look_at(self.loop_gap, self.loop_distance)
        closed = [self._close_loop(robot, state, row, *pair) for pair in pairs]
        if any(closed) and graph.solve():
            graph.take_pose()
            if graph.moved_since_drawn(first) > 0.5 * self.resolution:
                state["log_odds"][row] = np.nan
                first = 0
        state["node_drawn"][row, first : graph.count] = graph.poses[first:]
        area, beams = area_of("graph_slam", self), beams_of(robot, self.laser)
        b, r = row % len(beams.cos_b), row % len(beams.range_max)
        reach = float(beams.range_max[r, 0])
        add_nodes(
            area,
            state["origin"][row],
            state["node_pose"][row, first : graph.count],
            state["node_ranges"][row, first : graph.count],
            beams.mounts[row],
            beams.cos_b[b],
            beams.sin_b[b],
            reach,
            log_odds_evidence(),
            window_for(area, reach),
            np.empty(3),
            state["log_odds"][row],
        )

    def _close_loop(self, robot: RobotModel, state: State, row: int, near: int, node: int) -> bool:
        """Match a node of a row with the scans around one long before it; whether that became an edge."""
        graph = NodeGraph(state, row)
        around = np.arange(max(0, near - self.loop_scans), min(near + self.loop_scans, node - 1) + 1)
        scans = self._outlines_of(robot, row, state["node_ranges"][row, np.append(around, node)])
        far, turned = graph.window_between(near, node)
        window = Window(min(far, float(self.loop_window)), min(turned, float(self.loop_window_angle)), _ANGLE)
        rules = self._rules()._replace(window=window)
        reach, room = self._reach(robot), self._room(robot)
        room.start[:] = graph.relative(near, np.array([node]))[0]
        fit = submaps.align_with_submap(
            scans,
            graph.relative(near, around),
            mounts_of(robot, self.laser)[row],
            float(reach[row % len(reach), 0]),
            np.empty_like(scans.points),
            icp.reference(scans.points[:-1, :, 0].size),
            rules,
            room,
        )
        found = room.result
        is_good = fit >= self.loop_fit and found.quality[0] >= self.loop_share
        if not is_good or found.values[0] < self.degenerate * found.values[2]:
            return False
        if _slid_fit(room, scans.points[-1]) > _AMBIGUOUS * fit:
            return False
        return graph.close(near, node, found.pose, found.information)

    def beliefs(self, state: State) -> Beliefs:
        """The map and the graph, and of this step's match the beliefs of `scan_matching`.

        ``occupancy`` (N, rows, cols), nan where nothing was seen, ``occupancy_origin`` [m], ``occupancy_resolution``
        [m]; ``graph_poses`` (N, nodes, 3), nan beyond the last one; ``graph_edges`` (N, edges, 2), -1 beyond the last
        one; ``graph_measurements`` (N, edges, 3), the second pose in the frame of the first, and ``graph_information``
        (N, edges, 3, 3), less the more other edges contradict it; ``graph_loops``, how many edges closed a loop.
        """

        def probability(out: Array) -> None:
            occupancy.probabilities_of_log_odds(state["log_odds"], out)

        return LazyBeliefs(
            {
                **self._of_match(state),
                **map_beliefs(probability, state["origin"], area_of("graph_slam", self)),
                "graph_poses": lambda: state["node_pose"].copy(),
                "graph_edges": lambda: state["edge_nodes"].copy(),
                "graph_measurements": lambda: state["edge_measurement"].copy(),
                "graph_information": lambda: state["edge_information"] * state["edge_weight"][:, :, None, None],
                "graph_loops": loops_of(state),
            }
        )


def _slid_fit(room: Room, points: Array) -> float:
    """The best fit of a scan whose points are shifted from the match, along the match's least certain direction.

    Along a corridor all places fit alike, and the best of them tells nothing.
    """
    found = room.result
    _, axes = np.linalg.eigh(found.information[:2, :2])
    slides = np.concatenate((-_SLIDES, _SLIDES))
    poses = found.pose + slides[:, None] * np.array([*axes[:, 0], 0.0])
    return max(float(weigh(room.picture, points, pose)) for pose in poses)
