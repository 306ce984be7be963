"""Rubrics for grading: scenario, runs, held-out worlds, limits, and criteria with points."""

from __future__ import annotations

import os
from pathlib import Path

import attrs

from amorsim.core.errors import StudyError
from amorsim.core.numbers import is_number
from amorsim.grading.questions import Question, read_questions
from amorsim.grading.seeds import MOST_SEED, Seed
from amorsim.grading.toml_tables import read_tables
from amorsim.plugins.manager import default_registry
from amorsim.scenario.reading.faults import Node, shown
from amorsim.sweeps.plan import Measured
from amorsim.sweeps.read import read_metric

__all__ = ["Criterion", "Rubric", "read_rubric"]

_FAR = 1e15  # larger numbers are taken for mistakes
_MOST_RUNS = 10_000
_LISTS = (
    ("worlds", "map files, as in ['a.wld']"),
    ("files", "files, as in ['helper.py']"),
    ("beside", "names of files, as in ['policy.onnx']"),
)
_KEYS = (
    *("format", "title", "scenario", "robot", "role", "function", "files", "beside"),
    *("runs", "practice", "seeds", "worlds", "duration", "time_limit", "memory_limit", "criteria", "questions"),
)


@attrs.frozen(kw_only=True)
class Criterion:
    """A metric and its points: none at the value `none`, all at `full`, in proportion between.

    Of two values each, the first are for what is too small, and the second for what is too large. It earns nothing in a
    run in which the criterion `given` earns nothing: an estimate far from the truth is no better for being cautious.
    """

    measured: Measured
    points: float
    none: tuple[float, ...]
    full: tuple[float, ...]
    given: str = ""

    @property
    def name(self) -> str:
        """Its name in the rubric."""
        return self.measured.name

    @property
    def unit(self) -> str:
        """The unit of its values."""
        return self.measured.metric.unit

    @property
    def in_words(self) -> tuple[str, str]:
        """The values that earn no points, and those that earn all."""
        none, full = ([f"{value:g}" for value in values] for values in (self.none, self.full))
        return " and ".join(none) + (f", or without {self.given}" if self.given else ""), " to ".join(full)

    def share(self, value: float) -> float:
        """The share of the points that a value earns; 0 for nan."""
        if value != value:
            return 0.0
        shares = [(value - none) / (full - none) for none, full in zip(self.none, self.full, strict=True)]
        return min(1.0, max(0.0, min(shares)))


@attrs.frozen(kw_only=True)
class Rubric:
    """A rubric, as in its file.

    `seeds` is empty unless it is for practice: then `runs` seeds are drawn for each grading. `worlds` are maps that
    replace the scenario's own; the empty name means that one. `files` are given to every submission; files of the names
    in `beside` go with a submission where they lie next to its program.
    """

    title: str
    scenario: str
    robot: str
    role: str
    function: str
    files: tuple[Path, ...]
    beside: tuple[str, ...]
    runs: int
    practice: bool
    seeds: tuple[Seed, ...]
    worlds: tuple[str, ...]
    duration: float | None
    time_limit: float
    memory_limit: int
    criteria: tuple[Criterion, ...]
    questions: tuple[Question, ...] = ()

    @property
    def parts(self) -> tuple[Criterion | Question, ...]:
        """All that earns points."""
        return (*self.criteria, *self.questions)

    @property
    def points(self) -> float:
        """All that can be earned."""
        return sum(part.points for part in self.parts)


def read_rubric(path: str | os.PathLike[str]) -> Rubric:
    """The rubric in a file.

    Raises
    ------
    StudyError
        With all that is wrong with it.
    """
    rubric = read_tables(path, _KEYS, _read)
    assert rubric is not None
    return rubric


def _read(top: Node, path: Path) -> Rubric | None:
    registry = default_registry()
    scenario = top.child("scenario").text("the name of a scenario, or the path of its file") or ""
    if scenario not in registry.names("scenario") or (path.parent / scenario).is_file():
        scenario = str(path.parent.absolute() / scenario)
    role = top.child("role").text("'controller' or 'estimator'", "controller") or ""
    if role not in ("controller", "estimator"):
        top.child("role").fault(f"expected 'controller' or 'estimator', got {role!r}")
    own = "drive" if role == "controller" else "Estimator"
    function = top.child("function").text("the name of the function or class that submissions have", own) or ""
    title = top.child("title").text("a title", path.stem) or ""
    robot = "" if "robot" not in top else top.child("robot").text("the name of a robot") or ""
    worlds, files, beside = (_names(top.child(key), what) for key, what in _LISTS)
    for name in beside:
        if name != Path(name).name:
            top.child("beside").fault(f"expected names of files without a folder, got {shown(name)}")
    practice = top.child("practice")
    if practice.value is not None and type(practice.value) is not bool:
        practice.fault(f"expected true or false, got {shown(practice.value)}")
    runs, seeds = _runs(top, practice.value is True)
    numbers = {}
    for key, default in (("time_limit", 60.0), ("memory_limit", 4e9), ("duration", None)):
        node = top.child(key)
        if node.value is not None and (not is_number(node.value, below=_FAR) or node.value <= 0):
            node.fault(f"expected a number > 0, got {shown(node.value)}")
        numbers[key] = default if node.value is None else node.value
    criteria = _criteria(top.child("criteria"))
    questions = _questions(top.child("questions"), path.parent)
    if top.book.count:
        return None
    return Rubric(
        title=title,
        scenario=scenario,
        robot=robot,
        role=role,
        function=function,
        files=tuple(path.parent.absolute() / name for name in files),
        beside=tuple(beside),
        runs=runs,
        practice=practice.value is True,
        seeds=seeds,
        worlds=tuple(str(path.parent.absolute() / name) for name in worlds) or ("",),
        duration=numbers["duration"],
        time_limit=float(numbers["time_limit"] or 0.0),
        memory_limit=int(numbers["memory_limit"] or 0),
        criteria=tuple(criteria),
        questions=questions,
    )


