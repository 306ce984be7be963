"""Models in documents: the file of a robot or a device lies under what the scenario sets."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import attrs

from amorsim.core.errors import PluginError
from amorsim.core.files.reading import no_such_file, read_bytes, reason
from amorsim.core.unknown_names import no_such
from amorsim.plugins.registry import Registry
from amorsim.scenario.reading.faults import Branch, FaultCollector, Node, Source, shown
from amorsim.scenario.toml.layout import copied_tables
from amorsim.scenario.toml.parse import Written, read_written

__all__ = [
    "ERROR_KEYS",
    "FORMAT",
    "LOOKS",
    "MODEL_KEYS",
    "are_of_one_kind",
    "check_format",
    "drop_removed",
    "merge_models",
    "read_file",
    "read_layers",
    "read_toml",
]

FORMAT = 1
LOOKS = ("fiducial", "height", "colour")  # of a robot or an obstacle
MODEL_KEYS = (
    "format",
    "description",
    "model",
    "shape",
    "drive",
    "sensors",
    "ground",
    "estimators",
    "controller",
    "on_collision",
    "errors",
    *LOOKS,
)
ERROR_KEYS = {"scale", "add", "value", "per", "normal", "uniform"}  # keys of an error; no path ends with one
# What a robot has several of by name, and can be rid of with ``NAME = false``.
_NAMED = ("sensors", "estimators")


def read_toml(path: Path) -> dict[str, Any] | str:
    """The table in a TOML file, or a message why there is none."""
    written = read_file(path)
    if isinstance(written, str):
        return written
    if written.bad:
        first = written.bad[0]
        return f"line {first.line}: {first.message}"
    return written.values


def read_file(path: Path) -> Written | str:
    """The content of a TOML file, and which of its lines are not TOML; or a message why it cannot be read."""
    try:
        text = read_bytes(path).decode()  # with its line ends, for TOML has no lone CR
    except FileNotFoundError:
        return no_such_file(path)
    except UnicodeDecodeError as error:
        return f"not a text file in UTF-8: byte {error.start} is {error.object[error.start]:#04x}"
    except (OSError, ValueError) as error:
        return f"cannot be read: {'it is a folder' if isinstance(error, IsADirectoryError) else reason(error)}"
    return read_written(text.removeprefix("\N{BOM}"))


def check_format(node: Node) -> None:
    """A fault unless a file states the format that this program reads."""
    if node.value is None:
        node.fault(f"missing; expected format = {FORMAT}, the format of the file, at its top")
    elif type(node.value) is not int or node.value != FORMAT:
        node.fault(f"expected {FORMAT}, the only format that this amorsim reads, got {shown(node.value)}")


def merge_models(document: dict[str, Any], book: FaultCollector, registry: Registry) -> None:
    """Lay what the document sets for each robot over its model; note where each value came from.

    Tables are merged key by key; where the document names another ``use``, in shapes and in lists, it replaces
    what the model has. ``model`` becomes ``resolved_from``. A model may build on another, whose name it has under
    ``model``. Then the same is done for sensors that have a ``model``, a device.
    """
    robots = document.get("robots")
    if not isinstance(robots, list):
        return
    known: Known = {}
    for index, robot in enumerate(robots):
        if not isinstance(robot, dict):
            continue
        node = Node(robot, ("robots", str(index)), book)
        if "model" in robot:
            layers = _known_layers(node.child("model"), "robot", registry, known)
            name = robot.pop("model")
            if "resolved_from" in robot:
                node.child("resolved_from").fault("a resolved robot has no model; leave one of the two out")
            if layers is None:
                book.incomplete.add(node.path)
            else:
                robot["resolved_from"] = name
                _check_removals(layers, node)
                robots[index] = _merged(layers, node)
        _merge_devices(Node(robots[index], node.path, book), registry, known)


def _check_removals(layers: Sequence[Layer], robot: Node) -> None:
    """A fault for each sensor or estimator that is removed though the model has none of that name."""
    for kind in _NAMED:
        own = robot.value.get(kind)
        names = [name for _, values in layers if isinstance(values.get(kind), dict) for name in values[kind]]
        for name in [name for name, value in own.items() if value is False] if isinstance(own, dict) else []:
            if name not in names:
                robot.child(kind).child(name).fault(no_such(kind.removesuffix("s"), name, names, whose="the model"))


def _merge_devices(robot: Node, registry: Registry, known: Known) -> None:
    """Lay sensors over the devices that they name as their models."""
    sensors = robot.value.get("sensors")
    if not isinstance(sensors, dict):
        return
    for name, sensor in list(sensors.items()):
        if not isinstance(sensor, dict) or "model" not in sensor:
            continue
        node = robot.child("sensors").child(name)
        layers = _known_layers(node.child("model"), "device", registry, known)
        if layers is None:
            # The sensor is not to blame for missing what the device would have set.
            del sensors[name]
            robot.book.incomplete.add(robot.path)
            continue
        del sensor["model"]
        sensors[name] = _merged(layers, node)


Layer = tuple[Source, dict[str, Any]]
Known = dict[tuple[str, str, Path], list[Layer]]  # by the kind and the name of a model, and the folder it is named in

_WORDS = {"robot": "a robot model", "device": "a device"}


def read_layers(source: str, kind: str, registry: Registry) -> tuple[FaultCollector, dict[str, Any] | None]:
    """The content of a robot model or a device, by its name or the path of its file, on top of what it builds on.

    Nothing where it cannot be read; the book then has the faults, and otherwise knows what came from which file.
    """
    book = FaultCollector(Source(file="", folder=Path()))
    node = Node({}, (), book)
    layers = _read_layers(Node(source, ("model",), book), kind, registry)
    return book, None if layers is None or book.count else _merged(layers, node)


def _known_layers(node: Node, kind: str, registry: Registry, known: Known) -> list[Layer] | None:
    """The result of `_read_layers`, read once for all robots that name the same file without faults."""
    key = (kind, node.value, node.folder) if isinstance(node.value, str) else None
    if key is not None and key in known:
        return known[key]
    before = node.book.count
    layers = _read_layers(node, kind, registry)
    if key is not None and layers is not None and node.book.count == before:
        known[key] = layers
    return layers


def _read_layers(node: Node, kind: str, registry: Registry, seen: tuple[Path, ...] = ()) -> list[Layer] | None:
    """The content of a file without a model's top entries, after all that it builds on."""
    name = node.text(f"the name of {_WORDS[kind]}, or the path of its .toml file")
    if name is None:
        return None
    if name.endswith(".toml"):
        path = node.folder / name
    else:
        try:
            path = registry.file(kind, name)
        except PluginError as error:
            node.fault(str(error))
            return None
    model = read_toml(path)
    if isinstance(model, str):
        node.fault(f"the model {path}: {model}")
        return None
    if path.resolve() in seen:
        node.fault(f"{name} builds on itself; expected the name of another model")
        return None
    source = Source(file=str(path), folder=path.parent, kind="model" if kind == "robot" else kind)
    # Faults at the model's top level are found here, where no scenario's keys are mixed in.
    alone = FaultCollector(source)
    top = Node(model, (), alone)
    check_format(top.child("format"))
    if kind == "robot":
        top.refuse_unknown(MODEL_KEYS)
    if "description" in model:
        top.child("description").text("a text")
    layers: list[Layer] | None = []
    if "model" in model:
        layers = _read_layers(top.child("model"), kind, registry, (*seen, path.resolve()))
    for fault in alone.faults:
        node.book.add(fault)
    if layers is None:
        return None
    known = MODEL_KEYS[3:] if kind == "robot" else tuple(key for key in model if key not in MODEL_KEYS[:3])
    return [*layers, (source, {key: value for key, value in model.items() if key in known})]


