"""The changes that a window may make: each is a table, and several make one step."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from amorsim.core.errors import AmorsimError, DocumentError
from amorsim.core.numbers import is_number
from amorsim.scenario.documents.elsewhere import renamed
from amorsim.scenario.reading.fields import NONE
from amorsim.scenario.toml.layout import MISSING, found_at
from amorsim.scenario.toml.literals import parse
from amorsim.ui.editor.inspectors.knowing import know_landmarks, know_map
from amorsim.ui.editor.inspectors.sections import SHAPES
from amorsim.ui.editor.storage.bitmaps import cropped, filled, painted
from amorsim.ui.editor.storage.line_ends import with_line_ends
from amorsim.ui.editor.work import Work
from amorsim.ui.serve.wire import shown

__all__ = ["apply", "own_table"]

MOST_CHANGES = 20_000
_SAME = 1e-6  # [m, deg], by which a number that was not touched may differ, since it was shown

Change = Mapping[str, Any]


def apply(work: Work, changes: Sequence[Change]) -> list[str]:
    """Make all changes, in their order; returns the paths of what was added.

    - ``{op: "set", path, value}``: set a value; null is ``"none"``.
    - ``{op: "remove", path}``: remove the entry; a sensor or estimator of the model is left out.
    - ``{op: "add", path, value}``: an item more in a list; with ``folder``, its names of files start there.
    - ``{op: "move", path, index}``: an item of a list to another place in it.
    - ``{op: "pose", path, value}``: where a thing stands, x, y [m] and heading [deg]; null is what stays.
    - ``{op: "point", path, number, value}``: one of the points of a place, x, y [m]; ``insert`` makes it one more.
    - ``{op: "mount", path, value}``: where a sensor sits on its robot, x, y [m] and heading [deg]; null is what stays.
    - ``{op: "shape", path, value}``: another kind of shape.
    - ``{op: "know_map" | "know_landmarks", path, value}``: a robot's knowledge (`inspectors.knowing`).
    - ``{op: "toml", path, text}``: a table's whole content in the file, as TOML.
    - ``{op: "text", text}``: the whole text of the scenario.
    - ``{op: "paint", spans, occupied}``: cells of a bitmap, as ``[row, first column, one after the last]``.
    - ``{op: "fill", row, column, occupied}``: the area of a bitmap about a cell.
    - ``{op: "crop", box}``: a part of a bitmap: first row and column, and one after the last of each.
    - ``{op: "walls", add, change, remove}``: walls [m]; those that change as ``[number, wall]``.

    Raises
    ------
    AmorsimError
        If one cannot be made.
    """
    if not isinstance(changes, list) or not 0 < len(changes) <= MOST_CHANGES:
        raise AmorsimError(f"changes: expected a list of 1 to {MOST_CHANGES} changes")
    added: list[str] = []
    for change in changes:
        does = _OPS.get(change.get("op", "")) if isinstance(change, dict) else None
        if does is None:
            raise AmorsimError(f"op: expected {', '.join(_OPS)}; got {shown(change)}")
        new = does(work, change)
        if new:
            added.append(new)
    return added


def _path(change: Change) -> str:
    path = change.get("path")
    if not isinstance(path, str) or not path or len(path) > 500:
        raise AmorsimError(f"path: expected the path of a value, got {shown(path)}")
    return path


def _set(work: Work, change: Change) -> None:
    path, value = _path(change), change.get("value")
    value = NONE if value is None else value
    *before, last = path.split(".")
    if last.isdigit() and before:  # in a list that is only a default: all of the list
        items = _said(work, ".".join(before))
        if items is MISSING:
            raise AmorsimError(f"{'.'.join(before)}: say the whole list first")
    work.document.set(path, value)


def _remove(work: Work, change: Change) -> None:
    path = _path(change)
    parts = path.split(".")
    if _own(work, path) is MISSING and _said(work, path) is not MISSING:
        if len(parts) == 4 and parts[2] in ("sensors", "estimators"):
            work.document.set(path, False)
            return
        if parts[-1].isdigit():
            items = _said(work, ".".join(parts[:-1]))
            work.document.set(".".join(parts[:-1]), [item for n, item in enumerate(items) if n != int(parts[-1])])
            return
    is_sensor = len(parts) == 4 and parts[2] in ("sensors", "estimators")
    work.document.remove(path)
    if is_sensor and _said(work, path) is not MISSING:  # the model has one of that name too
        work.document.set(path, False)


def _add(work: Work, change: Change) -> str:
    path, value = _path(change), change.get("value")
    if "folder" in change:
        value = _from_folder(work, path, value, change["folder"])
    there = _said(work, path)
    if _own(work, path) is MISSING and isinstance(there, list) and there:  # a list of the model's, with one more
        work.document.set(path, [*there, value])
        return f"{path}.{len(there)}"
    return work.document.add(path, value)


def _from_folder(work: Work, path: str, value: Any, folder: Any) -> Any:
    """A table that was copied where names of files start in a folder, with their names from here."""
    if not isinstance(folder, str) or not Path(folder).is_absolute():
        raise AmorsimError(f"folder: expected an absolute path, got {shown(folder)}")
    if Path(folder) == work.here:
        return value
    return renamed({path: [value]}, work.registry, Path(folder), work.here)[path][0]


def _move(work: Work, change: Change) -> None:
    path, index = _path(change), change.get("index")
    whole, _, last = path.rpartition(".")
    items = _said(work, whole) if whole else MISSING
    if not isinstance(index, int) or isinstance(index, bool) or not isinstance(items, list) or not last.isdigit():
        raise AmorsimError(f"index: expected a place in a list, got {shown(index)}")
    if not (0 <= index < len(items) and int(last) < len(items)):
        raise AmorsimError(f"index: expected 0 to {len(items) - 1}, got {index}")
    if _own(work, whole) is MISSING:  # the model's list, in another order
        items = list(items)
        items.insert(index, items.pop(int(last)))
        work.document.set(whole, items)
    else:
        work.document.move(path, index)


def _pose(work: Work, change: Change) -> None:
    path, value = _path(change), change.get("value")
    parts = _numbers_of(value, ("x", "y", "heading_deg"))
    if path.split(".")[0] in ("landmarks", "lights"):
        parts.pop("heading_deg", None)
    else:
        path = f"{path}.pose"
        if _own(work, path) is MISSING:  # where the map's start was its place
            work.document.set(path, parts)
            return
    own: Any = _own(work, path)
    for key, part in parts.items():
        there: Any = own.get(key, 0.0) if isinstance(own, dict) else None
        if not is_number(there) or abs(there - part) > _SAME:
            work.document.set(f"{path}.{key}", part)


def _point(work: Work, change: Change) -> None:
    path, number, value = _path(change), change.get("number", 0), change.get("value")
    if not isinstance(value, list) or len(value) != 2 or not all(is_number(part, below=1e6) for part in value):
        raise AmorsimError(f"value: expected [x, y], got {shown(value)}")
    if not isinstance(number, int) or isinstance(number, bool) or number < 0:
        raise AmorsimError(f"number: expected that of a point, got {shown(number)}")
    written = _own(work, path)
    if isinstance(written, dict):  # with x and y of its own
        for key, part in zip(("x", "y"), value, strict=True):
            work.document.set(f"{path}.{key}", part)
    elif isinstance(written, list) and change.get("insert") is True:
        work.document.set(path, [*written[:number], value, *written[number:]])
    elif isinstance(written, list) and len(written) == 4 and not isinstance(written[0], list) and number < 2:  # a box
        corners = [value, written[2:]] if number == 0 else [written[:2], value]
        (x0, y0), (x1, y1) = corners
        work.document.set(path, [min(x0, x1), min(y0, y1), max(x0, x1), max(y0, y1)])
    elif isinstance(written, list) and len(written) == 2 and not isinstance(written[0], list):
        work.document.set(path, value)
    elif isinstance(written, list) and number < len(written):
        work.document.set(f"{path}.{number}", value)
    else:
        raise AmorsimError(f"{path}: the file has no such point")


def _mount(work: Work, change: Change) -> None:
    path, value = f"{_path(change)}.mount", change.get("value")
    for key, part in _numbers_of(value, ("x", "y", "heading_deg")).items():
        written = _said(work, path)
        there = written.get(key, 0.0) if isinstance(written, dict) else 0.0
        if not is_number(there) or abs(there - part) > _SAME:
            work.document.set(f"{path}.{key}", part)


def _numbers_of(value: Any, keys: tuple[str, ...]) -> dict[str, float]:
    """The numbers of a list by their keys, without those that are null."""
    if (
        not isinstance(value, list)
        or len(value) != len(keys)
        or not all(part is None or is_number(part, below=1e6) for part in value)
    ):
        raise AmorsimError(f"value: expected a list of {', '.join(keys)}, got {shown(value)}")
    return {key: part for key, part in zip(keys, value, strict=True) if part is not None}


def _shape(work: Work, change: Change) -> None:
    kind = change.get("value")
    if not isinstance(kind, str) or kind not in SHAPES:
        raise AmorsimError(f"value: expected {', '.join(SHAPES)}, got {shown(kind)}")
    work.document.set(_path(change), {kind: SHAPES[kind]})


def _toml(work: Work, change: Change) -> None:
    path, text = _path(change), change.get("text")
    if not isinstance(text, str):
        raise AmorsimError(f"text: expected TOML, got {shown(text)}")
    try:
        table = parse(text)
    except tomllib.TOMLDecodeError as error:
        raise AmorsimError(f"not valid TOML: {error}") from None
    if not table and _own(work, path) is not MISSING:
        work.document.remove(path)
    elif table:
        work.document.set(path, table)


def _text(work: Work, change: Change) -> None:
    text = change.get("text")
    if not isinstance(text, str) or any("\ud800" <= letter <= "\udfff" for letter in text):
        raise AmorsimError(f"text: expected a text, got {shown(text)}")
    work.set_text(with_line_ends(text, work.text))


def _walls(work: Work, change: Change) -> None:
    add = [_wall(one) for one in _list(change, "add")]
    remove = {_number(one) for one in _list(change, "remove")}
    moved: dict[int, list[float]] = {}
    for pair in _list(change, "change"):
        if not isinstance(pair, list) or len(pair) != 2:
            raise AmorsimError(f"change: expected [number, wall], got {shown(pair)}")
        moved[_number(pair[0])] = _wall(pair[1])
    try:
        work.world.walls(add=add, change=moved, remove=remove)
    except IndexError:
        raise AmorsimError("walls: there is no wall of that number") from None


def _paint(work: Work, change: Change) -> None:
    work.world.paint(lambda text: painted(text, change.get("spans"), is_occupied=change.get("occupied") is True))


def _fill(work: Work, change: Change) -> None:
    row, column = _number(change.get("row")), _number(change.get("column"))
    work.world.paint(lambda text: filled(text, row, column, is_occupied=change.get("occupied") is True))


def _crop(work: Work, change: Change) -> None:
    box = change.get("box")
    if not isinstance(box, list) or len(box) != 4 or not all(is_number(part, below=1e9) for part in box):
        raise AmorsimError(f"box: expected [top, left, end, right] in cells, got {shown(box)}")
    top, left, end, right = (int(part) for part in box)
    rows, _ = work.world.cells or (0, 0)
    table: Any = _own(work, "world")
    turned = table.get("origin_yaw_deg", 0.0) if isinstance(table, dict) else 0.0
    resolution: Any = table.get("resolution") if isinstance(table, dict) else None
    if turned or not is_number(resolution):
        raise AmorsimError("only a bitmap with a resolution, and that is not turned, can be cropped")
    work.world.paint(lambda text: cropped(text, top, left, end, right))
    # What stays is where it was: the picture's lower left corner is another.
    for key, cells in (("origin_x", max(0, left)), ("origin_y", rows - min(rows, end))):
        there = table.get(key, 0.0)
        if cells:
            work.document.set(f"world.{key}", round((there if is_number(there) else 0.0) + cells * resolution, 9))


def _list(change: Change, key: str) -> Iterable[Any]:
    found = change.get(key, [])
    if not isinstance(found, list):
        raise AmorsimError(f"{key}: expected a list, got {shown(found)}")
    return found


def _wall(value: Any) -> list[float]:
    if not isinstance(value, list) or len(value) != 4 or not all(is_number(part, below=1e6) for part in value):
        raise AmorsimError(f"a wall: expected [x1, y1, x2, y2] [m], got {shown(value)}")
    return [float(part) for part in value]


def _number(value: Any) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or value < 0:
        raise AmorsimError(f"a wall: expected its number, got {shown(value)}")
    return value


def own_table(work: Work, path: Any) -> dict[str, Any]:
    """The file's own table of a thing.

    Raises
    ------
    AmorsimError
        If it has none.
    """
    table = _own(work, path) if isinstance(path, str) else MISSING
    if not isinstance(table, dict):
        raise AmorsimError(f"the file says nothing of {shown(path)}")
    return table


def _own(work: Work, path: str) -> Any:
    """The file's own value at a path of numbers and keys."""
    return found_at(work.document.values, tuple(int(part) if part.isdigit() else part for part in path.split(".")))


def _said(work: Work, path: str) -> Any:
    """The value of the file, or of the model."""
    try:
        return work.document.get(path)
    except DocumentError:
        return MISSING


_OPS: Mapping[str, Callable[[Work, Change], str | None]] = {
    "set": _set,
    "remove": _remove,
    "add": _add,
    "move": _move,
    "pose": _pose,
    "point": _point,
    "mount": _mount,
    "shape": _shape,
    "know_map": lambda work, change: know_map(work, _path(change), change.get("value")),
    "know_landmarks": lambda work, change: know_landmarks(work, _path(change), change.get("value")),
    "toml": _toml,
    "text": _text,
    "walls": _walls,
    "paint": _paint,
    "fill": _fill,
    "crop": _crop,
}
