"""Writes docs/reference/python.md: every public name of amorsim, from docstrings and signatures.

Run it after a change of a public class, function or docstring; a test says when that was forgotten::

    python tools/make_python_reference.py

The groups of names and the examples stand in `tools/python_reference.toml`.
"""

from __future__ import annotations

import ast
import importlib
import inspect
import re
import textwrap
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import attrs

import amorsim as am
from amorsim.core.parameters import describe
from amorsim.plugins.manager import make_registry
from amorsim.plugins.registry import KINDS

__all__ = ["PAGE", "page"]

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "reference" / "python.md"
GROUPS = ROOT / "tools" / "python_reference.toml"

_WIDTH = 100
_SECTION = re.compile(r"^(Parameters|Attributes|Returns|Yields|Raises|Notes)\n-+$", re.MULTILINE)


class Raw:
    """An annotation that is shown as it was written."""

    def __init__(self, text: str) -> None:
        self.text = text

    def __repr__(self) -> str:
        return self.text


class Field(NamedTuple):
    """A field of a class, as the page shows it."""

    name: str
    kind: str
    default: str
    meaning: str


# ------------------------------------------------------------------------------------------------------- signatures


def _raw(annotation: Any) -> Any:
    return Raw(annotation) if isinstance(annotation, str) else annotation


def _signature(function: Any, *, drop_first: bool) -> inspect.Signature:
    found = inspect.signature(function)
    given = list(found.parameters.values())[1 if drop_first else 0 :]
    shown = [parameter.replace(annotation=_raw(parameter.annotation)) for parameter in given]
    return found.replace(parameters=shown, return_annotation=_raw(found.return_annotation))


def _call(name: str, function: Any, *, drop_first: bool = False) -> str:
    """A signature, on one line or with one argument a line."""
    signature = _signature(function, drop_first=drop_first)
    line = f"{name}{signature}".replace("=NOTHING", "=...")
    if len(line) <= _WIDTH:
        return line
    parts = re.fullmatch(r"\((.*)\)", str(signature.replace(return_annotation=inspect.Signature.empty)), re.DOTALL)
    assert parts is not None
    inside = []
    last = None
    for parameter in signature.parameters.values():
        if parameter.kind is parameter.KEYWORD_ONLY and last not in (parameter.KEYWORD_ONLY, parameter.VAR_POSITIONAL):
            inside.append("*")
        last = parameter.kind
        inside.append(str(parameter).replace("=NOTHING", "=...").replace("= NOTHING", "= ..."))
    result = signature.return_annotation
    arrow = "" if result is inspect.Signature.empty else f" -> {inspect.formatannotation(result)}"
    return "\n".join([f"{name}(", *(f"    {one}," for one in inside), f"){arrow}"])


# ------------------------------------------------------------------------------------------------------- docstrings


def _prose(text: str, *, keep_examples: bool) -> str:
    """Docstring text as Markdown: single backticks, and examples as indented code or left out."""
    parts = re.split(r"^::\n\n((?:(?: {4}.*)?\n)+)", text + "\n", flags=re.MULTILINE)
    kept = [part for place, part in enumerate(parts) if place % 2 == 0 or keep_examples]
    return re.sub(r"\n{3,}", "\n\n", "".join(kept).replace("``", "`").replace("::\n", ":\n")).strip()


def _items(text: str) -> Iterator[tuple[str, str]]:
    """The entries of a section: what stands at the margin, and the text below it."""
    name, lines = "", list[str]()
    for line in [*text.strip("\n").split("\n"), "end"]:
        if line and not line.startswith(" "):
            if name:
                yield name, " ".join(" ".join(lines).split()).replace("``", "`")
            name, lines = line, []
        else:
            lines.append(line)


def _doc(thing: Any, indent: str = "", *, has_example: bool = False) -> list[str]:
    """A docstring as lines of Markdown: its prose, then the entries of its sections as lists."""
    text = inspect.getdoc(thing) or ""
    pieces = _SECTION.split(text)
    lines = _prose(pieces[0], keep_examples=not has_example and not indent).split("\n")
    for title, body in zip(pieces[1::2], pieces[2::2], strict=True):
        if title in ("Notes", "Returns", "Yields"):
            lines += ["", f"{title}: " + " ".join(body.split()).replace("``", "`")]
            continue
        word = {"Raises": "Raises "}.get(title, "")
        lines += ["", *(f"- {word}`{name}`: {about}" for name, about in _items(body))]
    return [f"{indent}{line}".rstrip() for line in lines]


