"""What a submission is graded by: scenario, held-out seeds and worlds, limits, and criteria with points."""

from __future__ import annotations

import os
from pathlib import Path

import attrs

from amorsim.core.errors import ScenarioError, StudyError
from amorsim.core.numbers import is_number
from amorsim.plugins.manager import default_registry
from amorsim.scenario.contents import book_of
from amorsim.scenario.faults import Node, shown
from amorsim.scenario.models import check_format, read_file
from amorsim.scenario.toml_values import as_toml
from amorsim.sweeps.plan import Measured
from amorsim.sweeps.read import read_metric

__all__ = ["Case", "Criterion", "Rubric", "read_rubric"]

_FAR = 1e15  # larger numbers are taken for mistakes
_KEYS = (
    *(
        "format",
        "title",
        "scenario",
        "robot",
        "role",
        "function",
        "seeds",
        "worlds",
        "duration",
        "time_limit",
        "memory_limit",
    ),
    "criteria",
)


@attrs.frozen(kw_only=True)
class Criterion:
    """A metric and its points: none at the value `none`, all at `full`, in proportion between."""

    measured: Measured
    points: float
    none: float
    full: float

    def share(self, value: float) -> float:
        """The share of the points that a value earns; none for nan."""
        if value != value:
            return 0.0
        return min(1.0, max(0.0, (value - self.none) / (self.full - self.none)))


@attrs.frozen(kw_only=True)
class Case:
    """One run of a submission: a seed, and a world or the scenario's own."""

    seed: int
    world: str = ""

    def __str__(self) -> str:
        return f"seed {self.seed}" + (f", {Path(self.world).name}" if self.world else "")

    @property
    def settings(self) -> tuple[str, ...]:
        """The settings that it means."""
        return (f"world.map={as_toml(self.world)}",) if self.world else ()


@attrs.frozen(kw_only=True)
class Rubric:
    """A rubric, as its file says it."""

    title: str
    scenario: str
    robot: str
    role: str
    function: str
    cases: tuple[Case, ...]
    duration: float | None
    time_limit: float
    memory_limit: int
    criteria: tuple[Criterion, ...]

    @property
    def points(self) -> float:
        """All that can be earned."""
        return sum(criterion.points for criterion in self.criteria)


def read_rubric(path: str | os.PathLike[str]) -> Rubric:
    """The rubric in a file.

    Raises
    ------
    StudyError
        With all that is wrong with it.
    """
    path = Path(path)
    written = read_file(path)
    if isinstance(written, str):
        raise StudyError(f"{path}: {written}")
    book = book_of(written, path)
    top = Node(written.values, (), book)
    rubric = _read(top, path)
    try:
        book.raise_if_any()
    except ScenarioError as error:
        raise StudyError(str(error)) from None
    assert rubric is not None
    return rubric


def _read(top: Node, path: Path) -> Rubric | None:
    registry = default_registry()
    check_format(top.child("format"))
    top.refuse_unknown(_KEYS)
    scenario = top.child("scenario").text("the name of a scenario, or the path of its file") or ""
    if scenario not in registry.names("scenario") or (path.parent / scenario).is_file():
        scenario = str(path.parent.absolute() / scenario)
    role = top.child("role").text("'controller' or 'estimator'", "controller") or ""
    if role not in ("controller", "estimator"):
        top.child("role").fault(f"expected 'controller' or 'estimator', got {role!r}")
    own = "drive" if role == "controller" else "Estimator"
    function = top.child("function").text("the name of the function or class that submissions have", own) or ""
    seeds, worlds = top.child("seeds"), top.child("worlds")
    for node, kind in ((seeds, int), (worlds, str)):
        what = "seeds, as in [11, 12]" if kind is int else "map files, as in ['a.wld']"
        if node.value is not None and (
            not isinstance(node.value, list) or not node.value or any(type(item) is not kind for item in node.value)
        ):
            node.fault(f"expected a list of {what}, got {shown(node.value)}")
    numbers = {}
    for key, default in (("time_limit", 60.0), ("memory_limit", 4e9), ("duration", None)):
        node = top.child(key)
        if node.value is not None and (not is_number(node.value, below=_FAR) or node.value <= 0):
            node.fault(f"expected a number > 0, got {shown(node.value)}")
        numbers[key] = default if node.value is None else node.value
    criteria = _criteria(top.child("criteria"))
    if top.book.count:
        return None
    maps = [str(path.parent.absolute() / name) for name in worlds.value or ()] or [""]
    return Rubric(
        title=top.value.get("title", path.stem),
        scenario=scenario,
        robot=top.value.get("robot", ""),
        role=role,
        function=function,
        cases=tuple(Case(seed=seed, world=world) for world in maps for seed in seeds.value or (1,)),
        duration=numbers["duration"],
        time_limit=float(numbers["time_limit"] or 0.0),
        memory_limit=int(numbers["memory_limit"] or 0),
        criteria=tuple(criteria),
    )


def _criteria(node: Node) -> list[Criterion]:
    if not node.expect_table("a table of criteria, as in arrived = { use = 'success', points = 5 }"):
        return []
    found = []
    for name, child in node.children():
        measured = read_metric(name, child, default_registry(), beside=("points", "none", "full"))
        if measured is None:
            continue
        values = []
        for key, default in (("points", 1.0), ("none", 0.0), ("full", 1.0)):
            value = child.value.get(key, default)
            if not is_number(value, below=_FAR):
                child.child(key).fault(f"expected a number, got {shown(value)}")
                value = default
            values.append(float(value))
        if values[0] < 0.0:
            child.child("points").fault(
                f"expected 0 or more, got {values[0]:g}: a run that fails would have more; give the points for what is "
                "good; none and full say which values are good"
            )
        if values[1] == values[2]:
            child.child("full").fault("expected another value than for none, for the points lie between them")
            continue
        found.append(Criterion(measured=measured, points=values[0], none=values[1], full=values[2]))
    if not node.value:
        node.fault("expected one criterion at least, got none")
    return found
