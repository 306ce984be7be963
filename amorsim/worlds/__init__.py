"""Generated worlds: ``am.worlds.office(seed=7)`` is a `Map`. The generators' classes are in the modules.

With ``per="replica"``, or a `Distribution` in the place of a number, each replica of a simulation gets a world of its
own; the `Map` is that of replica 0.
"""

from amorsim.core.lazy_names import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__, __file__)
