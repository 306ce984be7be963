"""Drives: how wheels follow commands, and how the body moves as the wheels turn."""

from amorsim.core.lazy_names import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__, __file__)
