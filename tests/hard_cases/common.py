"""What the hard cases share: a world, commands as a function of time, and the checks that all of them go through."""

from __future__ import annotations

from collections.abc import Mapping

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import (
    Clock,
    Controller,
    Draws,
    Estimate,
    Measurement,
    RobotModel,
    State,
    parameter,
)
from amorsim.core.maps.map import Map
from amorsim.noise.diffusion import Diffusion
from amorsim.scenario.spec import NoiseElement, Scenario
from amorsim.simulation.simulation import Simulation

Array = npt.NDArray[np.float64]

SLIP = (NoiseElement(name="slip", noise=Diffusion(variance_per_length=1e-5)),)
"""Process noise that makes replicas differ."""


def room(width: float = 12.0, height: float = 12.0, resolution: float = 0.01) -> Map:
    """An empty room whose walls' inner faces lie within a cell of its rectangle."""
    corners = [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)]
    walls = [(*a, *b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]
    return Map.from_segments(np.array(walls), resolution=resolution)


@attrs.frozen(kw_only=True)
class Hold(Controller):
    """The same command for ever."""

    channels: tuple[float, ...] = parameter(help="the command, channel by channel")

    def command(
        self,
        robot: RobotModel,
        readings: Mapping[str, Measurement],
        estimate: Estimate,
        clock: Clock,
        state: State,
        draws: Draws,
    ) -> Array:
        return np.array(self.channels)


@attrs.frozen(kw_only=True)
class Weave(Controller):
    """A command whose channels swing about a middle, each with a phase of its own."""

    middle: tuple[float, ...] = parameter(help="middle of each channel")
    swing: tuple[float, ...] = parameter(help="how far each channel swings")
    period: float = parameter(4.0, unit="s", gt=0, help="of a swing")

    def command(
        self,
        robot: RobotModel,
        readings: Mapping[str, Measurement],
        estimate: Estimate,
        clock: Clock,
        state: State,
        draws: Draws,
    ) -> Array:
        middle, swing = np.array(self.middle), np.array(self.swing)
        phase = 2.0 * np.pi * clock.time / self.period + np.arange(middle.shape[1])
        return middle + swing * np.sin(phase)


def check_bits(scenario: Scenario, steps: int = 24) -> None:
    """Snapshot and restore in the middle change no bit, and replica 3 of 5 is replica 3 alone.

    `scenario` is to have draws in it, so that replicas differ and the comparison says something.
    """
    five = Simulation(scenario, replicas=5)
    before = five.true_pose.copy()
    advance(five, steps // 2)
    middle = five.snapshot()
    advance(five, steps - steps // 2)
    end, events = five.digest(), list(five.events)
    poses, stood = five.true_pose.copy(), bodies(five)
    assert not np.array_equal(poses, before)

    five.restore(middle)
    assert five.tick == steps // 2
    advance(five, steps - steps // 2)
    assert five.digest() == end
    assert np.array_equal(five.true_pose, poses)
    assert np.array_equal(bodies(five), stood)
    assert five.events == events

    alone = Simulation(scenario, replicas=[3])
    advance(alone, steps)
    assert alone.digest(3) == five.digest(3)
    count = len(stood) // 5
    assert np.array_equal(bodies(alone), stood[3 * count : 4 * count])  # obstacles too
    assert alone.digest(3) != five.digest(2)


def bodies(simulation: Simulation) -> Array:
    """Where all bodies stand `(B, 3)`: by replica, and in it robots by name, then obstacles by name."""
    return simulation._fleet.world.poses.copy()


def advance(simulation: Simulation, steps: int) -> list[Array]:
    """Step so many times; the true poses `(robots, 3)` of the first replica after each step."""
    path = []
    for _ in range(steps):
        simulation.step()
        path.append(simulation.true_pose[: len(simulation.names)].copy())
    return path
