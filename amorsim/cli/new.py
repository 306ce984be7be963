"""``amorsim new``: a scenario, a controller and a map to start from."""

from __future__ import annotations

import json
from collections.abc import Sequence
from importlib import resources
from pathlib import Path
from typing import Annotated

import typer

from amorsim.cli.console import say
from amorsim.core.errors import RunError
from amorsim.core.files.atomic_files import write_text
from amorsim.core.files.reading import is_file

__all__ = ["command"]

SCENARIO = "scenario.toml"
_FILES = (SCENARIO, "controller.py", "rooms.wld")
_SCHEMA = "scenario.schema.json"
_SCHEMA_LINE = f"#:schema {_SCHEMA}\n"


def command(
    folder: Annotated[
        Path, typer.Argument(metavar="DIR", help="The folder to make; it may exist, but nothing in it is replaced.")
    ],
    source: Annotated[
        str | None,
        typer.Option(
            "--from",
            metavar="SCENARIO",
            help="Begin with this scenario: a file (.toml, another program's, or a map), or the name of a bundled one. "
            "It names its files by relative paths.",
        ),
    ] = None,
    plugin: Annotated[
        list[str] | None,
        typer.Option(
            "--plugin",
            metavar="KIND",
            help="Make a package with a component of this kind instead: sensor, noise, controller, drive and so on. "
            "It may be given several times.",
        ),
    ] = None,
    copy: Annotated[
        bool, typer.Option("--copy", help="With --from: copy the files that the scenario names into the folder too.")
    ] = False,
) -> None:
    """Make a folder with a scenario, a controller of ten lines and a map, which run as they are."""
    if copy and source is None:
        raise RunError("--copy is for a scenario that is given with --from")
    if plugin:
        if source is not None:
            raise RunError("--plugin and --from do not go together: a package begins from no scenario")
        _make_package(folder, plugin)
        return
    wanted = _FILES if source is None else (SCENARIO,)
    _refuse_to_replace(folder, (*wanted, _SCHEMA))
    document = None
    if source is not None:
        from amorsim.scenario.documents.document import open_document

        document = open_document(source)
    _make_folder(folder)
    if document is not None:
        before = set(folder.iterdir())
        document.save(folder / SCENARIO, copy=copy)
        made = ", ".join(sorted(path.name for path in folder.iterdir() if path not in before))
    else:
        template = resources.files("amorsim.cli") / "template"
        for name in _FILES:
            write_text(folder / name, (template / name).read_text(encoding="utf-8"))
        made = ", ".join(_FILES)
    _add_schema(folder)
    say(f"made {made} and {_SCHEMA} in {folder}; now: amorsim run {folder / SCENARIO}")


def _add_schema(folder: Path) -> None:
    """Write the schema of scenarios, and name it in the scenario's first line, where editors look for it."""
    from amorsim.schemas import make_schema

    write_text(folder / _SCHEMA, json.dumps(make_schema("scenario")))
    # As bytes: the author's line ends stay, and a byte order mark stays first.
    text = (folder / SCENARIO).read_bytes().decode()
    mark, text = ("\N{BOM}", text[1:]) if text.startswith("\N{BOM}") else ("", text)
    if not text.startswith("#:schema"):
        write_text(folder / SCENARIO, mark + _SCHEMA_LINE + text)


def _refuse_to_replace(folder: Path, names: Sequence[str]) -> None:
    if there := [name for name in names if is_file(folder / name)]:
        raise RunError(f"{folder}: {', '.join(there)} would be replaced; name another folder")


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RunError(f"{folder}: cannot make this folder ({error.strerror or error})") from None


def _make_package(folder: Path, kinds: Sequence[str]) -> None:
    """Write the files of a plugin."""
    from amorsim.cli.plugin_package import package_files

    files = package_files(folder, kinds)
    _refuse_to_replace(folder, list(files))
    for name, text in files.items():
        _make_folder((folder / name).parent)
        write_text(folder / name, text)
    say(
        f"made a package with {', '.join(kinds)} in {folder}; now, in that folder: "
        'python -m pip install -e ".[test]" && python -m pytest && amorsim run try.toml'
    )
