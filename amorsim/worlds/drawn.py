"""Worlds that differ between replicas: each draws a generator's parameters, or all that is random in it."""

from __future__ import annotations

import types
import typing
from typing import Any, Self

import attrs

from amorsim.contracts import WorldGenerator
from amorsim.core.distributions import STUDY, Distribution, drawn
from amorsim.core.errors import MapError
from amorsim.core.maps.map import Map
from amorsim.core.parameters import Parameter, ParameterError, describe, parameter
from amorsim.worlds.made import MadeWorld, make_world

__all__ = ["DrawnParameter", "DrawnWorld", "can_be_drawn", "map_of", "middle_of", "origin_of"]


@attrs.frozen(kw_only=True)
class DrawnParameter:
    """A parameter of a generator that is drawn; `per` sets whether every replica draws its own, or the study one."""

    name: str
    distribution: Distribution
    per: str = parameter("replica", choices=("replica", "study"), help="who draws: each replica, or the study once")


@attrs.frozen(kw_only=True)
class DrawnWorld:
    """The origin of a map that each replica has of its own.

    Attributes
    ----------
    generator
        The generator; its parameters that are drawn have the middle of their distributions.
    seed
        Of all draws.
    per
        Whether what the generator draws differs between replicas (``"replica"``) or not (``"study"``).
    drawn
        The parameters that are drawn.
    replica
        The replica that the map is of; two origins are equal without it.
    """

    generator: WorldGenerator
    seed: int = 0
    per: str = parameter("study", choices=("study", "replica"), help="who draws: each replica, or the study once")
    drawn: tuple[DrawnParameter, ...] = ()
    replica: int = attrs.field(default=0, eq=False)

    @property
    def differs(self) -> bool:
        """Whether replicas have different maps."""
        return self.per == "replica" or any(one.per == "replica" for one in self.drawn)

    def of(self, replica: int) -> Self:
        """The origin of the map of a replica."""
        return attrs.evolve(self, replica=replica)

    def made(self) -> MadeWorld:
        """The generator with the parameters of its replica, and the draws that it gets.

        Raises
        ------
        MapError
            If the generator does not accept a number that was drawn; it names parameter and replica.
        """
        values: dict[str, Any] = {}
        fields = describe(type(self.generator))
        for one in self.drawn:
            replica = STUDY if one.per == "study" else self.replica
            number = drawn(one.distribution, self.seed, ("world", "parameter", one.name), replica)
            values[one.name] = _whole(number, one.distribution) if _is_whole(fields[one.name]) else number
        given: Any = self.generator  # an attrs class, as every component
        try:
            generator = attrs.evolve(given, **values)
        except ParameterError as error:
            per = {one.name: one.per for one in self.drawn}.get(error.name)
            whom = "the study" if per == "study" else f"replica {self.replica}"
            raise MapError(
                f"{type(self.generator).__name__} with seed {self.seed}: {error}, drawn for {whom}; take a narrower "
                "distribution"
            ) from error
        return MadeWorld(generator=generator, seed=self.seed, replica=self.replica if self.per == "replica" else 0)

    def make(self) -> Map:
        """The map of its replica, which has this as its `source`. Raises `MapError` as `made` and `make_world` do."""
        return attrs.evolve(make_world(self.made()), source=self)


def map_of(world: Map, replica: int) -> Map:
    """The map of a replica: the one made for it by a `DrawnWorld`; any other map is returned as it is."""
    origin = origin_of(world)
    return world if origin is None or origin.replica == replica else origin.of(replica).make()


def origin_of(world: Map) -> DrawnWorld | None:
    """The origin of a map if replicas have different ones, else None."""
    origin = world.source
    return origin if isinstance(origin, DrawnWorld) and origin.differs else None


def can_be_drawn(field: Parameter, distribution: Distribution | None = None) -> str:
    """Why a parameter cannot be drawn (from this distribution), in words; empty if it can be."""
    if float not in _kinds(field) and int not in _kinds(field):
        return f"only a number can be drawn, and this is {field.type_name}"
    if distribution is None or not _is_whole(field):
        return ""
    if distribution.kind == "uniform" and all(value.is_integer() for value in distribution.values):
        return ""
    return "a whole number is drawn as { uniform = [LOW, HIGH] }, both whole numbers, which are among the drawn"


def middle_of(field: Parameter, distribution: Distribution) -> float | int:
    """The middle of a distribution, which stands for a parameter until it is drawn."""
    first, second = distribution.values
    middle = first if distribution.kind == "normal" else first + 0.5 * (second - first)
    return int(middle) if _is_whole(field) else middle


def _kinds(field: Parameter) -> tuple[Any, ...]:
    kind = field.type
    is_union = isinstance(kind, types.UnionType) or typing.get_origin(kind) is typing.Union
    return typing.get_args(kind) if is_union else (kind,)


def _is_whole(field: Parameter) -> bool:
    return float not in _kinds(field)


def _whole(number: float, distribution: Distribution) -> int:
    """A whole number between the ends of a uniform distribution, all equally likely."""
    low, high = (int(value) for value in distribution.values)
    share = (number - low) / (high - low) if high > low else 0.0
    return min(low + int(share * (high - low + 1)), high)
