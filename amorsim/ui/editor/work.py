"""A scenario that is being edited: its document, the walls of its map, the steps that can be undone, and saving."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import attrs

from amorsim.core.errors import AmorsimError, DocumentError
from amorsim.core.whole_files import write_bytes
from amorsim.plugins.manager import default_registry
from amorsim.plugins.registry import Registry
from amorsim.scenario.document import Document, open_document
from amorsim.scenario.elsewhere import named_files
from amorsim.ui.editor.bitmaps import SUFFIXES, shape_of
from amorsim.ui.editor.history import History, Patch, Step, difference
from amorsim.ui.editor.journal import Journal, JournalError, Kept, mark_of
from amorsim.ui.editor.map_text import MapText, read_map_text
from amorsim.ui.editor.recent import remember
from amorsim.ui.editor.walls import EMPTY_WORLD, WallsError, world_of
from amorsim.ui.faults.files import Stamp, stamps_of

__all__ = ["EMPTY", "ChangedError", "Work"]

EMPTY = "format = 1\n"
SCENARIO = ""  # the name of the scenario's text; that of a map is its path


class ChangedError(AmorsimError):
    """A file that was changed by something else since it was read or saved."""


class Work:
    """A scenario that is being edited, and its map where that is a line world.

    What is not touched stays byte for byte, and nothing of a user's runs.

    Parameters
    ----------
    name
        A file, the name of a bundled scenario, of which a copy is edited, or nothing for an empty page.
    folder
        Where a copy or an empty page is saved.
    state
        The folder in which the steps are kept, so that they are there again when the same is opened; nowhere if none
        is given.

    Attributes
    ----------
    remark
        What the user should know of what was kept, or nothing.
    state
        As given.

    Raises
    ------
    DocumentError
        If there is no such file, or it is no text.
    """

    def __init__(self, name: str, folder: Path, *, state: Path | None = None, registry: Registry | None = None) -> None:
        self.registry = registry or default_registry()
        self.folder = folder.absolute()
        self.history = History()
        self._maps: dict[Path, MapText] = {}
        self._refused: dict[Path, str] = {}  # bitmaps that cannot be painted on, and why, since they were read
        self.is_new = True  # whether it has no file of its own yet
        if not name:
            self.path = self.folder / "untitled.toml"
            self.document = Document(EMPTY, self.path, registry=self.registry)
            self._saved: str | None = None
        else:
            self.document = open_document(name, registry=self.registry)
            self.path = self.document.path.absolute()
            self._saved = self.document.text
            self.is_new = not Path(name).is_file()
            if not self.is_new:
                self.folder = self.path.parent
        self.name = "untitled" if not name else self.path.stem
        self._original = self.document.text
        self._stamps = self._stamped()
        self.state = state
        self._known: set[str] = set()  # the texts that the journal has
        self.remark = ""
        self._journal = self._open_journal()
        kept = None if self._journal is None else self._journal.read()
        if kept is not None and SCENARIO in kept.texts:
            self._take_up(kept)
        self._rewrite_journal()
        self._note()

    def _note(self) -> None:
        """Count it among the files that were edited last."""
        if self.state is not None and not self.is_new:
            remember(self.state, self.path)

    def close(self) -> None:
        """Let another have its journal."""
        if self._journal is not None:
            self._journal.close()
            self._journal = None

    # -------------------------------------------------------------------------------------------------------- changes

    @property
    def text(self) -> str:
        """The scenario's text."""
        return self.document.text

    @property
    def texts(self) -> dict[str, str]:
        """All texts that are edited: the scenario's under an empty name, those of maps under their paths."""
        return {SCENARIO: self.text, **{str(path): found.text for path, found in self._maps.items()}}

    @property
    def is_saved(self) -> bool:
        """Whether the files have it all."""
        return self._saved == self.text and all(
            held.text == held.saved for path, held in self._maps.items() if held.saved is not None or path == self.map
        )

    def edit(self, label: str, change: Callable[[Work], Any]) -> Any:
        """Let a function change the work: all that it changes is one step, and nothing is if it raises."""
        before = self.texts
        try:
            found = change(self)
        except BaseException:
            self._restore(before)
            raise
        self._remember(label, before)
        return found

    def set_text(self, text: str) -> None:
        """Replace the whole text of the scenario."""
        self.document = Document(text, self.document.path, registry=self.registry)

    def walls(
        self,
        *,
        add: Iterable[list[float]] = (),
        change: Mapping[int, list[float]] | None = None,
        remove: Iterable[int] = (),
    ) -> None:
        """Change the walls of the world's map; a scenario without a map gets one, which is saved next to it.

        Raises
        ------
        AmorsimError
            If the map is no line world, or would be none.
        """
        if self._is_generated:
            raise AmorsimError(self.walls_fixed)
        if self._world() is None:
            path = self._free_map()
            self._maps[path] = MapText(text=EMPTY_WORLD, saved=None)
            self.document.set("world.map", path.name)
        path = self._map_path()
        held = self._held(path)
        held.text = world_of(self._world(), path.name).changed(
            held.text, add=list(add), change=dict(change or {}), remove=set(remove)
        )

    def paint(self, change: Callable[[str], str]) -> None:
        """Change the runs of the world's bitmap (see `amorsim.ui.editor.bitmaps`).

        Raises
        ------
        AmorsimError
            If the map is no bitmap that can be painted on.
        """
        if self.paint_fixed:
            raise WallsError(self.paint_fixed)
        held = self._held(self._map_path())
        held.text = change(held.text)

    def undo(self) -> str:
        """Take the last step back; what it is called, or nothing where there is none."""
        step = self.history.back()
        if step is None:
            return ""
        self._apply(step, back=True)
        if self._journal is not None:
            self._journal.undo()
        return step.label

    def redo(self) -> str:
        """Make the step again that was taken back last; what it is called, or nothing where there is none."""
        step = self.history.forward()
        if step is None:
            return ""
        self._apply(step)
        if self._journal is not None:
            self._journal.redo()
        return step.label

    def _apply(self, step: Step, *, back: bool = False) -> None:
        texts = self.texts
        for name in step.patches:
            if name not in texts:
                texts[name] = self._held(Path(name)).text
        self._restore(texts | {name: patch.apply(texts[name], back=back) for name, patch in step.patches.items()})

    def _restore(self, texts: Mapping[str, str]) -> None:
        if texts[SCENARIO] != self.text:
            self.set_text(texts[SCENARIO])
        for path, found in list(self._maps.items()):
            if str(path) in texts:
                found.text = texts[str(path)]
            else:
                del self._maps[path]

    def _remember(self, label: str, before: Mapping[str, str]) -> None:
        patches: dict[str, Patch] = {}
        for name, text in self.texts.items():
            there = before.get(name)
            if there is None:  # of a map that was read for this step
                there = self._maps[Path(name)].saved
                there = EMPTY_WORLD if there is None else there
            if there != text:
                patches[name] = difference(there, text)
        if patches:
            step = Step(label, patches)
            self.history.add(step)
            if self._journal is not None and set(patches) <= self._known:
                self._journal.step(step)
            else:
                self._rewrite_journal()

    # ----------------------------------------------------------------------------------------------------------- maps

    def _world(self) -> dict[str, Any] | None:
        """The table of the world, or None where it names no map."""
        try:
            table = self.document.get("world")
        except DocumentError:
            return None
        return table if isinstance(table, dict) and isinstance(table.get("map"), str) else None

    @property
    def _is_generated(self) -> bool:
        try:
            return isinstance(self.document.get("world.map"), dict)
        except DocumentError:
            return False

    @property
    def map(self) -> Path | None:
        """The file of the world's map, or None where none is named."""
        return None if self._world() is None else self._map_path()

    def _map_path(self) -> Path:
        table = self._world() or {}
        return Path(self.document.path.absolute().parent / table["map"])

    def _free_map(self) -> Path:
        folder = self.document.path.absolute().parent if not self._is_bundled else self.folder
        number, path = 1, folder / f"{self.name}.wld"
        while path.exists() or path in self._maps:
            number, path = number + 1, folder / f"{self.name}-{number}.wld"
        return path

    @property
    def _is_bundled(self) -> bool:
        return self.is_new and self._saved is not None

    def _held(self, path: Path) -> MapText:
        """The text of a map's file.

        Raises
        ------
        WallsError
            If it cannot be read.
        """
        if path not in self._maps:
            if not path.exists():
                self._maps[path] = MapText(text=EMPTY_WORLD, saved=None)
                return self._maps[path]
            self._maps[path] = read_map_text(path, self._world() or {})
            self._stamps |= stamps_of([path])
        return self._maps[path]

    @property
    def walls_fixed(self) -> str:
        """Why walls cannot be changed, or nothing."""
        if self._is_generated:
            return "the world is generated; write it into a file with amorsim generate, and draw in that"
        table = self._world()
        try:
            if table is not None:
                world_of(table, self._map_path().name)
        except WallsError as error:
            return str(error)
        return ""

    @property
    def paint_fixed(self) -> str:
        """Why the map cannot be painted on, or nothing."""
        table = self._world()
        if table is None or self._map_path().suffix.lower() not in SUFFIXES:
            return "the world is no bitmap; save it as .png to paint on it"
        if "size" in table:
            return f"{self._map_path().name}: is stretched by `size`; say its `resolution` instead to paint on it"
        path = self._map_path()
        if path not in self._refused:
            try:
                self._held(path)
            except WallsError as error:
                self._refused[path] = str(error)  # which takes a while to find out
        return self._refused.get(path, "")

    @property
    def cells(self) -> list[int] | None:
        """Rows and columns of the bitmap that can be painted on, or None."""
        return None if self.paint_fixed else list(shape_of(self._held(self._map_path()).text))

    # ---------------------------------------------------------------------------------------------------------- looking

    def view(self, folder: Path) -> Document:
        """The document as it is now, with the maps as they are now: where those are not saved, they lie in `folder`.

        A document of its own, for another thread.
        """
        found = Document(self.text, self.document.path, registry=self.registry)
        unsaved = {path: held for path, held in self._maps.items() if held.text != held.saved}
        if not unsaved:
            return found
        here = self.document.path.absolute().parent
        for named in named_files(self.document.values, self.registry, here):
            path = Path(here / named.name)
            if named.kind == "map" and path in unsaved:
                held = unsaved[path]
                data = held.data(path.suffix.lower())
                place = folder / hashlib.sha256(data).hexdigest()[:16] / path.name
                if not place.exists():
                    place.parent.mkdir(parents=True, exist_ok=True)
                    write_bytes(place, data)
                found.set(".".join(map(str, named.at)), str(place))
        return found

    # ----------------------------------------------------------------------------------------------------------- saving

    @property
    def files_changed(self) -> list[Path]:
        """The files that something else has changed since they were read or saved."""
        now = stamps_of(self._stamps)
        return [path for path, stamp in self._stamps.items() if now[path] != stamp]

    def _stamped(self) -> dict[Path, Stamp]:
        return {} if self.is_new else stamps_of([self.path, *self._maps])

    def save(self, *, force: bool = False) -> Path:
        """Write the files that differ.

        Parameters
        ----------
        force
            Whether files that something else has changed meanwhile are replaced.

        Raises
        ------
        ChangedError
            If something else has changed one.
        AmorsimError
            If it has no file yet, or one cannot be written.
        """
        if self.is_new:
            raise AmorsimError("it has no file yet; save it under a name")
        changed = self.files_changed
        if changed and not force:
            names = " and ".join(path.name for path in changed)
            raise ChangedError(f"{names}: changed by something else since it was read; reload it, or keep yours")
        self._save_maps()
        if self._saved != self.text or force:
            self.document.save(self.path)
        self._saved = self.text
        self._stamps = self._stamped()
        if self._journal is not None:
            self._journal.saved(self._marks())
        return self.path

    def _save_maps(self) -> None:
        for path, held in self._maps.items():
            is_named = path == self.map or held.saved is not None
            if held.text != held.saved and is_named:
                write_bytes(path, held.data(path.suffix.lower()))
                held.saved = held.text

    def save_as(self, path: Path, *, overwrite: bool = False) -> Path:
        """Write it all as another file, whose name it has from now on; maps that are not saved are written there too.

        Raises
        ------
        AmorsimError
            If the file is there and is not to be replaced, or cannot be written.
        """
        path = path.absolute()
        if path.exists() and not overwrite:
            raise AmorsimError(f"{path.name} is there already; name another file")
        before = self.text
        self.document.save(path, copy=self._is_bundled or path.parent != self.document.path.absolute().parent)
        other = open_document(path, registry=self.registry)
        self._bring_maps(other)
        self.document, self.path, self.name, self.is_new = other, path, path.stem, False
        self.folder, self._saved = path.parent, other.text
        if other.text != before:  # files are named otherwise from there: the steps are of another text
            self.history = History()
        self._stamps = self._stamped()
        self._forget_journal()
        self._journal = self._open_journal()
        self._rewrite_journal()
        self._note()
        return path

    def _bring_maps(self, other: Document) -> None:
        """Write the maps that are not saved where the other document names them."""
        here, there = self.document.path.absolute().parent, other.path.absolute().parent
        try:
            new = other.get("world.map")
        except DocumentError:
            return
        if not isinstance(new, str):  # it is generated
            return
        path = Path(there / new)
        old = Path(here / self.document.get("world.map"))
        held = self._maps.get(old)
        if held is not None:
            self.history.rename(str(old), str(path))
            write_bytes(path, held.data(path.suffix.lower()))
            self._maps = {path: attrs.evolve(held, saved=held.text)}

    def reload(self) -> None:
        """Read the files again, or begin again what has none; what was not saved is gone, but `undo` brings it back."""
        before = self.texts
        self._refused.clear()
        if self.is_new:
            self._maps = {path: held for path, held in self._maps.items() if held.saved is not None}
            for held in self._maps.values():
                held.text = held.saved or ""
            self.set_text(self._original)
        else:
            self.document = open_document(self.path, registry=self.registry)
            self._saved = self.text
            for path in list(self._maps):
                del self._maps[path]
                if path.exists():
                    self._held(path)
        if set(before) == set(self.texts):
            self._remember("reload", before)
        else:
            self.history = History()
            self._rewrite_journal()
        self._stamps = self._stamped()

    # ---------------------------------------------------------------------------------------------------------- journal

    def _marks(self) -> dict[str, str]:
        """What the files have, as far as is known."""
        return {SCENARIO: mark_of(self._saved), **{str(path): mark_of(held.saved) for path, held in self._maps.items()}}

    def _open_journal(self) -> Journal | None:
        if self.state is None:
            return None
        key = f"{self.folder / self.name} (new)" if self.is_new else str(self.path)
        try:
            return Journal(self.state, key)
        except JournalError as error:
            self.remark = str(error)
            return None

    def _rewrite_journal(self) -> None:
        if self._journal is None:
            return
        self._known = set(self.texts)
        try:
            self._journal.rewrite(Kept(texts=self.texts, history=self.history, saved=self._marks()))
        except JournalError as error:
            self.remark = str(error)
            self.close()

    def _forget_journal(self) -> None:
        """What had no file has one now: the next that begins so begins with nothing."""
        if self._journal is not None:
            self._journal.forget()
        self.close()

    def _take_up(self, kept: Kept) -> None:
        """Go on where the steps of before ended."""
        on_disk = self.texts
        try:
            for name in kept.texts:
                if name != SCENARIO:
                    on_disk[name] = self._held(Path(name)).text
        except WallsError:  # a map that is gone: its steps mean nothing
            self._maps.clear()
            return
        marks = self._marks()
        changed = [name for name, mark in kept.saved.items() if marks.get(name) != mark]
        had_unsaved = any(mark_of(text) != kept.saved.get(name) for name, text in kept.texts.items())
        self.history = kept.history
        self._restore(kept.texts)
        if changed and not had_unsaved:  # by hand, with nothing of ours to lose
            self._restore(on_disk)
            self._remember("changed by hand", kept.texts)
        elif changed and not self.is_new:
            for name in changed:
                self._stamps[Path(name) if name else self.path] = None
        if not self.is_saved and self.history.done:
            self.remark = "changes of before, which were not saved, are here again"
