"""A simulation as a film, GIF or MP4: at regular steps a frame of the first replica's true world."""

from __future__ import annotations

from pathlib import Path

from amorsim.runs.video_writer import Reel, shown_bodies
from amorsim.simulation.simulation import Simulation

__all__ = ["Film"]


class Film:
    """Films the first replica of a simulation; `keep` is called after each step, `save` at the end.

    Parameters
    ----------
    simulation
        Filmed from its present step on.
    path
        Path of the file.
    duration
        Simulated time still to come [s].
    size, rate, speed, kind
        As of `Reel`, whose errors it raises.
    """

    def __init__(
        self,
        simulation: Simulation,
        path: Path,
        duration: float,
        *,
        size: int = 480,
        rate: float = 10.0,
        speed: float | None = None,
        kind: str = "gif",
    ) -> None:
        self.path = path
        self._simulation = simulation
        self._steps = 0
        scenario, world = simulation.scenario, simulation._fleet.world
        owners = (world.name(owner) for owner in world.owner[: world.count].tolist())
        bodies = list(zip(owners, world.shapes, strict=True))
        shown = shown_bodies(bodies[: world.named], bodies[world.named :], scenario.robots, scenario.obstacles)
        self.reel = Reel(
            simulation.map_of(simulation.replicas[0]),
            shown,
            scenario.floor.patches,
            path=path,
            dt=simulation.dt,
            duration=duration,
            size=size,
            rate=rate,
            speed=speed,
            kind=kind,
        )
        self._take()

    def _take(self) -> None:
        world = self._simulation._fleet.world
        self.reel.add(float(self._simulation.ticks[0]) * self._simulation.dt, world.poses[: world.count].copy())

    def keep(self) -> None:
        """Take the step that was just made, if it is one to show."""
        self._steps += 1
        if self._steps % self.reel.every == 0:
            self._take()

    def save(self) -> None:
        """Write the file."""
        self.reel.save()
