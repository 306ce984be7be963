"""A run's text files as arrays."""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from amorsim.core.errors import RunError, did_you_mean

__all__ = ["RunFiles", "Table"]

Table = Mapping[str, npt.NDArray[Any]]


class RunFiles:
    """What lies in the folder of a run: `about` is its ``run.json``, `table` reads one of its files.

    A run that was killed can be read too, up to its last whole lines.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = Path(folder)
        try:
            self.about: dict[str, Any] = json.loads((self.folder / "run.json").read_text(encoding="utf-8"))
        except (OSError, ValueError):
            raise RunError(f"{folder}: expected the folder of a run, with a run.json in it") from None
        self.replicas: list[int] = self.about["replicas"]

    @property
    def sensors(self) -> list[str]:
        """The names of the sensors that were written."""
        return sorted(path.stem for path in (self.folder / "sensors").glob("*.csv"))

    @property
    def robots(self) -> list[str]:
        """The robots' names, in the order of their rows."""
        names = self.table("poses")["robot"]
        return list(dict.fromkeys(names.tolist()))

    def table(self, name: str, *, robot: str | None = None, replica: int | None = None) -> Table:
        """The columns of ``<name>.csv``, of all rows or of one robot's, in one replica if there are several."""
        path = self.folder / f"{name}.csv"
        try:
            with path.open(encoding="utf-8", newline="") as file:
                reader = csv.reader(file)
                header = next(reader, [])
                rows = [row for row in reader if len(row) == len(header)]
        except OSError as error:
            raise RunError(f"{path}: cannot be read ({error.strerror or error})") from None
        columns = {key: _column([row[i] for row in rows]) for i, key in enumerate(header)}
        chosen = np.ones(len(rows), dtype=bool)
        if robot is not None:
            known = set(columns["robot"].tolist())
            if rows and robot not in known:
                raise RunError(f"{path}: there is no robot {robot!r}.{did_you_mean(robot, known)}")
            chosen &= columns["robot"] == robot
        if "replica" in columns:
            wanted = self.replicas[0] if replica is None else replica
            chosen &= columns["replica"] == wanted
        return {key: column[chosen] for key, column in columns.items()}


def _column(cells: list[str]) -> npt.NDArray[Any]:
    try:
        return np.array([float(cell) if cell else np.nan for cell in cells])
    except ValueError:
        return np.array(cells, dtype=object)
