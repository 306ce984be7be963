"""The content of a Stage world: its models, with macros filled in."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import attrs

from amorsim.core.errors import did_you_mean
from amorsim.foreign.stage.tokens import Place, Token, fault_at, read_tokens

__all__ = ["TYPES", "Model", "Value", "World", "read_world"]

MOST_MODELS = 200_000
"""Most models, sensors and blocks that a world may have, all macros filled in."""
MOST_DEPTH = 60

TYPES = (
    *("model", "position", "floorplan", "zone", "puck", "charger"),
    *("ranger", "laser", "sensor", "fiducial", "fiducialfinder", "bumper", "block"),
    *("blobfinder", "camera", "gripper", "actuator", "lightindicator", "blinkenlight", "speech", "wifi", "loadcell"),
    *("window", "camera3d", "power_pack", "powerpack"),
)
"""What Stage's own types of models are called, and those of its usual ``.inc`` files."""


class Value(NamedTuple):
    """The value of a key: one word or text, or those in brackets."""

    items: tuple[str, ...]
    place: Place


@attrs.frozen(eq=False)
class Model:
    """A model of the world or in another model, a sensor of a ranger, or a block: macros are filled in.

    `kind` is one of `TYPES`, `called` the macro or type that the file names. `size` counts it and all in it.
    """

    kind: str
    called: str
    values: Mapping[str, Value]
    inner: tuple[Model, ...]
    place: Place
    size: int
    said: tuple[Any, ...] = attrs.field(init=False)
    """Its words and all in it, wherever the lines break."""

    @said.default
    def _all_said(self) -> tuple[Any, ...]:
        return self.said_but()

    def said_but(self, *keys: str) -> tuple[Any, ...]:
        """The same without some keys of its own."""
        return (
            self.kind,
            tuple((key, value.items) for key, value in self.values.items() if key not in keys),
            tuple(each.said for each in self.inner),
        )


@attrs.frozen(eq=False)
class World:
    """A world: its entries at the top, its models in order, and the files that it was read from."""

    values: Mapping[str, Value]
    models: tuple[Model, ...]
    files: tuple[Path, ...]


@attrs.define(eq=False)
class _Entity:
    """A model as it is written: of a type or a macro."""

    kind: str
    place: Place
    values: dict[str, Value] = attrs.field(factory=dict)
    inner: list[_Entity] = attrs.field(factory=list)


def read_world(path: Path) -> World:
    """The world in a file.

    Raises
    ------
    ScenarioError
        With the file and the line of what is wrong.
    """
    tokens = read_tokens(path)
    parser = _Parser(tokens.tokens)
    parser.parse()
    return World(parser.values, tuple(parser.models), tokens.files)


class _Parser:
    """Reads statements; a macro is filled in where it is used, as it is at that place."""

    def __init__(self, tokens: list[Token]) -> None:
        self._tokens = tokens
        self._at = 0
        self._macros: dict[str, _Entity] = {}
        self._filled: dict[int, tuple[_Entity, Model]] = {}  # with the entity, whose id is then nobody else's
        self._count = 0
        self.values: dict[str, Value] = {}
        self.models: list[Model] = []

    def parse(self) -> None:
        """Read all statements."""
        while self._at < len(self._tokens):
            token = self._next("a key, a model or define")
            if token.kind != "word":
                raise fault_at(token.place, f"expected a key, a model or define, got {token.text!r}")
            if token.text == "define":
                self._define(token)
            elif self._peek() == "(":
                model = self._fill(self._entity(token), 0)
                self._count += model.size
                if self._count > MOST_MODELS:
                    raise fault_at(token.place, f"there are more than {MOST_MODELS} models, macros filled in")
                self.models.append(model)
            else:
                self.values[token.text] = self._value(token)

    def _next(self, what: str) -> Token:
        if self._at >= len(self._tokens):
            last = self._tokens[-1]
            raise fault_at(last.place, f"expected {what} after {last.text!r}, got the end of the file")
        self._at += 1
        return self._tokens[self._at - 1]

    def _peek(self) -> str:
        return self._tokens[self._at].kind if self._at < len(self._tokens) else ""

    def _define(self, define: Token) -> None:
        name, base = self._next("a name"), self._next("a type")
        if name.kind != "word" or base.kind != "word" or self._peek() != "(":
            raise fault_at(define.place, "expected define NEW TYPE ( ... )")
        self._macros[name.text] = self._entity(base)
        self._filled.clear()  # what was filled in may have used the macro of that name before

    def _entity(self, head: Token) -> _Entity:
        """The model that begins with a type and an opening bracket, with all that is in it."""
        top = _Entity(head.text, head.place)
        self._at += 1
        within = [top]
        while within:
            token = self._next(f"')' for the '(' of line {within[-1].place.line}")
            if token.kind == ")":
                within.pop()
            elif token.kind != "word":
                raise fault_at(token.place, f"expected a key, a model or ')', got {token.text!r}")
            elif self._peek() == "(":
                if len(within) >= MOST_DEPTH:
                    raise fault_at(token.place, f"models are nested deeper than {MOST_DEPTH}")
                inner = _Entity(token.text, token.place)
                within[-1].inner.append(inner)
                within.append(inner)
                self._at += 1
            else:
                within[-1].values[token.text] = self._value(token)
        return top

    def _value(self, key: Token) -> Value:
        token = self._next(f"a value for {key.text}")
        if token.kind in ("word", "text"):
            return Value((token.text,), key.place)
        if token.kind != "[":
            raise fault_at(key.place, f"expected {key.text} with a value, got {token.text!r}")
        items: list[str] = []
        while (token := self._next(f"']' for the '[' of {key.text} in line {key.place.line}")).kind != "]":
            if token.kind not in ("word", "text"):
                raise fault_at(token.place, f"expected a number or ']' for {key.text}, got {token.text!r}")
            items.append(token.text)
        return Value(tuple(items), key.place)

    def _fill(self, entity: _Entity, depth: int) -> Model:
        """A model with its macros inserted: entries and children of a macro come first."""
        known = self._filled.get(id(entity))
        if known is not None:
            return known[1]
        if depth > MOST_DEPTH:
            raise fault_at(entity.place, f"{entity.kind} is nested deeper than {MOST_DEPTH}, or holds itself")
        layers, kind, seen = [entity], entity.kind, set[str]()
        while kind in self._macros and not (kind in seen and kind in TYPES):
            if kind in seen:
                raise fault_at(entity.place, f"{kind!r} is defined by itself")
            seen.add(kind)
            layers.append(self._macros[kind])
            kind = layers[-1].kind
        if kind not in TYPES:
            hint = did_you_mean(kind, (*TYPES, *self._macros))
            raise fault_at(entity.place, f"there is no type of model called {kind!r}, nor a macro.{hint}")
        values: dict[str, Value] = {}
        inner: list[Model] = []
        size = 1
        for layer in reversed(layers):
            values.update(layer.values)
            for each in layer.inner:
                inner.append(self._fill(each, depth + 1))
                size += inner[-1].size
                if size > MOST_MODELS:
                    raise fault_at(each.place, f"{entity.kind} holds more than {MOST_MODELS} models, macros filled in")
        model = Model(kind, entity.kind, values, tuple(inner), entity.place, size)
        if depth:
            self._filled[id(entity)] = entity, model
        return model
