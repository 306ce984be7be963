"""Robot-steps a second by number of robots: with peers in one world, and alone at constant density."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

import attrs

from benchmarks import worlds
from benchmarks.contest import Clock, drive, track_conduct
from benchmarks.ours import DISCS, PIONEER, Ours, disc, pioneer
from benchmarks.peers.base import Contender, Peer
from benchmarks.results import Conduct, Row, ratio_of
from benchmarks.worlds import World

__all__ = ["measure"]

SECTION = "fleet"
UNIT = "robot-steps/s"
_AREA = 10.0  # m2 for each robot, where density is constant
_CLEARANCE = 0.45  # m about a start: a disc, and what `wander` keeps free
_MANY = 100  # robots, from which on threads share them
_APART = 0.85  # m from start to start
_AT_LEAST = 0.3  # s timed of amorsim in a round
_AT_MOST = 1.5  # s, after which a peer that is watched makes no new step; it is timed over as many


@attrs.frozen(kw_only=True)
class _Setting:
    name: str
    world: Callable[[], World]
    robots: int
    steps: int
    replicas: int = 1  # of the robots, each in a world of its own
    with_pioneer: bool = False
    peers: bool = True

    @property
    def rows(self) -> int:
        return self.robots * self.replicas


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
        ),
        _Setting(name="one Pioneer, open field", world=worlds.open_field, robots=1, steps=60, with_pioneer=True),
        _Setting(name="10 discs, office", world=worlds.office, robots=10, steps=30),
        _Setting(name="10 discs, furnished office", world=worlds.furnished_office, robots=10, steps=10),
        _Setting(name="100 replicas of a disc, line room", world=worlds.line_room, robots=1, steps=20, replicas=100),
    ]
    if not quick:
        found += [
            _Setting(name="100 discs, office", world=worlds.office, robots=100, steps=10),
            _Setting(name="1000 discs, office", world=worlds.office, robots=1000, steps=4),
            _Setting(name="100 discs, open field", world=lambda: worlds.open_field(50.0), robots=100, steps=10),
            _Setting(
                name="1000 replicas of a disc, line room", world=worlds.line_room, robots=1, steps=10, replicas=1000
            ),
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
    clock: Clock,
    say: Callable[[str], None],
    threads: int = 1,
) -> list[Row]:
    """The rows; `threads` are amorsim's in fleets of a hundred robots and more."""
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
    threads = threads if setting.rows >= _MANY else 1
    world = setting.world()
    poses = worlds.places(world, setting.robots, _CLEARANCE, _APART)
    make = pioneer if setting.with_pioneer else disc
    robots = [make(f"r{n:05d}", pose) for n, pose in enumerate(poses)]
    ours = Ours(world, robots, threads, setting.replicas)
    task, track = ours.task(setting.steps)
    timed = ours.repeated(setting.steps)
    sides = [
        Contender.of(peer(task), track, setting.steps, _AT_MOST)
        for peer in peers
        if (peer.in_bitmaps or world.map.segments is not None)
        and (setting.robots == 1 or not peer.separate_worlds)
        and (setting.replicas == 1 or peer.separate_worlds)
        and setting.rows <= peer.most_robots
    ]
    rates: list[float] = []
    theirs: list[list[float]] = [[] for _ in sides]
    for _ in range(rounds):
        made = drive(timed, setting.steps, _AT_LEAST, clock)
        rates.append(setting.rows * made.steps / made.seconds)
        for side, found in zip(sides, theirs, strict=True):
            found.append(setting.rows / side.seconds_a_step(_AT_LEAST, clock))
    name = "amorsim" if threads == 1 else f"amorsim, {threads} threads"
    rows = [_row(setting, name, rates, track_conduct(track, setting.steps), PIONEER if setting.with_pioneer else DISCS)]
    for side, found in zip(sides, theirs, strict=True):
        row = _row(setting, side.name, found, side.seen.conduct, side.peer.computes)
        rows.append(attrs.evolve(row, ratio=side.ratio(ratio_of(rates, found))))
    return rows


def _row(setting: _Setting, side: str, rates: list[float], conduct: Conduct, note: str) -> Row:
    return Row(
        section=SECTION, setting=setting.name, side=side, unit=UNIT, rounds=tuple(rates), conduct=conduct, note=note
    )
