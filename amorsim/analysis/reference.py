"""The manual of a component, made from its class: for ``amorsim plugins show`` and for the reference pages."""

from __future__ import annotations

import inspect
import math
from typing import Any

import attrs

from amorsim.core.parameters import Parameter, describe
from amorsim.plugins.registry import Entry, Registry

__all__ = ["manual", "manual_parts", "reference_page", "summary_of"]

FILES = ("robot", "device", "scenario")  # kinds that are registered as files


def summary_of(registry: Registry, entry: Entry) -> str:
    """The description of a registered thing, in a line."""
    if entry.kind in FILES:
        text = registry.file(entry.kind, entry.name).read_text(encoding="utf-8")
        return text.split("\n")[0].lstrip("# ").rstrip()
    return _text(registry.get(entry.kind, entry.name)).split("\n")[0]


def _text(cls: type) -> str:
    """A class's docstring without the section on its parameters, which the fields describe better."""
    return (inspect.getdoc(cls) or "").split("\nParameters\n")[0].rstrip()


def manual(registry: Registry, entry: Entry) -> str:
    """The manual of a registered component as plain text; a model or scenario is a file, its own manual."""
    lines = [f"{entry.kind.replace('_', ' ')} {entry.name}  [{entry.plugin}]", ""]
    if entry.kind in FILES:
        path = registry.file(entry.kind, entry.name)
        return "\n".join([*lines, str(path), "", path.read_text(encoding="utf-8")])
    text, rows = manual_parts(registry, entry)
    lines += [text, ""]
    if not rows:
        return "\n".join([*lines, "It has no fields.", ""])
    widths = [max(len(row[column]) for row in rows) for column in range(3)]
    for row in rows:
        cells = [f"{cell:{width}}" for cell, width in zip(row[:3], widths, strict=True)]
        lines.append("  ".join(["", *cells, row[3]]).rstrip())
    return "\n".join([*lines, ""])


def manual_parts(registry: Registry, entry: Entry) -> tuple[str, list[tuple[str, str, str, str]]]:
    """What a component is, in paragraphs, and of each field its name in files, value, default and meaning."""
    cls = registry.get(entry.kind, entry.name)
    return _text(cls), [_row(parameter) for parameter in _parameters(cls)]


def reference_page(registry: Registry, entry: Entry) -> str:
    """The same of a component as Markdown."""
    text, rows = manual_parts(registry, entry)
    lines = [f"### `{entry.name}`", "", text, ""]
    if not rows:
        return "\n".join([*lines, "No fields.", ""])
    lines += ["| field | value | default | meaning |", "|---|---|---|---|"]
    for name, kind, default, help_ in rows:
        lines.append(f"| `{name}` | {kind} | {default or 'must be given'} | {help_} |")
    return "\n".join([*lines, ""])


def _parameters(cls: type) -> list[Parameter]:
    return list(describe(cls).values())


def _row(parameter: Parameter) -> tuple[str, str, str, str]:
    name = parameter.name + ("_deg" if parameter.is_angle else "")
    unit = parameter.unit.replace("rad", "degrees") if parameter.is_angle else parameter.unit
    if unit == "sensor":
        unit = f"the sensor's unit; {name}_deg, in degrees, for angles"
    kind = parameter.file_type_name + (f" [{unit}]" if unit else "")
    bounds = _in_degrees(parameter).bounds
    kind += f", {bounds}" if bounds else ""
    default = "" if parameter.is_required else _default(parameter)
    fixed = "" if parameter.live else " (fixed once a simulation is made)"
    return name, kind, default, parameter.help + fixed


def _in_degrees(parameter: Parameter) -> Parameter:
    if not parameter.is_angle:
        return parameter
    bounds = {key: getattr(parameter, key) for key in ("gt", "ge", "lt", "le")}
    degrees: dict[str, Any] = {key: None if bound is None else math.degrees(bound) for key, bound in bounds.items()}
    return attrs.evolve(parameter, **degrees)


def _default(parameter: Parameter) -> str:
    value = parameter.default
    if value is None:
        return "none"
    if parameter.component:
        return f"a {type(value).__name__} with its defaults"
    if parameter.is_angle and isinstance(value, (int, float)):
        return f"{math.degrees(value):g}"
    if attrs.has(type(value)):
        parameters = describe(type(value))
        return ", ".join(
            f"{name}_deg {math.degrees(number):g}" if parameters[name].is_angle else f"{name} {number:g}"
            for name, number in attrs.asdict(value).items()
        )
    if isinstance(value, tuple) and value and attrs.has(type(value[0])):
        return "; ".join(_default(attrs.evolve(parameter, default=item)) for item in value)
    return str(value)
