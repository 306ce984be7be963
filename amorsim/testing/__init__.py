"""For plugin authors: does a component keep its contract?

`check_component` is all that a plugin's own tests need; `example` makes a component from its class alone, and `Rig` is
the small world that components are tried in. `check_vector_env` checks an environment for learners.
"""

from __future__ import annotations

from amorsim.testing.check import check_component
from amorsim.testing.rig import Rig
from amorsim.testing.variants import example, variants
from amorsim.testing.vector_env import check_vector_env

__all__ = ["Rig", "check_component", "check_vector_env", "example", "variants"]
