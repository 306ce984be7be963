"""Where and with what a table was measured."""

from __future__ import annotations

import datetime
import importlib.metadata
import os
import platform

from amorsim.runs.machine import processor

__all__ = ["circumstances"]

_PACKAGES = ("amorsim", "numpy", "numba", "ir-sim", "navground", "raycast2D", "vmas", "torch")


def circumstances() -> dict[str, str]:
    """Date, processor, system, load at the start, and versions, each in words."""
    found = {
        "date": datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d %H:%M UTC"),
        "processor": f"{processor()}, {os.cpu_count()} cores",
        "system": f"{platform.system()} {platform.release()}, Python {platform.python_version()}",
    }
    if hasattr(os, "getloadavg"):
        found["load"] = f"{os.getloadavg()[0]:.1f} processes were running when it began"
    for package in _PACKAGES:
        try:
            found[package] = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            found[package] = "not installed"
    return found
