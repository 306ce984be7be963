"""The scenario that may be meant by a path at which there is no file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from amorsim.core.errors import did_you_mean
from amorsim.core.files.reading import is_folder

__all__ = ["SCENARIO_PATH", "mistaken"]

SCENARIO_PATH = "the path of a scenario's file, or the name of a bundled one, such as 'demo'"
"""The words for what names a scenario."""


def mistaken(path: Path, problem: str, bundled: Sequence[str]) -> str:
    """The problem with a path that is not a scenario's file, with the scenarios that may be meant.

    Of a folder these are its files, of a name without an ending those that are bundled.
    """
    if is_folder(path):
        files = sorted(path.glob("*.toml"), key=lambda file: (file.name != "scenario.toml", file.name))
        return f"it is a folder; expected a scenario, such as {files[0] if files else 'demo'}"
    if path.suffix:
        is_bundled = str(path) == f"{path.stem}.toml" and path.stem in bundled
        return f"{problem}; the bundled scenario is called {path.stem}" if is_bundled else problem
    return f"{problem}; bundled scenarios: {', '.join(bundled) or 'none'}.{did_you_mean(str(path), bundled)}"
