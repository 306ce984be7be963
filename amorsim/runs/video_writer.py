"""A film in the making, GIF or MP4: its number of frames, the robots that it shows, and writing it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

from amorsim.array_types import Array
from amorsim.core.errors import RunError
from amorsim.core.files.reading import is_folder
from amorsim.core.maps.map import Map
from amorsim.core.parameters import ParameterError
from amorsim.core.patches import Patch
from amorsim.core.shapes import Shape
from amorsim.render.animation import SMALLEST, Animation, Shown
from amorsim.render.video import check_video
from amorsim.scenario.colours import robot_colours
from amorsim.scenario.spec import Obstacle, Robot

__all__ = ["Reel", "check_film", "shown_bodies"]

LARGEST = 4096  # [px]: beyond it, frames fill the memory
LONGEST = 20.0  # [s] length of a film without a given speed
FASTEST = 25.0  # frames a second


def check_film(path: Path, size: int, rate: float, speed: float | None, kind: str = "gif") -> None:
    """Raise an error for settings that make no film, before anything is simulated; arguments and errors as `Reel`'s."""
    if path.suffix.lower() != f".{kind}":
        raise ParameterError(kind, f"expected the name of a file that ends in .{kind}, got {str(path)!r}")
    if kind == "mp4":
        check_video()
    if is_folder(path):
        raise RunError(f"{path}: is a folder; name a file")
    if not is_folder(path.parent):
        raise RunError(f"{path}: there is no folder {path.parent}")
    if not SMALLEST <= size <= LARGEST:
        raise ParameterError("gif-size", f"expected at least {SMALLEST} pixels and at most {LARGEST}, got {size}")
    if not 0.0 < rate <= FASTEST:
        raise ParameterError("gif-rate", f"expected frames a second > 0 and <= {FASTEST:g}, got {rate!r}")
    if speed is not None and not 0.0 < speed < 1e6:
        raise ParameterError("gif-speed", f"expected a number > 0 and < 1e6, got {speed!r}")


def shown_bodies(
    bodies: Iterable[tuple[str, Shape]],
    parts: Iterable[tuple[str, Shape]],
    robots: Sequence[Robot],
    obstacles: Sequence[Obstacle],
) -> list[Shown]:
    """How robots and obstacles, by name, are drawn, and after them the parts of robots, by the robot's name."""
    colours = {body.name: body.colour for body in obstacles} | robot_colours(robots)
    names = {robot.name for robot in robots}
    return [
        Shown(outline=shape.outline, is_robot=name in names, colour=colours[name], is_part=is_part)
        for is_part, these in ((False, bodies), (True, parts))
        for name, shape in these
    ]


class Reel:
    """The frames of a film of a run; `save` writes them.

    Parameters
    ----------
    map
        The world.
    bodies
        What moves, in the order of poses.
    patches
        Of the floor.
    path
        Path of the file.
    dt
        Time step of the run [s].
    duration
        Simulated time that is filmed [s].
    size
        Longer side of the picture [px].
    rate
        Frames a second, as shown; at most 25.
    speed
        Speed of the film relative to simulated time; by default 1, or faster so that the film takes 20 s.
    kind
        ``"gif"``, or ``"mp4"``, which needs imageio-ffmpeg.

    Attributes
    ----------
    every
        How many steps there are from one frame to the next.

    Raises
    ------
    ParameterError
        If a number is out of range, or the name does not end in ``.gif`` or ``.mp4``, as `kind` requires.
    RunError
        If the file's folder is not there, it is a folder itself, or imageio-ffmpeg is missing.
    """

    def __init__(
        self,
        map: Map,  # noqa: A002 - the field's word
        bodies: Sequence[Shown],
        patches: Sequence[Patch],
        *,
        path: Path,
        dt: float,
        duration: float,
        size: int,
        rate: float,
        speed: float | None,
        kind: str,
    ) -> None:
        check_film(path, size, rate, speed, kind)
        self.path = path
        self._kind = kind
        self._speed = max(1.0, duration / LONGEST) if speed is None else speed
        self.every = max(1, round(self._speed / rate / dt))
        self._rate = self._speed / (self.every * dt)
        try:
            self.animation = Animation(map, bodies, patches=patches, size=size)
        except ParameterError as error:
            raise ParameterError("gif-size", error.problem) from None

    def add(self, time: float, poses: Array) -> None:
        """Take a frame: where the bodies are `(B, 3)` at a time [s]."""
        self.animation.add(time, poses)

    def save(self) -> None:
        """Write the file."""
        if self._kind == "mp4":
            self.animation.save_video(self.path, self._rate)
        else:
            self.animation.save(self.path, self._speed)
