"""Checks that a class keeps the contract of its kind, as far as possible without an instance."""

from __future__ import annotations

import inspect
import numbers
import re
import types
import typing
from collections import Counter
from collections.abc import Iterator, Mapping
from typing import Any

import attrs

from amorsim.contracts import Controller, Drive, Estimator, Joint, Motion, Part, Planner, Task
from amorsim.core.error_text import RAISED, in_words
from amorsim.core.errors import ComponentError, did_you_mean
from amorsim.core.parameters import COMPONENTS, FRAMES, REFERS, Parameter, ParameterError, check_value, describe

__all__ = ["RESERVED", "check_class", "check_name"]

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,63}")
_PLAIN = (float, int, bool, str, types.NoneType)

RESERVED: dict[str, tuple[str, ...]] = {
    "drive": ("use",),
    "sensor": ("use", "model", "mount", "rate", "latency", "noise"),
    "noise": ("use", "name", "column"),
    "map_loader": ("use", "map", "landmarks"),
    "scenario_loader": (),
    "world_generator": ("generate", "seed"),
    "motion": ("use",),
    "estimator": ("use",),
    "controller": ("use",),
    "planner": ("use",),
    "recorder": ("use",),
    "metric": ("use", "robot"),
    "task": ("use",),
}
"""Keys that stand next to a component's fields in a scenario, and that no field may be called by."""


def check_name(name: object) -> str:
    """The problem with a name to register under; empty if there is none."""
    if isinstance(name, str) and _NAME.fullmatch(name):
        return ""
    expected = "a name of letters, digits, '-' and '_' that begins with a letter (64 at most)"
    return f"expected {expected}, got {in_words(name)}"


def check_class(kind: str, contract: type, cls: Any) -> tuple[str, ...]:
    """The problems of a class as a component of a kind: what was found and what was expected; empty if none."""
    expected = f"amorsim.contracts.{contract.__name__}"
    if not isinstance(cls, type):
        return (f"expected a subclass of {expected}, got {cls!r}",)
    if not issubclass(cls, contract):
        bases = ", ".join(base.__name__ for base in cls.__bases__)
        return (f"expected a subclass of {expected}, got a class with the bases {bases}",)
    problems = list(_check_methods(contract, cls))
    if not problems:  # only a class without abstract methods can be tried for being frozen
        problems += _check_attrs(kind, cls)
    problems += _check_constants(contract, cls)
    if contract is Drive:
        problems += _check_parts(contract, cls)
    return tuple(problems)


def _check_methods(contract: type, cls: type) -> Iterator[str]:
    missing = sorted(getattr(cls, "__abstractmethods__", ()))
    if missing:
        near = [_similar(cls, contract, name) for name in missing]
        yield f"expected the methods {', '.join(missing)}, found none of that name" + "".join(near)
    methods = {
        name: member
        for base in reversed(contract.__mro__)
        for name, member in vars(base).items()
        if not name.startswith("_") and isinstance(member, (types.FunctionType, classmethod))
    }
    for name, member in methods.items():
        found = inspect.getattr_static(cls, name)
        if found is member:
            continue
        if not isinstance(found, (types.FunctionType, classmethod, staticmethod)):
            yield f"{name}: expected a method, found {type(found).__name__}"
            continue
        wanted_names, _ = _positional(member)
        found_names, required = _positional(found)
        fits = found_names[: len(wanted_names)] == wanted_names and required <= len(wanted_names)
        if not fits:
            yield f"{name}: expected ({', '.join(wanted_names)}), found ({', '.join(found_names)})"
    if contract.__name__ == "Noise":
        if all(getattr(cls, name) is getattr(contract, name) for name in methods):
            yield "expected aim, corrupt, slide or delay to be overridden, found none of them"
        if (cls.delay is contract.delay) is not (cls.longest_delay is contract.longest_delay):  # type: ignore[attr-defined]
            yield "expected delay and longest_delay both to be overridden, or none of them, found one"


