"""The folder of a study: its description, a file for each finished chunk, and the table made of them."""

from __future__ import annotations

import contextlib
import hashlib
import json
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

from amorsim.core.error_text import in_words
from amorsim.core.errors import AmorsimError, RunError, StudyError
from amorsim.core.files.atomic_files import create_text, write_text
from amorsim.core.files.json_files import (
    Key,
    check_keys,
    is_figure,
    is_real,
    is_text,
    is_whole,
    list_of,
    read_table,
    table_of,
)
from amorsim.core.files.reading import is_file
from amorsim.core.files.temporary_folders import temporary_folder
from amorsim.runs.folder import check_free, circumstances, fingerprints
from amorsim.runs.manifest import read_about
from amorsim.scenario.files.write import table_text, with_copies
from amorsim.scenario.programs.local_imports import files_beside
from amorsim.scenario.reading.read import load
from amorsim.scenario.spec import Scenario
from amorsim.sweeps.chunk import Outcome
from amorsim.sweeps.judged import about_metric
from amorsim.sweeps.plan import Plan

__all__ = ["ABOUT", "FORMAT", "StudyFolder", "inputs_of", "read_study_about"]

FORMAT = 1
ABOUT = "study.json"
STUDY = "study.toml"
CHUNKS = "chunks"
_EACH = 1000  # chunks in a folder of their own, so that no folder holds a million files


