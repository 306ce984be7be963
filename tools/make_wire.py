"""Write what the window's scripts know of the messages: the layout of frames, the names of commands, types of tables.

``python tools/make_wire.py``, after a change of ``scene/wire.py``, of ``shown_faults.py`` or ``mending.py`` in
``faults``, or of ``protocol.py``, ``packing.py`` or ``messages.py`` in ``simulator``, all in ``amorsim/ui``. A test
says when it was forgotten.
"""

from __future__ import annotations

import re
import struct
import textwrap
import types
import typing
from collections.abc import Callable, Sequence
from enum import IntFlag
from pathlib import Path
from typing import Any

from amorsim.ui.faults import mending, shown_faults
from amorsim.ui.scene import wire as scenes
from amorsim.ui.simulator.frames import packing, protocol
from amorsim.ui.simulator.frames.messages import COMMANDS

FOLDER = Path(__file__).parent.parent / "amorsim" / "ui" / "web" / "simulator"
HEAD = "// Made by tools/make_wire.py from what amorsim/ui/{scene, simulator, faults} say: change it there.\n"
LONGEST = 120  # letters of a line
NO_BREAK = "\N{NO-BREAK SPACE}"
READERS = {"I": "Uint32", "i": "Int32", "f": "Float32", "d": "Float64"}
ARRAYS = {"f8": "Float64Array", "f4": "Float32Array", "u1": "Uint8Array"}
PLAIN = {str: "string", int: "number", float: "number", bool: "boolean", types.NoneType: "null", Any: "any"}


def camel(name: str) -> str:
    """A name as scripts have it."""
    return re.sub(r"_(\w)", lambda match: match[1].upper(), name.lower())


def flags_of(name: str, flags: type[IntFlag]) -> str:
    """A table of flags."""
    entries = ", ".join(f"{camel(flag.name or '')}: {flag.value}" for flag in flags)
    return f"export const {name} = {{ {entries} }};"


def type_of(hint: Any) -> str:
    """A type as TypeScript has it."""
    if hint in PLAIN:
        return PLAIN[hint]
    origin, inner = typing.get_origin(hint), typing.get_args(hint)
    if origin is list:
        one = type_of(inner[0])
        return f"({one})[]" if "|" in one else f"{one}[]"
    if origin in (types.UnionType, typing.Union):
        return " | ".join(type_of(one) for one in inner)
    if typing.is_typeddict(hint):
        return str(hint.__name__)
    raise TypeError(f"no type of scripts is known for {hint!r}")


def interface(name: str, about: str, fields: Sequence[tuple[str, str]]) -> str:
    """The declaration of a table's type, of a name and a type for each field."""
    parts = [f"{field}: {kind}" for field, kind in fields]
    line = f"export interface {name} {{ {'; '.join(parts)} }}"
    if len(line) > LONGEST:
        inner = textwrap.wrap("; ".join(part.replace(" ", NO_BREAK) for part in parts), LONGEST - 2)
        line = "\n".join([f"export interface {name} {{", *(f"  {one}" for one in inner), "}"]).replace(NO_BREAK, " ")
    return f"/** {about} */\n{line}\n"


def interface_of(table: Any) -> str:
    """The type of a table."""
    fields = [
        (f"{name}?" if name in table.__optional_keys__ else name, type_of(hint))
        for name, hint in typing.get_type_hints(table).items()
    ]
    return interface(table.__name__, (table.__doc__ or "").splitlines()[0], fields)


def frame_interface() -> str:
    """The type of a frame, as `readFrame` makes it of its bytes."""
    numbers = [(camel(name), "number") for name, form in packing.HEADER if form in READERS]
    arrays = [(camel(name), ARRAYS[form]) for name, form, _, _ in packing.BLOCKS]
    sensors = ("sensors", "{true: Float64Array, measured: Float64Array, age: number}[]")
    return interface("Frame", "A moment, of one robot all; `sensors` are its readings.", [*numbers, *arrays, sensors])


def declarations() -> str:
    """The types of messages."""
    modules = (scenes, protocol, shown_faults, mending)
    tables = [one for module in modules for name in module.__all__ if typing.is_typeddict(one := getattr(module, name))]
    names = textwrap.wrap(" | ".join(f'"{name}"' for name in COMMANDS), LONGEST - 2)
    command = "\n".join(["export type CommandName =", *(f"  {one}" for one in names)])
    return "\n".join(
        [
            HEAD,
            frame_interface(),
            f"{command};\n",
            interface("Command", "What a window asks for.", [("do", "CommandName"), ("[key: string]", "unknown")]),
            *map(interface_of, tables),
        ]
    )


def script() -> str:
    """The layout of frames."""
    fields, at = [], 0
    for name, form in packing.HEADER:
        if form in READERS:
            fields.append(f'  ["{camel(name)}", "{READERS[form]}", {at}],')
        at += struct.calcsize(f"<{form}")
    blocks = [
        f'  ["{camel(name)}", {ARRAYS[form]}, "{camel(counted)}", {each}],'
        for name, form, counted, each in packing.BLOCKS
    ]
    constructor = " | ".join(f"{kind}Constructor" for kind in ARRAYS.values())
    magic = int.from_bytes(packing.MAGIC, "little")
    parts = [
        HEAD,
        "/** How the simulation stands in a frame. */\n" + flags_of("FLAG", packing.FrameFlag),
        "\n/** How a robot stands in a frame. */\n" + flags_of("ROBOT", packing.RobotFlag),
        f"\nexport const MAGIC = {magic:#x}; // the first four bytes, little endian",
        f"export const HEADER_SIZE = {packing.FRAME_HEADER.size}; // bytes",
        "\n/** Where the numbers of a frame's header lie: name, kind, byte.",
        ' * @type {[string, "Uint32" | "Int32" | "Float32" | "Float64", number][]} */',
        "export const HEADER = [",
        *fields,
        "];",
        "\n/** What follows it: name, kind, which number of the header counts it, how many for each.",
        f" * @type {{[string, {constructor}, string, number][]}} */",
        "export const BLOCKS = [",
        *blocks,
        "];\n",
    ]
    return "\n".join(parts)


FILES: dict[str, Callable[[], str]] = {"wire.js": script, "messages.d.ts": declarations}


if __name__ == "__main__":
    for file, text in FILES.items():
        (FOLDER / file).write_text(text(), encoding="utf-8")
