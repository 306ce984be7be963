"""``amorsim compile``: compile the kernels ahead of the first run."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from amorsim.cli.console import compile_all, say
from amorsim.core.errors import AmorsimError

__all__ = ["command"]


def command(
    archive: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Take the compiled kernels from FILE if it is there and fits, and otherwise write them into it: for "
            "many machines of one kind. Take only files that you trust: what lies in them is run.",
        ),
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")] = False,
) -> None:
    """Compile ahead what usual runs, bundled scenarios, avoiders, generated worlds and planners need.

    It takes two to three minutes, once after installing or updating. What is compiled already is kept. A FILE fits
    machines with the same processor and the same versions of amorsim, numba and Python.
    """
    if archive is None:
        compile_all(quiet, more=True)
        return
    from amorsim.core.files.atomic_files import check_place
    from amorsim.kernels.archive import ArchiveError, misfit, pack_kernels, unpack_kernels
    from amorsim.kernels.cache_folder import cache_folder

    folder = cache_folder()
    if folder is None:
        raise AmorsimError("no folder can be written for compiled kernels; set NUMBA_CACHE_DIR to one that can")
    try:
        if archive.exists():
            why = misfit(folder, archive)
            if not why:
                unpack_kernels(folder, archive)
                _say(f"took the compiled kernels from {archive}", quiet)
                return
            _say(f"{archive} does not fit and is written anew: {why}", quiet)
        check_place(archive)
        compile_all(quiet, more=True)
        pack_kernels(folder, archive)
    except ArchiveError as error:
        raise AmorsimError(str(error)) from None
    _say(f"wrote the compiled kernels to {archive}", quiet)


def _say(text: str, quiet: bool) -> None:
    if not quiet:
        say(text)
