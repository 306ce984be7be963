"""Imports of a user's file from its own folder: ``from helpers import turn`` finds ``helpers.py`` there."""

from __future__ import annotations

import ast
import sys
from collections.abc import Mapping
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, SourceFileLoader
from importlib.util import spec_from_file_location
from pathlib import Path
from typing import Any, NamedTuple

__all__ = ["files_beside", "make_importable"]


def files_beside(path: Path, data: bytes | None = None) -> dict[str, Path]:
    """The files that a file of Python imports from its own folder, and those that these import, by name in the folder.

    Found in the text, wherever in it an import stands; of a package all its files. `data` is the file's content, if
    that has been read. What cannot be read or is not Python imports nothing.
    """
    folder = path.parent
    found: dict[str, Path] = {}
    waiting = [path]
    contents = {path: data}
    while waiting:
        file = waiting.pop()
        for name in _imported(file, contents.get(file)):
            module, package = folder / f"{name}.py", folder / name
            # A package comes before a module of the same name, as for Python.
            files = sorted(package.rglob("*.py")) if (package / "__init__.py").is_file() else [module]
            for each in files:
                key = each.relative_to(folder).as_posix()
                if each != path and each.is_file() and key not in found:
                    found[key] = each
                    waiting.append(each)
    return found


def _imported(file: Path, data: bytes | None) -> set[str]:
    """The first parts of the names that a file imports, without those of Python's library."""
    try:
        tree = ast.parse(file.read_bytes() if data is None else data)
    except (OSError, SyntaxError, ValueError):
        return set()
    names = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            names.add(node.module.partition(".")[0])
    return names - sys.stdlib_module_names


def make_importable(beside: Mapping[str, Path]) -> None:
    """Let the names be imported of what `files_beside` found, from now on, so that a function may import them too.

    A module that was imported so for another file stays, for what was made of it, if its content is the same; if not,
    it is imported again.
    """
    contents: dict[str, dict[str, bytes]] = {}
    places: dict[str, Path] = {}
    for key, file in beside.items():
        first, slash, _ = key.partition("/")
        name = first if slash else first.removesuffix(".py")
        contents.setdefault(name, {})[key] = file.read_bytes()
        if not slash or key == f"{name}/__init__.py":
            places[name] = file
    for name, files in contents.items():
        known = _finder.known.get(name)
        if known is None and name in sys.modules:  # another one, as for a script
            continue
        if known is not None and known.contents != files:
            for each in [each for each in sys.modules if each == name or each.startswith(f"{name}.")]:
                del sys.modules[each]
        _finder.known[name] = _Known(places[name], files)
    if _finder not in sys.meta_path:
        sys.meta_path.insert(0, _finder)


class _Known(NamedTuple):
    """Where a name is imported from, and the content of the files."""

    file: Path
    contents: Mapping[str, bytes]


class _Loader(SourceFileLoader):
    """Compiles the file's content: a cache next to it is not ours to write, and may be stale."""

    def path_stats(self, path: Any) -> Mapping[str, Any]:
        raise OSError("no cache")


class _Finder(MetaPathFinder):
    """Finds the names that user's files import from their own folder, and no others."""

    def __init__(self) -> None:
        self.known: dict[str, _Known] = {}

    def find_spec(self, fullname: str, path: Any = None, target: Any = None) -> ModuleSpec | None:
        known = self.known.get(fullname.partition(".")[0])
        if known is None:
            return None
        folder = known.file.parent
        inner = fullname.split(".")[1:]
        if not inner:
            return self._spec(fullname, known.file)
        base = folder.joinpath(*inner)
        package = base / "__init__.py"
        return self._spec(fullname, package if package.is_file() else base.with_suffix(".py"))

    def _spec(self, name: str, file: Path) -> ModuleSpec | None:
        if not file.is_file():
            return None
        folders = [str(file.parent)] if file.name == "__init__.py" else None
        return spec_from_file_location(name, file, loader=_Loader(name, str(file)), submodule_search_locations=folders)


_finder = _Finder()
