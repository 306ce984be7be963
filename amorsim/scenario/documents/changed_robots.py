"""Robots that were changed after a document was read, written into the document: what differs, and nothing else."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import attrs

from amorsim.core.errors import DocumentError
from amorsim.plugins.registry import Registry
from amorsim.scenario.documents.document import Document
from amorsim.scenario.documents.neutral import is_error, without_neutral
from amorsim.scenario.files.resolved import robot_table
from amorsim.scenario.spec import Deviation, Robot
from amorsim.scenario.toml.layout import MISSING, Path_, found_at
from amorsim.scenario.toml.literals import are_same

__all__ = ["robot_of", "set_robots"]

_NO_ERROR = attrs.asdict(Deviation(), filter=lambda _, value: value is not None)


def robot_of(robot: Robot, registry: Registry) -> dict[str, Any]:
    """The table of a robot, as in a resolved scenario, without errors that change nothing."""
    table = robot_table(robot, registry)
    return {**table, "errors": without_neutral(table.get("errors"))}


def set_robots(document: Document, before: Sequence[Robot], after: Sequence[Robot], registry: Registry) -> None:
    """Write into a document how its robots were changed.

    Names, starts and what robots know are left alone.

    Parameters
    ----------
    document
        A scenario's.
    before, after
        The robots that it means, in its order, and as they are now.

    Raises
    ------
    DocumentError
        If the document cannot express it: robots of one table with ``count`` differ now, or it does not allow so
        many robots.
    ScenarioError
        If a file cannot name something in a robot.
    """
    first = 0
    there = document.values.get("robots")
    for number, robot in enumerate(there if isinstance(there, list) else ()):
        path = f"robots.{number}"
        count = robot.get("count", 1) if isinstance(robot, dict) else 0
        if not isinstance(count, int) or count < 1:
            raise DocumentError("expected the table of a robot", path)
        tables = [
            (robot_of(one, registry), robot_of(other, registry))
            for one, other in zip(before[first : first + count], after[first : first + count], strict=True)
        ]
        if len(tables) != count:
            raise DocumentError(f"expected {count} robots, got {len(tables)}", path)
        first += count
        if not all(are_same(table, tables[0][1]) for _, table in tables):
            raise DocumentError("robots of one table differ from each other, which it cannot say", path)
        for at, value in _differences(*tables[0], ()):
            _set(document, ("robots", number, *at), found_at(tables[0][0], at), value)
    if first != len(before):
        raise DocumentError(f"expected {len(before)} robots, got {first}", "robots")


def _set(document: Document, at: Path_, before: Any, after: Any) -> None:
    path = _dotted(at)
    if after is MISSING:
        document.remove(path)
    elif not _is_chain(at, after):
        document.set(path, after)
    elif _is_said(document, at, before):
        _set_chain(document, path, before, after)
    else:
        document.set(path, after)
        for index in range(len(after)):
            _leave_out_defaults(document, f"{path}.{index}")


def _is_chain(at: Path_, value: Any) -> bool:
    return at[-1:] in (("ground",), ("noise",)) and isinstance(value, list)


def _is_said(document: Document, at: Path_, chain: Any) -> bool:
    """Whether the file itself has a chain with as many elements as this one."""
    there = found_at(document.values, at)
    return isinstance(there, list) and isinstance(chain, list) and len(there) == len(chain)


def _set_chain(document: Document, path: str, before: list[dict[str, Any]], after: list[dict[str, Any]]) -> None:
    """Change a chain of the file, element by element: an element that stays keeps its place and its comments."""
    kept = {element["name"] for element in after}
    there = {element["name"]: element for element in before}
    names = list(there)
    for index in reversed(range(len(names))):
        if names[index] not in kept:
            document.remove(f"{path}.{index}")
            del names[index]
    for index, element in enumerate(after):
        name, place = element["name"], f"{path}.{index}"
        if name not in names:
            names.insert(index, name)
            document.add(path, element, index)
            _leave_out_defaults(document, place)
            continue
        if names[index] != name:
            document.move(f"{path}.{names.index(name)}", index)
            names.remove(name)
            names.insert(index, name)
        if element["use"] != there[name]["use"] or element.keys() != there[name].keys():
            document.set(place, element)
            _leave_out_defaults(document, place)
            continue
        for key, value in element.items():
            if not are_same(value, there[name][key]):
                document.set(f"{place}.{key}", value)


def _leave_out_defaults(document: Document, path: str) -> None:
    """Remove from a new element what its defaults have as well."""
    element = document.get(path)
    for key, value in element.items():
        if key == "use":
            continue
        under = document.inherited(f"{path}.{key}").under
        default = element["use"] if key == "name" else None if under is None else under.value
        if are_same(value, default):
            document.remove(f"{path}.{key}")


def _dotted(at: Path_) -> str:
    return ".".join(map(str, at))


def _differences(before: Any, after: Any, path: Path_) -> Iterator[tuple[Path_, Any]]:
    """The paths at which two tables differ, with the second one's values; `MISSING` where it has none."""
    if are_same(before, after):
        return
    if _is_chain(path, after):
        yield path, after
    elif path[1:] and path[0] == "errors" and after is MISSING and is_error(before):
        yield path, {"scale": 1.0}  # which `Document.set` leaves out where no model sets another
    elif path[1:] and path[0] == "errors" and after is not MISSING and is_error(after):
        yield path, {key: value for key, value in after.items() if not are_same(value, _NO_ERROR.get(key))}
    elif path[:1] == ("errors",) and isinstance(before, dict) and after is MISSING:
        for key, item in before.items():
            yield from _differences(item, MISSING, (*path, key))
    elif isinstance(before, dict) and isinstance(after, dict):
        for key in dict.fromkeys((*before, *after)):
            yield from _differences(before.get(key, MISSING), after.get(key, MISSING), (*path, key))
    elif isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
        for index, item in enumerate(after):
            yield from _differences(before[index], item, (*path, index))
    elif path[:1] == ("errors",) and isinstance(after, dict):
        for key, item in after.items():
            yield from _differences(MISSING, item, (*path, key))
    else:
        yield path, after
