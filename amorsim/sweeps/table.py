"""The table of a study: a line for each point, seed and replica; written in parts, read as arrays."""

from __future__ import annotations

import csv
import math
import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from amorsim.array_types import AnyArray, Array
from amorsim.core.arguments import checked, path_of
from amorsim.core.display import in_notebook
from amorsim.core.errors import StudyError
from amorsim.core.execution.memory import too_large
from amorsim.core.files.atomic_files import replacing
from amorsim.core.files.reading import check_readable, is_file
from amorsim.sweeps.chunk import Outcome
from amorsim.sweeps.folder import read_study_about
from amorsim.sweeps.plan import Plan

__all__ = ["Study", "counted", "read_study", "write_tables"]

PARQUET, CSV = "table.parquet", "table.csv"
_MOST_BYTES = 1 << 32  # of a table
_BYTES_A_ROW = 100  # of memory, at least
_ROWS = 50_000  # of a part that is written at once
_WHOLE = ("point", "seed", "replica")
_TEXT = ("digest", "error")


class Study(dict[str, AnyArray]):
    """The table of a study, as a dict of arrays `(rows,)`, a row for each point, seed and replica.

    Its columns are ``point``, the axes, ``seed``, ``replica``, the metrics, ``digest`` and ``error``. Where a point
    failed, metrics are nan, and `error` is the reason.

    Attributes
    ----------
    folder
        Where it lies.
    about
        The content of its ``study.json``: versions, metrics with their units, and so on.
    """

    @checked
    def __init__(self, folder: Path, about: dict[str, Any], columns: dict[str, AnyArray]) -> None:
        super().__init__(columns)
        self.folder = folder
        self.about = about

    _repr_mimebundle_ = in_notebook

    def __repr__(self) -> str:
        rows = len(self["point"])
        return f"<study {self.about.get('name', '')!r}: {rows} rows of {', '.join(self)}; {self.about['status']}>"

    @property
    def axes(self) -> list[str]:
        """The names of the axes."""
        return list(self.about["axes"])

    @property
    def metrics(self) -> list[str]:
        """The names of the metrics."""
        return list(self.about["metrics"])

    @property
    def is_complete(self) -> bool:
        """Whether all points are done, those that failed among them."""
        return bool(self.about["status"] == "finished")

    @property
    def failures(self) -> list[tuple[int, str]]:
        """The points that failed, with their errors."""
        there = np.flatnonzero(self["error"] != "")
        return list(dict.fromkeys((int(self["point"][row]), str(self["error"][row])) for row in there.tolist()))

    def to_pandas(self) -> Any:
        """The table as a pandas frame; raises `StudyError` without pandas."""
        return _module("pandas").DataFrame(dict(self))

    def to_polars(self) -> Any:
        """The table as a polars frame; raises `StudyError` without polars."""
        return _module("polars").DataFrame(
            {name: values.tolist() if values.dtype == object else values for name, values in self.items()}
        )


def _module(name: str) -> Any:
    import importlib

    try:
        return importlib.import_module(name)
    except ModuleNotFoundError:
        raise StudyError(
            f"this needs {name}: python -m pip install {name}; the study itself is a dict of arrays"
        ) from None


def read_study(folder: str | os.PathLike[str]) -> Study:
    """The table of a study in a folder that `sweep` made, as arrays by column.

    Of a study that has not ended, or was killed, the table has what was done when it last stopped.

    Raises
    ------
    StudyError
        If the folder is none of a study, is of another version, or its table cannot be read.
    """
    folder = path_of(folder, "folder", "the folder of a study")
    about = read_study_about(folder)
    path = next((folder / name for name in (PARQUET, CSV) if is_file(folder / name)), None)
    if path is None:
        raise StudyError(
            f"{folder}: this study has no table yet; it is being computed, or was killed: give its command again"
        )
    kinds = _kinds(about["axes"], about["metrics"])
    most = about["chunks"] * about["replicas"]
    columns = _read_parquet(path, most) if path.name == PARQUET else _read_csv(path, kinds, most)
    if set(columns) != set(kinds):
        raise StudyError(f"{path}: is damaged: expected the columns {', '.join(kinds)}, got {', '.join(columns)}")
    try:
        arrays = {name: _as_array(columns[name], kind) for name, kind in kinds.items()}
    except (TypeError, ValueError, OverflowError) as error:
        raise StudyError(f"{path}: is damaged ({error})") from None
    return Study(folder, about, arrays)


def counted(mean: str, values: Array) -> str:
    """A mean as text, with the number of values `(n,)` that it is of, if some are nan: ``9.433 (7 of 20)``."""
    count = int(np.count_nonzero(~np.isnan(values)))
    return mean if count == len(values) else f"{mean} ({count} of {len(values)})"


def _as_array(values: Sequence[Any], kind: str) -> AnyArray:
    if kind == "text":
        if not all(isinstance(value, str) for value in values):
            raise ValueError("expected texts")
        found = np.empty(len(values), dtype=object)
        found[:] = list(values)
        return found
    dtype = {"whole": np.int64, "flag": np.bool_}.get(kind, np.float64)
    return np.array([math.nan if value is None else value for value in values], dtype=dtype)


