"""Files that a scenario names, copied into a folder."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path
from typing import Any

import attrs

from amorsim.core.errors import MapError, RunError
from amorsim.core.files.atomic_files import copy_file, write_text
from amorsim.core.maps.map import Map
from amorsim.scenario.files.maps import MapFile, companions_of, save_map
from amorsim.scenario.programs.local_imports import files_beside

__all__ = ["Copies"]


class Copies:
    """Files copied into a folder, and their names there.

    Unless it `replaces` what is there, a file of another content that lies in the folder keeps its name and its place;
    names that are `taken` are for other files.
    """

    # What a run itself writes into its folder.
    _TAKEN = (
        "scenario.toml",
        "run.json",
        "poses.csv",
        "velocities.csv",
        "commands.csv",
        "events.csv",
        "obstacles.csv",
        "parts.csv",
        "picture.png",
        "sensors",
        "estimates",
        "plots",
    )

    def __init__(self, folder: Path, *, replaces: bool = True, taken: tuple[str, ...] = ()) -> None:
        self._folder = folder
        self._taken = (*self._TAKEN, *taken)
        self._replaces = replaces
        self._names: dict[str, str] = {}

    def save(self, world: Map) -> Map:
        """Write a map that was made in Python into the folder: as lines if it was made of lines, else as pixels."""
        name = self._free_name(Path(f"{world.name or 'map'}.{'png' if world.segments is None else 'wld'}"))
        try:
            saved = save_map(world, self._folder / name)
        except MapError as error:
            raise RunError(str(error)) from error
        self._names[str((self._folder / name).absolute())] = name
        return saved

    def _free_name(self, path: Path) -> str:
        name, number = path.name, 1
        taken = {known.partition("/")[0].casefold() for known in (*self._taken, *self._names.values())}
        while name.casefold() in taken or self._is_kept(path, name):
            number += 1
            name = f"{path.stem}_{number}{path.suffix}"
        return name

    def _is_kept(self, path: Path, name: str) -> bool:
        """Whether the folder has another file of that name, which is to stay."""
        there = self._folder / name
        if self._replaces or not there.exists():
            return False
        try:
            return not (there.is_file() and path.is_file() and there.read_bytes() == path.read_bytes())
        except OSError:
            return True

    def of_program(self, component: dict[str, Any]) -> None:
        """Replace the name of a user's file in a component's table by that of its copy."""
        file, _, name = component["use"].rpartition(":")
        component["use"] = f"{self.of(file)}:{name}"
        for key, beside in files_beside(Path(file)).items():
            self._of_import(key, beside)

    def _of_import(self, key: str, path: Path) -> None:
        """Copy a file that a program imports from its folder, under its own name, for the import names it."""
        target = self._folder / key
        file = str(path)
        if file in self._names or path.resolve() == target.resolve():
            return
        if key in self._names.values() or key in self._taken or self._is_kept(path, key):
            try:
                if target.is_file() and target.read_bytes() == path.read_bytes():
                    return
            except OSError as error:
                raise RunError(f"{file}: cannot be copied into {self._folder} ({error.strerror or error})") from error
            raise RunError(
                f"{file}: cannot be copied into {self._folder} as {key}, which is another file there; give it "
                "another name, for a run's folder has one place for both"
            )
        self._copy(path, target)
        self._names[file] = key

    def of_map(self, file: MapFile) -> str:
        """The name of the copy of a map's file, with its companions copied too."""
        try:
            beside = companions_of(file)
        except MapError as error:
            raise RunError(str(error)) from error
        path = file.path.absolute()
        if str(path) in self._names or not beside:
            return self.of(str(path))
        if all(each.resolve().parent == self._folder.resolve() for each in (path, *beside)):  # all are there already
            self._names[str(path)] = path.name
            return path.name
        # The part of the disk that all of them lie in, as a folder of the map's name.
        root = Path(os.path.commonpath([path.parent, *(each.parent for each in beside)]))
        folder = self._folder / self._free_name(Path(path.stem))
        copies = [folder / each.relative_to(root) for each in (path, *beside)]
        for each, copy in zip((path, *beside), copies, strict=True):
            self._copy(each, copy)
        named = _companions_of_copy(file, copies[0])
        for number, each in enumerate(beside, 1):
            if each in named:  # by its whole path; loaders look for it next to the map first
                copies[number] = self._moved(each, copies[number], copies[0].with_name(each.name))
        made = [Path(os.path.abspath(copy)) for copy in copies]  # noqa: PTH100 - as companions are named
        for each in _companions_of_copy(file, copies[0]):
            if each not in made:
                raise RunError(f"{path}: its copy would still read {each}; name that file relative to {path.name}")
        self._names[str(path)] = copies[0].relative_to(self._folder).as_posix()
        return self._names[str(path)]

    def _copy(self, path: Path, copy: Path) -> None:
        """Copy a file, unless it is there already."""
        try:
            if copy.parent != self._folder:
                copy.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise RunError(f"{copy.parent}: cannot make this folder ({error.strerror or error})") from None
        if path.resolve() != copy.resolve():
            copy_file(path, copy)

    def _moved(self, path: Path, copy: Path, place: Path) -> Path:
        """Where the copy of a file is after moving it to a place where no file is yet."""
        if place.exists():
            return copy
        self._copy(path, place)
        if not copy.samefile(path):
            copy.unlink()
            with contextlib.suppress(OSError):  # other files are in there too
                os.removedirs(copy.parent)
        return place

    def of(self, file: str) -> str:
        """The name of a file's copy."""
        if file not in self._names:
            path = Path(file)
            name = self._free_name(path)
            self._copy(path, self._folder / name)
            self._names[file] = name
        return self._names[file]

    def of_text(self, file: Path, text: str) -> str:
        """The name of a file's copy that contains `text` in place of the file's own."""
        key = str(file)
        if key not in self._names:
            name, number = file.name, 1
            taken = {known.partition("/")[0].casefold() for known in (*self._taken, *self._names.values())}
            while name.casefold() in taken or self._says_else(name, text):
                number += 1
                name = f"{file.stem}_{number}{file.suffix}"
            write_text(self._folder / name, text)
            self._names[key] = name
        return self._names[key]

    def _says_else(self, name: str, text: str) -> bool:
        there = self._folder / name
        return there.exists() and not (there.is_file() and there.read_bytes() == text.encode())


def _companions_of_copy(file: MapFile, copy: Path) -> list[Path]:
    return companions_of(attrs.evolve(file, path=Path(os.path.abspath(copy))))  # noqa: PTH100 - as companions are named
