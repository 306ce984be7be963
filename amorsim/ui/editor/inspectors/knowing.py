"""A robot's knowledge in its inspector: a map, landmarks, its kidnappings; and changes of these."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from amorsim.core.errors import AmorsimError
from amorsim.core.numbers import is_number
from amorsim.scenario.kidnapping import Kidnapping
from amorsim.scenario.reading.worlds import KnownLandmark
from amorsim.scenario.toml.layout import MISSING, found_at
from amorsim.ui.editor.inspectors.sections import Section
from amorsim.ui.editor.inspectors.thing_fields import ThingFields
from amorsim.ui.editor.storage.formats import map_files
from amorsim.ui.forms.description import FieldForm, Widget, form_of
from amorsim.ui.serve.wire import shown

if TYPE_CHECKING:
    from amorsim.ui.editor.work import Work

__all__ = ["kidnappings", "know_landmarks", "know_map", "knowledge"]

WORLD = "the world's"
OWN, NUMBERED = "places of its own", "numbered places of its own"
GENERATED = "generated: "
_AT = ("knowledge",)


# ------------------------------------------------------------------------------------------------------------ sections


def kidnappings(of: ThingFields) -> Iterator[Section]:
    """When the robot is carried elsewhere, a section for each time."""
    heading = of.section("Kidnappings", ("kidnappings",), [])
    pose = of.table.get("pose")
    new: dict[str, Any] = {"time": 10.0, "x": 0.0, "y": 0.0}
    if isinstance(pose, dict):
        new |= {key: pose[key] for key in ("x", "y", "heading_deg") if is_number(pose.get(key))}
    heading["adding"] = [
        {
            "label": "carry it elsewhere",
            "path": of.path_of(("kidnappings",)),
            "kind": "kidnapping",
            "choices": [],
            "is_list": True,
            "value": new,
        }
    ]
    yield heading
    written = of.table.get("kidnappings")
    for number, one in enumerate(written if isinstance(written, list) else []):
        at = ("kidnappings", number)
        time = one.get("time") if isinstance(one, dict) else None
        title = f"kidnapping {number + 1}" + (f", at {time:g} s" if is_number(time) else "")
        section = of.section(title, at, of.form(Kidnapping, at))
        section["depth"] = 1
        section["can_go"] = True
        yield section


def knowledge(of: ThingFields) -> Iterator[Section]:
    """The map that the robot knows, and the landmarks."""
    table = found_at(of.table, _AT)
    written: dict[str, Any] = table if isinstance(table, dict) else {}
    yield _known_map(of, written)
    yield _known_landmarks(of, written)


def _known_map(of: ThingFields, written: Mapping[str, Any]) -> Section:
    known = written.get("map")
    section = of.section("Map that it knows", _AT, [])
    value = ""
    if isinstance(known, dict):
        value = f"{GENERATED}{known.get('generate', '?')}"
        at = (*_AT, "map")
        section["fields"] = [_seed(of, known), *_fields(of, at)]
    elif isinstance(known, str):
        value = known
        section["fields"] = _fields(of, _AT)
    if known is not None and _is_same(written, of.document.values.get("world")):
        value, section["fields"] = WORLD, []
    files = map_files(of.folder, of.registry)
    section["use"] = {
        "kind": "known map",
        "value": value,
        "choices": [WORLD, *files, *(f"{GENERATED}{name}" for name in of.registry.names("world_generator"))],
        "is_optional": True,
        "op": "know_map",
    }
    return section


def _fields(of: ThingFields, at: tuple[str, ...]) -> list[FieldForm]:
    cls = of.class_at(at)
    return [] if cls is None else of.form(cls, at)


def _seed(of: ThingFields, known: Mapping[str, Any]) -> FieldForm:
    seed = of.number((*_AT, "map", "seed"), "seed", "", known.get("seed", 0))
    seed["widget"] |= {"is_whole": True, "is_open": [False, True]}
    return seed


def _is_same(written: Mapping[str, Any], world: Any) -> bool:
    """Whether a table of knowledge names the world's own map, and reads it as the world does."""
    own = {key: value for key, value in written.items() if key != "landmarks"}
    return isinstance(world, dict) and own.get("map") == world.get("map") and (set(own) == {"map"} or own == world)


