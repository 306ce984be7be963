"""Names the wheel for the Python and the system that its kernels were compiled on."""

from __future__ import annotations

from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class Tagged(BuildHookInterface):  # type: ignore[misc]
    """Gives the wheel the tag that `tools/build_wheels.py` found."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Set the tag."""
        build_data["tag"] = self.config["tag"]
