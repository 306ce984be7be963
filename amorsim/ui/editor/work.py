"""A scenario that is being edited: its document and its files, the steps that can be undone, and saving."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from amorsim.core.errors import AmorsimError
from amorsim.core.files.reading import is_file, is_folder, is_there, reason
from amorsim.core.files.temporary_folders import temporary_folder
from amorsim.plugins.manager import default_registry
from amorsim.plugins.registry import Registry
from amorsim.scenario.documents.document import Document, open_document
from amorsim.scenario.documents.elsewhere import named_files
from amorsim.ui.editor.history import History, Patch, Step, difference
from amorsim.ui.editor.inspectors.walls import WallsError
from amorsim.ui.editor.journal import Kept, mark_of
from amorsim.ui.editor.storage.edited_files import Files, FilesError, FileText
from amorsim.ui.editor.storage.recent import remember
from amorsim.ui.editor.storage.world_map import WorldMap
from amorsim.ui.editor.undo_steps import Steps
from amorsim.ui.faults.changed_files import Stamps, stamps_of

__all__ = ["EMPTY", "ChangedError", "Work"]

EMPTY = "format = 1\n"
SCENARIO = ""  # the name of the scenario's text; that of a file is its path


class ChangedError(AmorsimError):
    """The error for a file that another program changed since it was read or saved."""


class Work:
    """A scenario that is being edited, with its map and its programs as texts.

    What is not touched stays byte for byte, and no program is run.

    Parameters
    ----------
    name
        A file, the name of a bundled scenario (a copy is edited), or empty for an empty page.
    folder
        Where a copy or an empty page is saved.
    state
        The folder of the journal, which restores the steps when the scenario is opened again; None keeps no journal.

    Attributes
    ----------
    files
        The files that are edited with the scenario.
    world
        The map of its world.
    steps
        The steps that can be undone, and the message about their journal.
    state
        As given.

    Raises
    ------
    DocumentError
        If there is no such file, or it is not text.
    """

    def __init__(self, name: str, folder: Path, *, state: Path | None = None, registry: Registry | None = None) -> None:
        self.registry = registry or default_registry()
        self.folder = folder.absolute()
        self.steps = Steps(state)
        self.files = Files()
        self.world = WorldMap(self)
        self.is_new = True  # whether it has no file of its own yet
        if not name:
            self.path = self.folder / "untitled.toml"
            self.document = Document(EMPTY, self.path, registry=self.registry)
            self._saved: str | None = None
        else:
            file = Path(name).absolute()  # now: later the folder may be gone from which relative paths lead
            self.is_new = not is_file(file)
            self.document = open_document(name if self.is_new else file, registry=self.registry)
            self.path = self.document.path.absolute()
            # For a map, or another program's file, there is no file of the scenario yet.
            self._saved = self.document.text if self.is_new or is_file(self.path) else None
            if not self.is_new:
                self.folder = self.path.parent
        self.name = "untitled" if not name else self.path.stem
        self._original = self.document.text
        self._stamps: Stamps = {} if self.is_new else stamps_of([self.path])
        self.state = state
        kept = self.steps.open(self._key)
        if kept is not None and SCENARIO in kept.texts:
            self._take_up(kept)
        self._rewrite_journal()
        self._note()

    def _note(self) -> None:
        """Remember the scenario among those that were edited last."""
        if self.state is not None and not self.is_new:
            remember(self.state, self.path)

    def close(self) -> None:
        """Release the journal, so that another Editor can open the scenario."""
        self.steps.close()

    # -------------------------------------------------------------------------------------------------------- changes

    @property
    def text(self) -> str:
        """The scenario's text."""
        return self.document.text

    @property
    def texts(self) -> dict[str, str]:
        """All texts that are edited: the scenario's under an empty name, those of files under their paths."""
        return {SCENARIO: self.text, **self.files.texts}

    @property
    def is_saved(self) -> bool:
        """Whether all that is edited is in the files."""
        return self._saved == self.text and not self._to_write

    @property
    def _is_bundled(self) -> bool:
        return self.is_new and self._saved is not None

    @property
    def here(self) -> Path:
        """The folder that file names in the scenario are relative to."""
        return self.document.path.parent

    def edit(self, label: str, change: Callable[[Work], Any]) -> Any:
        """Let a function change the work. All its changes are one step; if it raises, nothing is changed."""
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

    def program(self, name: str) -> FileText:
        """The text of a program by its name from the scenario's folder; without text where there is no such file.

        Raises
        ------
        FilesError
            If it cannot be read.
        """
        return self.held(self.here / name)

    def set_program(self, name: str, text: str) -> None:
        """Replace the text of a program."""
        self.program(name).text = text

    def undo(self) -> str:
        """Undo the last step; returns its label, empty if there is none."""
        step = self.steps.back()
        if step is None:
            return ""
        self._apply(step, back=True)
        return step.label

    def redo(self) -> str:
        """Redo the step that was undone last; returns its label, empty if there is none."""
        step = self.steps.forward()
        if step is None:
            return ""
        self._apply(step)
        return step.label

    def _apply(self, step: Step, *, back: bool = False) -> None:
        texts = self.texts
        for name in step.patches:
            if name not in texts:
                texts[name] = self.held(Path(name)).text
        self._restore(texts | {name: patch.apply(texts[name], back=back) for name, patch in step.patches.items()})

    def _restore(self, texts: Mapping[str, str]) -> None:
        if texts[SCENARIO] != self.text:
            self.set_text(texts[SCENARIO])
        self.files.restore(texts)

    def _remember(self, label: str, before: Mapping[str, str]) -> None:
        patches: dict[str, Patch] = {}
        for name, text in self.texts.items():
            there = before.get(name)
            if there is None:  # of a file that was read for this step
                there = self.files[Path(name)].first
            if there != text:
                patches[name] = difference(there, text)
        if patches and not self.steps.add(Step(label, patches)):
            self._rewrite_journal()

    # ---------------------------------------------------------------------------------------------------------- looking

    def held(self, path: Path) -> FileText:
        """The text of a file, read now if that was not done before.

        Raises
        ------
        FilesError, WallsError
            If it cannot be read, or is a bitmap that cannot be painted on.
        """
        return self.files.read(path, self.world.table or {})

    def view(self, folder: Path) -> Document:
        """A new document with all that is edited: it names copies in `folder` of the files that are not saved."""
        found = Document(self.text, self.document.path, registry=self.registry)
        if self.files.differing:
            for named in named_files(self.document.values, self.registry, self.here):
                path = self.here / named.name
                if named.kind == "program" or (named.kind == "map" and path in self.files):
                    place = self.files.place(path, folder)
                    if place != path:
                        found.set(".".join(map(str, named.at)), named.spelled(str(place)))
        return found

    # ----------------------------------------------------------------------------------------------------------- saving

    @property
    def files_changed(self) -> list[Path]:
        """The files that another program changed since they were read or saved."""
        before = self._stamps | self.files.stamps
        now = stamps_of(before)
        return [path for path, stamp in before.items() if now[path] != stamp]

    @property
    def files_gone(self) -> list[Path]:
        """Those of them that are not there any more."""
        return [path for path in self.files_changed if not is_there(path)]

    @property
    def _to_write(self) -> list[Path]:
        """The files to write: those that differ, but new ones only where the scenario names them."""
        differing = self.files.differing
        if all(held.saved is not None for held in differing.values()):
            return list(differing)
        named = {self.here / one.name for one in named_files(self.document.values, self.registry, self.here)}
        return [path for path, held in differing.items() if held.saved is not None or path in named]

    def save(self, *, force: bool = False) -> Path:
        """Write the files that differ, and those that another program has deleted.

        Parameters
        ----------
        force
            Whether files that something else has changed meanwhile are replaced, and folders that it has deleted are
            made again.

        Raises
        ------
        ChangedError
            If something else has changed one, or deleted its folder.
        AmorsimError
            If it has no file yet, or one cannot be written.
        """
        if self.is_new:
            raise AmorsimError("it has no file yet; save it under a name")
        changed, gone = self.files_changed, self.files_gone
        if force:
            _make_folders(gone)
        else:
            _refuse_changed([path for path in changed if path not in gone])
            _refuse_without_folder(gone)
        for path in dict.fromkeys([*self._to_write, *(path for path in changed if path in self.files)]):
            self.files.write(path)
        if self._saved != self.text or force or self.path in gone:
            self.document.save(self.path)
        self._saved = self.text
        self._stamps = stamps_of([self.path])
        self.steps.saved(self._marks())
        return self.path

    def save_program(self, name: str) -> bool:
        """Write a program only; returns whether that was possible: a bundled scenario has no folder until it is saved.

        Raises
        ------
        AmorsimError
            If it cannot be written.
        """
        if self._is_bundled:
            return False
        self.files.write(self.here / name)
        self.steps.saved(self._marks())
        return True

    def save_as(self, path: Path, *, overwrite: bool = False) -> Path:
        """Write everything as another file, and go on with that.

        In another folder, it gets copies of its files.

        Raises
        ------
        AmorsimError
            If the file is there and is not to be replaced, or cannot be written.
        """
        path = path.absolute()
        if is_there(path) and not overwrite:
            raise AmorsimError(f"{path.name} is there already; name another file")
        if self.is_new and self.world.is_unsaved and path.stem != self.name:
            self.edit(f"name the walls {path.stem}.wld", lambda work: work.world.rename(path.stem))
        before, here = self.text, self.here
        is_copied = self._is_bundled or path.parent != here
        if is_copied:
            with temporary_folder("save") as folder:
                self.view(folder).save(path, copy=True)
        else:
            for file in self._to_write:
                self.files.write(file)
            self.document.save(path)
        other = open_document(path, registry=self.registry)
        if is_copied:
            self._follow_copies(other, here)
        self.document, self.path, self.name, self.is_new = other, path, path.stem, False
        self.folder, self._saved = path.parent, other.text
        if other.text != before:  # files are named otherwise from there: the steps are of another text
            self.steps.history = History()
        self._stamps = stamps_of([path])
        self.steps.forget()  # it has another name now, and the next new page starts empty
        self.steps.open(self._key)
        self._rewrite_journal()
        self._note()
        return path

    def _follow_copies(self, other: Document, here: Path) -> None:
        """Hold the copies of files in place of the files that were held."""
        there = other.path.parent
        old = named_files(self.document.values, self.registry, here)
        new = named_files(other.values, self.registry, there)
        places = {here / one.name: there / two.name for one, two in zip(old, new, strict=True)}
        # What an undone step has left unnamed was not written, and has its place there too.
        unnamed = {file: there / file.relative_to(here) for file in self.files if file.is_relative_to(here)}
        self.files.move(unnamed | places, written=places)
        for file, place in (unnamed | places).items():
            self.steps.history.rename(str(file), str(place))

    def reload(self) -> None:
        """Read the files again, or begin anew if there are none. `undo` brings unsaved changes back."""
        before = self.texts
        self.world.forget()
        if self.is_new:
            for path in self.files:
                self.files[path].text = self.files[path].first
            self.set_text(self._original)
        else:
            self.document = open_document(self.path, registry=self.registry)
            self._saved = self.text
            for path in self.files:
                self.files.drop(path)
                if is_there(path):
                    self.held(path)
        if set(before) == set(self.texts):
            self._remember("reload", before)
        else:
            self.steps.history = History()
            self._rewrite_journal()
        self._stamps = {} if self.is_new else stamps_of([self.path])

    # ---------------------------------------------------------------------------------------------------------- journal

    def _marks(self) -> dict[str, str]:
        """Marks of the files' contents, as far as they are known."""
        return {SCENARIO: mark_of(self._saved), **self.files.marks}

    @property
    def _key(self) -> str:
        """The journal's."""
        return f"{self.folder / self.name} (new)" if self.is_new else str(self.path)

    def _rewrite_journal(self) -> None:
        self.steps.rewrite(self.texts, self._marks())

    def _take_up(self, kept: Kept) -> None:
        """Continue from the steps in the journal."""
        on_disk = self.texts
        try:
            for name in kept.texts:
                if name != SCENARIO:
                    on_disk[name] = self.held(Path(name)).text
        except (FilesError, WallsError):  # a file that can no longer be read: its steps mean nothing
            self.files.clear()
            return
        marks = self._marks()
        changed = [name for name, mark in kept.saved.items() if marks.get(name) != mark]
        had_unsaved = any(mark_of(text) != kept.saved.get(name) for name, text in kept.texts.items())
        self.steps.history = kept.history
        self._restore(kept.texts)
        if changed and not had_unsaved:  # by hand, with nothing of ours to lose
            self._restore(on_disk)
            self._remember("changed by hand", kept.texts)
        elif changed and not self.is_new:
            for name in changed:
                (self.files.stamps if name else self._stamps)[Path(name) if name else self.path] = None
        if not self.is_saved and self.steps.history.done:
            self.steps.remark = "changes that were not saved last time are restored"


def _refuse_changed(files: Sequence[Path]) -> None:
    if files:
        names = " and ".join(path.name for path in files)
        raise ChangedError(f"{names}: changed by something else since it was read; reload it, or keep yours")


def _refuse_without_folder(files: Sequence[Path]) -> None:
    for file in files:
        if not is_folder(file.parent):
            raise ChangedError(
                f"{file.name}: its folder {file.parent} was deleted by something else; make it again and save, or "
                "press 'keep mine', which makes it"
            )


def _make_folders(files: Sequence[Path]) -> None:
    for file in files:
        try:
            file.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise AmorsimError(f"{file.parent}: this folder cannot be made: {reason(error)}") from None