class StudyFolder:
    """The folder of a study that is computed now: new, or of the same study that was begun before.

    Parameters
    ----------
    path
        The folder.
    plan, scenario
        The study, and its scenario before anything is set.

    Raises
    ------
    StudyError
        If the folder holds something else, another study, or one of another version; or cannot be made.
    """

    def __init__(self, path: Path, plan: Plan, scenario: Scenario) -> None:
        self.path = path
        self._plan = plan
        inputs = inputs_of(plan, scenario)
        if is_file(path / ABOUT):
            self.about = read_study_about(path)
            self._check_same(inputs)
        else:
            self.about = {
                "format": FORMAT,
                "status": "running",
                "name": plan.name,
                "scenario": plan.scenario,
                "inputs": inputs,
                "points": plan.points,
                "chunks": plan.chunks,
                "replicas": plan.replicas,
                "seeds": [scenario.seed if seed < 0 else seed for seed in plan.seeds],
                "duration": scenario.duration if plan.duration is None else plan.duration,
                "stop": plan.stop,
                "axes": {axis.name: list(axis.labels) for axis in plan.axes},
                "metrics": {
                    each.name: about_metric(each, plan.tables["metrics"][each.name]["use"], scenario.robots)
                    for each in plan.metrics
                },
                **circumstances(),
            }
            self._begin()
        if not is_file(path / STUDY):  # or it was killed before
            self._write(STUDY, table_text(plan.tables))

    def _begin(self) -> None:
        try:
            check_free(self.path)
            self.path.mkdir(parents=True, exist_ok=True)
            create_text(self.path / ABOUT, self._text())  # first: a study that is killed from here on can go on
        except OSError as error:
            raise StudyError(
                f"{self.path}: cannot make this folder for the study ({error.strerror or error})"
            ) from None
        except RunError as error:
            raise StudyError(str(error).replace("for the run", "for the study")) from None

    def _write(self, name: str, text: str) -> None:
        try:
            write_text(self.path / name, text, within=self.path)
        except RunError as error:
            raise StudyError(str(error)) from None

    def _check_same(self, inputs: Mapping[str, str]) -> None:
        """Raise unless the folder is of this very study, by the same version."""
        were = self.about.get("inputs", {})
        changed = [name for name in {**were, **inputs} if were.get(name) != inputs.get(name)]
        if changed:
            raise StudyError(
                f"{self.path}: this study was begun with another {', '.join(sorted(changed))}; its results would not "
                "belong together. Take back the change, or name another folder with --out"
            )
        now = circumstances()
        for key in ("amorsim", "python", "packages", "plugins", "processor"):
            if self.about.get(key) != now[key]:
                raise StudyError(
                    f"{self.path}: this study was begun with another version: {key} was {_shown(self.about.get(key))} "
                    f"and is {_shown(now[key])}; go on with the same, or name another folder with --out"
                )

    def write_about(self, status: str) -> None:
        """Write ``study.json``; raises `RunError` as `write_text`."""
        self.about["status"] = status
        write_text(self.path / ABOUT, self._text(), within=self.path)

    def _text(self) -> str:
        return json.dumps(self.about, indent=2) + "\n"

    def _file(self, index: int) -> Path:
        return self.path / CHUNKS / f"{index // _EACH:05d}" / f"{index:08d}.json"

    def marker(self, index: int) -> Path:
        """A file that is there while a local process computes a chunk."""
        return self.path / CHUNKS / f"{index:08d}.begun"

    def forget_begun(self) -> None:
        """Remove the markers of an earlier run."""
        for file in (self.path / CHUNKS).glob("*.begun"):
            file.unlink(missing_ok=True)

    def run_folder(self, index: int) -> Path:
        """The folder of a run that is kept; its name has the seed, if the study names seeds."""
        chunk = self._plan.chunk(index)
        seed = f"-seed-{chunk.seed}" if chunk.seed >= 0 else ""
        return self.path / "runs" / f"point-{chunk.point:06d}{seed}"

    def missing(self, kept: Collection[int]) -> list[int]:
        """The unfinished chunks, and those points of `kept` whose run's folder is missing.

        Computed again, they come out the same.
        """
        chunks = range(self._plan.chunks)
        return [index for index in chunks if not self._file(index).exists() or (kept and self._lacks_run(index, kept))]

    def _lacks_run(self, index: int, kept: Collection[int]) -> bool:
        """Whether a finished chunk should have left the folder of its run and has not."""
        if self._plan.chunk(index).point not in kept or self._read(index).error:
            return False
        try:
            return bool(read_about(self.run_folder(index))["status"] != "finished")
        except RunError:
            return True

    def write(self, outcome: Outcome) -> None:
        """Write the outcome of a chunk; raises `StudyError` if it cannot be written."""
        file = self._file(outcome.index)
        content: dict[str, Any] = {"index": outcome.index, "seed": outcome.seed}
        content |= {"error": outcome.error} if outcome.error else {"values": outcome.values, "digests": outcome.digests}
        try:
            write_text(file, json.dumps(content) + "\n", within=self.path)
        except RunError as error:
            raise StudyError(
                f"{error}; what was done before is in {self.path}. Make room, and give the same command again"
            ) from None
        with contextlib.suppress(OSError):
            self.marker(outcome.index).unlink()

    def outcomes(self) -> Iterator[Outcome]:
        """The outcomes of the chunks that are done, in their order."""
        for index in range(self._plan.chunks):
            if self._file(index).exists():
                yield self._read(index)

    def _read(self, index: int) -> Outcome:
        file, count = self._file(index), self._plan.replicas
        metrics = {each.name for each in self._plan.metrics}
        values: Key = (
            lambda found: table_of(list_of(is_figure, count))(found) and set(found) == metrics,
            f"a table of {count} numbers for each of the metrics {', '.join(sorted(metrics))}",
        )
        keys: dict[str, Key] = {"index": (lambda found: type(found) is int and found == index, f"{index}")}
        result: dict[str, Key] = {"values": values, "digests": (list_of(is_text, count), f"a list of {count} texts")}
        try:
            content = read_table(file, StudyError)
            if content.get("error"):
                content = {key: content[key] for key in ("index", "seed", "error") if key in content}
            keys |= {"error": (is_text, "a text")} if content.get("error") else result
            check_keys(file, content, keys, {"seed": (_is_seed, "a whole number >= -1")}, StudyError)
        except (FileNotFoundError, StudyError) as error:
            raise StudyError(f"{error}; remove it, and give the same command again") from None
        return Outcome(
            index=index,
            seed=content.get("seed", -1),
            values={name: list(map(float, each)) for name, each in content.get("values", {}).items()},
            digests=content.get("digests", []),
            error=content.get("error", ""),
        )


