"""Packages whose names are looked up when first used, so that importing a package costs nothing.

The names stand in the package's ``__init__.pyi``, as imports. Type checkers and editors read the same file.
"""

from __future__ import annotations

import ast
import importlib
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

__all__ = ["lazy_names"]


def lazy_names(package: str, file: str) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """Return what a package needs to look up its names: its `__getattr__`, `__dir__` and `__all__`.

    Parameters
    ----------
    package, file
        The package's `__name__` and `__file__`.
    """
    homes: dict[str, str] = {}  # the module of each name
    public: list[str] = []
    for statement in ast.parse(Path(file).with_suffix(".pyi").read_text(encoding="utf-8")).body:
        if isinstance(statement, ast.ImportFrom):
            homes.update((alias.name, statement.module or "") for alias in statement.names)
        elif isinstance(statement, ast.Assign):
            public = ast.literal_eval(statement.value)

    def look_up(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        module = homes[name]
        value = importlib.import_module(f"{module}.{name}" if module == package else module)
        if module != package:
            value = getattr(value, name)
        setattr(sys.modules[package], name, value)  # found at once from here on
        return value

    def names() -> list[str]:
        return sorted(homes)

    return look_up, names, public
