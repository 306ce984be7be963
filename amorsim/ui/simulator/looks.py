"""Which robot each window looks at."""

from __future__ import annotations

__all__ = ["Looks"]


class Looks:
    """Robots by window, each at first that of place 0."""

    def __init__(self) -> None:
        self._robots: dict[str, int] = {}

    def of(self, window: str) -> int:
        """The robot that a window looks at, which is counted among `robots` from now on."""
        return self._robots.setdefault(window, 0)

    def turn(self, window: str, robot: int) -> None:
        """Let a window look at another robot."""
        self._robots[window] = robot

    def close(self, window: str) -> None:
        """Forget a window."""
        self._robots.pop(window, None)

    @property
    def robots(self) -> list[int]:
        """All that are looked at, each once; that of place 0 where none is."""
        return sorted(set(self._robots.values())) or [0]
