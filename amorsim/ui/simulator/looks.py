"""The robot that is selected in each window."""

from __future__ import annotations

__all__ = ["Looks"]


class Looks:
    """Robots by window, each at first that of place 0."""

    def __init__(self) -> None:
        self._robots: dict[str, int] = {}

    def of(self, window: str) -> int:
        """The robot that a window has selected, which is among `robots` from now on."""
        return self._robots.setdefault(window, 0)

    def turn(self, window: str, robot: int) -> None:
        """Let a window look at another robot."""
        self._robots[window] = robot

    def close(self, window: str) -> None:
        """Forget a window."""
        self._robots.pop(window, None)

    @property
    def robots(self) -> list[int]:
        """All selected robots, each once; the first robot if none is selected."""
        return sorted(set(self._robots.values())) or [0]
