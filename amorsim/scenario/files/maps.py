"""Map files: which loader reads one, its options, and the file that a map was read from."""

from __future__ import annotations

import contextlib
import os
import tomllib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, cast

import attrs

from amorsim.contracts import MapLoader
from amorsim.core.arguments import checked, path_of
from amorsim.core.error_text import RAISED, error_in_words
from amorsim.core.errors import MapError, PluginError
from amorsim.core.files.atomic_files import replacing
from amorsim.core.files.reading import check_readable, is_file, is_folder, no_such_file, read_text, reason
from amorsim.core.maps.lost_cells import Lost, lost_cells
from amorsim.core.maps.map import Map
from amorsim.core.maps.same_cells import have_same_cells
from amorsim.core.parameters import ParameterError, describe
from amorsim.core.unknown_names import no_such
from amorsim.plugins.manager import default_registry
from amorsim.plugins.registry import Registry

__all__ = ["MapFile", "companions_of", "find_loader", "load_map", "read_map", "save_map", "write_map"]

_HEAD = 4096
_MOST_BYTES = 10**9  # of any map; loaders that hold it in memory as it is written ask for less

# What is often taken for a map, and what to do, by its extension.
_NO_MAPS = {
    ".dwg": ("a DWG drawing is", "save it as .dxf"),
    ".inc": ("a file that worlds of Stage include is", "give the .world"),
    ".pdf": ("a PDF is", "save it as .svg or .png"),
    ".scen": ("problems on a map of MovingAI are", "give the .map"),
    ".sdf": ("a world of Gazebo is", "save a map of it as .yaml, as map_saver of ROS does"),
    ".svgz": ("a compressed drawing is", "unpack it to a plain .svg"),
    ".webp": ("a WebP picture is", "save it as .png"),
}


@attrs.frozen(kw_only=True)
class MapFile:
    """A file that a map was read from, and the loader that read it, which holds its options."""

    path: Path
    loader: MapLoader


@checked
def load_map(path: str | Path, *, use: str | None = None, registry: Registry | None = None, **options: Any) -> Map:
    """The map in a file.

    Parameters
    ----------
    path
        The file. Its extension, or else its first bytes, decide which loader reads it.
    use
        The loader's name, where neither decides.
    registry
        Where loaders are looked up; the default registry if none is given.
    options
        The fields of the loader, in SI units and radians: ``resolution=0.05``.

    Raises
    ------
    MapError
        If the file is not there or not to be read, if no loader knows it, if an option is unknown or of a
        wrong value, or if the file is not what it seems.
    """
    path = path_of(path, "path", "the path of a map's file")
    try:
        name, cls = find_loader(path, use, registry or default_registry())
    except PluginError as error:
        raise MapError(f"{path}: {error}") from error
    fields = describe(cls)
    for option in options:
        if option not in fields:
            raise MapError(f"{path}: {no_such('option', option, fields, whose=f'the loader {name!r}')}")
    try:
        loader = cls(**options)
    except ParameterError as error:
        raise MapError(f"{path}: option {error}") from error
    except TypeError as error:  # a required option that is not there
        raise MapError(f"{path}: options of {name!r}: {error}") from error
    return read_map(MapFile(path=path, loader=loader))


def read_map(file: MapFile) -> Map:
    """The map in a file, by the loader that is named with it; it remembers the file as its `source`.

    Raises
    ------
    MapError
        Whatever is wrong with the file.
    """
    try:
        found = file.loader.load(file.path)
    except MapError:
        raise
    except RAISED as error:  # a third party's loader
        loader = type(file.loader).__name__
        raise MapError(f"{file.path}: {loader} failed with {error_in_words(error)}") from error
    if not isinstance(found, Map):
        raise MapError(f"{file.path}: {type(file.loader).__name__} gave {found!r}, which is not a map")
    if getattr(file.loader, "resolution", 0.0) is None:  # what the loader took is what a run writes down
        file = attrs.evolve(file, loader=attrs.evolve(cast(Any, file.loader), resolution=found.resolution))
    return attrs.evolve(found, source=file, name=found.name or file.path.stem)


