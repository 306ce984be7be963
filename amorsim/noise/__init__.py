"""Noise: chain elements for the errors of devices and of the contact between wheels and ground."""

from amorsim.core.lazy_names import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__, __file__)
