"""amorsim: mobile robots in the plane, where every quantity is true, measured and estimated.

Everything that a user or a plugin author needs is here; the names are looked up when first used, so that importing
the package costs nothing.
"""

import importlib

from amorsim.core.display import show_by
from amorsim.core.lazy_names import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__, __file__)

show_by(lambda value: importlib.import_module("amorsim.reports.notebook").bundle(value))
