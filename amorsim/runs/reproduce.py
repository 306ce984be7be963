"""Running a run again, and finding where it differs."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import attrs

from amorsim.core.arguments import checked, path_of
from amorsim.core.errors import AmorsimError, RunError
from amorsim.core.execution.progress import progress_shown
from amorsim.core.files.temporary_folders import temporary_folder
from amorsim.runs.compare import TOLERANCE, Difference, first_difference
from amorsim.runs.folder import circumstances, fingerprints
from amorsim.runs.manifest import RUN_FOLDER, read_about, scenario_of
from amorsim.runs.replay import Replay
from amorsim.runs.session import RunSession
from amorsim.runs.tables import last_line
from amorsim.runs.world_digests import different_world
from amorsim.simulation.simulation import Simulation

__all__ = ["Outcome", "reproduce"]


@attrs.frozen(kw_only=True)
class Outcome:
    """How a second run compares with the first.

    On another kind of processor, or with other versions, the last bits of results may differ: `is_exact` is false
    then, but `is_same` true as long as all files agree to 2e-6.
    """

    is_same: bool
    is_exact: bool
    steps: int
    difference: str = ""  # the first, in words
    tick: int | None = None  # of the first difference, where the files hold one
    robot: str = ""  # the robot of the first difference
    notes: tuple[str, ...] = ()  # versions, machines and files that have changed

    def __str__(self) -> str:
        if self.is_exact:
            head = f"the same to the bit, over {self.steps} steps"
        elif self.is_same:
            head = f"the same to {TOLERANCE:g}, over {self.steps} steps, but not to the bit"
        else:
            head = f"not the same: {self.difference}"
        return "\n".join([head, *(f"note: {note}" for note in self.notes)])


@checked
def reproduce(folder: str | os.PathLike[str], *, progress: bool | Callable[[float], None] | None = True) -> Outcome:
    """Run the content of a run's folder again: its scenario, its recorded commands by hand, its live changes.

    It compares the digests of all exact results, all text files line by line, and all arrays of beliefs.

    Parameters
    ----------
    folder
        Folder of a run that has ended; an interrupted run is repeated up to its interruption.
    progress
        As for `run`.

    Raises
    ------
    RunError
        If it is not the folder of a run, the run did not end, or an input file in it is damaged; the message names
        the file and the line or key. A damaged result counts as a difference, not as an error.
    """
    before = path_of(folder, "folder", RUN_FOLDER)
    about = read_about(before)
    _check_ended(before, about)
    notes = [*_other_circumstances(about), *_other_inputs(about, before)]
    scenario = scenario_of(before, about)
    if scenario.dt != about["dt"]:
        raise RunError(
            f"{before / 'run.json'}: is damaged: 'dt' is {about['dt']:g} s, and in {before / 'scenario.toml'} "
            f"simulation.dt is {scenario.dt:g} s; one of the two has been changed since the run"
        )
    steps = _steps_done(before, about)
    scenario = attrs.evolve(scenario, recording=attrs.evolve(scenario.recording, picture=False))
    with temporary_folder("reproduce") as beside:
        after = beside / "run"
        try:
            simulation = Simulation(scenario, seed=about["seed"], replicas=about["replicas"])
            if problem := different_world(about, simulation):
                return Outcome(is_same=False, is_exact=False, steps=0, difference=problem, notes=tuple(notes))
            replay = Replay(simulation, before, about.get("changes_before", 0))
            with (
                RunSession(simulation, after, wanted_steps=steps, is_kept=False) as session,
                progress_shown(progress, "simulating", float) as show,
            ):
                for done in range(1, steps + 1):
                    replay.give()
                    simulation.step()
                    session.keep()
                    if show is not None:
                        show(done / steps)
        except AmorsimError as error:
            if not notes:
                raise
            return Outcome(is_same=False, is_exact=False, steps=0, difference=str(error), notes=tuple(notes))
        digests = {str(replica): digest for replica, digest in session.summary.digests.items()}
        return _outcome(about, digests, first_difference(before, after, about["dt"]), steps, notes)


def _check_ended(folder: Path, about: Mapping[str, Any]) -> None:
    if not about.get("digests"):
        raise RunError(
            f"{folder}: this run did not end in order (its status is {about['status']!r}), so it has no digests to "
            "compare with"
        )


def _steps_done(folder: Path, about: Mapping[str, Any]) -> int:
    path = folder / "run.json"
    steps: int | None = about.get("steps_done")
    if steps is None:
        raise RunError(f"{path}: is damaged: expected a number of steps under 'steps_done', got nothing")
    if set(about["digests"]) != set(map(str, about["replicas"])):
        raise RunError(f"{path}: is damaged: expected a digest of each of the 'replicas' under 'digests'")
    # A wrong number would keep the simulation busy for that long.
    last = last_line(folder / "poses.csv")
    there = -1.0 if last is None else last.real("time") / about["dt"]
    if not abs(there - steps) <= 0.5:
        end = "has no line" if last is None else f"ends at {last.text('time')[:60]} s"
        raise RunError(
            f"{path}: is damaged: 'steps_done' is {steps}, which is {steps * about['dt']:g} s, and "
            f"{folder / 'poses.csv'} {end}; one of the two has been changed since the run"
        )
    return steps


def _outcome(
    about: Mapping[str, Any], digests: Mapping[str, str], found: Difference | None, steps: int, notes: list[str]
) -> Outcome:
    differing = [replica for replica, digest in about["digests"].items() if digests.get(replica) != digest]
    if not differing and found is None:
        return Outcome(is_same=True, is_exact=True, steps=steps, notes=tuple(notes))
    if not differing:
        assert found is not None
        text = f"the digests agree, but a file was changed after the run: {found}"
        return Outcome(
            is_same=False,
            is_exact=False,
            steps=steps,
            difference=text,
            tick=found.tick,
            robot=found.robot,
            notes=tuple(notes),
        )
    is_elsewhere = bool(_other_circumstances(about))
    if is_elsewhere and (found is None or found.is_small):
        return Outcome(is_same=True, is_exact=False, steps=steps, notes=tuple(notes))
    if found is None:
        text = f"the digest of replica {differing[0]}; all files agree, so by less than is written into them"
        return Outcome(is_same=False, is_exact=False, steps=steps, difference=text, notes=tuple(notes))
    if not notes and any(name.endswith(".py") for name in about.get("inputs", ())):
        notes = [*notes, "a controller with a clock or randomness of its own does not reproduce"]
    return Outcome(
        is_same=False,
        is_exact=False,
        steps=steps,
        difference=f"first {found}",
        tick=found.tick,
        robot=found.robot,
        notes=tuple(notes),
    )


def _other_circumstances(about: Mapping[str, Any]) -> list[str]:
    notes = []
    for key, value in circumstances().items():
        was = about.get(key)
        if isinstance(value, dict) and isinstance(was, dict):
            for name in sorted({*was, *value}):
                if was.get(name) != value.get(name):
                    notes.append(f"{name} was {_version(was.get(name))} and is {_version(value.get(name))}")
        elif was != value:
            notes.append(f"{key} was {was} and is {value}")
    return notes


def _version(version: Any) -> str:
    return "absent" if version is None else str(version)


def _other_inputs(about: Mapping[str, Any], folder: Path) -> list[str]:
    were = about.get("inputs", {})
    now = fingerprints(folder, list(were))
    return [
        f"{name} {'has been changed' if name in now else 'has gone'} since the run"
        for name, digest in were.items()
        if now.get(name) != digest
    ]
