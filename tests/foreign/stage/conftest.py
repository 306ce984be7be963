"""Worlds of Stage in a folder of their own, and the real ones, which others drew."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

MAPS = Path(__file__).resolve().parents[4] / "shared" / "maps" / "stage"

Write = Callable[..., Path]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """Writes a world, and other files by their names; returns the world's path."""

    def written(text: str, **others: str) -> Path:
        for name, other in others.items():
            (tmp_path / f"{name}.inc").write_text(other)
        path = tmp_path / "lab.world"
        path.write_text(text)
        return path

    return written


@pytest.fixture
def real() -> Callable[[str], Path]:
    """The path of a real file, where they are."""

    def found(name: str) -> Path:
        if not (MAPS / name).is_file():
            pytest.skip(f"no {MAPS / name}")
        return MAPS / name

    return found
