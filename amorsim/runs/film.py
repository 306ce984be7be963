"""A simulation as a film, GIF or MP4: at regular steps a frame of the first replica's true world."""

from __future__ import annotations

from pathlib import Path

from amorsim.array_types import Array
from amorsim.render.animation import Shown
from amorsim.runs.video_writer import Reel, shown_bodies
from amorsim.simulation.simulation import Simulation

__all__ = ["Film", "bodies_in", "poses_in"]


def bodies_in(simulation: Simulation) -> list[Shown]:
    """The moving bodies of each replica: robots, obstacles, and the robots' parts."""
    scenario, world = simulation.scenario, simulation._fleet.world
    owners = (world.name(owner) for owner in world.owner[: world.count].tolist())
    bodies = list(zip(owners, world.shapes, strict=True))
    return shown_bodies(bodies[: world.named], bodies[world.named :], scenario.robots, scenario.obstacles)


def poses_in(simulation: Simulation, index: int) -> Array:
    """Where they truly are `(B, 3)` in the replica of this index among those that are simulated."""
    world = simulation._fleet.world
    return world.poses[index * world.count : (index + 1) * world.count].copy()


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
        self.reel = Reel(
            simulation.map_of(simulation.replicas[0]),
            bodies_in(simulation),
            simulation.scenario.floor.patches,
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
        self.reel.add(float(self._simulation.ticks[0]) * self._simulation.dt, poses_in(self._simulation, 0))

    def keep(self) -> None:
        """Take the step that was just made, if it is one to show."""
        self._steps += 1
        if self._steps % self.reel.every == 0:
            self._take()

    def save(self) -> None:
        """Write the file."""
        self.reel.save()
