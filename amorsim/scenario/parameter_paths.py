"""Numbers of a robot by path: ``drive.track``, ``sensors.laser.mount.heading``, ``controller.speed`` ..."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import attrs

from amorsim.core.error_text import in_words
from amorsim.core.errors import did_you_mean
from amorsim.core.parameters import describe
from amorsim.core.unknown_names import no_such
from amorsim.scenario.spec import Deviation, MountedSensor, NoiseElement, Pose, Robot

__all__ = ["changed", "index_in", "value_in", "with_value"]

Change = Callable[[Any], Any]
_NUMBERS = ("scale", "add", "value")  # of a deviation
_BESIDE = ("mount", "rate", "latency", "noise")  # of a sensor, next to its own parameters
_LIVE = ("drive", "ground", "sensors", "estimators", "controller", "pose")  # of a robot


def with_value(robot: Robot, path: str, value: Any) -> Robot:
    """The robot with another value at `path`, of a parameter that may change while a simulation runs.

    Besides the paths of parameters, ``errors.<path>`` takes a `Deviation` or a table of its fields, and
    ``errors.<path>.scale`` (``.add``, ``.value``) one of them; a value takes the place of scale and add. None at
    ``errors.<path>`` takes the error away.

    Raises
    ------
    LookupError
        If the path leads nowhere, or to what is fixed once a simulation is made; the message states which.
    ParameterError
        If the parameter does not take the value.
    """
    if not isinstance(path, str):
        raise LookupError(f"expected a path, as 'drive.track', got {in_words(path)}")  # noqa: TRY004 - of what leads nowhere
    parts = path.split(".")
    if parts[0] != "errors":
        if parts[0] not in _LIVE and parts[0] in attrs.fields_dict(Robot):
            raise LookupError(f"{parts[0]!r} of a robot is fixed once a simulation is made")
        return changed(robot, parts, lambda _: value, live=True)  # type: ignore[no-any-return]
    if value is None and parts[-1] not in _NUMBERS:
        target = ".".join(parts[1:])
        changed(robot, target.split("."), lambda nominal: nominal, live=True)
        return attrs.evolve(robot, errors={path: error for path, error in robot.errors.items() if path != target})
    if isinstance(value, (dict, Deviation)):
        target = ".".join(parts[1:])
        deviation = value if isinstance(value, Deviation) else _deviation(value)
    else:
        target, field = ".".join(parts[1:-1]), parts[-1]
        if field not in _NUMBERS:
            raise LookupError(
                f"expected a path that ends with one of {', '.join(_NUMBERS)}, as in errors.drive.track.scale, or a "
                f"table of these, got {in_words(value)}.{did_you_mean(field, _NUMBERS)}"
            )
        before = robot.errors.get(target, Deviation())
        is_instead = field == "value" and value is not None  # of scale and add
        deviation = Deviation(value=value, per=before.per) if is_instead else attrs.evolve(before, **{field: value})
    changed(robot, target.split("."), lambda nominal: nominal, live=True)  # the path must lead somewhere
    return attrs.evolve(robot, errors={**robot.errors, target: deviation})


def _deviation(table: dict[str, Any]) -> Deviation:
    known = attrs.fields_dict(Deviation)
    for name in table:
        if name not in known:
            raise LookupError(no_such("key", name, known, whose="an error"))
    return Deviation(**table)


def changed(thing: Any, path: list[str], change: Change, *, live: bool = False) -> Any:
    """`thing` with the number at `path` changed; tables, tuples and dicts on the way are copied, not altered.

    With `live`, only what may change while a simulation runs.
    """
    name, rest = path[0], path[1:]
    if isinstance(thing, dict):
        if name not in thing:
            raise LookupError(no_such("entry", name, thing))
        return {**thing, name: _descend(thing[name], rest, change, live)}
    if isinstance(thing, tuple):
        index = index_in(thing, name)
        return (*thing[:index], _descend(thing[index], rest, change, live), *thing[index + 1 :])
    if not attrs.has(type(thing)):
        raise LookupError(f"the path should end before {name!r}, where there is {thing!r}")
    fields = attrs.fields_dict(type(thing))
    # As in a file, a device's parameters stand next to its mount, and an element's next to its name. No other path
    # leads to them, for a number has one error.
    is_within = isinstance(thing, NoiseElement) or (isinstance(thing, MountedSensor) and name not in _BESIDE)
    if is_within:
        inner = "sensor" if isinstance(thing, MountedSensor) else "noise"
        return attrs.evolve(thing, **{inner: changed(getattr(thing, inner), path, change, live=live)})
    if name not in fields:
        raise LookupError(no_such("parameter", name, fields))
    value = getattr(thing, name)
    parameter = describe(type(thing))[name]
    # What fixes shapes is equal in all rows of a group, so it can neither change nor differ from replica to replica.
    if parameter.static or (not rest and live and not parameter.live):
        raise LookupError(f"{name!r} of {type(thing).__name__} is fixed once a simulation is made")
    if value is None and name == "pose":
        value = Pose()
    return attrs.evolve(thing, **{name: _descend(value, rest, change, live)})


def value_in(thing: Any, path: list[str]) -> Any:
    """The value at a path of `changed`."""
    found: list[Any] = []

    def keep(value: Any) -> Any:
        found.append(value)
        return value

    changed(thing, path, keep)
    return found[0]


def _descend(value: Any, rest: list[str], change: Change, live: bool) -> Any:
    if rest:
        return changed(value, rest, change, live=live)
    if isinstance(value, tuple) and value:
        raise LookupError(
            f"only a number can be changed, and this is a list of {len(value)}: end the path with one of 0 to "
            f"{len(value) - 1}"
        )
    if not isinstance(value, (int, float)) or isinstance(value, bool):
        raise LookupError(f"only a number can be changed, and this is {in_words(value)}")  # noqa: TRY004 - of the path
    return change(value)


def index_in(items: tuple[Any, ...], name: str) -> int:
    """The index of the item that a part of a path names, by the item's name or by its number.

    Raises
    ------
    LookupError
        If it means none.
    """
    names = [getattr(item, "name", None) for item in items]
    if name in names:
        return names.index(name)
    numbers = [str(number) for number in range(len(items))]
    if name in numbers:
        return numbers.index(name)
    known = [n for n in names if n] or ([f"0 to {len(items) - 1}"] if items else [])
    raise LookupError(no_such("element", name, known))
