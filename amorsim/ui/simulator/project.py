"""The project's folder: where windows may save scenarios and runs, and nowhere else."""

from __future__ import annotations

import asyncio
import contextlib
import json
import re
import subprocess
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from amorsim.core.errors import AmorsimError
from amorsim.core.files.reading import is_there
from amorsim.runs.folder import new_folder, next_folder
from amorsim.ui.simulator.process.pipes import python_for
from amorsim.ui.simulator.recipe import Recipe

__all__ = ["Saver", "free_places", "place_for"]

_PART = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.() -]{0,99}")


def place_for(project: Path, name: Any, suffix: str = "") -> Path:
    """The file or folder in the project's folder for a name given in a window; `suffix` is added if it has none.

    Raises
    ------
    AmorsimError
        If it would lie elsewhere, the name is not of letters, digits and ``_ - . ( )``, or a folder that it names may
        not be looked into.
    """
    parts = name.split("/") if isinstance(name, str) else []
    if not 0 < len(parts) <= 5 or not all(_PART.fullmatch(part) and not part.endswith((".", " ")) for part in parts):
        raise AmorsimError(
            f"expected a name of letters, digits, '_', '-' and '.', folders parted by '/', got {str(name)[:100]!r}"
        )
    path = project.joinpath(*parts)
    if suffix and path.suffix != suffix:
        path = path.with_name(path.name + suffix)
    try:
        # A link in the folder may lead out of it.
        is_inside = path.resolve().is_relative_to(project.resolve())
        path.exists()
    except (OSError, RuntimeError) as error:  # RuntimeError: links that lead to each other
        raise AmorsimError(f"{name}: cannot be looked at ({getattr(error, 'strerror', None) or error})") from None
    if not is_inside:
        raise AmorsimError(f"{name}: is not in the project's folder {project}")
    return path


def free_places(project: Path, scenario: str) -> dict[str, str]:
    """Names in the project's folder that are free yet: of a folder for a ``run``, and of a file for a ``scenario``."""
    run = project / "run"
    changed = project / f"{scenario.removesuffix('.toml')}-changed"
    number, file = 2, changed.with_name(f"{changed.name}.toml")
    while is_there(file):
        number, file = number + 1, changed.with_name(f"{changed.name}-{number}.toml")
    return {"run": (next_folder(run) if is_there(run) else run).name, "scenario": file.name}


class Saver:
    """Saves runs, each in a process of its own (see `amorsim.ui.simulator.saving`)."""

    def __init__(self, project: Path, recipe: Recipe) -> None:
        self._project = project
        self._recipe = recipe
        self._running: set[subprocess.Popen[str]] = set()
        self._is_closed = False

    async def save(
        self, job: Mapping[str, Any], name: Any, scenario: str, *, within: Path | None = None
    ) -> dict[str, Any]:
        """Let a process simulate the same again and write it down.

        Parameters
        ----------
        job
            ``inputs``, ``tick`` and ``digest``, as the child gives them.
        name
            Of the folder in the project's folder; None for a new one, after the scenario's name.
        within
            A folder in place of the project's.

        Raises
        ------
        AmorsimError
            If the folder cannot be written.
        """
        project = within or self._project
        folder = new_folder(scenario, project) if name is None else place_for(project, name)
        order = {"recipe": self._recipe.to_json(), "inputs": job["inputs"], "tick": job["tick"], "folder": str(folder)}
        out, log = await self._run(json.dumps(order) + "\n")
        try:
            answer = json.loads(out.splitlines()[-1])
        except (IndexError, ValueError):
            raise AmorsimError(f"{folder}: the run could not be saved\n{log.strip()[-2000:]}") from None
        if not answer["ok"]:
            raise AmorsimError(answer["error"])
        same = None if job["digest"] is None else answer["digest"] == job["digest"]
        return {"ok": True, "folder": str(folder), "same": same}

    async def _run(self, order: str) -> tuple[str, str]:
        if self._is_closed:
            raise AmorsimError("the simulation has ended")
        process = subprocess.Popen(
            python_for("amorsim.ui.simulator.saving"),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        self._running.add(process)
        try:
            return await asyncio.to_thread(_talk, process, order)
        finally:
            self._running.discard(process)

    def close(self) -> None:
        """Stop what is being saved; its files are complete up to there."""
        self._is_closed = True
        for process in self._running:
            with contextlib.suppress(OSError):
                if process.stdin is not None:
                    process.stdin.close()


def _talk(process: subprocess.Popen[str], order: str) -> tuple[str, str]:
    """Give a process an order; returns its output until its end, and its log."""
    assert process.stdin is not None
    assert process.stdout is not None
    assert process.stderr is not None
    log: list[str] = []
    reader = threading.Thread(target=lambda: log.extend(process.stderr or ()), daemon=True)
    reader.start()
    with contextlib.suppress(OSError, ValueError):
        # It stays open: at its end the process ends too.
        process.stdin.write(order)
        process.stdin.flush()
    out = process.stdout.read()
    process.wait()
    reader.join()
    for pipe in (process.stdin, process.stdout, process.stderr):
        with contextlib.suppress(OSError):
            pipe.close()
    return out, "".join(log)
