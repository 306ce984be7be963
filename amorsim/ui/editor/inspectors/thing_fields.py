"""A thing of a document and its fields: the value of each, and where it comes from."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from amorsim.core.errors import AmorsimError, DocumentError
from amorsim.core.numbers import is_number
from amorsim.plugins.registry import Registry
from amorsim.scenario.documents.document import Document
from amorsim.scenario.documents.field_at import component_at
from amorsim.scenario.toml.layout import MISSING, found_at
from amorsim.ui.editor.inspectors.sections import Section
from amorsim.ui.forms.description import FieldForm, form_of

__all__ = ["At", "ThingFields"]

At = tuple[str | int, ...]
"""A path within a thing."""


class ThingFields:
    """Makes the fields of a thing.

    Attributes
    ----------
    at
        The thing's path.
    registry, folder, document
        The components there are, the scenario's folder, and the document.
    table
        Its values in the file and the model.

    Raises
    ------
    DocumentError
        If there is nothing at the path, and nothing is known of it.
    """

    def __init__(self, document: Document, path: str, registry: Registry) -> None:
        self.registry = registry
        self.folder = document.path.absolute().parent
        self.document = document
        self.at: At = tuple(int(part) if part.isdigit() else part for part in path.split("."))
        try:
            table = document.get(path)
        except DocumentError:
            if self.at[0] not in ("simulation", "world", "recording", "floor", "task") or len(self.at) > 1:
                raise
            table = {}
        if not isinstance(table, dict):
            raise DocumentError(f"{path}: no table")
        self.table: dict[str, Any] = table
        # As the whole scenario with the model's tables: of this thing alone, for the rest is not asked for.
        self._values: dict[str, Any] = {}
        place: Any = self._values
        for n, part in enumerate(self.at):
            last = n == len(self.at) - 1
            inner: Any = self.table if last else ([] if isinstance(self.at[n + 1], int) else {})
            if isinstance(part, int):
                place.extend([{}] * part)
                place.append(inner)
            else:
                place[part] = inner
            place = inner

    def own(self, at: At) -> dict[str, Any]:
        """The file's own table of the thing, or of a part of it."""
        found = found_at(self.document.values, (*self.at, *at))
        return found if isinstance(found, dict) else {}

    def path_of(self, at: At) -> str:
        """The path in the document for a path within the thing."""
        return ".".join(map(str, (*self.at, *at)))

    def class_at(self, at: At) -> type | None:
        """The class of the component in a table within the thing; None if it is not known."""
        try:
            return component_at(self._values, (*self.at, *at), self.registry, self.folder)
        except (AmorsimError, OSError, LookupError, TypeError):
            return None

    def form(self, cls: type, at: At, names: tuple[str, ...] | None = None, unit: str = "") -> list[FieldForm]:
        """The fields of a class, with where each value comes from."""
        table = found_at(self.table, at) if at else self.table
        written = table if isinstance(table, dict) else {}
        fields = form_of(
            cls,
            written,
            spelling="file",
            sensor_unit=unit,
            names=self._names(),
            path=self.path_of(at),
            registry=self.registry,
        )
        fields = [field for field in fields if names is None or field["path"].rpartition(".")[2] in names]
        for field in fields:
            self.mark(field, (*at, field["path"].rpartition(".")[2]))
        return fields

    def mark(self, field: FieldForm, at: At) -> None:
        """Note where the field's value comes from, and where those of the fields within it come from."""
        is_own = found_at(self.own(()), at) is not MISSING
        is_said = found_at(self.table, at) is not MISSING
        field["is_given"] = is_own
        more: dict[str, Any] = {"origin": "file" if is_own else "model" if is_said else "default"}
        if is_said and not is_own:
            more["source"] = self.from_model()
        field.update(more)  # type: ignore[typeddict-item]
        for inner in field["widget"].get("fields", ()) if field["widget"]["kind"] in ("form", "component") else ():
            self.mark(inner, (*at, inner["path"].rpartition(".")[2]))

    def from_model(self) -> str:
        """Where the values that the file does not set come from, in words."""
        model = self.own(()).get("model")
        return f"from the model {model}" if isinstance(model, str) else "from a model"

    def _names(self) -> dict[str, list[str]]:
        found = {}
        for key in ("sensors", "estimators"):
            tables = self.table.get(key)
            found[key] = [name for name, one in tables.items() if one is not False] if isinstance(tables, dict) else []
        joints = getattr(self.class_at(("drive",)), "joints", ())
        found["joints"] = (
            [joint.name for joint in joints] if isinstance(joints, tuple) else []
        )  # else its fields decide
        return found

    def name(self) -> list[FieldForm]:
        """The field of the thing's own name."""
        return [self.text("name", "name", "letters, digits, '_' and '-'; unique in the scenario", "text")]

    def text(self, at: Any, label: str, help_: str, kind: str) -> FieldForm:
        """A text, or the path of a file, depending on the `kind` of widget."""
        place = (at,) if isinstance(at, str) else at
        value = found_at(self.table, place)
        field: FieldForm = {
            "path": self.path_of(place),
            "label": label,
            "help": help_,
            "widget": {"kind": kind, "is_optional": False},
            "value": None if value is MISSING else value,
            "default": None,
            "is_given": True,
            "is_required": False,
            "fixed": "",
        }
        self.mark(field, place)
        return field

    def choice(self, at: str, label: str, choices: Sequence[str], help_: str) -> FieldForm:
        """One of some words, or none."""
        field = self.text(at, label, help_, "choice")
        field["widget"] = {"kind": "choice", "is_optional": True, "choices": list(choices)}
        return field

    def number(self, at: At, label: str, unit: str, value: Any) -> FieldForm:
        """A number above 0."""
        field = self.text(at, label, "", "number")
        field["widget"] = {
            "kind": "number",
            "is_optional": False,
            "unit": unit,
            "low": 0.0,
            "high": None,
            "is_open": [True, True],
            "is_whole": False,
        }
        field["value"] = value if is_number(value) else None
        return field

    def section(self, title: str, at: At, fields: list[FieldForm]) -> Section:
        """A section with these fields, of the table at a path within the thing."""
        is_said = bool(at) and found_at(self.table, at) is not MISSING
        is_inherited = is_said and found_at(self.own(()), at) is MISSING
        return {
            "title": title,
            "path": self.path_of(at),
            "depth": 0,
            "use": None,
            "fields": fields,
            "toml": None,
            "can_go": False,
            "origin": self.from_model() if is_inherited else "",
            "adding": [],
        }
