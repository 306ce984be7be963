"""The map of a Stage world: its floor plan, with what else in it cannot move."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import ClassVar

import attrs

from amorsim.contracts import MapLoader
from amorsim.core.errors import MapError, ScenarioError
from amorsim.core.map import Map
from amorsim.core.parameters import parameter
from amorsim.foreign.stage.bitmaps import fill
from amorsim.foreign.stage.entities import read_world
from amorsim.foreign.stage.notes import Notes
from amorsim.foreign.stage.plan import Plan, plan_of
from amorsim.foreign.stage.tokens import looks_like_stage

__all__ = ["StageMap"]


@attrs.frozen(kw_only=True)
class StageMap(MapLoader):
    """The walls of Stage worlds (``.world``): floor plans, boundaries, and models that overlap others.

    A bitmap is stretched over the size of its model, about its pose; pixels darker than mid grey are walls. Other
    models are obstacles, robots and so on, for which the scenario loader of the same name cares.
    """

    extensions: ClassVar[tuple[str, ...]] = (".world",)

    resolution: float | None = parameter(None, unit="m", gt=0, help="side of a cell; without it, what the world says")
    crop_bitmaps: bool = parameter(
        False, help="whether the dark part alone of a bitmap fills the model's size, as in Stage, and not all of it"
    )

    @classmethod
    def sniff(cls, head: bytes) -> bool:
        """Whether a file's first bytes may be those of a world of Stage."""
        return looks_like_stage(head)

    def load(self, path: Path) -> Map:
        """The map of a world.

        Raises
        ------
        MapError
            If a file cannot be read, or a line of it is wrong: then with its number.
        """
        plan = self._plan(path)
        try:
            lines = Map.from_segments(
                plan.segments,
                resolution=plan.resolution,
                extent=plan.extent,
                warnings=plan.remarks,
                name=path.stem,
            )
            if not plan.pictures:
                return lines
            cells = lines.to_array()
            for picture in plan.pictures:
                fill(cells, plan.resolution, lines.origin[:2], picture.dark, picture.box)
            return Map.from_array(
                cells, resolution=plan.resolution, origin=lines.origin, warnings=plan.remarks, name=path.stem
            )
        except MapError as error:
            raise MapError(f"{path}: {error}") from error

    def companions(self, path: Path) -> Sequence[Path]:
        """The included files and the bitmaps."""
        try:
            world = read_world(path)
        except ScenarioError as error:
            raise MapError(str(error)) from error
        return (*world.files[1:], *self._plan(path).bitmaps)

    def _plan(self, path: Path) -> Plan:
        notes = Notes()
        try:
            plan = plan_of(read_world(path), notes, crop_bitmaps=self.crop_bitmaps, resolution=self.resolution)
            notes.raise_if_any()
        except ScenarioError as error:
            raise MapError(str(error)) from error
        return plan
