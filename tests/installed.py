"""Modules of plugins installed for tests, as far as amorsim can see it: in a folder that Python looks into."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from amorsim.plugins import manager

__all__ = ["install_module", "registered", "write_info"]


def write_info(site: Path, name: str, version: str, modules: Mapping[str, str]) -> importlib.metadata.Distribution:
    """What tells of a distribution in `site` that has these modules as plugins."""
    info = site / f"{name.replace('-', '_')}-{version}.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n", encoding="utf-8")
    lines = ["[amorsim]"] + [f"{key} = {module}" for key, module in modules.items()]
    (info / "entry_points.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return importlib.metadata.Distribution.at(info)


def install_module(module: ModuleType, site: Path) -> None:
    """Copy a module into `site` as a plugin of its own, for other processes that have `site` in their path."""
    name = module.__name__.rpartition(".")[2]
    write_info(site, name.replace("_", "-"), "0.1.0", {name: name})
    assert module.__file__ is not None
    (site / f"{name}.py").write_text(Path(module.__file__).read_text(encoding="utf-8"), encoding="utf-8")


@contextmanager
def registered(monkeypatch: pytest.MonkeyPatch, plugin: Any) -> Iterator[Any]:
    """The registry with a plugin more, which is that of all until the end."""
    registry = manager.make_registry({"tested": plugin}, entry_points=(), disabled="")
    with monkeypatch.context() as patch:
        patch.setattr(manager, "make_registry", lambda: registry)
        manager.default_registry.cache_clear()
        try:
            yield registry
        finally:
            manager.default_registry.cache_clear()
