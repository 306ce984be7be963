"""Robot-steps a second by number of robots: with peers in one world, and alone at constant density."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

import attrs

from benchmarks import published, worlds
from benchmarks.contest import Clock, drive, followed, track_conduct
from benchmarks.ours import DISCS, PIONEER, Ours, disc, pioneer
from benchmarks.peers.base import Peer
from benchmarks.results import Conduct, Ratio, Row, compare, ratio_of
from benchmarks.worlds import World

__all__ = ["measure"]

SECTION = "fleet"
UNIT = "robot-steps/s"
_AREA = 10.0  # m2 for each robot, where density is constant
_CLEARANCE = 0.45  # m about a start: a disc, and what `wander` keeps free
_MANY = 100  # robots, from which on threads share them
_APART = 0.85  # m from start to start
_AT_LEAST = 0.3  # s timed of amorsim in a round
_AT_MOST = 1.5  # s timed of a peer in a round, if it does not get through all steps


@attrs.frozen(kw_only=True)
class _Setting:
    name: str
    world: Callable[[], World]
    robots: int
    steps: int
    with_pioneer: bool = False
    peers: bool = True
    published: bool = True  # whether figures of peers that are not here are told beside it


def _settings(quick: bool) -> list[_Setting]:
    found = [
        _Setting(name="one Pioneer, line room", world=worlds.line_room, robots=1, steps=60, with_pioneer=True),
        _Setting(name="one Pioneer, office", world=worlds.office, robots=1, steps=60, with_pioneer=True),
        _Setting(
            name="one Pioneer, furnished office",
            world=worlds.furnished_office,
            robots=1,
            steps=60,
            with_pioneer=True,
            published=False,
        ),
        _Setting(name="10 discs, office", world=worlds.office, robots=10, steps=30),
    ]
    if not quick:
        found += [
            _Setting(name="100 discs, office", world=worlds.office, robots=100, steps=10),
            _Setting(name="1000 discs, office", world=worlds.office, robots=1000, steps=4),
        ]
    for robots in (10, 100) if quick else (10, 100, 1000, 10_000):
        side = 5.0 * math.ceil(math.sqrt(_AREA * robots) / 5.0)
        found.append(
            _Setting(
                name=f"{robots} discs, one in 10 m2",
                world=lambda side=side: worlds.office(side),  # type: ignore[misc]
                robots=robots,
                steps=30 if robots <= 100 else 10,
                peers=False,
            )
        )
    return found


def measure(
    rounds: int,
    quick: bool,
    peers: list[type[Peer]],
    plain_rates: tuple[float, ...],
    clock: Clock,
    say: Callable[[str], None],
    threads: int = 1,
) -> list[Row]:
    """The rows; `plain_rates` are the plain traversal's on the office, by which published figures are scaled.

    `threads` are amorsim's in fleets of a hundred robots and more.
    """
    rows: list[Row] = []
    costs: dict[int, tuple[float, ...]] = {}
    for setting in _settings(quick):
        say(f"fleet: {setting.name}")
        made = _contest(setting, rounds, peers if setting.peers else [], clock, threads)
        ours = made[0].rounds
        if not setting.peers:
            costs[setting.robots] = ours
            if setting.robots > 10:
                # Robots per step grow: cost per robot-step against ten robots, less is better.
                spread = ratio_of(ours, costs[10], less_is_better=True)
                times = f"{spread.median:.2f} ({spread.low:.2f} to {spread.high:.2f})"
                grown = f"a robot-step costs {times} x that of ten robots"
                made[0] = attrs.evolve(made[0], note=f"{made[0].note}; {grown}")
        elif "office" in setting.name and setting.published and plain_rates:
            made += _published(setting, ours, plain_rates)
        rows += made
    rows += [_threads(robots, rounds, say) for robots in ((100,) if quick else (100, 1000))]
    return rows


def _threads(robots: int, rounds: int, say: Callable[[str], None]) -> Row:
    """Two threads against one on the clock on the wall, for the processor's counts both."""
    setting = f"two threads against one, {robots} discs"
    say(f"fleet: {setting}")
    world = worlds.office()
    poses = worlds.places(world, robots, _CLEARANCE, _APART)
    fleet = [disc(f"r{n:05d}", pose) for n, pose in enumerate(poses)]
    sides = [Ours(world, fleet, threads) for threads in (1, 2)]
    steps = 10 if robots > 100 else 40
    ratios = []
    for _ in range(rounds):
        one, two = (drive(side, steps, _AT_LEAST, time.perf_counter) for side in sides)
        ratios.append((two.steps / two.seconds) / (one.steps / one.seconds))
    return Row(section=SECTION, setting=setting, side="amorsim", unit="x as fast", rounds=tuple(ratios))


def _contest(setting: _Setting, rounds: int, peers: list[type[Peer]], clock: Clock, threads: int = 1) -> list[Row]:
    threads = threads if setting.robots >= _MANY else 1
    world = setting.world()
    poses = worlds.places(world, setting.robots, _CLEARANCE, _APART)
    make = pioneer if setting.with_pioneer else disc
    ours = Ours(world, [make(f"r{n:05d}", pose) for n, pose in enumerate(poses)], threads)
    task, track = ours.task(setting.steps)
    timed = ours.repeated(setting.steps)
    fit = [
        peer
        for peer in peers
        if (peer.in_bitmaps or world.map.segments is not None)
        and (setting.robots == 1 or not peer.separate_worlds)
        and setting.robots <= peer.most_robots
    ]
    sides = [(peer, peer(task)) for peer in fit]
    rates: list[float] = []
    theirs: dict[str, list[float]] = {peer.name: [] for peer in fit}
    conducts: dict[str, Conduct] = {}
    for _ in range(rounds):
        made = drive(timed, setting.steps, _AT_LEAST, clock)
        rates.append(setting.robots * made.steps / made.seconds)
        for peer, side in sides:
            did, conducts[peer.name] = followed(side, setting.steps, _AT_MOST, clock)
            theirs[peer.name].append(setting.robots * did.steps / did.seconds)
    side = "amorsim" if threads == 1 else f"amorsim, {threads} threads"
    rows = [_row(setting, side, rates, track_conduct(track, setting.steps), PIONEER if setting.with_pioneer else DISCS)]
    for peer in fit:
        conduct = conducts[peer.name]
        assert conduct.steps is not None
        why_not = compare(track_conduct(track, conduct.steps, peer.lag), conduct)
        ratio = Ratio(spread=ratio_of(rates, theirs[peer.name]), counts=not why_not, why_not=why_not)
        row = _row(setting, f"{peer.name} {peer.version()}", theirs[peer.name], conduct, peer.computes)
        rows.append(attrs.evolve(row, ratio=ratio))
    return rows


def _row(setting: _Setting, side: str, rates: list[float], conduct: Conduct, note: str) -> Row:
    return Row(
        section=SECTION, setting=setting.name, side=side, unit=UNIT, rounds=tuple(rates), conduct=conduct, note=note
    )


def _published(setting: _Setting, ours: tuple[float, ...], plain_rates: tuple[float, ...]) -> list[Row]:
    rows = []
    for peer in published.FLEETS.get(setting.robots, ()):
        scaled: Any = published.here(peer.figure, plain_rates)
        rows.append(
            Row(
                section=SECTION,
                setting=setting.name,
                side=peer.name,
                unit=UNIT,
                rounds=scaled,
                ratio=Ratio(spread=ratio_of(ours, scaled), counts=False, why_not="published figure, scaled"),
                note=f"published {peer.figure:g}, scaled by the plain traversal; {peer.computes}",
            )
        )
    return rows