def _names(node: Node, what: str) -> list[str]:
    """The names of files in a list; the list may be missing."""
    value = node.value
    if value is None:
        return []
    if isinstance(value, list) and value and all(isinstance(each, str) and each for each in value):
        return value
    node.fault(f"expected a list of {what}, got {shown(value)}")
    return []


def _runs(top: Node, is_practice: bool) -> tuple[int, tuple[Seed, ...]]:
    """The number of runs in each world, and their seeds if they are given."""
    runs, seeds = top.child("runs"), top.child("seeds")
    if is_practice:
        if runs.value is not None:
            runs.fault("for practice, give seeds in its place, as in seeds = [1, 2]")
        value = [1] if seeds.value is None else seeds.value
        if isinstance(value, list) and value and all(type(each) is int and 0 <= each <= MOST_SEED for each in value):
            return len(value), tuple(map(Seed, value))
        seeds.fault(f"expected a list of seeds, as in [11, 12], got {shown(value)}")
        return 1, ()
    if seeds.value is not None:
        seeds.fault(
            "a submission can find a seed by trying, and with it the truth: write runs = 2, and seeds are drawn; or "
            "practice = true, if no marks depend on it"
        )
    count = 1 if runs.value is None else runs.value
    if type(count) is not int or not 0 < count <= _MOST_RUNS:
        runs.fault(f"expected a whole number of runs from 1 to {_MOST_RUNS}, got {shown(count)}")
        count = 1
    return count, ()


def _criteria(node: Node) -> list[Criterion]:
    if not node.expect_table("a table of criteria, as in arrived = { use = 'success', points = 5 }"):
        return []
    found: list[Criterion] = []
    for name, child in node.children():
        measured = read_metric(name, child, default_registry(), beside=("points", "none", "full", "given"))
        if measured is None:
            continue
        points = child.value.get("points", 1.0)
        if not is_number(points, below=_FAR):
            child.child("points").fault(f"expected a number, got {shown(points)}")
            points = 1.0
        if points < 0.0:
            child.child("points").fault(
                f"expected 0 or more, got {points:g}: a run that fails would have more; give the points for what is "
                "good; none and full say which values are good"
            )
        none, full = (_bounds(child, key, default) for key, default in (("none", 0.0), ("full", 1.0)))
        if not _fit(none, full):
            child.child("full").fault(
                "expected another value than for none, for the points lie between them"
                if len(none) == len(full) == 1
                else "expected two values as for none, and between them, as in none = [0, 10], full = [1, 5]"
            )
            continue
        given = child.value.get("given", "")
        above = [each.name for each in found]
        if "given" in child and given not in above:
            child.child("given").fault(f"expected the name of a criterion above it, got {shown(given)}")
            given = ""
        found.append(Criterion(measured=measured, points=float(points), none=none, full=full, given=given))
    if not node.value:
        node.fault("expected one criterion at least, got none")
    return found


def _questions(node: Node, folder: Path) -> tuple[Question, ...]:
    """The questions in the named file; empty without one."""
    if node.value is None:
        return ()
    name = node.text("the name of a file of questions, as in 'answers.toml'")
    if not name:
        return ()
    try:
        return read_questions(folder / name)
    except StudyError as error:
        node.fault(str(error))
        return ()


def _bounds(child: Node, key: str, default: float) -> tuple[float, ...]:
    """The value of `none` or `full`, or a pair of them."""
    value = child.value.get(key, default)
    values = value if isinstance(value, list) and len(value) == 2 else [value]
    for each in values:
        if not is_number(each, below=_FAR):
            child.child(key).fault(f"expected a number, or two in a list, got {shown(value)}")
            return (default,)
    return tuple(map(float, values))


def _fit(none: tuple[float, ...], full: tuple[float, ...]) -> bool:
    """Whether values that earn nothing and values that earn all are apart."""
    if len(none) != len(full):
        return False
    return none != full if len(none) == 1 else none[0] < full[0] <= full[1] < none[1]
