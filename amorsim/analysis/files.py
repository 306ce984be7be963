"""A run's text files as arrays."""

from __future__ import annotations

import csv
import functools
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from amorsim.core.errors import RunError, did_you_mean
from amorsim.runs.about import read_about
from amorsim.scenario.read import load
from amorsim.scenario.spec import Scenario

__all__ = ["RunFiles", "Table"]

Table = Mapping[str, npt.NDArray[Any]]


class RunFiles:
    """What lies in the folder of a run: `about` is its ``run.json``, `table` reads one of its files.

    A run that was killed can be read too, up to its last whole lines.

    Raises
    ------
    RunError
        If the folder is none of a run.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = Path(folder)
        self.about: dict[str, Any] = read_about(self.folder)
        self.replicas: list[int] = self.about["replicas"]

    @functools.cached_property
    def scenario(self) -> Scenario:
        """The scenario that was run."""
        return load(self.folder / "scenario.toml")

    @property
    def sensors(self) -> list[str]:
        """The names of the sensors that were written."""
        return sorted(path.stem for path in (self.folder / "sensors").glob("*.csv"))

    @property
    def robots(self) -> list[str]:
        """The robots' names, in the order of their rows."""
        return sorted(robot.name for robot in self.scenario.robots)

    def table(self, name: str, *, robot: str | None = None, replica: int | None = None) -> Table:
        """The columns of ``<name>.csv``, of all rows or of one robot's, in one replica if there are several.

        Parameters
        ----------
        name
            Such as ``"poses"`` or ``"sensors/laser"``.
        replica
            Its number; without it, the first.

        Raises
        ------
        RunError
            If the file cannot be read, or there is no such robot or replica.
        """
        if robot is not None and robot not in self.robots:
            known = ", ".join(self.robots)
            raise RunError(
                f"{self.folder}: there is no robot {robot!r}, but: {known}.{did_you_mean(robot, self.robots)}"
            )
        if replica is not None and replica not in self.replicas:
            known = ", ".join(map(str, self.replicas[:20])) + (" ..." if len(self.replicas) > 20 else "")
            raise RunError(f"{self.folder}: there is no replica {replica}, but: {known}")
        header, rows = self._rows(self.folder / f"{name}.csv")
        if robot is not None:
            column = header.index("robot")
            rows = [row for row in rows if row[column] == robot]
        if "replica" in header:
            column = header.index("replica")
            wanted = str(self.replicas[0] if replica is None else replica)
            rows = [row for row in rows if row[column] == wanted]
        columns = list(zip(*rows, strict=True)) if rows else [()] * len(header)
        return {key: _column(cells) for key, cells in zip(header, columns, strict=True)}

    def _rows(self, path: Path) -> tuple[list[str], list[list[str]]]:
        try:
            text = path.read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise RunError(f"{path}: cannot be read ({error})") from None
        lines = text.split("\n")
        # What follows the last line end is not a whole line: the run was killed while it was written.
        if '"' in text:
            header, *rows = csv.reader(lines[:-1])
        else:
            header, *rows = (line.split(",") for line in lines[:-1] or [""])
        for number, row in enumerate(rows, start=2):
            if len(row) != len(header):
                raise RunError(f"{path}, line {number}: is damaged: expected {len(header)} cells, got {len(row)}")
        return header, rows


def _column(cells: tuple[str, ...]) -> npt.NDArray[Any]:
    try:
        return np.array([float(cell) if cell else np.nan for cell in cells])
    except ValueError:
        return np.array(cells, dtype=object)
