"""Zones of the floor, as they act on the wheels of a group of robots."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from amorsim.array_types import Array, Bools
from amorsim.contracts import Context, Drive, State
from amorsim.core.poses import compose
from amorsim.core.segment_crossings import contains, share_rolled, share_within
from amorsim.core.shapes import Shape
from amorsim.scenario.spec import Zone
from amorsim.simulation.error_context import ErrorContext
from amorsim.simulation.sensing.noise_chain import Chain, Streams

__all__ = ["Zones", "contact_points", "zone_streams"]


_BORDER = 1e-6  # [m] on either side, within which rounding might move a wheel that rests on the border


def zone_streams(zones: Sequence[Zone]) -> list[tuple[str, ...]]:
    """The names of the random streams that a robot uses in zones."""
    return [("zone", zone.name, "noise", element.name) for zone in zones for element in zone.ground]


class Zones:
    """The zones of a scenario, in order, with the states and draws of a group's rows in each."""

    def __init__(self, zones: Sequence[Zone], rows: int, streams: Streams, whose: ErrorContext) -> None:
        self._zones = [zone for zone in zones if zone.ground]
        self._chains = [Chain(zone.ground, streams, whose, "zone", zone.name) for zone in self._zones]
        for zone, chain in zip(self._zones, self._chains, strict=True):
            chain.set_parameters([zone.ground] * rows)
        self._discs = [_disc(zone) for zone in self._zones]
        # Of each zone, the wheels `(N, r)` that were inside in the last step: a wheel that rests on the border after it
        # entered differs by this from one that is about to enter.
        self._memories: list[State] = [{} for _ in self._zones]

    def __bool__(self) -> bool:
        return bool(self._zones)

    def start(self, context: Context) -> None:
        """Begin an episode; the size in `context` is the number of joints that roll."""
        for chain, memory in zip(self._chains, self._memories, strict=True):
            chain.states = chain.start(context)
            memory["inside"] = np.zeros((context.rows, context.size), dtype=bool)

    def put(self, row: int) -> None:
        """Forget in which zones the wheels of a row were, as it was put somewhere else."""
        for memory in self._memories:
            memory["inside"] = memory["inside"].copy()
            memory["inside"][row] = False

    def halt(self, stopped: Bools, points: Array) -> None:
        """Judge rows that something `stopped` `(N,)` by where their wheels are, `points` `(N, r, 2)` in the world."""
        for zone, memory in zip(self._zones, self._memories, strict=True):
            near = _around(zone.shape, _in_frame(zone, points.reshape(-1, 2)))[1].reshape(memory["inside"].shape)
            memory["inside"] = memory["inside"] & (near | ~stopped[:, None])

    def passed(
        self,
        drive: Drive,
        before: Array,
        after: Array,
        rolling: npt.NDArray[np.intp],
        radius: Array,
        pose: Array,
        elapsed: Array,
    ) -> tuple[Array, Array | None]:
        """The joints `(N, j)` that match the travel over the ground, at `pose`, for joints from `before` to `after`.

        Also returns the bodies' slide `(N, 3)`, if a zone makes one. `rolling` are the joints that roll, `radius`
        `(N, r)` [m/rad] their travel over the ground per turn. Each zone acts on the part of a joint's travel that is
        within it, on the straight line between its first and last point of contact. A step is cut where a joint
        crosses the border, so the result depends on the step size only through the curvature of the path within one
        step.
        """
        begin = contact_points(drive, before, pose)
        end = contact_points(drive, after, compose(pose, drive.displacement(before, after, np.ones((len(pose), 1)))))
        travel = (after[:, rolling] - before[:, rolling]) * radius
        motion = drive.twist(before, after) if any(chain.slides for chain in self._chains) else None
        slipped, slide = self._corrupt(travel, begin, end, elapsed, motion)
        found = after.copy()
        # Robots outside all zones are unaffected, to the bit.
        found[:, rolling] = np.where(slipped == travel, after[:, rolling], before[:, rolling] + slipped / radius)
        return found, slide

    def _corrupt(
        self, travel: Array, begin: Array, end: Array, elapsed: Array, motion: Array | None
    ) -> tuple[Array, Array | None]:
        start, stop = begin.reshape(-1, 2), end.reshape(-1, 2)
        slide = None if motion is None else np.zeros_like(motion)
        way = np.sqrt((stop[:, 0] - start[:, 0]) ** 2 + (stop[:, 1] - start[:, 1]) ** 2)
        for zone, chain, memory, (x, y, reach) in zip(
            self._zones, self._chains, self._memories, self._discs, strict=True
        ):
            apart = (start[:, 0] - x) ** 2 + (start[:, 1] - y) ** 2
            if (apart > (way + reach) ** 2).all():
                # Call the elements anyway: a robot's state must not depend on where others are.
                nothing = np.zeros_like(travel)
                memory["inside"] = np.zeros(travel.shape, dtype=bool)
                chain.corrupt(nothing, {"entered": nothing, "inside": nothing}, elapsed)
                if chain.slides and motion is not None:
                    chain.slide(np.zeros_like(motion), elapsed)
                continue
            a, b = _in_frame(zone, start), _in_frame(zone, stop)
            share = share_within(zone.shape, a, b).reshape(travel.shape)
            stays = memory["inside"]
            inside = _around(zone.shape, a)[0].reshape(travel.shape) | stays
            entered = (share > 0.0) & (travel != 0.0) & ~inside
            side = {"entered": entered.astype(np.float64), "inside": stays.astype(np.float64)}
            # Outside the zone nothing changes, not even the sign of a zero.
            within = np.where(share > 0.0, travel * share, 0.0)
            share = _cut(zone, a, b, share, within, chain.median(within, side, elapsed))
            within = np.where(share > 0.0, travel * share, 0.0)
            passed = chain.corrupt(within, side, elapsed)
            slipped = np.where(share > 0.0, (travel - within) + passed, travel)
            if chain.slides and motion is not None and slide is not None:
                slide = slide + chain.slide(motion * _mean(share), elapsed)
            # The next zone acts on the path that this one leaves.
            over = np.where(travel != 0.0, travel, 1.0)
            stop = start + (stop - start) * np.where(travel != 0.0, slipped / over, 1.0).reshape(-1, 1)
            travel = slipped
            # By the straight line, not by where it comes: on a curve, one that rests on the border may come off it.
            near = _around(zone.shape, _in_frame(zone, stop))[1].reshape(travel.shape)
            memory["inside"] = (inside | entered) & near
        return travel, slide

    def states(self) -> dict[str, State]:
        """The states of all zones and of their elements, by their place; the dicts themselves."""
        found = {f"zone {zone.name}": memory for zone, memory in zip(self._zones, self._memories, strict=True)}
        for zone, chain in zip(self._zones, self._chains, strict=True):
            found |= {f"zone {zone.name} {name}": s for name, s in zip(chain.names, chain.states, strict=True)}
        return found


