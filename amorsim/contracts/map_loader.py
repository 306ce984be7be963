"""The contract of map loaders."""

from __future__ import annotations

import abc
from collections.abc import Sequence
from pathlib import Path
from typing import ClassVar

from amorsim.core.errors import MapError
from amorsim.core.maps.map import Map

__all__ = ["MapLoader"]


class MapLoader(abc.ABC):
    """Reads maps of one format; its fields are the options of `amorsim.load_map`."""

    extensions: ClassVar[tuple[str, ...]]  # with the dot, lower case
    read_only: ClassVar[tuple[str, ...]] = ()  # those of them that `save` does not write

    @classmethod
    def sniff(cls, head: bytes) -> bool:
        """Whether a file that begins with `head` has this format; called if the extension does not decide."""
        return False

    @abc.abstractmethod
    def load(self, path: Path) -> Map:
        """The map in a file. Raises `MapError`, which names the fault and, where possible, the line."""

    def companions(self, path: Path) -> Sequence[Path]:
        """The other files that `load` reads for this one, such as the picture that it names.

        A run's folder gets copies of all of them, in the same places relative to each other, so a file must name its
        companions relative to itself. If it names one by its whole path, the loader must prefer a file of that name
        next to it: the copy is put there. Raises `MapError` if the file cannot be read.
        """
        return ()

    @classmethod
    def save(cls, world: Map, path: Path) -> MapLoader:
        """Write a map to a file of this format, if the loader can; returns the loader that reads it again.

        Companions are written next to it and named relative to it: all files move to their final place once they are
        complete. `amorsim.save_map` reads the file back and checks that the cells are the same.
        """
        raise MapError(f"maps cannot be written as {' or '.join(cls.extensions)}")
