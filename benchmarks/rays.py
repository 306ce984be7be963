"""Ray casting by cell size: amorsim's public `Map.cast_rays` against the plain traversal and raycast2D."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks import plain, published, worlds
from benchmarks.contest import Clock
from benchmarks.peers.raycast2d import COMPUTES, Raycast2D
from benchmarks.results import Conduct, Ratio, Row, compare, mean_range, ratio_of
from benchmarks.task import BEAMS, FOV, RANGE_MAX

__all__ = ["measure", "same_bits"]

Array = npt.NDArray[np.float64]

SECTION = "rays"
UNIT = "rays/s"
_BEARINGS = np.linspace(-FOV / 2.0, FOV / 2.0, BEAMS)
_CLEARANCE = 0.1  # m
_SIZES = (0.002, 0.005, 0.01, 0.02, 0.05)  # m, of the line room besides 1 mm
_BUDGET = 0.6  # s, about, of the plain traversal in a round

OURS = "Map.cast_rays: exact cell and distance of 181 beams of 8 m from each pose, one thread"
PLAIN = "plain traversal, frozen: one test a cell, exact, one thread"


def same_bits(a: Array, b: Array) -> float:
    """The share of distances that are equal to 2 units in the last place (both inf is equal)."""
    finite = np.isfinite(a) & np.isfinite(b)
    near = np.abs(np.where(finite, a, 0.0) - np.where(finite, b, 0.0)) <= 2.0 * np.spacing(np.where(finite, a, 1.0))
    return float(((finite & near) | (a == b)).mean())


def measure(rounds: int, quick: bool, clock: Clock, say: Callable[[str], None]) -> tuple[list[Row], tuple[float, ...]]:
    """The rows, and the plain traversal's rays a second on the office in each round."""
    settings: list[Callable[[], worlds.World]] = [worlds.line_room, worlds.bitmap_room]
    settings += [lambda side=side: worlds.line_room(side) for side in (_SIZES[:1] if quick else _SIZES)]  # type: ignore[misc]
    rows: list[Row] = []
    for build in settings:
        made, _ = _by_size(build(), rounds, quick, clock, say)
        rows += made
    made, plain_rates = _by_size(worlds.office(), rounds, quick, clock, say)
    rows += made
    ours = next(row for row in made if row.side == "amorsim").rounds
    for peer in published.RAYS["office"]:
        theirs = published.here(peer.figure, plain_rates)
        rows.append(
            Row(
                section=SECTION,
                setting="office of 50 m, 5 cm",
                side=peer.name,
                unit=UNIT,
                rounds=theirs,
                ratio=Ratio(spread=ratio_of(ours, theirs), counts=False, why_not="published figure, scaled"),
                note=f"published {peer.figure / 1e6:g} M rays/s, scaled by the plain traversal; {peer.computes}",
            )
        )
    rows += _raycast2d(worlds.office(), rounds, quick, clock, say)
    return rows, plain_rates


def _by_size(
    world: worlds.World, rounds: int, quick: bool, clock: Clock, say: Callable[[str], None]
) -> tuple[list[Row], tuple[float, ...]]:
    say(f"rays: {world.name}")
    poses = worlds.places(world, 1000 if quick else 10_000, _CLEARANCE)
    cells, side = world.cells, world.map.resolution
    few, count = _fit(world, poses, _BUDGET / (4.0 if quick else 1.0), clock)
    exact = plain.cast(cells, side, few, _BEARINGS, RANGE_MAX)
    ours = world.map.cast_rays(poses, _BEARINGS, RANGE_MAX)
    same = same_bits(ours[:count], exact)
    rates: dict[str, list[float]] = {"amorsim": [], "plain traversal": []}
    for _ in range(rounds):
        taken = _timed(lambda: plain.cast(cells, side, few, _BEARINGS, RANGE_MAX), clock)
        rates["plain traversal"].append(exact.size / taken)
        taken = _timed(lambda: world.map.cast_rays(poses, _BEARINGS, RANGE_MAX), clock)
        rates["amorsim"].append(ours.size / taken)
    # Both sides stand still here, and are compared on the poses that both have.
    a, b = (_still(scan, few) for scan in (ours[:count], exact))
    why_not = compare(a, b) or ("" if same == 1.0 else f"only {same:.4%} of the rays are exact")
    spread = ratio_of(rates["amorsim"], rates["plain traversal"])
    rows = [
        Row(
            section=SECTION,
            setting=world.name,
            side="amorsim",
            unit=UNIT,
            rounds=tuple(rates["amorsim"]),
            conduct=_still(ours, poses),
            note=f"{OURS}; {len(poses)} poses",
        ),
        Row(
            section=SECTION,
            setting=world.name,
            side="plain traversal",
            unit=UNIT,
            rounds=tuple(rates["plain traversal"]),
            ratio=Ratio(spread=spread, counts=not why_not, why_not=why_not),
            conduct=b,
            note=f"{PLAIN}; the first {count} of the poses, where {same:.2%} of amorsim's rays are the same to 2 ulp",
        ),
    ]
    return rows, tuple(rates["plain traversal"])


def _fit(world: worlds.World, poses: Array, budget: float, clock: Clock) -> tuple[Array, int]:
    """As many of the poses as the plain traversal takes about `budget` seconds for."""
    plain.cast(world.cells, world.map.resolution, poses[:1], _BEARINGS, RANGE_MAX)
    trial = poses[:20]
    taken = _timed(lambda: plain.cast(world.cells, world.map.resolution, trial, _BEARINGS, RANGE_MAX), clock)
    count = int(np.clip(len(trial) * budget / taken, 20, len(poses)))
    return np.ascontiguousarray(poses[:count]), count


def _still(scan: Array, poses: Array) -> Conduct:
    return Conduct(
        first_range=mean_range(scan[:1], RANGE_MAX),
        mean_range=mean_range(scan, RANGE_MAX),
        all_beams=scan.shape == (len(poses), BEAMS),
    )


def _timed(work: Callable[[], Any], clock: Clock) -> float:
    started = clock()
    work()
    return clock() - started


def _raycast2d(world: worlds.World, rounds: int, quick: bool, clock: Clock, say: Callable[[str], None]) -> list[Row]:
    """Both sides from the middles of cells, away from the border."""
    try:
        peer = Raycast2D(world, worlds.places(world, 300 if quick else 2000, _CLEARANCE))
    except ImportError as error:
        return [Row(section=SECTION, setting=world.name, side="raycast2D", unit=UNIT, note=f"not installed ({error})")]
    say("rays: raycast2D")
    poses, theirs = peer.poses, peer.ranges()
    ours = world.map.cast_rays(poses, _BEARINGS, RANGE_MAX)
    rates: dict[str, list[float]] = {"amorsim": [], "raycast2D": []}
    for _ in range(rounds):
        rates["raycast2D"].append(theirs.size / _timed(peer.cast, clock))
        taken = _timed(lambda: world.map.cast_rays(poses, _BEARINGS, RANGE_MAX), clock)
        rates["amorsim"].append(ours.size / taken)
    conduct = _still(theirs, poses)
    why_not = compare(_still(ours, poses), conduct)
    return [
        Row(
            section=SECTION,
            setting=world.name,
            side="raycast2D",
            unit=UNIT,
            rounds=tuple(rates["raycast2D"]),
            ratio=Ratio(spread=ratio_of(rates["amorsim"], rates["raycast2D"]), counts=not why_not, why_not=why_not),
            conduct=conduct,
            note=f"{COMPUTES}; {len(poses)} poses in the middles of cells, for both sides",
        )
    ]