def read_study_about(folder: Path) -> dict[str, Any]:
    """The content of a study's ``study.json``.

    Raises
    ------
    StudyError
        If it is not a study's folder, of another version, or damaged.
    """
    path = folder / ABOUT
    try:
        about = read_table(path, StudyError)
    except FileNotFoundError:
        raise StudyError(f"{folder}: expected the folder of a study, with a {ABOUT} in it") from None
    if about.get("format") != FORMAT:
        version = about["amorsim"] if is_text(about.get("amorsim")) else "unknown"
        raise StudyError(
            f"{path}: expected a study of format {FORMAT}, which this amorsim reads, got "
            f"{in_words(about.get('format'))}; take the amorsim that wrote it ({version})"
        )
    check_keys(path, about, _KEYS, {}, StudyError)
    return about


def _is_seed(value: Any) -> bool:
    return type(value) is int and -1 <= value < 2**63


def _is_metric(value: Any) -> bool:
    return table_of(is_text)(value) and {"unit", "better"} <= set(value)


def _is_axis(value: Any) -> bool:
    return list_of(lambda label: is_text(label) or is_figure(label) or isinstance(label, bool))(value) and bool(value)


_COUNT: Key = (is_whole, "a whole number >= 0")
_TEXT: Key = (is_text, "a text")
_TEXTS: Key = (table_of(is_text), "a table of texts")
_KEYS: dict[str, Key] = {
    "status": _TEXT,
    "points": _COUNT,
    "chunks": _COUNT,
    "replicas": (lambda value: is_whole(value) and value > 0, "a whole number > 0"),
    "axes": (table_of(_is_axis), "a table of lists of numbers, flags or texts"),
    "metrics": (table_of(_is_metric), "a table of metrics, each with unit and better"),
    "name": _TEXT,
    "scenario": _TEXT,
    "inputs": _TEXTS,
    "seeds": (list_of(is_whole), "a list of whole numbers >= 0"),
    "duration": (is_real, "a number [s]"),
    "stop": _TEXT,
    "amorsim": _TEXT,
    "python": _TEXT,
    "processor": _TEXT,
    "system": _TEXT,
    "packages": _TEXTS,
    "plugins": (table_of(lambda value: value is None or is_text(value)), "a table of texts"),
}


def inputs_of(plan: Plan, scenario: Scenario) -> dict[str, str]:
    """A fingerprint of the study, and of each file that it depends on."""
    study = json.dumps(plan.tables, sort_keys=True, default=str).encode()
    found = {"study": hashlib.blake2b(study, digest_size=16).hexdigest()}
    try:
        found |= _files_of(scenario)
    except AmorsimError as error:
        raise StudyError(str(error)) from None
    for each in plan.metrics:
        if each.source:
            path = Path(each.source.rpartition(":")[0])
            found |= {str(path.parent / name): digest for name, digest in _fingerprints_of_program(path).items()}
    read: set[str] = set()
    for axis in plan.axes:
        for label, settings, files in zip(axis.labels, axis.settings, axis.files, strict=True):
            if read.issuperset(files):  # reading a large map takes long
                continue
            for file in files:
                path = Path(file)
                found[file] = fingerprints(path.parent, [path.name]).get(path.name, "")
            with contextlib.suppress(AmorsimError):  # a point that fails, or a value that needs another axis's
                for name, digest in _files_of(load(plan.scenario, settings)).items():
                    if name != "scenario" and found.get(name) != digest:
                        found[f"{name} of {axis.name} = {label}"] = digest
                read.update(files)
    return found


def _fingerprints_of_program(path: Path) -> dict[str, str]:
    """A fingerprint of a file of Python, and of each that it imports from its folder."""
    return fingerprints(path.parent, [path.name, *files_beside(path)])


def _files_of(scenario: Scenario) -> dict[str, str]:
    """Fingerprints of a scenario and of each file that it needs: maps of several files, imports of programs.

    Raises
    ------
    AmorsimError
        If a file cannot be read.
    """
    with temporary_folder("study") as folder:
        text = table_text(with_copies(scenario, folder))
        files = sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())
        return {
            "scenario": hashlib.blake2b(text.encode(), digest_size=16).hexdigest(),
            **fingerprints(folder, files),
        }


def _shown(value: Any) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{name} {version}" for name, version in value.items())
    return str(value)
