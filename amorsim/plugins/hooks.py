"""The hooks that a plugin may implement, each marked with `hookimpl`.

A plugin is a module, named in the entry-point group ``amorsim`` of its distribution::

    [project.entry-points.amorsim]
    my_robots = "my_package.amorsim_plugin"

Hooks are for setting up and for watching, never for the step: only components act in a step.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pluggy

if TYPE_CHECKING:
    from amorsim.plugins.registry import Registry

__all__ = ["GROUP", "Hooks", "hookimpl"]

GROUP = "amorsim"

hookspec = pluggy.HookspecMarker(GROUP)
hookimpl = pluggy.HookimplMarker(GROUP)


class Hooks:
    """The hooks that a plugin may implement."""

    @hookspec
    def amorsim_register(self, registry: Registry) -> None:
        """Register components, robots and scenarios; called once, when the plugins are loaded."""

    @hookspec
    def amorsim_run_started(self, simulation: Any) -> None:
        """Called before the first step of a run; the simulation is for looking at, not for changing."""

    @hookspec
    def amorsim_run_finished(self, simulation: Any) -> None:
        """Called after the last step of a run, also when it was broken off."""