def companions_of(file: MapFile) -> list[Path]:
    """The other files that are read for a map's file, by their absolute paths.

    Raises
    ------
    MapError
        If the loader cannot name them, or one of them is not a file.
    """
    loader = type(file.loader).__name__
    try:
        found = file.loader.companions(file.path)
    except MapError:
        raise
    except RAISED as error:  # a third party's loader
        raise MapError(f"{file.path}: {loader}.companions failed with {error_in_words(error)}") from error
    if not isinstance(found, Sequence) or not all(isinstance(path, Path) for path in found):
        raise MapError(f"{file.path}: {loader}.companions gave {found!r}; expected a list of paths")
    # Not resolve(), for the same reason as where a scenario names its map.
    paths = [Path(os.path.abspath(file.path.parent / path)) for path in found]  # noqa: PTH100
    for path in paths:
        if not is_file(path):
            raise MapError(f"{file.path}: {path}, which it should read, is not a file")
    return paths


@checked
def save_map(world: Map, path: str | Path, *, use: str | None = None, registry: Registry | None = None) -> Map:
    """Write a map into a file, and read it again: the map that is returned names the file as its `source`.

    The file's extension selects the format: ``.wld`` as lines, ``.png`` or ``.bmp`` as pixels, ``.yaml`` as a pair
    of files for ROS, and so on. Its cells, and so all ranges and collisions, are the same.

    Parameters
    ----------
    world
        The map.
    path
        The file. One that is there is replaced once the new one is whole.
    use
        The loader's name, where the extension does not decide.
    registry
        Where loaders are looked up; the default registry if none is given.

    Raises
    ------
    MapError
        If the format cannot hold the map exactly, the file cannot be written, or no loader knows the extension. The
        file that was there is there still.
    """
    path = path_of(path, "path", "the path of a map's file")
    with _replacing_map(world, path, use, registry or default_registry()) as again:
        if not have_same_cells(again, world):
            cls = type(again.source.loader).__name__
            raise MapError(f"read again, it has other cells; {cls} cannot hold this map exactly")
    return _now_in(again, path)


def write_map(
    world: Map,
    path: str | Path,
    *,
    force: bool = False,
    use: str | None = None,
    more: str = "",
    registry: Registry | None = None,
) -> tuple[Map, Lost]:
    """Write a map into a file as well as its format can; returns the map as read again, and what was lost.

    Parameters
    ----------
    world, path, use, registry
        As for `save_map`.
    force
        Whether files that are there are replaced, once the new ones are whole.
    more
        The content of the file, a text, after the map.

    Raises
    ------
    MapError
        If a file is there and is not to be replaced, cannot be written, or no loader knows the extension. What was
        there is there still.
    """
    path = Path(path)

    with _replacing_map(world, path, use, registry or default_registry()) as again:
        folder = again.source.path.parent
        for made in () if force else sorted(folder.rglob("*")):
            place = path.parent / made.relative_to(folder)
            if made.is_file() and os.path.lexists(place):
                raise MapError(f"{place.name} is there already; --force replaces it")
        if more:
            with again.source.path.open("a", encoding="utf-8", newline="") as file:
                file.write(more)
    return _now_in(again, path), lost_cells(world, again)


@contextlib.contextmanager
def _replacing_map(world: Map, path: Path, use: str | None, registry: Registry) -> Iterator[Map]:
    """The map as it is read again from a temporary file, which replaces `path` unless the block raises a `MapError`."""
    try:
        cls = _writer(path, use, registry)
    except PluginError as error:
        raise MapError(f"{path}: {error}") from error
    with replacing(path, MapError) as new:
        try:
            yield read_map(_written(cls, world, new))
        except MapError as error:
            raise MapError(f"{path}: cannot be written: {str(error).removeprefix(f'{new}: ')}") from error


def _now_in(again: Map, path: Path) -> Map:
    return attrs.evolve(again, source=MapFile(path=path, loader=again.source.loader))


