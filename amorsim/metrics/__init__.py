"""Metrics: a number for each replica of a run, for studies and comparisons."""

from amorsim.core.lazy_names import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__, __file__)
