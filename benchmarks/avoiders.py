"""Avoiders: a thousand robots that keep apart by ORCA beside navground's, and what a decision of MPPI costs a robot."""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Callable
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt

import amorsim as am
from benchmarks.contest import Clock
from benchmarks.results import Ratio, Row, ratio_of

__all__ = ["measure"]

Array = npt.NDArray[np.float64]
Side = tuple[Callable[[], Any], Callable[[], Array]]  # what makes a step, and where the robots are

SECTION = "avoiders"
ROBOTS = 1000
RADIUS, AXIS, WHEEL = 0.15, 0.25, 0.05  # m
SPEED = 0.5  # m/s
SPACE = 4.0  # m2 for each
REACH, NEIGHBOURS = 5.0, 10  # m, robots that one takes into account
DT = 0.1
_STEPS = 20


def measure(rounds: int, quick: bool, clock: Clock, say: Callable[[str], None]) -> list[Row]:
    """The rows: robot-steps a second of a crowd of robots by ORCA, side by side in each round, and MPPI's time."""
    count = 100 if quick else ROBOTS
    setting = f"{count} robots by ORCA, {NEIGHBOURS} neighbours within {REACH:g} m, one in {SPACE:g} m2"
    starts, goals = _places(count)
    sides = {"amorsim": _ours(starts, goals)}
    if importlib.util.find_spec("navground") is not None:
        sides["navground"] = _theirs(starts, goals)
    rates: dict[str, list[float]] = {name: [] for name in sides}
    ways: dict[str, float] = {}
    for step, _ in sides.values():
        for _ in range(_STEPS):  # whatever is not compiled yet is now, and all are under way
            step()
    for number in range(rounds):
        say(f"{SECTION}: {setting}, round {number + 1}")
        for name, (step, places) in sides.items():
            before, started = places(), clock()
            for _ in range(_STEPS):
                step()
            rates[name].append(count * _STEPS / (clock() - started))
            ways[name] = float(np.hypot(*(places() - before).T).mean())
    crowd = [
        Row(
            section=SECTION,
            setting=setting,
            side=name,
            unit="robot-steps/s",
            rounds=tuple(values),
            ratio=None if name == "amorsim" else Ratio(spread=ratio_of(rates["amorsim"], values), counts=True),
            note=f"{ways[name] / (_STEPS * DT):.2f} m/s in the mean of the last round",  # neither stands
        )
        for name, values in rates.items()
    ]
    return [*crowd, _mppi(rounds, quick, clock, say)]


# -------------------------------------------------------------------------------------------------------------- ORCA


def _places(count: int) -> tuple[Array, Array]:
    """Where robots start and what they drive to `(N, 2)`: anywhere on a square, none on top of another at the start."""
    random = np.random.default_rng(7)
    side = int(np.ceil(np.sqrt(count)))
    step = np.sqrt(SPACE)
    cells = np.stack(np.divmod(np.arange(count), side), axis=1) + 0.5
    starts = (cells + random.uniform(-0.25, 0.25, cells.shape)) * step
    return starts, random.uniform(0.0, side * step, cells.shape)


def _ours(starts: Array, goals: Array) -> Side:
    robots = [
        am.Robot(
            name=f"r{number:04d}",
            shape=am.Shape.circle(RADIUS),
            on_collision="continue",
            pose=am.Pose(x=float(start[0]), y=float(start[1])),
            controller=am.controllers.Orca(
                goals=(tuple(goal.tolist()), tuple(start.tolist())), loop=True, tolerance=0.5, speed=SPEED
            ),
            drive=am.drives.Differential(
                wheel_radius_left=WHEEL, wheel_radius_right=WHEEL, track=AXIS, rate_max=2.0 * SPEED / WHEEL
            ),
            sensors={
                "encoder": am.MountedSensor(sensor=am.sensors.Encoder(counts_per_revolution=4000.0)),
                "neighbours": am.MountedSensor(sensor=am.sensors.Neighbours(slots=NEIGHBOURS, range_max=REACH)),
            },
            estimators={"dead_reckoning": am.estimators.DeadReckoning()},
        )
        for number, (start, goal) in enumerate(zip(starts, goals, strict=True))
    ]
    low, high = starts.min(axis=0) - SPACE, starts.max(axis=0) + SPACE
    ground = am.Map.from_segments([], resolution=0.1, extent=(*low.tolist(), *high.tolist()))
    simulation = am.Simulation(am.Scenario(map=ground, robots=robots, dt=DT, seed=11))
    return simulation.step, lambda: simulation.true_pose[:, :2].copy()


def _theirs(starts: Array, goals: Array) -> Side:
    core: Any = importlib.import_module("navground.core")
    sim: Any = importlib.import_module("navground.sim")
    world = sim.World()
    agents = []
    for start, goal in zip(starts.tolist(), goals.tolist(), strict=True):
        kinematics = core.kinematics.TwoWheelsDifferentialDriveKinematics(max_speed=2.0 * SPEED, wheel_axis=AXIS)
        behaviour = core.Behavior.make_type("ORCA")
        behaviour.kinematics, behaviour.radius, behaviour.optimal_speed = kinematics, RADIUS, SPEED
        behaviour.max_number_of_neighbors, behaviour.horizon = NEIGHBOURS, REACH
        agent = sim.Agent(
            radius=RADIUS,
            behavior=behaviour,
            kinematics=kinematics,
            task=sim.tasks.WaypointsTask(waypoints=[tuple(goal), tuple(start)], loop=True, tolerance=0.5),
            state_estimations=[sim.state_estimations.BoundedStateEstimation(range=REACH)],
            control_period=0.0,
        )
        agent.pose = core.Pose2(tuple(start), 0.0)
        world.add_agent(agent)
        agents.append(agent)
    return (lambda: world.update(DT)), lambda: np.array([tuple(agent.pose.position) for agent in agents])


# -------------------------------------------------------------------------------------------------------------- MPPI


def _mppi(rounds: int, quick: bool, clock: Clock, say: Callable[[str], None]) -> Row:
    """What a step of a robot takes that decides by MPPI, its sensors and all else included."""
    runs, steps = 1000, 56
    robot = am.load_robot("pioneer2dx")
    controller = am.controllers.Mppi(goals=((9.0, 5.0), (1.0, 5.0)), loop=True, samples=runs, time_steps=steps)
    room = am.Map.from_segments([(0, 0, 10, 0), (10, 0, 10, 10), (10, 10, 0, 10), (0, 10, 0, 0), (5, 4, 5, 6)])
    placed = attrs.evolve(robot, controller=controller, pose=am.Pose(x=1.0, y=5.0))
    simulation = am.Simulation(am.Scenario(map=room, robots=[placed], dt=DT, seed=11))
    times = []
    simulation.step()
    for number in range(rounds):
        say(f"{SECTION}: mppi, round {number + 1}")
        made, started = 0, clock()
        while clock() - started < (0.05 if quick else 0.5):
            simulation.step()
            made += 1
        times.append((clock() - started) / made * 1e3)
    setting = f"a step of a Pioneer by MPPI, {runs} runs of {steps} steps"
    return Row(section=SECTION, setting=setting, side="amorsim", unit="ms", rounds=tuple(times))