def _around(shape: Shape, points: Array) -> tuple[Bools, Bools]:
    """Whether points `(M, 2)` [m] of a shape's frame are inside, and not on its border; and whether they are on either.

    The points around one show whether it is on the border, so corners and cuts between parts need no rule of their own.
    """
    around = [contains(shape, points + np.array(offset)) for offset in itertools.product((-_BORDER, _BORDER), repeat=2)]
    return np.all(around, axis=0), np.any(around, axis=0)


def _cut(zone: Zone, a: Array, b: Array, share: Array, within: Array, passed: Array) -> Array:
    """The share `(N, r)` of the wheels' rolling that is within a zone, where `within` of rolling moves them `passed`.

    `share` is that of wheels without slip, on the lines from `a` to `b` in the zone's frame.
    """
    slips = (share > 0.0) & (passed != within) & (within != 0.0)
    if not slips.any():
        return share
    ratio = np.where(slips, passed / np.where(slips, within, 1.0), 1.0)
    return np.where(slips, share_rolled(zone.shape, a, b, ratio.reshape(-1)).reshape(share.shape), share)


def _mean(share: Array) -> Array:
    """The mean over the wheels `(N, 1)`, in one order for every row."""
    total = share[:, :1]
    for i in range(1, share.shape[1]):
        total = total + share[:, i : i + 1]
    return np.asarray(total / share.shape[1])


def contact_points(drive: Drive, joints: Array, pose: Array) -> Array:
    """Where the rolling joints of bodies at `pose` `(N, 3)` touch the ground, in the world `(N, r, 2)` [m]."""
    offsets = drive.contacts(joints)
    rows, r = offsets.shape[:2]
    at = np.concatenate((offsets.reshape(-1, 2), np.zeros((rows * r, 1))), axis=1)
    return compose(np.repeat(pose, r, axis=0), at)[:, :2].reshape(rows, r, 2)


def _disc(zone: Zone) -> tuple[float, float, float]:
    """A disc in the world that contains the zone, with a small margin: x, y and radius [m]."""
    corners = zone.outline
    x, y = (float(value) for value in corners.mean(axis=0))
    # A circle's border is drawn by chords; the circle is less than one percent wider than these.
    reach = float(np.sqrt((corners[:, 0] - x) ** 2 + (corners[:, 1] - y) ** 2).max())
    return x, y, 1.01 * reach


def _in_frame(zone: Zone, points: Array) -> Array:
    """Points of the world `(M, 2)` [m] in the frame of a zone."""
    c, s = math.cos(zone.pose.heading), math.sin(zone.pose.heading)
    x, y = points[:, 0] - zone.pose.x, points[:, 1] - zone.pose.y
    return np.stack((c * x + s * y, c * y - s * x), axis=1)