def _known_landmarks(of: ThingFields, written: Mapping[str, Any]) -> Section:
    marks = written.get("landmarks")
    at = (*_AT, "landmarks")
    section = of.section("Landmarks that it knows", at, [])
    value = ""
    if marks == "world":
        value = WORLD
    elif isinstance(marks, list):
        is_numbered = any(isinstance(one, dict) for one in marks)
        value = NUMBERED if is_numbered else OWN
        field = of.text(at, "places", "where it believes them to be; drag them on the canvas", "table")
        field["widget"] = _numbered() if is_numbered else _POINTS
        section["fields"] = [field]
    section["use"] = {
        "kind": "known landmarks",
        "value": value,
        "choices": [WORLD, OWN, NUMBERED],
        "is_optional": True,
        "op": "know_landmarks",
    }
    return section


_POINTS: Widget = {
    "kind": "table",
    "is_optional": False,
    "frame": "world",
    "columns": ["x", "y"],
    "item": {"kind": "number", "is_optional": False, "unit": "m", "low": None, "high": None, "is_whole": False},
}


def _numbered() -> Widget:
    return {"kind": "forms", "is_optional": False, "fields": form_of(KnownLandmark, {"id": 1, "x": 0.0, "y": 0.0})}


# ------------------------------------------------------------------------------------------------------------- changes


def know_map(work: Work, path: str, choice: Any) -> None:
    """Give a robot another map to know: the world's, a file, a generated one; none for an empty choice.

    Raises
    ------
    AmorsimError
        If there is no such choice.
    """
    table = _said(work, path)
    if not isinstance(choice, str):
        raise AmorsimError(f"value: expected the name of a map, got {shown(choice)}")
    kept = {key: value for key, value in table.items() if key == "landmarks"}
    world = work.document.values.get("world")
    new: dict[str, Any] = {}
    if choice == WORLD:
        if not isinstance(world, dict) or "map" not in world:
            raise AmorsimError("the world has no map yet")
        new = {"map": world["map"]}
    elif choice.startswith(GENERATED):
        new = {"map": {"generate": choice.removeprefix(GENERATED), "seed": 1}}
    elif choice:
        new = {"map": choice}
    _say(work, path, {**new, **kept})


def know_landmarks(work: Work, path: str, choice: Any) -> None:
    """Give a robot landmarks to know: the world's, or its own list, which begins as a copy of those.

    Raises
    ------
    AmorsimError
        If there is no such choice.
    """
    holder, _, _ = path.rpartition(".")
    table = _said(work, holder)
    there = table.get("landmarks")
    marks = work.document.values.get("landmarks") if not isinstance(there, list) else there
    places = [place for one in (marks if isinstance(marks, list) else []) if (place := _place(one)) is not None]
    places = places or [(1, 0.0, 0.0)]
    new = {key: value for key, value in table.items() if key != "landmarks"}
    if choice == WORLD:
        new["landmarks"] = "world"
    elif choice == OWN:
        new["landmarks"] = [[x, y] for _, x, y in places]
    elif choice == NUMBERED:
        new["landmarks"] = [{"id": number, "x": x, "y": y} for number, x, y in places]
    elif choice:
        raise AmorsimError(f"value: expected {WORLD}, {OWN} or {NUMBERED}, got {shown(choice)}")
    _say(work, holder, new)


def _place(mark: Any) -> tuple[int, float, float] | None:
    """The number of a landmark, and where it is."""
    if isinstance(mark, dict) and is_number(mark.get("x")) and is_number(mark.get("y")):
        number = mark.get("id")
        return (number if isinstance(number, int) and number > 0 else 1), mark["x"], mark["y"]
    if isinstance(mark, list) and len(mark) == 2 and all(map(is_number, mark)):
        return 1, mark[0], mark[1]
    return None


def _said(work: Work, path: str) -> dict[str, Any]:
    at = tuple(int(part) if part.isdigit() else part for part in path.split("."))
    robot = found_at(work.document.values, at[:2])
    if at[0] != "robots" or at[2:] != _AT or not isinstance(robot, dict):
        raise AmorsimError(f"path: expected that of a robot's knowledge, got {shown(path)}")
    found = found_at(work.document.values, at)
    return {} if found is MISSING or not isinstance(found, dict) else found


def _say(work: Work, path: str, table: dict[str, Any]) -> None:
    if table:
        work.document.set(path, table)
    elif _said(work, path):
        work.document.remove(path)