def _merged(layers: list[Layer], node: Node) -> dict[str, Any]:
    """The layers, each over those before it, and over all of them the node's own table."""
    # The table's own parts may come from several files: those of a robot with a model, which have devices.
    before = FaultCollector(node.book.source(node.path))
    before.set_branch(node.path, node.book.branch(node.path))
    merged: dict[str, Any] = {}
    for source, values in layers:
        alone = FaultCollector(attrs.evolve(source, depth=len(node.path)))
        _merge(merged, copied_tables(values), node.path, alone.branch, node.book)
    _merge(merged, node.value, node.path, before.branch, node.book)
    return merged


def _merge(
    under: dict[str, Any],
    over: dict[str, Any],
    path: tuple[str, ...],
    origin: Callable[[tuple[str, ...]], Branch],
    book: FaultCollector,
) -> None:
    for key, value in over.items():
        old = under.get(key)
        at = (*path, key)
        if isinstance(old, dict) and isinstance(value, dict) and are_of_one_kind(at, old, value):
            _merge(old, value, at, origin, book)
        else:
            under[key] = value
            book.set_branch(at, origin(at))


def are_of_one_kind(path: tuple[str, ...], old: dict[str, Any], new: dict[str, Any]) -> bool:
    """Whether a table laid over another is merged with it key by key, instead of replacing it."""
    # Half of one shape, or of one error, and half of another is none.
    if path[-1] == "shape" or ("errors" in path[:-1] and set(new) <= ERROR_KEYS):
        return False
    return all(new.get(key, old.get(key)) == old.get(key) for key in ("use", "model"))


def drop_removed(robot: Any) -> None:
    """Leave out the sensors and estimators of a robot that are ``false``."""
    if isinstance(robot, dict):
        for kind in _NAMED:
            if isinstance(robot.get(kind), dict):
                robot[kind] = {name: value for name, value in robot[kind].items() if value is not False}
