"""Robot models in documents: a model's file, under what the scenario says of the robot."""

from __future__ import annotations

import copy
import tomllib
from pathlib import Path
from typing import Any

from amorsim.core.errors import PluginError
from amorsim.plugins.registry import Registry
from amorsim.scenario.angles import parse_float
from amorsim.scenario.faults import Book, Node, Source, shown

__all__ = ["FORMAT", "LOOKS", "MODEL_KEYS", "check_format", "drop_removed", "merge_models", "read_toml"]

FORMAT = 1
LOOKS = ("fiducial", "height", "colour")  # of a robot or an obstacle
MODEL_KEYS = (
    "format",
    "description",
    "shape",
    "drive",
    "sensors",
    "ground",
    "estimators",
    "controller",
    "on_collision",
    *LOOKS,
)
# What a robot has several of by name, and can be rid of with ``NAME = false``.
_NAMED = ("sensors", "estimators")


def read_toml(path: Path) -> dict[str, Any] | str:
    """The document in a TOML file, or a text that says why there is none."""
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        return "there is no such file"
    except UnicodeDecodeError as error:
        return f"not a text file in UTF-8: byte {error.start} is {error.object[error.start]:#04x}"
    except (OSError, ValueError) as error:
        return f"cannot be read: {'it is a folder' if isinstance(error, IsADirectoryError) else error}"
    try:
        return tomllib.loads(text.removeprefix("\N{BOM}"), parse_float=parse_float)
    except (ValueError, RecursionError) as error:
        return f"not valid TOML: {error}"


def check_format(node: Node) -> None:
    """A fault unless a file says that it is of the format that this program reads."""
    if node.value is None:
        node.fault(f"missing; expected format = {FORMAT}, the format of the file, at its top")
    elif type(node.value) is not int or node.value != FORMAT:
        node.fault(f"expected {FORMAT}, the only format that this amorsim reads, got {shown(node.value)}")


def merge_models(document: dict[str, Any], book: Book, registry: Registry) -> None:
    """Put what each robot's model says under what the document says of it; note which came from where.

    Tables are merged key by key; where the document names another ``use``, in shapes and in lists, it replaces
    what the model has. ``model`` becomes ``resolved_from``.
    """
    robots = document.get("robots")
    if not isinstance(robots, list):
        return
    for index, robot in enumerate(robots):
        if isinstance(robot, dict) and "model" in robot:
            node = Node(robot, ("robots", str(index)), book)
            model = _read_model(node.child("model"), registry)
            name = robot.pop("model")
            if "resolved_from" in robot:
                node.child("resolved_from").fault("a resolved robot has no model: leave one of the two out")
            if model is None:
                book.incomplete.add(node.path)
            else:
                robot["resolved_from"] = name
                robots[index] = _merge_robot(model, node)


def _read_model(node: Node, registry: Registry) -> tuple[Source, dict[str, Any]] | None:
    name = node.text("the name of a robot model, or the path of its .toml file")
    if name is None:
        return None
    if name.endswith(".toml"):
        path = node.folder / name
    else:
        try:
            path = registry.file("robot", name)
        except PluginError as error:
            node.fault(str(error))
            return None
    model = read_toml(path)
    if isinstance(model, str):
        node.fault(f"the model {path}: {model}" if "TOML" not in model else f"the model {path} is {model}")
        return None
    source = Source(file=str(path), folder=path.parent)
    book = node.book
    # Faults at the model's top level are found here, where no scenario's keys are mixed in.
    alone = Book(source)
    top = Node(model, (), alone)
    check_format(top.child("format"))
    top.refuse_unknown(MODEL_KEYS)
    if "description" in model:
        top.child("description").text("a text")
    for fault in alone.faults:
        book.add(fault)
    return source, {key: value for key, value in model.items() if key in MODEL_KEYS[2:]}


def _merge_robot(model: tuple[Source, dict[str, Any]], node: Node) -> dict[str, Any]:
    source, values = model
    merged = copy.deepcopy(values)
    own = node.book.source(node.path)
    source = Source(file=source.file, folder=source.folder, depth=len(node.path))
    for key in merged:
        node.book.set_source((*node.path, key), source)
    _merge(merged, node.value, node.path, own, node.book)
    return merged


def _merge(under: dict[str, Any], over: dict[str, Any], path: tuple[str, ...], own: Source, book: Book) -> None:
    for key, value in over.items():
        old = under.get(key)
        at = (*path, key)
        if isinstance(old, dict) and isinstance(value, dict) and _is_of_one_kind(key, old, value):
            _merge(old, value, at, own, book)
        else:
            under[key] = value
            book.set_source(at, own)


def _is_of_one_kind(key: str, old: dict[str, Any], new: dict[str, Any]) -> bool:
    # Half of one shape and half of another is none.
    return key != "shape" and new.get("use", old.get("use")) == old.get("use")


def drop_removed(robot: Any) -> None:
    """Leave out the sensors and estimators of a robot that are ``false``."""
    if isinstance(robot, dict):
        for kind in _NAMED:
            if isinstance(robot.get(kind), dict):
                robot[kind] = {name: value for name, value in robot[kind].items() if value is not False}
