"""A simulation as a film, GIF or MP4: at regular steps a frame of the first replica's true world."""

from __future__ import annotations

from pathlib import Path

from amorsim.core.errors import RunError
from amorsim.core.parameters import ParameterError
from amorsim.render.animation import SMALLEST, Animation, Shown
from amorsim.render.video import check_video
from amorsim.scenario.colours import robot_colours
from amorsim.scenario.spec import Obstacle, Robot
from amorsim.simulation.simulation import Simulation

__all__ = ["Film", "check_film"]

LARGEST = 4096  # [px]: beyond it, frames fill the memory
LONGEST = 20.0  # [s] length of a film without a given speed
FASTEST = 25.0  # frames a second


def check_film(path: Path, size: int, rate: float, speed: float | None, kind: str = "gif") -> None:
    """Raise an error for settings that make no film, before anything is simulated; arguments and errors as `Film`'s."""
    if path.suffix.lower() != f".{kind}":
        raise ParameterError(kind, f"expected the name of a file that ends in .{kind}, got {str(path)!r}")
    if kind == "mp4":
        check_video()
    if path.is_dir():
        raise RunError(f"{path}: is a folder; name a file")
    if not path.parent.is_dir():
        raise RunError(f"{path}: there is no folder {path.parent}")
    if not SMALLEST <= size <= LARGEST:
        raise ParameterError("gif-size", f"expected at least {SMALLEST} pixels and at most {LARGEST}, got {size}")
    if not 0.0 < rate <= FASTEST:
        raise ParameterError("gif-rate", f"expected frames a second > 0 and <= {FASTEST:g}, got {rate!r}")
    if speed is not None and not 0.0 < speed < 1e6:
        raise ParameterError("gif-speed", f"expected a number > 0 and < 1e6, got {speed!r}")


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
    size
        Longer side of the picture [px].
    rate
        Frames a second, as shown; at most 25.
    speed
        Speed of the film relative to simulated time; by default 1, or faster so that the film takes 20 s.
    kind
        ``"gif"``, or ``"mp4"``, which needs imageio-ffmpeg.

    Raises
    ------
    ParameterError
        If a number is out of range, or the name does not end in ``.gif`` or ``.mp4``, as `kind` says.
    RunError
        If the file's folder is not there, it is a folder itself, or imageio-ffmpeg is missing.
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
        check_film(path, size, rate, speed, kind)
        self.path = path
        self._kind = kind
        self._simulation = simulation
        self._speed = max(1.0, duration / LONGEST) if speed is None else speed
        self._every = max(1, round(self._speed / rate / simulation.dt))
        self._steps = 0
        scenario, robots = simulation.scenario, set(simulation.names)
        bodies: dict[str, Robot | Obstacle] = {body.name: body for body in scenario.robots}
        bodies |= {body.name: body for body in scenario.obstacles}
        colours = {body.name: body.colour for body in scenario.obstacles} | robot_colours(scenario.robots)
        world = simulation._fleet.world
        shown = []
        for number, shape in enumerate(world.shapes):
            name, is_part = world.name(int(world.owner[number])), number >= world.named
            shown.append(Shown(outline=shape.outline, is_robot=name in robots, colour=colours[name], is_part=is_part))
        try:
            self._animation = Animation(
                simulation.map_of(simulation.replicas[0]), shown, patches=simulation.scenario.floor.patches, size=size
            )
        except ParameterError as error:
            raise ParameterError("gif-size", error.problem) from None
        self._take()

    def _take(self) -> None:
        world = self._simulation._fleet.world
        self._animation.add(float(self._simulation.ticks[0]) * self._simulation.dt, world.poses[: world.count])

    def keep(self) -> None:
        """Take the step that was just made, if it is one to show."""
        self._steps += 1
        if self._steps % self._every == 0:
            self._take()

    def save(self) -> None:
        """Write the file."""
        if self._kind == "mp4":
            self._animation.save_video(self.path, self._speed / (self._every * self._simulation.dt))
        else:
            self._animation.save(self.path, self._speed)
