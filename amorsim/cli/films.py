"""The options of moving pictures, of commands that make some."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

import attrs
import typer

__all__ = ["Force", "Gif", "GifRate", "GifSize", "GifSpeed", "Mp4", "Wanted", "in_options"]

Gif = Annotated[
    Path | None, typer.Option(metavar="FILE", help="Make a moving picture of the first replica: a .gif file.")
]
Mp4 = Annotated[
    Path | None, typer.Option(metavar="FILE", help="The same as a video: a .mp4 file. Needs the extra video.")
]
GifSize = Annotated[int, typer.Option(metavar="PIXELS", help="Longer side of the moving picture.")]
GifRate = Annotated[float, typer.Option(metavar="N", help="Its frames a second, at most 25.")]
GifSpeed = Annotated[
    float | None,
    typer.Option(
        metavar="X",
        help="How much faster than the simulated time it is shown. [default: 1, or so fast that it takes 20 s]",
    ),
]

Force = Annotated[bool, typer.Option("--force", help="Replace moving pictures that are there.")]


@attrs.frozen(kw_only=True)
class Wanted:
    """The films that a user wants: their files and settings; none without a file."""

    SIZE, RATE = 480, 10.0

    gif: Path | None
    mp4: Path | None
    size: int
    rate: float
    speed: float | None
    force: bool

    @property
    def files(self) -> dict[str, Path]:
        """The files by their kind."""
        return {kind: file for kind, file in (("gif", self.gif), ("mp4", self.mp4)) if file is not None}

    def settings(self, kind: str) -> dict[str, Any]:
        """The settings of a film of that kind, by the names of the arguments."""
        return {"size": self.size, "rate": self.rate, "speed": self.speed, "kind": kind}

    def check(self) -> None:
        """Raise an error for options that make no film, before anything is done."""
        from amorsim.core.errors import AmorsimError

        if not self.files:
            if (self.size, self.rate, self.speed) != (self.SIZE, self.RATE, None):
                raise AmorsimError(
                    "--gif-size, --gif-rate and --gif-speed say how a moving picture is; --gif FILE or --mp4 FILE "
                    "makes one"
                )
            return
        from amorsim.core.files.atomic_files import check_place
        from amorsim.core.files.reading import is_file
        from amorsim.runs.video_writer import check_film

        for kind, file in self.files.items():
            with in_options():
                check_film(file, **self.settings(kind))
            if is_file(file) and not self.force:
                raise AmorsimError(f"{file} is there already; --force replaces it")
            check_place(file)


@contextlib.contextmanager
def in_options() -> Iterator[None]:
    """Turn errors of a film into messages that name the options."""
    from amorsim.core.errors import AmorsimError
    from amorsim.core.parameters import ParameterError

    try:
        yield
    except ParameterError as error:
        raise AmorsimError(f"--{error.name}: {error.problem}") from None
