"""Writes a value into a document, and only where it differs from the inherited one."""

from __future__ import annotations

from typing import Any

from amorsim.scenario.documents.neutral import error_over, errors_in, is_error, meaning_of
from amorsim.scenario.documents.origins import Origins, kind_of
from amorsim.scenario.files.models import are_of_one_kind
from amorsim.scenario.reading.bodies import SHAPES
from amorsim.scenario.reading.fields import NONE
from amorsim.scenario.toml.editing import Editor
from amorsim.scenario.toml.layout import MISSING, Path_, changed, found_at, without
from amorsim.scenario.toml.literals import are_same, plain

__all__ = ["Setter"]

_COORDINATES = ("x", "y", "heading_deg")


class Setter:
    """Writes values into the file of an editor, as `Document.set` does.

    Parameters
    ----------
    editor
        Of the file as it was opened.
    origins
        Where its values come from.
    """

    def __init__(self, editor: Editor, origins: Origins) -> None:
        self._editor = editor
        self._origins = origins
        self._opened = editor.values

    @property
    def models_begin(self) -> int:
        """The least number of parts of a path to something that a model may set."""
        return 2 if kind_of(self._editor.values) == "scenario" else 0

    def set(self, at: Path_, value: Any) -> None:
        """Set a plain value at a path."""
        error = error_over(self._editor.values, at)
        self._set(at, value)
        self._drop_component(at)
        if error is not None:
            self._drop_error(error)

    def _set(self, at: Path_, value: Any) -> None:
        values = self._editor.values
        written = found_at(values, at)
        if are_same(written, value):
            return
        merged = self._origins.merged(values, at)
        if component := self._origins.default_over(values, at):
            path, table = component
            self._editor.set(path, plain(changed(table, at[len(path) :], value)))
            return
        if whole := self._whole_over(at, merged):
            self._editor.set(at[:whole], plain(changed(found_at(merged, at[:whole]), at[whole:], value)))
            return
        for length, part in enumerate(at):
            if (
                isinstance(part, int) and found_at(values, at[:length]) is MISSING
            ):  # a list of the model's, or a default
                there = found_at(merged, at[:length])
                there = self._origins.default(values, at[:length]) if there is MISSING else there
                self._editor.set(at[:length], plain(changed(there, at[length:], value)))
                return
        holder, there = found_at(merged, at[:-1]), found_at(merged, at)
        if holder == NONE and at[-1] == "use":  # a component where there was none
            self._set(at[:-1], {"use": value})
        elif isinstance(holder, dict) and _is_another(at, holder, value):
            self._editor.set(at[:-1], {at[-1]: value})
        elif isinstance(value, dict) and isinstance(written, dict):
            self._set_table(at, written, value)
        elif isinstance(value, dict) and isinstance(there, dict) and are_of_one_kind(_keys(at), there, value):
            self._set_table(at, {}, value)
        elif not isinstance(value, dict) and self._is_inherited(at, value):
            if written is not MISSING:
                self._drop(at)
        else:
            self._editor.set(at, value)
            self._drop_list(at)

    def _whole_over(self, at: Path_, merged: dict[str, Any]) -> int:
        """The number of parts to the model's table over a path that the file can only replace as a whole, or 0."""
        for length in range(self.models_begin + 1, len(at)):
            table = found_at(merged, at[:length])
            if found_at(self._editor.values, at[:length]) is not MISSING or not isinstance(table, dict):
                continue
            is_other = at[length] == "model" or _is_another(at[: length + 1], table, None)
            if not is_other and not are_of_one_kind(_keys(at[:length]), table, {str(at[length]): None}):
                return length
        return 0

    def _drop_list(self, at: Path_) -> None:
        """Leave out the list that a path leads into, where it is the model's again."""
        for length in range(self.models_begin + 1, len(at)):
            holder = at[:length]
            if isinstance(at[length], int):
                if self._is_inherited(holder, found_at(self._editor.values, holder)):
                    self._drop(holder)
                return

    def _drop_component(self, at: Path_) -> None:
        """Leave out the component that a path leads into, where it is the model's or its field's default again."""
        for length in range(self.models_begin + 1, len(at) + 1):
            component = at[:length]
            is_new = found_at(self._opened, component) is MISSING
            if is_new and self._origins.is_needless(self._editor.values, component):
                self._drop(component)
                return

    def _drop_error(self, error: Path_) -> None:
        """Remove an error from the file if it changes nothing there."""
        present = found_at(self._editor.values, error)
        if present is MISSING or not is_error(present):
            return
        rest = without(self._editor.values, error)
        for length in range(len(error) - 1, errors_in(error), -1):  # an empty table would hide the model's
            if found_at(rest, error[:length]) == {}:
                rest = without(rest, error[:length])
        if meaning_of(found_at(self._origins.merged(rest, error), error)) == meaning_of(present):
            self._drop(error)

    def _set_table(self, at: Path_, written: dict[str, Any], value: dict[str, Any]) -> None:
        if "use" in value:  # first, for the keys of another component go with it
            self._set((*at, "use"), value["use"])
        inherited = found_at(self._origins.merged(self._editor.values, at), at)
        for key in written:
            if key not in value and found_at(self._editor.values, (*at, key)) is not MISSING:
                self._editor.remove((*at, key))
        for key, item in value.items():
            if key not in written and isinstance(inherited, dict) and are_same(inherited.get(key), item):
                continue
            self._set((*at, key), item)
        inherited = found_at(self._origins.merged(self._editor.values, at), at)
        if inherited is MISSING:
            self._editor.set(at, {})
            return
        for key, item in inherited.items():
            if key not in value and key != "use":
                self._take_away((*at, key), item)

    def _take_away(self, at: Path_, inherited: Any) -> None:
        """State that a value of the model does not hold, as far as a file can: the default does."""
        default = self._origins.default(self._editor.values, at)
        if at[-2] in ("sensors", "estimators") and len(at) == self.models_begin + 2:
            self._editor.set(at, False)
        elif isinstance(inherited, dict):
            self._set_table(at, {}, {})
        elif default is not None:
            if not are_same(default, inherited):
                self._editor.set(at, default)
        elif at[-1] in ("noise", "ground"):
            self._editor.set(at, [])

    def _is_inherited(self, at: Path_, value: Any) -> bool:
        """Whether the value at a path holds without an entry in the file."""
        origin = self._origins.find(self._editor.values, at)
        if origin is not None and origin.source == "file":
            origin = origin.under
        if origin is None or not _are_equal(origin.value, value):
            return False
        if origin.source != "default":
            return True
        if at[-2] == "pose" and found_at(self._opened, at[:-1]) is MISSING:
            return False  # no pose at all means another place: the map's start, or where a motion begins
        opened = found_at(self._opened, at)
        # A place is given by all of its coordinates, be some of them 0.
        return opened is MISSING or not (at[-1] in _COORDINATES or _are_equal(opened, value))

    def _drop(self, at: Path_) -> None:
        """Remove what is at a path, and the tables around it that become empty.

        Those that were in the file stay, but for tables of errors.
        """
        self._editor.remove(at)
        for length in range(len(at) - 1, 0, -1):
            is_new = found_at(self._opened, at[:length]) is MISSING or length >= errors_in(at) > 0
            there = found_at(self._editor.values, at[:length])
            if there is MISSING:  # it went with what was in it
                continue
            if there != {} or not is_new:
                return
            self._editor.remove(at[:length])


def _keys(at: Path_) -> tuple[str, ...]:
    return tuple(map(str, at))


def _is_another(at: Path_, holder: dict[str, Any], value: Any) -> bool:
    """Whether a value makes its table another component or shape, so that nothing else in it stays."""
    if at[-1] == "use":
        return bool(holder.get("use", value) != value)
    return at[-2:-1] == ("shape",) and at[-1] in SHAPES and at[-1] not in holder


def _are_equal(one: Any, other: Any) -> bool:
    """Whether two values are the same number, or otherwise equal: 1 is 1.0."""
    is_flag = isinstance(one, bool), isinstance(other, bool)
    return bool(one == other) and is_flag[0] == is_flag[1]
