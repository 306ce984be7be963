"""How wheels follow commands, and how a body moves as they turn."""

from __future__ import annotations

from amorsim.drives.differential import Differential

__all__ = ["Differential"]