def _written(cls: type[MapLoader], world: Map, path: Path) -> MapFile:
    try:
        return MapFile(path=path, loader=cls.save(world, path))
    except (MapError, OSError):
        raise
    except RAISED as error:  # a third party's loader
        raise MapError(f"{cls.__name__} failed with {error_in_words(error)}") from error


def _writer(path: Path, use: str | None, registry: Registry) -> type[MapLoader]:
    if use is not None:
        found: type[MapLoader] = registry.get("map_loader", use)
        return found
    known: list[str] = []
    for entry in registry.entries("map_loader"):
        cls: type[MapLoader] = registry.get("map_loader", entry.name)
        if path.suffix.lower() in cls.extensions:
            return cls
        known += _writable(cls)
    raise MapError(
        f"{path}: no map can be written with this extension; those that can: {', '.join(sorted(set(known)))}"
    )


def _writable(cls: type[MapLoader]) -> list[str]:
    """The extensions of the files that a loader writes."""
    writes = cls.save.__func__ is not MapLoader.save.__func__  # type: ignore[attr-defined]  # a class's method
    return [extension for extension in cls.extensions if writes and extension not in cls.read_only]


def find_loader(path: Path, use: str | None, registry: Registry) -> tuple[str, type[MapLoader]]:
    """Name and class of the loader for a file: by name, else by extension, else by the file's first bytes.

    Raises
    ------
    MapError
        If there is no such file, it is a folder or not to be read, or no loader knows it.
    PluginError
        If the loader's name is unknown.
    """
    head = _head(path)
    if use is not None:
        return use, registry.get("map_loader", use)
    loaders: list[tuple[str, type[MapLoader]]] = []
    for entry in registry.entries("map_loader"):
        try:
            loaders.append((entry.name, registry.get("map_loader", entry.name)))
        except PluginError as error:
            registry.report(str(error))
    extension = path.suffix.lower()
    by_extension = [(name, cls) for name, cls in loaders if extension in cls.extensions]
    # Where two claim an extension, the one that knows the file's first bytes reads it.
    for name, cls in (*by_extension, *loaders):
        if (len(by_extension) == 1 and (name, cls) in by_extension) or _knows(cls, head):
            return name, cls
    if by_extension:
        return by_extension[0]
    if extension in _NO_MAPS:
        what, advice = _NO_MAPS[extension]
        raise MapError(f"{path}: {what} not a map that amorsim reads; {advice}")
    known = ", ".join(sorted({suffix for _, cls in loaders for suffix in cls.extensions}))
    raise MapError(f"{path}: no map of a known format; known extensions: {known}")


def _knows(cls: type[MapLoader], head: bytes) -> bool:
    """Whether a loader accepts a file's first bytes; one that raises does not."""
    try:
        return bool(cls.sniff(head))
    except RAISED:
        return False


def _of_a_scenario(path: Path) -> str:
    """How to have the map of a registered scenario, if one is called so, with or without its ending."""
    registry = default_registry()
    for entry in registry.entries("scenario"):
        try:
            name = tomllib.loads(read_text(registry.file("scenario", entry.name)))["world"]["map"]
        except (OSError, ValueError, LookupError, TypeError):  # a plugin's may be anything
            continue
        if isinstance(name, str) and path.name in (name, Path(name).stem):
            return f". The scenario {entry.name!r} has one of this name: amorsim convert {entry.name} {name}"
    return ""


def _head(path: Path) -> bytes:
    try:
        check_readable(path, _MOST_BYTES)
        with path.open("rb") as file:
            return file.read(_HEAD)
    except FileNotFoundError:
        raise MapError(f"{path}: {no_such_file(path)}{_of_a_scenario(path)}") from None
    except IsADirectoryError:
        raise MapError(f"{path}: this is a folder; a map is a file") from None
    except PermissionError:
        # On Windows, opening a folder is refused in these words too.
        problem = "this is a folder; a map is a file" if is_folder(path) else "no permission to read this file"
        raise MapError(f"{path}: {problem}") from None
    except (OSError, ValueError) as error:
        raise MapError(f"{path}: cannot be read: {reason(error)}") from None
