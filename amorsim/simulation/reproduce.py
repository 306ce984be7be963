"""Running a run again, and telling where it differs."""

from __future__ import annotations

import csv
import json
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import attrs

from amorsim.core.errors import RunError
from amorsim.scenario.read import load
from amorsim.simulation.run import run
from amorsim.simulation.simulation import Simulation

__all__ = ["Outcome", "reproduce"]


@attrs.frozen(kw_only=True)
class Outcome:
    """How a second run compares with the first."""

    is_same: bool
    steps: int
    difference: str = ""
    circumstances: tuple[str, ...] = ()  # versions and machines that differ

    def __str__(self) -> str:
        if self.is_same:
            return f"the same to the bit, over {self.steps} steps"
        lines = [f"not the same: {self.difference}"]
        lines += [f"note: {text}" for text in self.circumstances]
        return "\n".join(lines)


def reproduce(folder: Path) -> Outcome:
    """Run what lies in a run's folder again: its scenario, its recorded hand-given commands, its live changes.

    Raises
    ------
    RunError
        If the folder is none of a run, or the run did not end.
    """
    about = _read_about(folder)
    scenario = load(folder / "scenario.toml")
    scenario = attrs.evolve(scenario, recording=attrs.evolve(scenario.recording, picture=False, sensors="none"))
    simulation = _Replay(scenario, about, folder)
    with tempfile.TemporaryDirectory(prefix="amorsim-") as beside:
        again = Path(beside) / "run"
        duration = about["steps_done"] * about["dt"]
        summary = run(scenario, again, duration=duration, simulation=simulation)
        differing = [replica for replica, digest in about["digests"].items() if summary.digests[int(replica)] != digest]
        if not differing:
            return Outcome(is_same=True, steps=summary.steps)
        difference = _first_difference(folder, again) or (
            f"replica {differing[0]} differs by less than the micrometre that files are written to, "
            "or in a sensor's reading only"
        )
    return Outcome(
        is_same=False, steps=summary.steps, difference=difference, circumstances=tuple(_circumstances(about, folder))
    )


def _read_about(folder: Path) -> dict[str, Any]:
    path = folder / "run.json"
    try:
        about = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise RunError(f"{folder}: expected the folder of a run, with a run.json in it") from None
    except (OSError, ValueError) as error:
        raise RunError(f"{path}: cannot be read ({error})") from None
    if "digests" not in about:
        raise RunError(f"{folder}: this run did not end (its status is {about.get('status')!r}), so it has no digest")
    return dict(about)


class _Replay(Simulation):
    """A simulation in which what came from outside comes again at its tick: commands by hand, changes, poses."""

    def __init__(self, scenario: Any, about: Mapping[str, Any], folder: Path) -> None:
        super().__init__(scenario, seed=about["seed"], replicas=about["replicas"])
        self._changes: dict[int, list[dict[str, str]]] = {}
        for row in _rows(folder / "events.csv"):
            if row["kind"] in ("parameter_set", "pose_set"):
                self._changes.setdefault(int(row["tick"]), []).append(row)
        self._by_hand = [group for group in self._fleet.groups if "command" in group.controller_state]
        self._commands = _rows(folder / "commands.csv") if self._by_hand else iter(())
        self._next = next(self._commands, None)

    def step(self) -> None:
        """Give what was given before this step, then make it."""
        for row in self._changes.get(self.tick, []):
            replica = int(row.get("replica", self.replicas[0]))
            value = json.loads(row["value"])
            if row["kind"] == "pose_set":
                self.set_pose(row["robot"], value, replica=replica)
            else:
                self.set(row["robot"], row["path"], value, replica=replica)
        self._give_commands()
        super().step()

    def _give_commands(self) -> None:
        """Commands stand in the file at the tick that they led to."""
        at = (self.tick + 1) * self.dt
        while self._next is not None and float(self._next["time"]) < at + 0.5 * self.dt:
            row = self._next
            if float(row["time"]) > at - 0.5 * self.dt:
                replica = int(row.get("replica", self.replicas[0]))
                handle = self.robot(row["robot"], replica)
                if any(handle._group is group for group in self._by_hand) and handle.is_active:
                    channels = handle._group.channels
                    handle.command(*(float(row[name]) for name in channels))
            self._next = next(self._commands, None)


def _rows(path: Path) -> Iterator[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as file:
        yield from csv.DictReader(file)


def _first_difference(before: Path, after: Path) -> str:
    for name in ("poses.csv", "commands.csv"):
        for old, new in zip(_rows(before / name), _rows(after / name), strict=False):
            if old != new:
                column = next(key for key in old if old[key] != new[key])
                where = f"replica {old['replica']}, " if "replica" in old else ""
                return (
                    f"first at {float(old['time']):g} s, {where}robot {old['robot']!r}: "
                    f"{column} was {old[column]} and is {new[column]}"
                )
    return ""


def _circumstances(about: Mapping[str, Any], folder: Path) -> Iterator[str]:
    from amorsim.simulation.run import circumstances

    now = circumstances()
    for key, value in now.items():
        if about.get(key) != value:
            yield f"{key} was {about.get(key)!r} and is {value!r}"
    scenario = (folder / "scenario.toml").read_text(encoding="utf-8")
    if ".py:" in scenario:
        yield "a controller of a user's own does not reproduce if it has a clock or randomness of its own"
