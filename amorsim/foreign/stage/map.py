"""The map of a Stage world: its floor plan, and other models that cannot move."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import ClassVar

import attrs
import numpy as np
from PIL import Image

from amorsim.contracts import MapLoader
from amorsim.core.errors import MapError, ScenarioError
from amorsim.core.maps.map import Map
from amorsim.core.parameters import parameter
from amorsim.foreign.stage.bitmaps import fill
from amorsim.foreign.stage.entities import read_world
from amorsim.foreign.stage.notes import Notes
from amorsim.foreign.stage.plan import MOST_CELLS, Plan, plan_of
from amorsim.foreign.stage.tokens import looks_like_stage

__all__ = ["StageMap"]

# Stage has no such type by itself.
_FLOORPLAN = """\
define floorplan model
(
  color "gray30"
  boundary 0
  gui_nose 0
  gui_grid 0
  gui_outline 0
  gripper_return 0
  fiducial_return 0
)
"""


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
        """Whether a file's first bytes are those of a world of Stage, whatever its extension is."""
        return looks_like_stage(head, is_sure=True)

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

    @classmethod
    def save(cls, world: Map, path: Path) -> StageMap:
        """Write a map's cells as a bitmap, and a world with it as its floor plan; see `amorsim.save_map`."""
        rows, cols = world.shape
        if rows * cols > MOST_CELLS:
            raise MapError(f"it has {rows * cols:.3g} cells; expected {MOST_CELLS:g} at most, so a coarser resolution")
        left, bottom, yaw = world.origin
        if yaw:
            raise MapError("the cells of a Stage world lie along x and y, and this map is turned")
        picture = path.with_suffix(".png")
        Image.fromarray(np.where(world.to_array()[::-1], 0, 255).astype(np.uint8)).convert("1").save(picture)
        width, height = world.size
        place = f"size [{width!r} {height!r} 1] pose [{left + width / 2!r} {bottom + height / 2!r} 0 0]"
        plan = f'floorplan\n(\n  name "{path.stem}"\n  bitmap "{picture.name}"\n  {place}\n)\n'
        text = f"# Written by amorsim.\n\nresolution {world.resolution!r}\n\n{_FLOORPLAN}\n{plan}"
        path.write_text(text, encoding="utf-8", newline="\n")
        return cls()

    def _plan(self, path: Path) -> Plan:
        notes = Notes()
        try:
            plan = plan_of(read_world(path), notes, crop_bitmaps=self.crop_bitmaps, resolution=self.resolution)
            notes.raise_if_any()
        except ScenarioError as error:
            raise MapError(str(error)) from error
        return plan
