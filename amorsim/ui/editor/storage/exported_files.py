"""Files made from the document that was read: its world in another format, its robots and sensors as models."""

from __future__ import annotations

import base64
import io
from pathlib import Path
from typing import Any

from amorsim.core.errors import AmorsimError, MapError
from amorsim.core.files.reading import is_there
from amorsim.core.files.temporary_folders import temporary_folder
from amorsim.core.maps.map import Map
from amorsim.plugins.registry import Registry
from amorsim.render.picture import draw_map
from amorsim.scenario.files.map_words import lost_in_words, needed_options
from amorsim.scenario.files.maps import write_map
from amorsim.scenario.files.model_files import save_device, save_robot
from amorsim.scenario.reading.partial import Partial
from amorsim.scenario.spec import Robot
from amorsim.ui.editor.inspectors.things import Thing

__all__ = ["picture_of", "save_model", "write_world"]


def write_world(world: Map | None, target: Path, *, is_trial: bool, force: bool, registry: Registry) -> dict[str, Any]:
    """Write the world into a file, or only try; returns what is lost, in words, and the options to read it with.

    Raises
    ------
    AmorsimError
        If it cannot be written there.
    """
    if world is None:
        raise AmorsimError("the world cannot be read; mend its faults first")
    if is_there(target) and not force:
        raise AmorsimError(f"{target.name} is there already; name another file")
    with temporary_folder("world") as folder:
        file = folder / target.name if is_trial else target
        try:
            again, lost = write_map(world, file, force=True, registry=registry)
        except MapError as error:
            raise MapError(str(error).replace(f"{file.parent}/", "")) from None
        rows, columns = again.shape
        words = [f"{columns} × {rows} cells of {again.resolution:g} m", lost_in_words(lost), *_unkept(world, target)]
        return {"words": words, "is_lossy": not lost.is_nothing, "options": needed_options(again)}


def _unkept(world: Map, target: Path) -> list[str]:
    """The parts of the file besides cells that one format keeps and another does not."""
    source = getattr(world.source, "path", None)
    found = [f"warning: {one}" for one in world.warnings]
    if source is None or source == target:
        return found
    if source.suffix.lower() == ".wld":
        lines = source.read_text(encoding="utf-8", errors="replace").splitlines()
        comments = sum(1 for line in lines if ";" in line)
        if comments:
            found.append(f"{comments} comments of {source.name} are not kept")
        if any(line.split()[:1] in (["push"], ["pop"]) for line in lines):
            found.append("groups of walls (push and pop) are not kept")
    if world.segments is not None and target.suffix.lower() not in (".wld", ".svg", ".dxf", ".geojson", ".json"):
        found.append(f"walls become cells of {world.resolution:g} m: single walls can no longer be moved")
    return found


def picture_of(world: Map | None, kind: str, title: str, registry: Registry) -> str:
    """The world as a PNG or an SVG, in base 64."""
    if world is None:
        raise AmorsimError("the world cannot be read; mend its faults first")
    if kind == "png":
        data = io.BytesIO()
        draw_map(world, title=title).save(data, format="PNG")
        return base64.b64encode(data.getvalue()).decode()
    with temporary_folder("world") as folder:
        file = folder / "world.svg"
        write_map(world, file, registry=registry)
        return base64.b64encode(file.read_bytes()).decode()


def save_model(partial: Partial, thing: Thing, sensor: str, target: Path, parent: str, registry: Registry) -> str:
    """Write a robot as a model, or one of its sensors as a device: only what differs from its parent.

    Raises
    ------
    AmorsimError
        If it cannot be read whole, or written.
    """
    if is_there(target):
        raise AmorsimError(f"{target.name} is there already; name another file")
    if not thing["robots"] or thing["faults"]:
        raise AmorsimError(f"{thing['name']}: mend its faults first")
    robot: Robot = partial.robots[thing["robots"][0]]
    if not sensor:
        save_robot(robot, target, model=parent or None, registry=registry)
    elif sensor in robot.sensors:
        save_device(robot.sensors[sensor], target, model=parent, registry=registry)
    else:
        raise AmorsimError(f"{robot.name} has no sensor {sensor!r}")
    return target.read_text(encoding="utf-8")
