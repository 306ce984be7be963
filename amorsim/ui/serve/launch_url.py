"""Telling a user where the window is: an address for him, one for his browser, and then one for the next browser."""

from __future__ import annotations

import contextlib
from collections.abc import Callable

from amorsim.core.errors import AmorsimError
from amorsim.ui.serve.opening import OpeningPage
from amorsim.ui.serve.security import Door

__all__ = ["LaunchUrl"]

Say = Callable[[str], None]


class LaunchUrl:
    """Prints the addresses of a server's door; each works once.

    Parameters
    ----------
    browser
        Whether to open the window in the browser.
    say, complain
        Called with the addresses, and with warnings.
    fragment
        What each address ends with, such as ``"#lecture"``; the page reads it.
    """

    def __init__(self, *, browser: bool, say: Say, complain: Say, fragment: str = "") -> None:
        self._fragment = fragment
        self._browser, self._say, self._complain = browser, say, complain
        self._opening: list[OpeningPage] = []

    def ready(self, door: Door) -> None:
        """The server answers from now on."""
        if not door.is_for_this_machine:
            self._complain(
                f"served on {door.host} without encryption: anyone who can read this network's traffic can see the "
                f"window and take it over. Where you do not trust the network, leave the host out and forward the port "
                f"by ssh -L"
            )
        self._say(door.new_address(used=lambda: self._invite(door)) + self._fragment)
        if self._browser:
            try:
                self._opening.append(OpeningPage(door.new_address(used=self.forget) + self._fragment))
            except AmorsimError as error:
                self._complain(str(error))
            else:
                self._opening[-1].open()

    def _invite(self, door: Door) -> None:
        """Print where another browser gets in, once the address that was printed last has been used."""
        with contextlib.suppress(OSError):  # nobody reads the output any more
            self._say(f"for another browser: {door.new_address(used=lambda: self._invite(door))}{self._fragment}")

    def forget(self) -> None:
        """Remove the page that leads the browser to the window; may be called again."""
        for page in self._opening:
            page.remove()