def _kinds(axes: dict[str, list[Any]], metrics: Iterable[str]) -> dict[str, str]:
    """The type of each column: whole numbers, numbers, flags or texts."""
    found = {"point": "whole"}
    for name, labels in axes.items():
        kinds = {type(label) for label in labels}
        found[name] = (
            "flag" if kinds == {bool} else "whole" if kinds == {int} else "number" if kinds <= {int, float} else "text"
        )
        if found[name] == "whole" and any(abs(label) >= 2**63 for label in labels):
            found[name] = "text"
    return (
        found
        | dict.fromkeys(("seed", "replica"), "whole")
        | dict.fromkeys(metrics, "number")
        | dict.fromkeys(_TEXT, "text")
    )


# ------------------------------------------------------------------------------------------------------------- writing


def write_tables(folder: Path, plan: Plan, own_seed: int, outcomes: Iterable[Outcome]) -> Path:
    """Write the table of the chunks' outcomes, in order; as Parquet if pyarrow is installed, else as CSV.

    Parameters
    ----------
    own_seed
        The scenario's, where the study names none.

    Raises
    ------
    StudyError
        If it cannot be written; the old one stays then.
    """
    kinds = _kinds({axis.name: list(axis.labels) for axis in plan.axes}, [each.name for each in plan.metrics])
    parts = _parts(plan, own_seed, outcomes, kinds)
    try:
        import pyarrow
    except ModuleNotFoundError:
        pyarrow = None
    path = folder / (CSV if pyarrow is None else PARQUET)
    with replacing(path, StudyError, within=folder) as new:
        if pyarrow is None:
            _write_csv(new, kinds, parts)
        else:
            _write_parquet(new, kinds, parts)
    (folder / (PARQUET if pyarrow is None else CSV)).unlink(missing_ok=True)
    return path


def _parts(plan: Plan, own_seed: int, outcomes: Iterable[Outcome], kinds: dict[str, str]) -> Iterator[dict[str, Any]]:
    """The table, some rows at a time, as lists by column."""
    part: dict[str, list[Any]] = {name: [] for name in kinds}
    for outcome in outcomes:
        chunk = plan.chunk(outcome.index)
        count = plan.replicas
        part["point"] += [chunk.point] * count
        for axis, label in zip(plan.axes, chunk.labels, strict=True):
            kind = kinds[axis.name]
            value = str(label) if kind == "text" else float(label) if kind == "number" else label
            part[axis.name] += [value] * count
        own = own_seed if outcome.seed < 0 else outcome.seed  # an axis may have set it
        part["seed"] += [own if chunk.seed < 0 else chunk.seed] * count
        part["replica"] += range(count)
        for each in plan.metrics:
            part[each.name] += outcome.values.get(each.name, [math.nan] * count)
        part["digest"] += outcome.digests or [""] * count
        part["error"] += [outcome.error] * count
        if len(part["point"]) >= _ROWS:
            yield part
            part = {name: [] for name in kinds}
    yield part


def _write_csv(path: Path, kinds: dict[str, str], parts: Iterable[dict[str, Any]]) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(kinds)
        for part in parts:
            writer.writerows(zip(*([_cell(value) for value in part[name]] for name in kinds), strict=True))


def _cell(value: Any) -> str:
    return (
        ("true" if value else "false") if isinstance(value, bool) else value if isinstance(value, str) else repr(value)
    )


def _write_parquet(path: Path, kinds: dict[str, str], parts: Iterable[dict[str, Any]]) -> None:
    import pyarrow
    from pyarrow import parquet

    types = {
        "whole": pyarrow.int64(),
        "number": pyarrow.float64(),
        "flag": pyarrow.bool_(),
        "text": pyarrow.string(),
    }
    # Seeds may need all 64 bits without a sign.
    schema = pyarrow.schema([(name, types[kind]) for name, kind in kinds.items()])
    with parquet.ParquetWriter(path, schema) as writer:
        for part in parts:
            writer.write_table(pyarrow.table(part, schema=schema))


def _read_parquet(path: Path, most: int) -> dict[str, Any]:
    try:
        from pyarrow import lib, parquet
    except ModuleNotFoundError:
        raise StudyError(f'{path}: needs pyarrow: python -m pip install "amorsim[sweep]"') from None
    try:
        check_readable(path, _MOST_BYTES)
        with parquet.ParquetFile(path) as file:
            _check_rows(path, file.metadata.num_rows, most)
            table = file.read()
        return {name: table.column(name).to_pylist() for name in table.column_names}
    except (OSError, ValueError, OverflowError, KeyError, lib.ArrowException) as error:
        raise StudyError(f"{path}: cannot be read ({error})") from None


def _check_rows(path: Path, rows: int, most: int) -> None:
    if rows > most or too_large(rows, _BYTES_A_ROW):
        raise StudyError(f"{path}: is damaged: it has {rows} rows; expected at most {most}, as many as the study has")


def _read_csv(path: Path, kinds: dict[str, str], most: int) -> dict[str, Any]:
    try:
        check_readable(path, _MOST_BYTES)
        with path.open(encoding="utf-8", newline="") as file:
            header, *rows = csv.reader(file)
        columns = list(zip(*rows, strict=True)) if rows else [()] * len(header)
    except (OSError, ValueError, csv.Error) as error:
        raise StudyError(f"{path}: cannot be read ({error})") from None
    _check_rows(path, len(rows), most)
    found: dict[str, Any] = {}
    for name, cells in zip(header, columns, strict=False):
        kind = kinds.get(name, "text")
        try:
            found[name] = [_value(cell, kind) for cell in cells]
        except ValueError as error:
            raise StudyError(f"{path}, column {name!r}: is damaged ({error})") from None
    return found


def _value(cell: str, kind: str) -> Any:
    if kind == "flag":
        return cell == "true"
    return int(cell) if kind == "whole" else float(cell) if kind == "number" else cell