def _similar(cls: type, contract: type, name: str) -> str:
    own = [other for other in vars(cls) if not other.startswith("_") and not hasattr(contract, other)]
    near = did_you_mean(name, own)
    return f" (is {near.split()[-1][:-1]} meant to be {name}?)" if near else ""


def _positional(method: Any) -> tuple[list[str], int]:
    """Names of a method's positional parameters without the instance or class, and how many must be given."""
    function = method.__func__ if isinstance(method, (classmethod, staticmethod)) else method
    parameters = list(inspect.signature(function).parameters.values())
    if not isinstance(method, staticmethod):
        parameters = parameters[1:]
    kinds = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
    positional = [parameter for parameter in parameters if parameter.kind in kinds]
    required = sum(
        parameter.default is inspect.Parameter.empty
        for parameter in parameters
        if parameter.kind in (*kinds, inspect.Parameter.KEYWORD_ONLY)
    )
    return [parameter.name for parameter in positional], required


def _check_attrs(kind: str, cls: type) -> Iterator[str]:
    if "__attrs_attrs__" not in vars(cls):
        yield "expected a class made with @attrs.frozen(kw_only=True), found one without that decorator"
        return
    # A recorder has files to keep open; every other component keeps nothing on itself.
    if kind != "recorder" and not _is_frozen(cls):
        yield "expected a frozen class, @attrs.frozen(kw_only=True), found one whose fields can be set"
    for field in attrs.fields(cls):
        if not field.init:
            continue
        if not field.kw_only:
            yield f"field {field.name!r}: expected a keyword-only field, @attrs.frozen(kw_only=True)"
        if field.name in RESERVED[kind]:
            yield f"field {field.name!r}: the name has a meaning of its own in a scenario; take another"
        if "amorsim" not in field.metadata:
            yield f"field {field.name!r}: expected it to be made with amorsim.parameter(...)"
            return
        if field.name.startswith("_"):
            yield f"field {field.name!r}: expected a name that begins with a letter, as files give it"
    try:
        described = describe(cls)
    except ComponentError as error:
        yield str(error)
        return
    except RAISED as error:
        yield f"the types of its fields cannot be read: {type(error).__name__}: {error}"
        return
    problems = [problem for parameter in described.values() for problem in _check_field(parameter)]
    # The words for a key and a default are made of the field's own description.
    yield from problems or [*_check_keys(described), *_check_defaults(cls, described)]


def _check_keys(described: Mapping[str, Parameter]) -> Iterator[str]:
    keys = {name: f"{name}_deg" if parameter.is_angle else name for name, parameter in described.items()}
    for key, times in Counter(keys.values()).items():
        if times > 1:
            names = " and ".join(repr(name) for name in keys if keys[name] == key)
            yield f"fields {names}: both have the key {key!r} in files, as angles are in degrees there; rename one"


def _check_defaults(cls: type, described: Mapping[str, Parameter]) -> Iterator[str]:
    for field in attrs.fields(cls):
        if not field.init or getattr(field.default, "takes_self", False):  # it depends on other fields
            continue
        parameter = described[field.name]
        try:
            if not parameter.is_required:
                check_value(parameter, parameter.default)
        except ParameterError as error:
            yield f"field {field.name!r}: its default: {error.problem}"


def _check_parts(contract: type, cls: type) -> Iterator[str]:
    """A drive with parts must give their poses and their travel; neither has a default."""
    parts = inspect.getattr_static(cls, "parts")
    if not isinstance(parts, property):  # else static fields decide them
        if not isinstance(parts, tuple) or not all(isinstance(part, Part) for part in parts):
            yield f"parts: expected a tuple of Part, found {parts!r}"
            return
        if not parts:
            return
    needed = ("part_poses", "part_travel")
    missing = [name for name in needed if inspect.getattr_static(cls, name) is inspect.getattr_static(contract, name)]
    if missing:
        yield f"parts: expected {' and '.join(missing)} to be overridden where there are parts, found none of that name"


