"""The formats of maps: which files of a folder are maps, and what can be written."""

from __future__ import annotations

import contextlib
from pathlib import Path

from amorsim.contracts import MapLoader
from amorsim.core.errors import PluginError
from amorsim.plugins.registry import Registry

__all__ = ["map_files", "written_endings"]

MOST_LISTED = 200  # files of a folder that are listed


def map_files(folder: Path, registry: Registry) -> list[str]:
    """The files of a folder that may be maps."""
    endings = {ending for name in registry.names("map_loader") for ending in _endings(name, registry)}
    return [path.name for path in sorted(folder.glob("*")) if path.suffix.lower() in endings][:MOST_LISTED]


def written_endings(registry: Registry) -> list[str]:
    """The endings of maps' files that can be written."""
    found: list[str] = []
    for name in registry.names("map_loader"):
        with contextlib.suppress(PluginError):
            cls = registry.get("map_loader", name)
            if cls.save.__func__ is not MapLoader.save.__func__:  # type: ignore[attr-defined]
                found += [ending for ending in cls.extensions if ending not in found]
    return found


def _endings(loader: str, registry: Registry) -> tuple[str, ...]:
    try:
        return tuple(registry.get("map_loader", loader).extensions)
    except Exception:  # a plugin's class, which may be anything
        return ()
