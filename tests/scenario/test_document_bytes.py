"""Documents keep every byte that a change is not about: random files and changes, and all files that ship."""

from __future__ import annotations

import copy
import difflib
import tomllib
from pathlib import Path

import pytest
from hypothesis import HealthCheck, assume, given
from hypothesis import strategies as st

import amorsim as am
from amorsim.scenario.documents.document import Document, open_document
from amorsim.scenario.toml.literals import are_same, as_toml, keys_as_toml, parse
from tests.examples import settings
from tests.some_cases import one_in

ROOT = Path(__file__).resolve().parents[2]
FILES = sorted(
    [*(ROOT / "amorsim").rglob("*.toml"), *(ROOT / "plugins_example").rglob("*.toml"), *(ROOT / "docs").rglob("*.toml")]
)

KEYS = st.sampled_from(["a", "b", "c", "use-d", "3", "a b", "x.y", "", "ü", "name"])
SCALARS = st.one_of(
    st.integers(-(10**6), 10**6),
    st.floats(allow_nan=False),
    st.booleans(),
    st.text(st.characters(exclude_categories=("Cs",)), max_size=6),
    st.dates(),
)


VALUES = st.recursive(
    SCALARS,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(KEYS, inner, max_size=3),
    max_leaves=6,
)
TABLES = st.dictionaries(KEYS, VALUES, max_size=4)
SPACES = st.sampled_from(["", " ", "  ", "\t"])
COMMENTS = st.sampled_from(["", "", " # why", "# [x] = {"])


@st.composite
def spelt(draw: st.DrawFn, value: object, *, is_line: bool = False) -> str:
    """A value as an author may write it."""
    if isinstance(value, list):
        items = [draw(spelt(item, is_line=is_line)) for item in value]
        if not is_line and draw(st.booleans()):
            inside = "".join(
                f"{draw(st.sampled_from(['', '  # of [the] next', '']))}\n    {item},{draw(COMMENTS)}" for item in items
            )
            if draw(st.booleans()) and items:
                inside = inside[: inside.rindex(",")] + draw(st.sampled_from(["", " # last"]))
            return f"[{inside}\n]"
        comma = draw(st.sampled_from(["", ",", " , "])) if items else ""
        return f"[{draw(SPACES)}{f',{draw(SPACES)}'.join(items)}{comma}]"
    if isinstance(value, dict):
        pairs = []
        for key, item in value.items():
            if isinstance(item, dict) and item and draw(st.booleans()):
                pairs += [
                    f"{keys_as_toml((key, inner))}{draw(SPACES)}={draw(SPACES)}{draw(spelt(each, is_line=True))}"
                    for inner, each in item.items()
                ]
            else:
                pairs.append(f"{keys_as_toml((key,))} = {draw(spelt(item, is_line=True))}")
        return f"{{{draw(SPACES)}{f',{draw(SPACES)}'.join(pairs)}{draw(SPACES)}}}"
    if isinstance(value, str) and draw(st.booleans()):
        if "'" not in value and value.isprintable():
            return f"'{value}'"
        if not is_line and "'''" not in value and value.isprintable() and not value.endswith("'"):
            return f"'''\n{value}'''"
    if type(value) is int and abs(value) > 999 and draw(st.booleans()):
        return f"{value:_}"
    if type(value) is float and value == int(value if abs(value) < 1e9 else 0.5) and draw(st.booleans()):
        return f"{value:.3f}"
    return as_toml(value)


