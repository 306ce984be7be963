"""The contract of scenario loaders."""

from __future__ import annotations

import abc
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar

import attrs

__all__ = ["ScenarioDocument", "ScenarioLoader"]


@attrs.frozen(kw_only=True)
class ScenarioDocument:
    """The content of another program's file, as a scenario's own file would have it.

    Parameters
    ----------
    tables
        The tables of a scenario: ``{"format": 1, "world": {...}, "robots": [...], ...}``, angles in degrees. Relative
        paths start at the file's folder. The map is usually the same file again, read by a map loader.
    remarks
        What was left out or changed, a sentence each.
    lines
        The line of the file for a path: ``{"robots.0": 12}``; messages about faults show it.
    """

    tables: dict[str, Any]
    remarks: tuple[str, ...] = ()
    lines: Mapping[str, int] = attrs.field(factory=dict)


class ScenarioLoader(abc.ABC):
    """Reads scenarios from another program's files; its fields are options, as in ``--set loader.crop_bitmaps=true``.

    A loader only reads: it runs no program that a file names.
    """

    extensions: ClassVar[tuple[str, ...]]  # with the dot, lower case

    @classmethod
    @abc.abstractmethod
    def sniff(cls, head: bytes) -> bool:
        """Whether a file with one of the extensions, which begins with `head`, has this format."""

    @abc.abstractmethod
    def read(self, path: Path) -> ScenarioDocument:
        """The scenario in a file. Raises `ScenarioError` with the file and the line of each fault."""
