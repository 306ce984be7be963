"""The version of amorsim that is installed."""

from __future__ import annotations

import importlib.metadata

__all__ = ["version"]


def version() -> str:
    """The version, such as ``"0.3.0"``; ``"not installed"`` for sources that are only on the path."""
    try:
        return importlib.metadata.version("amorsim")
    except importlib.metadata.PackageNotFoundError:
        return "not installed"