# ----------------------------------------------------------------------------------------------------------- fields


def _source(cls: type) -> tuple[ast.ClassDef | None, list[str]]:
    try:
        text = textwrap.dedent(inspect.getsource(cls))
    except (OSError, TypeError):
        return None, []
    found = ast.parse(text).body[0]
    return (found if isinstance(found, ast.ClassDef) else None), text.split("\n")


def _comment(node: ast.AnnAssign, following: ast.stmt | None, lines: list[str]) -> str:
    """What the source says of a field: in comments at its end or before it, or in a text after it."""
    if isinstance(following, ast.Expr) and isinstance(following.value, ast.Constant):
        return " ".join(str(following.value.value).split())
    own = lines[node.lineno - 1 : node.end_lineno]
    found = [match[1] for line in own if (match := re.search(r"\s# (.*)$", line))]
    above = node.lineno - 2
    while not found and above >= 0 and lines[above].strip().startswith("# "):
        found = [lines[above].strip()[2:]]
        above -= 1
    return " ".join(found)


def _fields(cls: type) -> list[Field]:
    """Fields of a class and its bases, in order."""
    parameters = describe(cls) if attrs.has(cls) else {}
    found: dict[str, Field] = {}
    for base in reversed([base for base in cls.__mro__ if base.__module__.startswith("amorsim")]):
        node, lines = _source(base)
        body = node.body if node is not None else []
        for place, one in enumerate(body):
            if not isinstance(one, ast.AnnAssign) or not isinstance(one.target, ast.Name):
                continue
            name = one.target.id
            if name.startswith("_"):
                continue
            kind = re.sub(r"^ClassVar\[(.*)\]$", r"\1", ast.unparse(one.annotation))
            default = "" if one.value is None else ast.unparse(one.value)
            about = _comment(one, body[place + 1] if place + 1 < len(body) else None, lines)
            if name in parameters:
                parameter = parameters[name]
                default = "" if parameter.is_required else _short(parameter.default)
                about = parameter.help or about
                unit = f" [{parameter.unit}]" if parameter.unit and parameter.unit != "sensor" else ""
                kind = f"{kind}{unit}" + (f", {parameter.bounds}" if parameter.bounds else "")
            found[name] = Field(name, kind, default, about.replace("``", "`"))
    return list(found.values())


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 40 else "..."


def _cell(text: str) -> str:
    return text.replace("|", r"\|")


def _table(fields: list[Field]) -> list[str]:
    lines = ["| field | type | default | meaning |", "|---|---|---|---|"]
    for name, kind, default, meaning in fields:
        shown = f"`{_cell(default)}`" if default else ""
        lines.append(f"| `{name}` | {_cell(kind)} | {shown} | {_cell(meaning)} |")
    return lines


# ---------------------------------------------------------------------------------------------------------- entries


def _methods(cls: type, fields: set[str]) -> Iterator[tuple[str, Any]]:
    """Public methods and properties, those of bases after a class's own."""
    seen = set(fields)
    for base in cls.__mro__:
        if not base.__module__.startswith("amorsim"):
            continue
        for name, member in vars(base).items():
            plain = member.__func__ if isinstance(member, (classmethod, staticmethod)) else member
            if name.startswith("_") or name in seen or not (inspect.isfunction(plain) or isinstance(plain, property)):
                continue
            seen.add(name)
            yield name, member


def _method(name: str, member: Any) -> list[str]:
    if isinstance(member, property):
        result = _signature(member.fget, drop_first=True).return_annotation
        shown = "" if result is inspect.Signature.empty else f": {inspect.formatannotation(result)}"
        head, about = f"{name}{shown}", member
    else:
        plain = member.__func__ if isinstance(member, (classmethod, staticmethod)) else member
        is_static = isinstance(member, staticmethod)
        head = " ".join(_call(name, plain, drop_first=not is_static).split()).replace("( ", "(").replace(", )", ")")
        about = plain
    notes = ["class method"] if isinstance(member, classmethod) else []
    notes += ["must be written"] if getattr(member, "__isabstractmethod__", False) else []
    tail = f" ({', '.join(notes)})" if notes else ""
    return [f"- `{head}`{tail}", "", *_doc(about, "  "), ""]


