"""Studies of several scenarios on the same seeds, side by side in one folder, for a comparison."""

from __future__ import annotations

import json
import os
import shlex
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import attrs

from amorsim.core.errors import AmorsimError, StudyError
from amorsim.core.files.atomic_files import write_text
from amorsim.core.files.json_files import read_table
from amorsim.core.files.reading import is_file
from amorsim.runs.folder import RUNS, check_free, new_folder
from amorsim.scenario.reading.read import load
from amorsim.sweeps.folder import inputs_of
from amorsim.sweeps.judged import metrics_of_shared
from amorsim.sweeps.read import read_plan
from amorsim.sweeps.sweep import Progress, sweep
from amorsim.sweeps.table import Study

__all__ = ["StudySet"]

FORMAT = 1
ABOUT = "systems.json"


@attrs.frozen(kw_only=True)
class StudySet:
    """Scenarios to simulate with the same seeds, replicas and metrics, each as a study without axes.

    Attributes
    ----------
    scenarios
        Paths of their files, or names of bundled ones.
    metrics
        Names of components of the kind `metric`, with their defaults.
    estimators
        Whose estimates are measured; without them, those of all estimators that the scenarios share.
    robot
        Whose; may be empty where each scenario has one robot.
    duration
        In place of the scenarios' own [s].
    measured
        The ``[metrics]`` of each study, as `metrics_of_shared` makes them.

    Raises
    ------
    StudyError
        If a scenario cannot be read, has no such robot, or lacks an estimator.
    """

    scenarios: tuple[str, ...]
    metrics: tuple[str, ...]
    replicas: int
    seeds: tuple[int, ...]
    estimators: tuple[str, ...] = ()
    robot: str = ""
    duration: float | None = None
    measured: Mapping[str, Mapping[str, str]] = attrs.field(init=False)

    @measured.default
    def _of_shared(self) -> Mapping[str, Mapping[str, str]]:
        scenarios = {}
        for label, name in zip(self.labels, self.scenarios, strict=True):
            try:
                scenarios[label] = load(name)
            except AmorsimError as error:
                raise StudyError(f"{label}: {error}") from None
        return metrics_of_shared(scenarios, self.metrics, self.estimators, self.robot)

    @property
    def labels(self) -> list[str]:
        """A name for each: that of its file, with a number where names repeat."""
        stems = [Path(name).stem for name in self.scenarios]
        return [stem if stems.count(stem) == 1 else f"{stem}-{place}" for place, stem in enumerate(stems, start=1)]

    @property
    def command(self) -> str:
        """The command that compares them."""
        words = ["amorsim", "compare", *self.scenarios, "--replicas", str(self.replicas)]
        words += ["--seeds", ",".join(map(str, self.seeds))]
        words += [] if self.duration is None else ["--duration", f"{self.duration:g}"]
        words += ["--robot", self.robot] if self.robot else []
        for option, names in (("--metric", self.metrics), ("--estimator", self.estimators)):
            for name in names:
                words += [option, name]
        return shlex.join(words)

    def folder(self, out: Path | None, name: str, *, ended: str) -> Path:
        """The folder to simulate in, made now: that of the same unfinished set, or a new one.

        Parameters
        ----------
        out
            The folder, if the user names one: new, empty, or one in which the same was begun.
        name
            Without `out`, it is ``amorsim-runs/<name>-<number>``.
        ended
            The file that is in it once everything is done.

        Raises
        ------
        StudyError
            If a scenario cannot be read.
        RunError
            If the named folder holds something else, or cannot be made.
        """
        about = self._about()
        if out is None:
            begun = (path.parent for path in Path.cwd().glob(f"{RUNS}/{name}-*/{ABOUT}"))
            same = (path for path in begun if not (path / ended).exists() and _read(path) == about)
            if (found := max(same, default=None)) is not None:
                return found
            folder = new_folder(name)
        else:
            folder = out
            if is_file(folder / ABOUT):
                _check_same(folder, about)
                return folder
            check_free(folder)
            try:
                folder.mkdir(parents=True, exist_ok=True)
            except OSError as error:
                raise StudyError(f"{folder}: cannot make this folder ({error.strerror or error})") from None
        write_text(folder / ABOUT, json.dumps(about, indent=2) + "\n", within=folder)
        return folder

    def sweep(
        self,
        place: int,
        folder: str | os.PathLike[str],
        *,
        jobs: int = 1,
        progress: Callable[[Progress], None] | None = None,
    ) -> Study:
        """Run the study of one scenario, or continue it; see `sweep`."""
        return sweep(self._tables(place), Path(folder) / self.labels[place], jobs=jobs, progress=progress)

    def _tables(self, place: int) -> dict[str, Any]:
        tables: dict[str, Any] = {
            "format": 1,
            "scenario": self.scenarios[place],
            "replicas": self.replicas,
            "seeds": list(self.seeds),
            "metrics": dict(self.measured),
        }
        return tables if self.duration is None else tables | {"duration": self.duration}

    def _about(self) -> dict[str, Any]:
        """The scenario that is simulated, with a fingerprint of every file."""
        inputs: dict[str, dict[str, str]] = {}
        for place, label in enumerate(self.labels):
            plan = read_plan(self._tables(place))
            try:
                inputs[label] = inputs_of(plan, load(plan.scenario))
                del inputs[label]["study"]  # all of it is in the rest
            except AmorsimError as error:
                raise StudyError(f"{label}: {error}") from None
        about = attrs.asdict(self) | {"inputs": inputs}
        return {"format": FORMAT} | {
            key: list(each) if isinstance(each, tuple) else each for key, each in about.items()
        }


def _read(folder: Path) -> dict[str, Any]:
    """The study that was begun in a folder; None if it cannot be read."""
    try:
        return read_table(folder / ABOUT, StudyError)
    except (FileNotFoundError, StudyError):
        return {}


def _check_same(folder: Path, about: dict[str, Any]) -> None:
    was = _read(folder)
    changed = [key for key in about if was.get(key) != about[key]]
    if not changed:
        return
    if changed == ["inputs"]:
        changed = _changed_inputs(was["inputs"], about["inputs"])
    raise StudyError(
        f"{folder}: the comparison that was begun here differs in: {', '.join(changed)}; take back the change, or name "
        "another folder with --out"
    )


def _changed_inputs(was: Any, now: dict[str, dict[str, str]]) -> list[str]:
    """The files that differ, each with the label of its scenario."""
    if not isinstance(was, dict) or not all(isinstance(each, dict) for each in was.values()):
        return ["inputs"]
    return [
        f"{name} of {label}"
        for label, files in now.items()
        for name in {**was.get(label, {}), **files}
        if was.get(label, {}).get(name) != files.get(name)
    ]
