"""``amorsim plugins``: what is registered, by whom, and the manual of each component."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from amorsim.cli.console import complain, say

if TYPE_CHECKING:
    from amorsim.plugins.registry import Entry, Registry

__all__ = ["app"]


class _Commands(TyperGroup):
    """Commands; another word is the name of a component, whose manual is shown."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """The command that the first word names, and what is left of the words."""
        is_name = self.get_command(ctx, args[0]) is None and not args[0].startswith("-")
        return super().resolve_command(ctx, ["show", *args] if is_name else args)


app = typer.Typer(
    cls=_Commands,
    help="List the registered components, and by whom; `show NAME` prints its manual, `check NAME` checks it.",
    invoke_without_command=True,
    rich_markup_mode=None,
)


@app.callback()
def list_all(context: typer.Context) -> None:
    """List the registered components, and by whom; `show NAME` prints its manual, `check NAME` checks it."""
    if context.invoked_subcommand is not None:
        return
    from amorsim.analysis.reference import summary_of
    from amorsim.plugins.manager import default_registry

    registry = default_registry()
    for kind in dict.fromkeys(entry.kind for entry in registry.entries()):
        entries = registry.entries(kind)
        say(f"{kind.replace('_', ' ')}:")
        width = max(len(entry.name) for entry in entries)
        for entry in entries:
            # Components of amorsim itself need no note of their origin on every line.
            by = "" if entry.plugin.name == "builtin" else f"  [{entry.plugin}]"
            say(f"  {entry.name:{width}}  {summary_of(registry, entry)}{by}")
    for problem in registry.problems:
        complain(f"problem: {problem}")


@app.command()
def show(
    name: Annotated[
        str,
        typer.Argument(metavar="NAME", help="A component's name, such as laser; or kind/name, such as sensor/laser."),
    ],
) -> None:
    """Print the manual of a component: what it is, and its fields with units, defaults, bounds and help."""
    from amorsim.analysis.reference import manual
    from amorsim.plugins.manager import default_registry

    registry = default_registry()
    for number, entry in enumerate(_entries(registry, name)):
        if number:
            say("")
        say(manual(registry, entry).rstrip())


@app.command()
def check(
    name: Annotated[
        str,
        typer.Argument(metavar="NAME", help="A component's name, such as laser; or kind/name, such as sensor/laser."),
    ],
    path: Annotated[
        Path | None, typer.Option("--path", metavar="FILE", help="The file that a loader is to read.")
    ] = None,
) -> None:
    """Check that a component keeps its contract, as `amorsim.testing.check_component` does, and report in words."""
    from amorsim.analysis.reference import FILES
    from amorsim.core.errors import PluginError
    from amorsim.plugins.manager import default_registry
    from amorsim.testing import check_component

    registry = default_registry()
    for entry in _entries(registry, name):
        if entry.kind in FILES:
            raise PluginError(f"{name}: a {entry.kind} is a file; amorsim check looks for its faults")
        if entry.kind in ("map_loader", "scenario_loader") and path is None:
            raise PluginError(f"{name}: a loader is checked with a file that it reads: --path FILE")
        check_component(registry.get(entry.kind, entry.name), path=path)
        say(f"{entry.kind.replace('_', ' ')} {entry.name} keeps its contract")


def _entries(registry: Registry, name: str) -> list[Entry]:
    """All that is registered under a name, or KIND/NAME."""
    from amorsim.core.errors import PluginError, did_you_mean

    kind, _, short = name.rpartition("/")
    found = [entry for entry in registry.entries(kind or None) if entry.name == short]
    if not found:
        known = sorted({entry.name for entry in registry.entries()})
        hint = did_you_mean(short, known)
        raise PluginError(f"nothing is registered as {name!r}.{hint} `amorsim plugins` lists all, kind by kind")
    return found
