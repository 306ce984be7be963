"""Documents: scenarios' files as their authors wrote them, which can be changed in places and saved."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import attrs

from amorsim.core.arguments import checked, path_of
from amorsim.core.errors import DocumentError, Fault, ScenarioError
from amorsim.core.files.atomic_files import write_bytes
from amorsim.core.files.reading import is_file, no_such_file, read_bytes, reason
from amorsim.plugins.manager import default_registry
from amorsim.plugins.registry import Registry
from amorsim.scenario.documents.assign import Setter
from amorsim.scenario.documents.elsewhere import copied, named_files, near
from amorsim.scenario.documents.origins import Origin, Origins, kind_of
from amorsim.scenario.documents.undo import Journal
from amorsim.scenario.files.copied_files import Copies
from amorsim.scenario.files.mistaken import SCENARIO_PATH, mistaken
from amorsim.scenario.files.other_files import scenario_of_other
from amorsim.scenario.files.resolved import resolved_table
from amorsim.scenario.reading.faults import shown
from amorsim.scenario.reading.fields import NONE
from amorsim.scenario.reading.interpret import Meaning, read_meaning
from amorsim.scenario.reading.partial import Partial, read_partial, whole_of
from amorsim.scenario.spec import Scenario
from amorsim.scenario.toml.editing import Editor
from amorsim.scenario.toml.layout import MISSING, Path_, found_at
from amorsim.scenario.toml.literals import checked_text, plain
from amorsim.scenario.toml.names_in_lists import index_of
from amorsim.scenario.toml.parse import Written, line_of, read_written

__all__ = ["Document", "open_document"]

_LISTS = (("robots",), ("obstacles",), ("landmarks",), ("lights",), ("zones",))


@checked
def open_document(path: str | os.PathLike[str], *, registry: Registry | None = None) -> Document:
    """The document of a scenario's file, or of the bundled scenario of that name; it may have faults.

    Another program's file, or a map, is not changed: its document is a new one, which `Document.save` writes as TOML
    into the same folder.

    Raises
    ------
    DocumentError
        If there is no such file, or it is not a text in UTF-8.
    """
    registry = registry or default_registry()
    file = path_of(path, "path", SCENARIO_PATH)
    names = registry.names("scenario")
    if str(path) in names and not is_file(file):
        file = registry.file("scenario", str(path))
    if (found := scenario_of_other(file, registry)) is not None:
        return Document(*found, registry=registry)
    try:
        data = read_bytes(file)
        return Document(data.decode(), file, registry=registry)
    except FileNotFoundError:
        raise DocumentError(f"{path}: {mistaken(file, no_such_file(file), names)}") from None
    except UnicodeDecodeError as error:
        byte = f"byte {error.start} is {error.object[error.start]:#04x}"
        raise DocumentError(f"{path}: not a text file in UTF-8: {byte}") from None
    except (OSError, ValueError) as error:
        raise DocumentError(f"{path}: {mistaken(file, f'cannot be read: {reason(error)}', names)}") from None


class Document:
    """A scenario's file as its author wrote it: read, changed in places, checked and saved; made by `open_document`.

    A path leads to a value as in ``--set``: ``"robots.rover.drive.track"``, with the names or the numbers of robots
    and of other things in lists. A change touches the lines of what it is about, and no others: comments, order,
    blank lines and the spelling of numbers stay.
    """

    @checked
    def __init__(self, text: str, path: str | os.PathLike[str], *, registry: Registry | None = None) -> None:
        self._path = Path(path)
        self._registry = registry or default_registry()
        self._bom = "\N{BOM}" if text.startswith("\N{BOM}") else ""
        written = read_written(text.removeprefix("\N{BOM}"))
        self._has_bad_lines = bool(written.bad)
        self._editor = Editor(list(written.statements), written.values)
        self._origins = Origins(self._path, self._registry)
        self._setter = Setter(self._editor, self._origins)
        self._journal = Journal(self._editor)

    def __repr__(self) -> str:
        return f"<document {str(self._path)!r}>"

    def __reduce__(self) -> tuple[Any, ...]:
        # As a file of that text, just opened; by the plugins of the process where it then is.
        return Document, (self.text, self._path)

    @property
    def path(self) -> Path:
        """The file."""
        return self._path

    @property
    def values(self) -> dict[str, Any]:
        """The tables of the file, as `tomllib` reads them; they must not be changed."""
        return self._editor.values

    @property
    def text(self) -> str:
        """The file's text, as `save` would write it."""
        return self._bom + self._editor.text

    # ---------------------------------------------------------------------------------------------------------- values

    def get(self, path: str) -> Any:
        """The value that holds at a path, as files have it: angles in degrees, tables as dicts.

        It is the file's own, or else that of the robot's model, of a device, or a default (see `inherited`). A
        table has the entries of the file and of the model.

        Raises
        ------
        DocumentError
            If there is no value.
        """
        values = self._editor.values
        at = self._at(path)
        value = found_at(self._origins.merged(values, at), at)
        if value is MISSING:
            origin = self._origins.find(values, at)
            if origin is None:
                raise DocumentError("nothing says it: neither the file, nor a model, nor a default", path)
            value = origin.value
        return plain(value)

    def inherited(self, path: str) -> Origin:
        """Where the value at a path comes from, and what would hold if the file did not set it.

        Raises
        ------
        DocumentError
            If there is no value.
        """
        at = self._at(path)
        origin = self._origins.find(self._editor.values, at)
        if origin is None:
            raise DocumentError("nothing says it: neither the file, nor a model, nor a default", path)
        if origin.source == "file":
            statements = self._editor.statements
            origin = attrs.evolve(origin, line=line_of(statements, self._editor.layout, at))
        return origin

    def set(self, path: str, value: Any) -> None:
        """Set the value at a path, in the place of the one that is there.

        Of a table or a list, only what differs is written. What holds anyway is left out: a value that is set back to
        what the model, a device or a default sets is removed from the file. A default stays if it was in the file when
        it was opened, and so does a coordinate. An error that changes nothing goes as a whole. Another ``use`` is
        another component: the keys of the one before go.

        Raises
        ------
        DocumentError
            If the path leads nowhere, or TOML has no such value.
        """
        at = self._at(path)
        value = plain(value, path)
        with self._journal.changing():
            self._setter.set(at, value)

    def _override(self, path: Sequence[str], value: Any) -> Path_:
        """Set the value at a path, given by its parts; returns the path of what was made for it.

        That is the path of the value, or of the first table on the way that neither the file nor a model has.
        """
        at, value = self._at(path), plain(value)
        merged = self._origins.merged(self._editor.values, at)
        made = next((at[:length] for length in range(1, len(at)) if found_at(merged, at[:length]) is MISSING), at)
        with self._journal.changing():
            self._setter.set(at, value)
        return made

    def remove(self, path: str) -> None:
        """Remove from the file what is at a path: a value, a table or an item of a list.

        Raises
        ------
        DocumentError
            If the file has nothing there.
        """
        at = self._at(path)
        if not at or found_at(self._editor.values, at) is MISSING:
            origin = self._origins.find(self._editor.values, at) if at else None
            where = "" if origin is None or origin.file is None else f"; {origin.file} does, of which the robot is made"
            raise DocumentError(f"the file says nothing of it{where}", path)
        with self._journal.changing():
            self._editor.remove(at)

    def add(self, path: str, value: Any, index: int | None = None) -> str:
        """Append an item to the list at a path, which is made where there is none; returns the item's path.

        Parameters
        ----------
        path
            Of the list: ``"obstacles"``.
        value
            The item: ``{"name": "box", "shape": {"circle": 0.2}}``.
        index
            Before which item of the list; at its end if none is given.

        Raises
        ------
        DocumentError
            If there is something else than a list, or TOML has no such value.
        """
        at, value = self._at(path), plain(value, path)
        there = found_at(self._editor.values, at)
        if there is not MISSING and not isinstance(there, list):
            raise DocumentError(f"expected a list, to which something can be added; it is {shown(there)}", path)
        count = 0 if there is MISSING else len(there)
        place = self._place(path, count if index is None else index, count + 1)
        with self._journal.changing():
            if there is MISSING:
                self._editor.begin_list(at, value)
            else:
                self._editor.insert(at, place, value)
        return ".".join(map(str, (*at, place)))

    def move(self, path: str, index: int) -> str:
        """Move an item of a list, with all of it that the file has; returns its path there.

        What is in a table moves among what the file has in the table: the first of a robot's estimators is the one
        that its controller gets.

        Raises
        ------
        DocumentError
            If the file has nothing at the path, or the list or table has no such place.
        """
        at = self._at(path)
        if found_at(self._editor.values, at) is MISSING:
            raise DocumentError("expected what the file says, as 'robots.rover' or 'robots.rover.drive'", path)
        there = found_at(self._editor.values, at[:-1])
        place = self._place(path, index, len(there))
        with self._journal.changing():
            self._editor.move(at, place)
        return ".".join(map(str, (*at[:-1], place if isinstance(there, list) else at[-1])))

    @staticmethod
    def _place(path: str, index: int, count: int) -> int:
        if not isinstance(index, int) or isinstance(index, bool) or not 0 <= index < count:
            problem = f"index: expected a whole number from 0 to {count - 1}, got {shown(index)}"
            raise DocumentError(problem, path)
        return index

    def _at(self, path: str | Sequence[str | int]) -> Path_:
        """A path with numbers in the places of names."""
        if not isinstance(path, (str, list, tuple)) or not path:
            raise DocumentError(f"expected a path, as 'robots.rover.drive.track', got {shown(path)}")
        parts = path.split(".") if isinstance(path, str) else [str(part) for part in path]
        place: Any = self._editor.values
        at: Path_ = ()
        for number, part in enumerate(parts):
            if number == self._setter.models_begin:  # a model may have what the file does not
                place = found_at(self._origins.merged(self._editor.values, (*at, part)), at)
            if isinstance(path, str) and not part.strip():
                raise DocumentError(f"expected a path, as 'robots.rover.drive.track', got {shown(path)}")
            part = checked_text(part.strip() if isinstance(path, str) else part)
            if place is MISSING and part.isdecimal():  # an item of a list that is a field's default
                default = [] if at in _LISTS else self._origins.default(self._editor.values, at)
                place = default if isinstance(default, list) else MISSING
            if isinstance(place, list):
                index = index_of(place, part, str(at[-1]))
                if isinstance(index, str):
                    raise DocumentError(index, ".".join(map(str, (*at, part))))
                place, at = place[index], (*at, index)
                continue
            if place == NONE:  # in the place of a component that may be chosen
                place = MISSING
            if place is not MISSING and not isinstance(place, dict):
                problem = f"there is nothing under {'.'.join(map(str, at))}: it is {shown(place)}"
                raise DocumentError(problem, ".".join(map(str, (*at, part))))
            place = place.get(part, MISSING) if place is not MISSING else MISSING
            at = (*at, part)
        return at

    # --------------------------------------------------------------------------------------------------------- journal

    def undo(self) -> bool:
        """Undo the last change, to the byte; false if there is none."""
        return self._journal.undo()

    def redo(self) -> bool:
        """Redo the change that was undone last; false if there is none."""
        return self._journal.redo()

    # --------------------------------------------------------------------------------------------------------- meaning

    def scenario(self) -> Scenario:
        """The scenario of the document, as `load` reads it from the file.

        Raises
        ------
        ScenarioError
            With all faults, each with its line.
        DocumentError
            If it is a model or a device.
        """
        looked = self._look(shares_alike=False)
        if looked.faults:
            raise ScenarioError(looked.faults, looked.book.warnings)
        if looked.scenario is None:
            raise DocumentError(f"{self._path}: this is the {kind_of(self._editor.values)} of robots, and no scenario")
        return attrs.evolve(looked.scenario, resolved=resolved_table(looked.scenario, registry=self._registry))

    def faults(self) -> tuple[Fault, ...]:
        """All faults of the document: of lines that are not TOML, of keys, and of values; none if it is sound.

        Nothing of a user's runs: of components in files the text is checked. `check_code`
        finds what only shows when they run, and `Simulation` what depends on draws, such as random starts.
        """
        return self._look().faults

    def partial(self) -> Partial:
        """The readable part of the document, whatever faults it has, to show it; no code of a user runs."""
        looked = self._look()
        if looked.scenario is not None:
            return whole_of(looked.values)
        return read_partial(looked.merged, looked.book, self._registry, looked.maps, looked.faults)

    def files(self) -> tuple[Path, ...]:
        """The document's own file, and those that it names, whether they exist or not."""
        here = self._path.absolute().parent
        named = (here / file.name for file in named_files(self._editor.values, self._registry, here))
        return tuple(dict.fromkeys([self._path.absolute(), *named]))

    def _look(self, *, shares_alike: bool = True) -> Meaning:
        return read_meaning(self._written(), self._path, self._registry, shares_alike=shares_alike)

    def _written(self) -> Written:
        if self._has_bad_lines:  # they may stand elsewhere by now
            return read_written(self._editor.text)
        return Written(self._editor.text, self._editor.values, self._editor.statements)

    # ------------------------------------------------------------------------------------------------------------ file

    @checked
    def save(self, path: str | os.PathLike[str] | None = None, *, copy: bool = False) -> Path:
        """Write the file, whole or not at all; returns where it is.

        Written elsewhere, it names maps, models, programs and other files from there, by relative paths; the document
        stays that of its own file.

        Parameters
        ----------
        path
            Another file, which is replaced if it is there.
        copy
            Whether files that lie outside the folder of `path` are copied into it, with what they need in turn. None
            is replaced: of two files of one name, the copy gets a number.

        Raises
        ------
        RunError
            If it cannot be written; what was there is there still.
        """
        file = self._path if path is None else path_of(path, "path")
        text = self.text
        if file.absolute().parent != self._path.absolute().parent or copy:
            text = self._for(file.absolute(), copy)
        write_bytes(file, text.encode())
        return file

    @checked
    def moved(self, path: str | os.PathLike[str]) -> Document:
        """The same document as if its file were elsewhere, naming the same other files; writes nothing.

        Raises
        ------
        RunError
            If no relative path leads from there to one of the files.
        """
        return Document(self._for(Path(path).absolute(), copy=False), path, registry=self._registry)

    def _for(self, target: Path, copy: bool, copies: Copies | None = None) -> str:
        """The text for another file."""
        folder, here = target.parent, self._path.absolute().parent
        other = Document(self.text, self._path, registry=self._registry)
        values = self._editor.values
        copies = copies or Copies(folder, replaces=False, taken=(target.name,))
        for named in named_files(values, self._registry, here):
            file = Path(os.path.abspath(here / named.name))  # noqa: PTH100 - a link keeps the name that it was given
            if not copy or file.is_relative_to(folder):
                name = near(file, folder)
            elif named.kind == "model":
                name = copies.of_text(file, open_document(file, registry=self._registry)._for(target, copy, copies))
            else:
                name = copied(named, file, values, copies, self._registry)
            if name != named.name:
                other._editor.set(named.at, named.spelled(name))
        return other.text
