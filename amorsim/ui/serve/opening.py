"""Opening the window in the browser, with its token out of the list of processes, which every account can read."""

from __future__ import annotations

import html
import shutil
import tempfile
import threading
import webbrowser
from pathlib import Path

from amorsim.core.errors import AmorsimError
from amorsim.core.files.temporary_folders import make_folder

__all__ = ["OpeningPage"]

_PAGE = """<!doctype html>
<meta charset="utf-8">
<meta name="referrer" content="no-referrer">
<meta http-equiv="refresh" content="0; url={address}">
<title>amorsim</title>
<a href="{address}">Open the window</a>
"""


class OpeningPage:
    """A page that leads the browser to an address, in a file that only the user can read.

    Raises
    ------
    AmorsimError
        If the file cannot be written.
    """

    def __init__(self, address: str) -> None:
        # A browser that is a snap sees another /tmp than we do, and of the home only what is not hidden.
        parent = Path("~").expanduser() if Path("/snap").is_dir() else None
        try:
            self._folder = make_folder(parent or Path(tempfile.gettempdir()), "amorsim-open-")  # 0700
            self.path = self._folder / "amorsim.html"
            self.path.touch(0o600, exist_ok=False)
            self.path.write_text(_PAGE.format(address=html.escape(address)), encoding="utf-8")
        except (OSError, RuntimeError) as error:  # RuntimeError: the user has no home
            reason = getattr(error, "strerror", None) or error
            raise AmorsimError(
                f"the browser is not opened: cannot write the page that leads it to the window ({reason}); "
                f"open the address by hand"
            ) from None

    def open(self) -> None:
        """Open it in the browser, without waiting: some browsers hold up the program that opens them."""
        threading.Thread(target=webbrowser.open, args=(self.path.as_uri(),), daemon=True).start()

    def remove(self) -> None:
        """Remove it, as soon as it has been used; may be called again."""
        shutil.rmtree(self._folder, ignore_errors=True)