@st.composite
def body(draw: st.DrawFn, table: dict[str, object], path: tuple[str, ...]) -> str:
    """A table's pairs, and below them its tables, each in one of the ways that there are."""
    lines, below = [], []
    indent = draw(SPACES)
    for key, value in table.items():
        lines += draw(st.lists(st.sampled_from(["\n", "# a comment\n", "  \n"]), max_size=1))
        keys = keys_as_toml((key,))
        how = draw(st.sampled_from(["inline", "header", "dotted"])) if isinstance(value, dict) else "inline"
        is_tables = isinstance(value, list) and value and all(isinstance(item, dict) for item in value)
        if is_tables and draw(st.booleans()):
            name = keys_as_toml((*path, key))
            below += [f"[[{name}]]{draw(COMMENTS)}\n{draw(body(item, (*path, key)))}" for item in value]
        elif how == "header":
            name = keys_as_toml((*path, key))
            is_super = value and all(isinstance(item, dict) and item for item in value.values())
            if is_super and draw(st.booleans()):
                text = "".join(
                    f"[{keys_as_toml((*path, key, inner))}]\n{draw(body(item, (*path, key, inner)))}"
                    for inner, item in value.items()
                )
            else:
                text = f"[ {name} ]{draw(COMMENTS)}\n{draw(body(value, (*path, key)))}"
            below.append(draw(st.sampled_from(["", "\n", "# of the next\n", "\n# of the next\n"])) + text)
        elif how == "dotted" and value:
            lines += [
                f"{indent}{keys}{draw(SPACES)}.{keys_as_toml((inner,))} = {draw(spelt(item))}{draw(COMMENTS)}\n"
                for inner, item in value.items()
            ]
        else:
            lines.append(f"{indent}{keys}{draw(SPACES)}={draw(SPACES)}{draw(spelt(value))}{draw(COMMENTS)}\n")
    return "".join(lines + below)


@st.composite
def texts(draw: st.DrawFn) -> str:
    """Files of TOML in every style."""
    text = draw(st.sampled_from(["", "# first\n", "\n"])) + draw(body(draw(TABLES), ()))
    if draw(st.booleans()):
        text = text.removesuffix("\n")
    if draw(st.integers(0, 3)) == 0:
        text = text.replace("\r", "").replace("\n", "\r\n")
    if draw(st.integers(0, 5)) == 0:
        text = "\N{BOM}" + text
    return text


def places(value: object, path: tuple[str | int, ...] = ()) -> list[tuple[tuple[str | int, ...], object]]:
    """Every path in a value, with what is there."""
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [(path, value), *(found for key, item in inner for found in places(item, (*path, key)))]


def pruned(value: object) -> object:
    """Without empty tables and lists, which dotted keys and headers that went cannot leave behind."""
    if isinstance(value, dict):
        found = {key: pruned(item) for key, item in value.items()}
        return {key: item for key, item in found.items() if item not in ({}, [])}
    return [pruned(item) for item in value] if isinstance(value, list) else value


def holder(values: object, path: tuple[str | int, ...]) -> object:
    for part in path[:-1]:
        values = values[part]
    return values


@st.composite
def changes(draw: st.DrawFn, values: dict[str, object]) -> tuple[object, ...]:
    """What to do, and the values after it."""
    path, there = draw(st.sampled_from(places(values)))
    after = copy.deepcopy(values)
    what = draw(st.sampled_from(["set", "new", "remove", "add", "move"]))
    if what == "set" and path:
        value = draw(st.one_of(SCALARS, VALUES))
        holder(after, path)[path[-1]] = value
        return "set", path, value, after
    if what == "new" and isinstance(there, dict):
        key, value = draw(KEYS), draw(VALUES)
        more = draw(st.lists(KEYS, max_size=2)) if key not in there else []
        for each in reversed(more):
            value = {each: value}
        holder(after, (*path, key))[key] = value
        for each in more:
            value = value[each]
        return "set", (*path, key, *more), value, after
    if what == "remove" and path:
        del holder(after, path)[path[-1]]
        return "remove", path, None, after
    if what == "add" and isinstance(there, list):
        value, place = draw(VALUES), draw(st.integers(0, len(there)))
        holder(after, (*path, 0)).insert(place, value)
        return "add", path, (value, place), after
    if what == "move" and path and isinstance(path[-1], int):
        items = holder(after, path)
        place = draw(st.integers(0, len(items) - 1))
        items.insert(place, items.pop(path[-1]))
        return "move", path, place, after
    return "none", (), None, after


def make(document: Document, change: tuple[object, ...]) -> None:
    what, path, value, _ = change
    if what == "set":
        document.set(path, value)
    elif what == "remove":
        document.remove(path)
    elif what == "add":
        document.add(path, *value)
    elif what == "move":
        document.move(path, value)


RANDOM = settings(
    max_examples=200, deadline=None, suppress_health_check=[HealthCheck.filter_too_much, HealthCheck.too_slow]
)


