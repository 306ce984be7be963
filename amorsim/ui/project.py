"""The project's folder: where windows may save scenarios and runs, and nowhere else."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from amorsim.core.errors import AmorsimError
from amorsim.runs.folder import new_folder
from amorsim.ui.recipe import Recipe

__all__ = ["place_for", "save_run"]

_PART = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.() -]{0,99}")


def place_for(project: Path, name: Any, suffix: str = "") -> Path:
    """The file or folder in the project's folder that a window means by a name, with `suffix` where it has none.

    Raises
    ------
    AmorsimError
        If it would lie elsewhere, or the name is not of letters, digits and ``_ - . ( )``.
    """
    parts = name.split("/") if isinstance(name, str) else []
    if not 0 < len(parts) <= 5 or not all(_PART.fullmatch(part) and not part.endswith((".", " ")) for part in parts):
        raise AmorsimError(
            f"expected a name of letters, digits, '_', '-' and '.', folders parted by '/', got {str(name)[:100]!r}"
        )
    path = project.joinpath(*parts)
    if suffix and path.suffix != suffix:
        path = path.with_name(path.name + suffix)
    # A link in the folder may lead out of it.
    if not path.resolve().is_relative_to(project.resolve()):
        raise AmorsimError(f"{name}: is not in the project's folder {project}")
    return path


def save_run(project: Path, recipe: Recipe, job: Mapping[str, Any], name: Any, scenario: str) -> dict[str, Any]:
    """Let another process simulate the same again and write it down (see `amorsim.ui.saving`).

    Raises
    ------
    AmorsimError
        If the folder cannot be written.
    """
    folder = new_folder(scenario, project) if name is None else place_for(project, name)
    order = {"recipe": recipe.to_json(), "inputs": job["inputs"], "tick": job["tick"], "folder": str(folder)}
    done = subprocess.run(
        [sys.executable, "-m", "amorsim.ui.saving"],
        input=json.dumps(order) + "\n",
        capture_output=True,
        text=True,
        check=False,
        start_new_session=True,
    )
    try:
        answer = json.loads(done.stdout.splitlines()[-1])
    except (IndexError, ValueError):
        raise AmorsimError(f"{folder}: the run could not be saved\n{done.stderr.strip()[-2000:]}") from None
    if not answer["ok"]:
        raise AmorsimError(answer["error"])
    same = None if job["digest"] is None else answer["digest"] == job["digest"]
    return {"ok": True, "folder": str(folder), "same": same}
