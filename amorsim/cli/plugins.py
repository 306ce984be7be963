"""``amorsim plugins``: what is registered, by whom, and the manual of each component."""

from __future__ import annotations

from typing import Annotated

import typer

from amorsim.cli.console import complain, say

__all__ = ["app"]

app = typer.Typer(
    help="List the components that are registered, and by whom; `show NAME` prints a component's manual.",
    invoke_without_command=True,
    rich_markup_mode=None,
)


@app.callback()
def list_all(context: typer.Context) -> None:
    """List the components that are registered, and by whom; `show NAME` prints a component's manual."""
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
    from amorsim.core.errors import PluginError, did_you_mean
    from amorsim.plugins.manager import default_registry

    registry = default_registry()
    kind, _, short = name.rpartition("/")
    found = [entry for entry in registry.entries(kind or None) if entry.name == short]
    if not found:
        known = sorted({entry.name for entry in registry.entries()})
        hint = did_you_mean(short, known)
        raise PluginError(f"nothing is registered as {name!r}.{hint} `amorsim plugins` lists all, kind by kind")
    for number, entry in enumerate(found):
        if number:
            say("")
        say(manual(registry, entry).rstrip())
