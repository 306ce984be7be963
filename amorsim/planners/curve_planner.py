"""Dubins and Reeds-Shepp: the shortest curve of a car that touches no wall."""

from __future__ import annotations

import abc
from collections.abc import Sequence
from typing import ClassVar

import attrs
import numpy as np

from amorsim.algorithms.curves import Curve, all_curves
from amorsim.array_types import Array
from amorsim.contracts import Plan
from amorsim.core.maps.map import Map
from amorsim.core.parameters import parameter
from amorsim.core.shapes import Shape
from amorsim.kernels.search.curves import dubins_words, reeds_shepp_words
from amorsim.planners.on_poses import Ends, PosePlanner, Query

__all__ = ["CurvePlanner", "Dubins", "ReedsShepp"]


_SHOWN = 200  # radii over the spacing of poses in a plan: chords are shorter than their arcs by 1e-6 of them


@attrs.frozen(kw_only=True)
class CurvePlanner(PosePlanner):
    """A planner that tries curves between start and goal, the shortest first, and takes the first that is free."""

    name: ClassVar[str]

    budget: int = parameter(48, ge=0, help="curves tried at most")

    @abc.abstractmethod
    def curves(self, ends: Ends) -> list[Curve]:
        """The curves to try, the shortest first."""

    def plan(
        self, world: Map, start: Sequence[float], goal: Sequence[float], *, footprint: Shape | None = None
    ) -> Plan:
        """The plan for a car with this footprint; see `amorsim.Planner.plan`.

        Without a heading, start and goal have that of the line between them.
        """
        query, ends = self.query(world, start, goal, footprint)
        for name, pose in zip(("start", "goal"), ends, strict=True):
            blocked = query.blocked(name, pose)
            if blocked is not None:
                return blocked
        return self._first_free(query, ends)

    def _first_free(self, query: Query, ends: Ends) -> Plan:
        tried: list[Array] = []
        curves = self.curves(ends)
        spacing = self.spacing(query.shape.reach, self.radius / _SHOWN)
        for number, curve in enumerate(curves[: self.budget]):
            poses = curve.poses(spacing)
            gaps = query.gaps(poses)
            free = gaps >= self.clearance
            if free.all():
                poses[-1] = ends[1]
                return Plan(
                    status="found",
                    poses=poses,
                    length=curve.length,
                    cost=curve.length,
                    expanded=number + 1,
                    links=_links(tried),
                )
            tried.append(poses[: int(np.argmin(free)) + 1])
        if len(curves) > self.budget:
            message = f"the budget of {self.budget} curves was used up"
            return Plan(status="budget", expanded=len(tried), links=_links(tried), message=message)
        message = (
            f"none of the {len(curves)} {self.name} curves of radius {self.radius:g} m keeps the footprint "
            f"{self.clearance:g} m from the walls; "
        )
        message += query.narrow_place(ends) or "hybrid_a_star finds a way around them"
        return Plan(status="unreachable", expanded=len(tried), links=_links(tried), message=message)


def _links(tried: list[Array]) -> Array:
    """The lines (E, 4) of the curves that meet a wall, up to there."""
    pieces = [np.concatenate((poses[:-1, :2], poses[1:, :2]), axis=1) for poses in tried]
    return np.concatenate([np.empty((0, 4)), *pieces])


@attrs.frozen(kw_only=True)
class Dubins(CurvePlanner):
    """The shortest curve of a car that drives forwards only and turns no sharper than `radius`.

    It tries the words of Dubins, arcs and a straight line between them, in the order of their lengths, and takes the
    first that touches no wall. If none is free there may be a longer way around, which it does not look for: that is
    what `HybridAStar` does.
    """

    name: ClassVar[str] = "Dubins"

    def curves(self, ends: Ends) -> list[Curve]:
        """The words of Dubins."""
        return all_curves(dubins_words, *ends, self.radius)


@attrs.frozen(kw_only=True)
class ReedsShepp(CurvePlanner):
    """The shortest curve of a car that drives forwards and backwards and turns no sharper than `radius`.

    It tries the words of Reeds and Shepp, up to five arcs and straight lines, in the order of their lengths, and takes
    the first that touches no wall. If none is free there may be a longer way around: see `HybridAStar`. Headings of
    `Plan.poses` are the car's, also where it backs.
    """

    name: ClassVar[str] = "Reeds-Shepp"

    def curves(self, ends: Ends) -> list[Curve]:
        """The words of Reeds and Shepp."""
        return all_curves(reeds_shepp_words, *ends, self.radius)