@RANDOM
@given(st.data())
def test_a_change_does_what_it_says_and_taking_it_back_leaves_the_same_bytes(data: st.DataObject) -> None:
    text = data.draw(texts())
    try:
        values = parse(text.removeprefix("\N{BOM}"))
    except tomllib.TOMLDecodeError:
        assume(False)
    document = Document(text, "random.toml")
    assert document.text == text
    seen = [text]
    for _ in range(data.draw(st.integers(1, 3))):
        change = data.draw(changes(values))
        make(document, change)
        found = parse(document.text.removeprefix("\N{BOM}"))
        assert are_same(pruned(found), pruned(change[-1])), (seen[-1], change, document.text)
        values = found
        if document.text != seen[-1]:
            seen.append(document.text)
    for before in reversed(seen[:-1]):
        assert document.undo()
        assert document.text == before
    assert not document.undo()
    for after in seen[1:]:
        assert document.redo()
        assert document.text == after
    assert not document.redo()


@RANDOM
@given(st.data())
def test_another_value_changes_its_own_line_only(data: st.DataObject) -> None:
    text = data.draw(texts())
    try:
        values = parse(text.removeprefix("\N{BOM}"))
    except tomllib.TOMLDecodeError:
        assume(False)
    scalars = [(path, value) for path, value in places(values) if not isinstance(value, (dict, list))]
    assume(scalars)
    path, _ = data.draw(st.sampled_from(scalars))
    document = Document(text, "random.toml")
    document.set(path, data.draw(SCALARS))
    before, after = text.splitlines(keepends=True), document.text.splitlines(keepends=True)
    kinds = [kind for kind, *_ in difflib.SequenceMatcher(None, before, after, autojunk=False).get_opcodes()]
    assert len([kind for kind in kinds if kind != "equal"]) <= 1


@pytest.mark.parametrize("path", one_in(4, FILES), ids=lambda path: path.stem)
def test_every_file_that_ships_can_be_changed_anywhere_and_back(path: Path, tmp_path: Path) -> None:
    data = path.read_bytes()
    file = tmp_path / path.name
    file.write_bytes(data)
    assert open_document(file).save() == file
    assert file.read_bytes() == data
    document = Document(data.decode(), path)
    values = parse(data.decode())
    found = places(values)[1:]
    for at, there in found[:: len(found) // 50 + 1]:
        if not isinstance(there, (dict, list)) and at[-1] != "use":
            document.set(at, "another")
            after = copy.deepcopy(values)
            holder(after, at)[at[-1]] = "another"
            assert parse(document.text) == after
            pairs = zip(data.decode().splitlines(), document.text.splitlines(), strict=True)
            assert sum(before != now for before, now in pairs) == 1
            document.undo()
        document.remove(at)
        after = copy.deepcopy(values)
        del holder(after, at)[at[-1]]
        assert pruned(parse(document.text)) == pruned(after), at
        left = document.text.splitlines()
        kinds = {kind for kind, *_ in difflib.SequenceMatcher(None, data.decode().splitlines(), left).get_opcodes()}
        assert kinds <= {"equal", "delete", "replace"}
        document.undo()
        assert document.text.encode() == data


@settings(RANDOM, max_examples=60)
@given(st.data())
def test_what_is_in_a_table_moves_whole_or_stays_where_it_is(data: st.DataObject) -> None:
    text = data.draw(texts())
    try:
        values = parse(text.removeprefix("\N{BOM}"))
    except tomllib.TOMLDecodeError:
        assume(False)
    keyed = [path for path, _ in places(values) if path and isinstance(path[-1], str)]
    assume(keyed)
    path = data.draw(st.sampled_from(keyed))
    keys = list(holder(values, path))
    place = data.draw(st.integers(0, len(keys) - 1))
    document = Document(text, "random.toml")
    try:
        document.move(path, place)
    except am.DocumentError:  # as a pair below a header would be that table's
        assert document.text == text
        return
    found = parse(document.text.removeprefix("\N{BOM}"))
    assert are_same(found, values)
    keys.insert(place, keys.pop(keys.index(path[-1])))
    assert list(holder(found, path)) == keys
    document.undo()
    assert document.text == text
