"""A lab's handout as a Jupyter notebook: its text, its commands as cells, and the file to hand in as a cell to edit."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from amorsim.core.errors import StudyError
from amorsim.core.files.atomic_files import write_text
from amorsim.labs.labs import HANDOUT, Lab, read_handout

__all__ = ["NOTEBOOK", "write_notebook"]

NOTEBOOK = "handout.ipynb"
_FENCED = re.compile(r"^```sh\n(.*?)\n```\n", re.MULTILINE | re.DOTALL)
_VIEW = re.compile(r"amorsim view (\S+)")
_SECOND = "## 2."  # the section in which the student begins to write


def write_notebook(lab: Lab, folder: Path) -> None:
    """Write the notebook of a lab's handout into a folder that holds the lab's files.

    Raises
    ------
    StudyError
        If the handout has no second section.
    RunError
        If it cannot be written.
    """
    cells = [_cell(number, kind, text) for number, (kind, text) in enumerate(_cells(lab), start=1)]
    content = {
        "cells": cells,
        "metadata": {
            "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
            "language_info": {"name": "python"},
        },
        "nbformat": 4,
        "nbformat_minor": 5,
    }
    write_text(folder / NOTEBOOK, json.dumps(content, indent=1, ensure_ascii=False) + "\n")


def _cells(lab: Lab) -> Iterator[tuple[str, str]]:
    """The kinds and texts of the cells, in order."""
    head, second, rest = read_handout(lab).partition(f"\n{_SECOND}")
    if not second:
        raise StudyError(f"{lab.folder / HANDOUT}: expected a section that begins with {_SECOND!r}")
    yield from _text_and_commands(head)
    file = lab.handed_in
    yield (
        "markdown",
        f"This is `{file.name}`. Change it here and run the cell, which writes it; then run the cell above again.",
    )
    yield "code", f"%%writefile {file.name}\n{file.read_text(encoding='utf-8')}"
    yield from _text_and_commands(f"{_SECOND}{rest}")


def _text_and_commands(text: str) -> Iterator[tuple[str, str]]:
    for place, part in enumerate(_FENCED.split(text)):
        if place % 2:
            yield "code", "\n\n".join(map(_command, part.splitlines()))
        elif part.strip():
            yield "markdown", part.strip()


def _command(line: str) -> str:
    """A command of the handout as it runs in a notebook: the window becomes a widget."""
    view = _VIEW.fullmatch(line)
    if view is None:
        return f"!{line}"
    return f'import amorsim as am\n\nsim = am.Simulation(am.load("{view[1]}"))\nam.widget(sim)'


def _cell(number: int, kind: str, text: str) -> dict[str, Any]:
    cell: dict[str, Any] = {"id": f"cell-{number}", "cell_type": kind, "metadata": {}}
    if kind == "code":
        cell |= {"execution_count": None, "outputs": []}
    return {**cell, "source": text.strip("\n").splitlines(keepends=True)}
