"""A folder as `amorsim new` makes it, for tests that run scenarios from files."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

__all__ = ["make_study"]


def make_study(folder: Path, controller: str | None = None) -> Path:
    """The path of a scenario with a map of 8 m x 5 m, and the controller of the template or the one given."""
    template = resources.files("amorsim.cli") / "template"
    folder.mkdir()
    for name in ("scenario.toml", "controller.py", "rooms.wld"):
        (folder / name).write_text((template / name).read_text(encoding="utf-8"), encoding="utf-8")
    if controller is not None:
        (folder / "controller.py").write_text(controller, encoding="utf-8")
    return folder / "scenario.toml"
