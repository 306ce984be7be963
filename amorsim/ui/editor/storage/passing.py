"""The temporary folder of an Editor's session."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

from amorsim.core.errors import AmorsimError
from amorsim.core.files.temporary_folders import make_folder, remove_left

__all__ = ["PassingFolder"]


class PassingFolder:
    """A temporary folder of this process. Making one removes those of processes that have ended."""

    def __init__(self) -> None:
        parent = Path(tempfile.gettempdir())
        remove_left(parent)
        self._path: Path | None = make_folder(parent, "amorsim-edit-")

    @property
    def path(self) -> Path:
        """The folder.

        Raises
        ------
        AmorsimError
            If it has been removed: nothing more is to be written there.
        """
        if self._path is None:
            raise AmorsimError("the Editor is ending")
        return self._path

    def remove(self) -> None:
        """Delete it with all that it holds; calling it again does nothing."""
        if self._path is not None:
            shutil.rmtree(self._path, ignore_errors=True)
            self._path = None