def _entry(title: str, thing: Any, settings: dict[str, Any]) -> list[str]:
    """One name: heading, signature, docstring, fields, methods, example."""
    name = title.rpartition(".")[2]
    lines = [f"### `{title}`", ""]
    example = settings.get("examples", {}).get(name)
    if text := settings.get("texts", {}).get(name):
        lines += [text, ""]
    elif inspect.isclass(thing):
        lines += _class(name, thing, has_example=example is not None)
    else:
        lines += ["```py", _call(name, thing), "```", "", *_doc(thing, has_example=example is not None), ""]
    if example is not None:
        lines += ["```python", example["code"].strip("\n"), "```", ""]
        if output := example.get("output"):
            lines += ["```text", output.strip("\n"), "```", ""]
    return lines


def _class(name: str, cls: type, *, has_example: bool) -> list[str]:
    fields = _fields(cls)
    lines = []
    if issubclass(cls, Exception):
        bases = ", ".join(f"`{base.__name__}`" for base in cls.__bases__)
        lines += [f"A subclass of {bases}.", ""]
    is_made_of_fields = attrs.has(cls) or issubclass(cls, tuple) or Protocol in cls.__bases__
    if not is_made_of_fields and not inspect.isabstract(cls) and "__init__" in vars(cls):
        lines += ["```py", _call(name, cls.__init__, drop_first=True).removesuffix(" -> None"), "```", ""]
    lines += [*_doc(cls, has_example=has_example), ""]
    if fields:
        lines += [*_table(fields), ""]
    for method, member in _methods(cls, {field.name for field in fields}):
        lines += _method(method, member)
    return lines


def _package(name: str) -> list[str]:
    """The built-in components of a package, each with a line and a link to its page."""
    registry = make_registry(entry_points=[])
    module = getattr(am, name)
    lines = [f"### `amorsim.{name}`", "", *_doc(module), "", "| class | in a file | what it is |", "|---|---|---|"]
    for public in module.__all__:
        thing = getattr(module, public)
        known = [registry.name_of(kind, thing) for kind in KINDS] if inspect.isclass(thing) else []
        used = next((found for found in known if found), None)
        link = f"[`{used}`](components.md#{used})" if used else ""
        about = (inspect.getdoc(thing) or "").split("\n")[0].replace("``", "`")
        lines.append(f"| `{public}` | {link} | {_cell(about)} |")
    return [*lines, ""]


def _check_complete(groups: list[dict[str, Any]]) -> None:
    grouped = [name for group in groups for name in group.get("names", [])]
    grouped += [name for group in groups for name in group.get("packages", [])]
    missing = sorted(set(_plain_names()) - set(grouped) - {"analysis", "testing"})
    unknown = sorted(set(grouped) - set(am.__all__))
    if missing or unknown:
        raise SystemExit(f"{GROUPS.name}: put {missing} into a group; no such names: {unknown}")


def _plain_names() -> Iterator[str]:
    return (name for name in am.__all__ if not _is_error(getattr(am, name)))


def _is_error(thing: Any) -> bool:
    return inspect.isclass(thing) and issubclass(thing, Exception)


def page() -> str:
    """The whole page."""
    settings = tomllib.loads(GROUPS.read_text(encoding="utf-8"))
    groups = settings["groups"]
    _check_complete(groups)
    lines = [settings["head"].strip("\n"), ""]
    lines += [f"- [{group['title']}](#{group['title'].lower().replace(' ', '-')})" for group in groups]
    for group in groups:
        lines += ["", f"## {group['title']}", "", group["about"].strip("\n"), ""]
        for name in group.get("names", []):
            lines += _entry(f"am.{name}", getattr(am, name), settings)
        if group.get("errors"):
            for name in sorted(am.__all__):
                if _is_error(getattr(am, name)):
                    lines += _entry(f"am.{name}", getattr(am, name), settings)
        for name in group.get("packages", []):
            lines += _package(name)
        for path in group.get("from", []):
            module, _, name = path.rpartition(".")
            lines += _entry(path, getattr(importlib.import_module(module), name), settings)
    parts = "\n".join(lines).split("```")
    parts[::2] = [re.sub(r"\n{3,}", "\n\n", text) for text in parts[::2]]  # not the code between
    return "```".join(parts).rstrip("\n") + "\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
