"""The version of amorsim that is installed."""

from __future__ import annotations

import importlib.metadata

__all__ = ["__version__"]

try:
    __version__ = importlib.metadata.version("amorsim")
    """Such as ``"0.3.0"``; ``"not installed"`` for sources that are only on the path."""
except importlib.metadata.PackageNotFoundError:
    __version__ = "not installed"
