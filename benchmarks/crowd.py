"""Crowds: a thousand pedestrians by the social force, in simulated seconds a second, beside JuPedSim.

The two models are not the same: amorsim has that of 1995, whose forces reach 7 m, and which is stable at any step;
JuPedSim that of 2000, cut off at 2.5 m, with stiff contacts. So each makes the steps that it is meant for (0.1 s;
0.01 s, JuPedSim's default), and JuPedSim those of 0.05 s as well, about the longest at which its people stay in the
hall. At times one of them does not, which ends JuPedSim's simulation; the ratio then does not count.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Protocol

import numpy as np
import numpy.typing as npt

import amorsim as am
from benchmarks.contest import Clock
from benchmarks.peers.jupedsim import COMPUTES, JuPedSim
from benchmarks.results import Ratio, Row, ratio_of
from benchmarks.task import DT

__all__ = ["measure"]

Array = npt.NDArray[np.float64]

SECTION = "crowd"
UNIT = "simulated s/s"
OURS = (
    "moves circles by the social force model of D. Helbing and P. Molnar (1995), with ellipses over relative steps "
    "of 1 s, as the bundled scenario `crowd` has them; steps of 0.1 s, rigid contact with walls and one another; "
    "goals changed when they are reached; a robot with encoders stands among them"
)
SPEED = 1.34  # m/s
RADIUS = 0.22  # m
_STEPS = (0.01, 0.05)  # s, of JuPedSim; the first is its default
_WALK = 5.0  # s simulated before anything is timed, and then to see how fast people are
_ALIKE = 0.25
"""How far mean speeds of people may differ, so that both crowds walk and neither is jammed."""


class Crowd(Protocol):
    """A crowd that walks."""

    dt: float

    def step(self) -> None:
        """Make one step of `dt`."""

    def places(self) -> Array:
        """Where all are `(N, 2)` [m]."""


class Ours:
    """The same crowd in amorsim."""

    dt = DT

    def __init__(self, side: float, starts: Array, goals: Array) -> None:
        people = [
            am.Obstacle(
                name=f"p{n:05d}",
                shape=am.Shape.circle(RADIUS),
                pose=am.Pose(x=x, y=y),
                motion=am.motions.Pedestrian(
                    goals=tuple(map(tuple, between)),
                    tolerance=1.0,
                    relative=True,
                    step_time=1.0,
                    speed=SPEED,
                    speed_std=0.0,
                    velocity_noise=0.0,
                ),
            )
            for n, ((x, y), between) in enumerate(zip(starts.tolist(), goals.tolist(), strict=True))
        ]
        robot = am.Robot(
            name="robot",
            shape=am.Shape.circle(0.1),
            drive=am.drives.Differential(wheel_radius_left=0.1, wheel_radius_right=0.1, track=0.15, rate_max=10.0),
            sensors={"encoder": am.sensors.Encoder(counts_per_revolution=1000.0)},
            pose=am.Pose(x=0.2, y=0.2),
            on_collision="continue",
        )
        walls = [(0.0, 0.0, side, 0.0), (side, 0.0, side, side), (side, side, 0.0, side), (0.0, side, 0.0, 0.0)]
        hall = am.Map.from_segments(walls, resolution=0.05, extent=(0.0, 0.0, side, side))
        self._simulation = am.Simulation(am.Scenario(map=hall, robots=[robot], obstacles=people, dt=DT, seed=1))

    def step(self) -> None:
        """One step."""
        self._simulation.step()

    def places(self) -> Array:
        """Where the pedestrians are."""
        return np.concatenate([frame.true_pose[:, :2] for frame in self._simulation.obstacle_frames()])


def measure(rounds: int, quick: bool, clock: Clock, say: Callable[[str], None]) -> list[Row]:
    """The rows, of a thousand people with 4 m2 for each, and with 1 m2."""
    count, at_least = (100, 0.1) if quick else (1000, 1.0)
    return [row for area in (4.0, 1.0) for row in _contest(count, area, rounds, at_least, clock, say)]


def _contest(
    count: int, area: float, rounds: int, at_least: float, clock: Clock, say: Callable[[str], None]
) -> list[Row]:
    setting = f"{count} pedestrians, one in {area:g} m2"
    say(f"crowd: {setting}")
    side, starts, goals = _people(count, area)
    sides: dict[str, Crowd] = {"amorsim": Ours(side, starts, goals)}
    try:
        for dt in _STEPS:
            name = f"JuPedSim {JuPedSim.version()}, steps of {dt:g} s"
            sides[name] = JuPedSim(side, starts, goals, SPEED, RADIUS, dt)
    except ImportError as error:
        say(f"crowd: JuPedSim is not installed ({error})")
    speeds: dict[str, float] = {}
    found: dict[str, list[float]] = {name: [] for name in sides}
    stopped: dict[str, str] = {}
    for turn in range(rounds + 1):
        for name, crowd in sides.items():
            if name in stopped:
                continue
            try:
                if turn == 0:
                    speeds[name] = _walked(crowd)
                else:
                    found[name].append(_rate(crowd, at_least, clock))
            except RuntimeError as error:  # so JuPedSim says that its forces threw someone out of the hall
                if name == "amorsim":
                    raise
                stopped[name] = str(error)
                say(f"crowd: {name}, stopped after {len(found[name])} rounds: {error}")
    rows = []
    for name, rates in found.items():
        if not rates:
            continue
        note = f"{OURS if name == 'amorsim' else COMPUTES}; people went {speeds[name]:.2f} m/s"
        ratio = None
        if name != "amorsim":
            alike = abs(speeds[name] - speeds["amorsim"]) <= _ALIKE * speeds["amorsim"]
            why_not = f"it stopped: {stopped[name]}" if name in stopped else "" if alike else "people are not as fast"
            of_ours = ratio_of(found["amorsim"][: len(rates)], rates)
            ratio = Ratio(spread=of_ours, counts=not why_not, why_not=why_not)
        rows.append(
            Row(section=SECTION, setting=setting, side=name, unit=UNIT, rounds=tuple(rates), ratio=ratio, note=note)
        )
    return rows


def _people(count: int, area: float) -> tuple[float, Array, Array]:
    """The side of the hall [m], the starts `(N, 2)`, about on a grid, and two goals for each `(N, 2, 2)`."""
    side = math.sqrt(count * area)
    draw = np.random.default_rng(20261124)
    across = math.ceil(math.sqrt(count))
    cells = np.column_stack(np.divmod(np.arange(count), across)) + 0.5
    starts = (cells + draw.uniform(-0.1, 0.1, (count, 2))) * (side / across)
    return side, starts, draw.uniform(2.0, side - 2.0, (count, 2, 2))


def _walked(crowd: Crowd) -> float:
    """The mean speed of all [m/s] by where they are after a second each, once they are on their way."""
    for _ in range(round(_WALK / crowd.dt)):
        crowd.step()
    speeds = []
    for _ in range(round(_WALK)):
        before = crowd.places()
        for _ in range(round(1.0 / crowd.dt)):
            crowd.step()
        speeds.append(np.hypot(*(crowd.places() - before).T).mean())
    return float(np.mean(speeds))


def _rate(crowd: Crowd, at_least: float, clock: Clock) -> float:
    """Simulated seconds a second, over `at_least` seconds; all sides by this loop."""
    made, seconds = 0, 0.0
    chunk = max(1, round(0.1 / crowd.dt))
    while seconds < at_least:
        started = clock()
        for _ in range(chunk):
            crowd.step()
        seconds += clock() - started
        made += chunk
    return made * crowd.dt / seconds