def _check_field(parameter: Parameter) -> Iterator[str]:
    if parameter.component:
        yield from _check_component(parameter)
    elif not _is_supported(parameter.type):
        yield (
            f"field {parameter.name!r}: expected float, int, bool, str, | None of them, an attrs class with "
            f"such fields, or a tuple of those, found {parameter.type}"
        )
    for fact in ("unit", "help"):
        if not isinstance(getattr(parameter, fact), str):
            yield f"field {parameter.name!r}: {fact}: expected a text, found {in_words(getattr(parameter, fact))}"
    for fact in ("gt", "ge", "lt", "le"):
        bound: Any = getattr(parameter, fact)
        if bound is not None and (isinstance(bound, bool) or not isinstance(bound, numbers.Real)):
            yield f"field {parameter.name!r}: {fact}: expected a number, found {in_words(bound)}"
    if not isinstance(parameter.choices, (tuple, list)) or not all(isinstance(one, str) for one in parameter.choices):
        found = in_words(parameter.choices)
        yield f"field {parameter.name!r}: choices: expected a tuple or list of texts, found {found}"
    for fact, given, known in (("frame", parameter.frame, FRAMES), ("refers", parameter.refers, REFERS)):
        if given and given not in known:
            words = " or ".join(map(repr, known))
            yield f"field {parameter.name!r}: {fact}: expected {words}, found {given!r}.{did_you_mean(given, known)}"


def _check_component(parameter: Parameter) -> Iterator[str]:
    """The problems of a field that holds a component: its kind is unknown, or its annotation is not of the contract."""
    contracts: tuple[type, ...] = (Planner, Controller, Estimator, Motion, Task)
    contract = dict(zip(COMPONENTS, contracts, strict=True)).get(parameter.component)
    if contract is None:
        yield f"field {parameter.name!r}: component: expected {' or '.join(COMPONENTS)}, found {parameter.component!r}"
    elif not (isinstance(parameter.contract, type) and issubclass(parameter.contract, contract)):
        words = f"{contract.__name__} or a class of it, or one of these | None"
        yield f"field {parameter.name!r}: expected {words}, found {parameter.type}"


def _is_frozen(cls: type) -> bool:
    instance: Any = object.__new__(cls)
    try:
        instance._amorsim_probe = None
    except attrs.exceptions.FrozenError:
        return True
    except AttributeError:  # slots, not frozen
        return False
    return False


def _is_supported(kind: Any) -> bool:
    if kind in _PLAIN or kind is Ellipsis:
        return True
    origin = typing.get_origin(kind)
    if origin in (tuple, types.UnionType, typing.Union):
        return all(_is_supported(item) for item in typing.get_args(kind))
    if isinstance(kind, type) and attrs.has(kind):
        return all(_is_supported(parameter.type) for parameter in describe(kind).values())
    return False


def _check_constants(contract: type, cls: type) -> Iterator[str]:
    wanted: dict[str, type] = {"joints": Joint, "channels": str, "extensions": str}
    declared = {
        name
        for name, annotation in inspect.get_annotations(contract).items()
        if "ClassVar" in str(annotation) and not hasattr(contract, name)
    }
    for name in sorted(declared):
        value = getattr(cls, name, None)
        if name in ("joints", "channels") and isinstance(value, property):
            continue  # static fields decide them
        if name in wanted:
            item = wanted[name]
            if not (isinstance(value, tuple) and value and all(isinstance(part, item) for part in value)):
                yield f"{name}: expected a tuple of {item.__name__}, found {value!r}"
            elif name == "extensions" and not all(ext.startswith(".") and ext == ext.lower() for ext in value):
                yield f"extensions: expected lower case with the dot, as in ('.map',), found {value!r}"
        elif name == "unit" and not isinstance(value, str):
            yield f"unit: expected a text such as 'm', found {value!r}"
        elif value is None:
            yield f"{name}: expected it to be set on the class, found nothing"
