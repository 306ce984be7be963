"""The contract of world generators."""

from __future__ import annotations

import abc

from amorsim.core.draws import Draws
from amorsim.core.maps.map import Map

__all__ = ["WorldGenerator"]


class WorldGenerator(abc.ABC):
    """Generates worlds. Its fields are the parameters next to ``generate`` in a scenario's map."""

    @abc.abstractmethod
    def generate(self, draws: Draws) -> Map:
        """A world, with a free place for the robot as its `start`.

        All that is random comes from `draws`, which has one row, so that the same seed gives the same cells on every
        machine: leave out sines and the like, whose last bits differ. It must end, so bound all tries. Raises
        `MapError` if the parameters admit no world; the message names those to change.
        """
