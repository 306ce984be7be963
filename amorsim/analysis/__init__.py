"""Analysis of runs, studies and trajectories: errors of estimates, their consistency, and what may be claimed.

The names are looked up when first used; only what draws needs matplotlib.
"""

from amorsim.core.lazy_names import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__, __file__)
