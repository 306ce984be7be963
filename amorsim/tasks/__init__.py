"""Tasks for learners: what is observed and rewarded, and when an episode ends."""

from amorsim.core.lazy_names import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__, __file__)
