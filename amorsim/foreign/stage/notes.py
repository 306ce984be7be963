"""Notes taken while a Stage world is read: values of keys, faults, and what is left out."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

from amorsim.core.errors import Fault, ScenarioError, did_you_mean
from amorsim.foreign.stage.entities import Model, Value
from amorsim.foreign.stage.tokens import Place
from amorsim.foreign.text import NUMBER

__all__ = ["Notes"]

_MOST = 1e9
_MOST_FAULTS = 50
_MOST_REMARKS = 30

# Of Stage's window, its pace and its threads; nothing that moves or measures depends on them.
_SHOWN_ONLY = re.compile(
    r"gui_.*|trail_.*|show_.*|paused|speedup|threads|interval_real|say|alwayson|disabled|stack_children|data_color|icon|"
    r"event_queues|ppm|power_budget|watts|watts_give|watts_take|joules|joules_capacity|mass|friction|blob_return|"
    r"gripper_return|verbose"
)
_READ_EVERYWHERE = frozenset({"name", "ctrl", "color", "color_rgba", "shape"})


class Notes:
    """Reads the values of keys; an invalid value is a fault, and its default is used to find further faults."""

    def __init__(self) -> None:
        self.faults: list[Fault] = []
        self._remarks: dict[str, str] = {}  # by what they are about, so that each thing is remarked on once
        self._shown_only: dict[str, None] = {}

    def fault(self, place: Place, message: str) -> None:
        """Note a fault in a line, once: a value may be read for several things."""
        fault = Fault(file=str(place.file), path="", line=place.line, message=message)
        if len(self.faults) < _MOST_FAULTS and fault not in self.faults:
            self.faults.append(fault)

    def raise_if_any(self) -> None:
        """Raise a `ScenarioError` if there are faults."""
        if self.faults:
            raise ScenarioError(self.faults)

    def remark(self, about: str, text: str, place: Place | None = None) -> None:
        """Note what is left out or changed, unless that was noted."""
        where = "" if place is None else f"{place.file.name}:{place.line}: "
        self._remarks.setdefault(about, where + text)

    def remark_shown_only(self, key: str) -> None:
        """Note a key that only matters to Stage's window and pace."""
        self._shown_only[key] = None

    @property
    def remarks(self) -> tuple[str, ...]:
        """The remarks, in order; of very many the first, and how many more there are."""
        texts = tuple(self._remarks.values())
        if self._shown_only:
            texts = (f"of Stage's window, pace and power, and left out: {', '.join(self._shown_only)}", *texts)
        if len(texts) <= _MOST_REMARKS:
            return texts
        return (*texts[:_MOST_REMARKS], f"... and {len(texts) - _MOST_REMARKS} remarks more")

    def text(self, values: Mapping[str, Value], key: str, default: str = "") -> str:
        """The value of a key, as a text."""
        value = values.get(key)
        return default if value is None or not value.items else value.items[0]

    def number(self, values: Mapping[str, Value], key: str, default: float) -> float:
        """The number at a key."""
        value = values.get(key)
        if value is None:
            return default
        found = self._numbers(key, value)
        if found is None:
            return default
        if len(found) != 1:
            self.fault(value.place, f"{key}: expected a number, got {len(found)}")
            return default
        return found[0]

    def count(self, values: Mapping[str, Value], key: str, default: int, most: int) -> int:
        """The whole number from 0 to `most` at a key."""
        found = self.number(values, key, default)
        if not (found == int(found) and 0 <= found <= most):
            self.fault(values[key].place, f"{key}: expected a whole number from 0 to {most}, got {found:g}")
            return default
        return int(found)

    def numbers(self, values: Mapping[str, Value], key: str, least: int) -> list[float]:
        """The numbers at a key, at least `least` of them; None if it is missing, or after a fault."""
        value = values.get(key)
        if value is None:
            return []
        found = self._numbers(key, value)
        if found is None:
            return []
        if len(found) < least:
            self.fault(value.place, f"{key}: expected {least} numbers, got {len(found)}")
            return []
        return found

    def _numbers(self, key: str, value: Value) -> list[float] | None:
        found = []
        for item in value.items:
            number = float(item) if NUMBER.fullmatch(item) else math.nan
            if not abs(number) <= _MOST:
                self.fault(value.place, f"{key}: expected a number of at most {_MOST:g}, got {item[:40]!r}")
                return None
            found.append(number)
        return found

    def check_keys(self, model: Model, known: frozenset[str]) -> None:
        """A remark for each key that is not read here, unless it is only about how things look in Stage's window."""
        self._check_keys(model.values, known, model.kind)

    def check_keys_of_world(self, values: Mapping[str, Value], known: frozenset[str]) -> None:
        """The same for the keys at the top of a world."""
        self._check_keys(values, known, "the world")

    def _check_keys(self, values: Mapping[str, Value], known: frozenset[str], of: str) -> None:
        for key, value in values.items():
            if key.partition("[")[0] in known or key in _READ_EVERYWHERE:
                continue
            if _SHOWN_ONLY.fullmatch(key):
                self.remark_shown_only(key)
                continue
            self.remark(f"key {of} {key}", f"{key} of {of} is left out.{did_you_mean(key, known)}", value.place)
