"""The map of a scenario's world as it is edited: the walls of a line world, the cells of a bitmap."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from amorsim.core.errors import DocumentError
from amorsim.scenario.documents.document import Document
from amorsim.scenario.documents.elsewhere import named_files, near
from amorsim.ui.editor.inspectors.walls import EMPTY_WORLD, WallsError, world_of
from amorsim.ui.editor.storage.bitmaps import SUFFIXES, shape_of
from amorsim.ui.editor.storage.edited_files import FilesError

if TYPE_CHECKING:
    from amorsim.ui.editor.work import Work

__all__ = ["WorldMap", "take_map"]


def take_map(document: Document, file: Path, options: Mapping[str, Any]) -> None:
    """Let a file be the world's map, read with these options."""
    specified = document.values.get("world")
    for key in specified if isinstance(specified, dict) else ():
        if key != "map" and key not in options:
            document.remove(f"world.{key}")
    document.set("world.map", near(file, document.path.absolute().parent))
    for key, value in options.items():
        document.set(f"world.{key}", value)


class WorldMap:
    """The map of the world of a `Work`."""

    def __init__(self, work: Work) -> None:
        self._work = work
        self._refused: dict[Path, str] = {}  # bitmaps that cannot be painted on, and why, since they were read

    def forget(self) -> None:
        """Read files anew when they are needed, since they may have changed."""
        self._refused.clear()

    @property
    def table(self) -> dict[str, Any] | None:
        """The table of the world; None if it names no map."""
        try:
            table = self._work.document.get("world")
        except DocumentError:
            return None
        return table if isinstance(table, dict) and isinstance(table.get("map"), str) else None

    @property
    def file(self) -> Path | None:
        """The file of the map; None if it names no file."""
        table = self.table
        return None if table is None else Path(self._work.here / table["map"])

    @property
    def _is_generated(self) -> bool:
        try:
            return isinstance(self._work.document.get("world.map"), dict)
        except DocumentError:
            return False

    # ---------------------------------------------------------------------------------------------------------- walls

    @property
    def walls_fixed(self) -> str:
        """Why walls cannot be changed; empty if they can."""
        if self._is_generated:
            return "the world is generated; make its walls a file first, and draw in that"
        try:
            if self.file is not None:
                world_of(self.table, self.file.name)
        except WallsError as error:
            return str(error)
        return ""

    def walls(
        self,
        *,
        add: Iterable[list[float]] = (),
        change: Mapping[int, list[float]] | None = None,
        remove: Iterable[int] = (),
    ) -> None:
        """Change the walls; a scenario without a map gets one, which is saved next to it.

        Raises
        ------
        AmorsimError
            If the map is not a line world, or would not be one.
        """
        if self._is_generated:
            raise WallsError(self.walls_fixed)
        path = self.file
        if path is None:
            path = self.free_file()
            self._work.files.begin(path, EMPTY_WORLD)
            self._work.document.set("world.map", path.name)
        held = self._work.held(path)
        held.text = world_of(self.table, path.name).changed(
            held.text, add=list(add), change=dict(change or {}), remove=set(remove)
        )

    def become_lines(self, path: Path, text: str, options: Mapping[str, Any]) -> None:
        """Take a line world of this text as the map, read with these options. Its file is written when all is saved."""
        self._work.files.begin(path, "")
        self._work.files[path].text = text
        take_map(self._work.document, path, options)

    @property
    def is_unsaved(self) -> bool:
        """Whether it is a line world that was drawn here and is in no file yet."""
        path, files = self.file, self._work.files
        return path is not None and path.suffix == ".wld" and path in files and files[path].saved is None

    def rename(self, stem: str) -> None:
        """Give walls that are in no file yet another name, wherever the scenario names them."""
        work, old = self._work, self.file
        assert old is not None
        text, new = work.files[old].text, self.free_file(stem)
        work.files.begin(new, "")
        work.files[new].text = text
        for named in named_files(work.document.values, work.registry, work.here):
            if work.here / named.name == old:
                work.document.set(".".join(map(str, named.at)), named.spelled(new.name))

    def free_file(self, stem: str = "") -> Path:
        """A line world next to the scenario that is not there yet, named after it or otherwise."""
        work, stem = self._work, stem or self._work.name
        number, path = 1, work.here / f"{stem}.wld"
        while path.exists() or path in work.files:
            number, path = number + 1, work.here / f"{stem}-{number}.wld"
        return path

    # ---------------------------------------------------------------------------------------------------------- cells

    @property
    def paint_fixed(self) -> str:
        """Why the map cannot be painted on; empty if it can."""
        table, path = self.table, self.file
        if table is None or path is None or path.suffix.lower() not in SUFFIXES:
            return "the world is not a bitmap; save it as .png to paint on it"
        if "size" in table:
            return f"{path.name}: is stretched by `size`; say its `resolution` instead to paint on it"
        if path not in self._refused:
            try:
                self._work.held(path)
            except (FilesError, WallsError) as error:
                self._refused[path] = str(error)  # which takes a while to find out
        return self._refused.get(path, "")

    @property
    def cells(self) -> list[int] | None:
        """Rows and columns of the bitmap that can be painted on, or None."""
        path = self.file
        return None if self.paint_fixed or path is None else list(shape_of(self._work.held(path).text))

    def paint(self, change: Callable[[str], str]) -> None:
        """Change the runs of the bitmap (see `amorsim.ui.editor.storage.bitmaps`).

        Raises
        ------
        AmorsimError
            If the map is not a bitmap that can be painted on.
        """
        if self.paint_fixed or self.file is None:
            raise WallsError(self.paint_fixed)
        held = self._work.held(self.file)
        held.text = change(held.text)
