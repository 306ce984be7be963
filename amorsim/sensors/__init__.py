"""Sensors: ideal readings of the world. The errors of real devices are in `amorsim.noise`."""

from amorsim.core.lazy_names import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__, __file__)
