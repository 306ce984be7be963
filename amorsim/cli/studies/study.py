"""Shared by commands that make experiments: the scenario, the folder and the plots."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from amorsim.cli.console import compile_once, complain
from amorsim.core.errors import RunError
from amorsim.core.files.reading import is_folder

if TYPE_CHECKING:
    from amorsim.scenario.spec import Scenario

__all__ = ["check_out", "claim_folder", "draw", "read_study", "table"]


def read_study(name: str, changes: Sequence[str] | None, seed: int | None) -> Scenario:
    """The scenario that a user named, with another seed if one is given."""
    from amorsim.runs.scenario_argument import look_up, read_scenario, with_options

    compile_once(lambda: look_up(name, changes=changes or (), seed=seed))
    return with_options(read_scenario(name, changes=changes or []), seed)


def check_out(out: Path | None) -> None:
    """Raise an error if `claim_folder` could not make the folder, or nothing could be written there; makes nothing.

    Parameters
    ----------
    out
        The folder that the user names; None for a new one under ``amorsim-runs``.

    Raises
    ------
    RunError
        If the folder is not empty, or cannot be made or written.
    """
    from amorsim.runs.folder import RUNS, check_free

    check_free(out)
    place = Path.cwd() / RUNS if out is None else out
    nearest = next(folder for folder in (place, *place.parents) if os.path.lexists(folder))
    if out is None and nearest == place and not is_folder(place):
        raise RunError(f"{place}: is in the way of the folder for runs; name one with --out")
    if not is_folder(nearest):
        raise RunError(f"{place}: cannot make this folder ({nearest} is not a folder)")
    if not os.access(nearest, os.W_OK | os.X_OK):
        raise RunError(f"{place}: cannot make this folder or write into it (no permission to write in {nearest})")


def claim_folder(out: Path | None, scenario: Scenario, what: str) -> Path:
    """The folder of that name, made now; without a name ``amorsim-runs/<scenario>-<what>-<number>``.

    Raises
    ------
    RunError
        If it cannot be made.
    """
    from amorsim.runs.folder import new_folder

    if out is None:
        stem = scenario.source.stem if scenario.source is not None else "map"
        return new_folder(f"{stem}-{what}")
    _make(out)
    return out


def _make(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RunError(f"{folder}: cannot make this folder ({error.strerror or error})") from None


def draw(path: Path, plot: Callable[[Any], None]) -> bool:
    """Draw a plot by `plot`, which is given the module of plots; false if matplotlib is missing."""
    try:
        from amorsim.analysis.plots import study_plots
    except ModuleNotFoundError as error:
        if error.name is None or error.name.partition(".")[0] != "matplotlib":
            raise
        complain(f'{path.name} is left out: plots need matplotlib: python -m pip install "amorsim[plot]"')
        return False
    plot(study_plots)
    return True


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Lines of a table: the first column to the left, all others to the right."""
    lines = [list(head), *(list(row) for row in rows)]
    widths = [max(len(line[i]) for line in lines) for i in range(len(head))]
    return "\n".join(
        "  ".join(
            cell.ljust(w) if i == 0 else cell.rjust(w) for i, (cell, w) in enumerate(zip(line, widths, strict=True))
        )
        for line in lines
    ).replace(" \n", "\n")
