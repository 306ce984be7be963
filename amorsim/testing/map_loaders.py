"""How readers of map files are tried."""

from __future__ import annotations

import os
import random
import shutil
import tempfile
from pathlib import Path

from amorsim.contracts import MapLoader
from amorsim.core.error_text import RAISED, error_in_words
from amorsim.core.errors import MapError
from amorsim.core.maps.map import Map
from amorsim.testing.failure import Who

__all__ = ["check_map_loader"]


def check_map_loader(who: Who, loader: MapLoader, path: Path | None) -> None:
    """Try a loader with files of other formats, and with one of its own, if there is one."""
    noise = random.Random(1)
    junk = [b"", b"\x00" * 64, bytes(noise.randrange(256) for _ in range(4096)), b"no map at all\n"]
    for head in junk:
        with who.calling("sniff"):
            answer = loader.sniff(head)
        who.require(isinstance(answer, bool), "sniff", f"sniff() of {head[:8]!r}...", "true or false", repr(answer))
    with tempfile.TemporaryDirectory() as folder:
        for i, content in enumerate(junk):
            file = Path(folder) / f"junk{i}{loader.extensions[0]}"
            file.write_bytes(content)
            _load_or_refuse(who, loader, file, f"a file that begins with {content[:8]!r}")
        missing = Path(folder) / f"none{loader.extensions[0]}"
        _load_or_refuse(who, loader, missing, "a file that is not there", refuse=True)
    if path is not None:
        with who.calling("load"):
            first, second = loader.load(path), loader.load(path)
        who.require(isinstance(first, Map), "load", f"load({path.name})", "a Map", type(first).__name__)
        who.require(first == second, "determinism", f"a second load({path.name})", "the same map", "another one")
        _check_companions(who, loader, path.absolute(), first)


def _check_companions(who: Who, loader: MapLoader, path: Path, world: Map) -> None:
    """Copy a file with those that the loader names, as into a run's folder, and see whether it is the same map."""
    with who.calling("companions"):
        found = list(loader.companions(path))
    for each in found:
        what = f"companions({path.name})"
        who.require(isinstance(each, Path), "companions", what, "paths", repr(each))
        who.require((path.parent / each).is_file(), "companions", what, "files that are there", each)
    files = [path, *(Path(os.path.abspath(path.parent / each)) for each in found)]  # noqa: PTH100
    root = Path(os.path.commonpath([each.parent for each in files]))
    with tempfile.TemporaryDirectory() as folder:
        copies = [Path(folder) / each.relative_to(root) for each in files]
        for each, copy in zip(files, copies, strict=True):
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(each, copy)
        what = f"a copy of {path.name} and its companions in another folder"
        with who.calling("companions"):
            named = {Path(os.path.abspath(copies[0].parent / each)) for each in loader.companions(copies[0])}  # noqa: PTH100
        who.require(named == set(copies[1:]), "companions", what, "the copies as its companions", sorted(named))
        try:
            again = loader.load(copies[0])
        except RAISED as error:
            who.fail("companions", f"{what}: expected the same map, found {error_in_words(error)}")
        who.require(again == world, "companions", what, "the same map", "another one")


def _load_or_refuse(who: Who, loader: MapLoader, path: Path, what: str, *, refuse: bool = False) -> None:
    try:
        found = loader.load(path)
    except MapError:
        return
    except RAISED as error:
        who.fail("errors", f"load() of {what}: expected a MapError, found {error_in_words(error)}")
    who.require(isinstance(found, Map), "load", f"load() of {what}", "a Map", type(found).__name__)
    who.require(not refuse, "errors", f"load() of {what}", "a MapError", "a map")
