"""Each address that is printed ends with what the page is to read."""

from __future__ import annotations

from typing import Any

from amorsim.ui.serve.launch_url import LaunchUrl


class Door:
    host, is_for_this_machine = "127.0.0.1", True

    def __init__(self) -> None:
        self.used: list[Any] = []

    def new_address(self, used: Any) -> str:
        self.used.append(used)
        return f"http://127.0.0.1:1/{len(self.used)}"


def test_a_window_for_a_class_has_addresses_that_say_so() -> None:
    said: list[str] = []
    door: Any = Door()
    LaunchUrl(browser=False, say=said.append, complain=said.append, fragment="#lecture").ready(door)
    door.used[0]()
    assert said == ["http://127.0.0.1:1/1#lecture", "for another browser: http://127.0.0.1:1/2#lecture"]
