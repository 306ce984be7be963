"""The scene of a recorded run: what stays as it is in one replica, read without any user's code."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs

from amorsim.contracts import Controller, Estimator
from amorsim.core.errors import AmorsimError, RunError
from amorsim.runs.tables import check_file
from amorsim.runs.world_digests import KEY, world_fingerprint
from amorsim.scenario.documents.document import open_document
from amorsim.scenario.reading.partial import Partial
from amorsim.ui.scene.still import StillBuilder
from amorsim.ui.scene.wire import Scene
from amorsim.ui.simulator.sources.recorded import RecordedFiles
from amorsim.worlds.drawn import map_of, origin_of

__all__ = ["RecordedScene"]

_HOW = {
    "finished": "it finished",
    "interrupted": "it was interrupted",
    "broken off": "it was broken off",
    "running": "it is still going on, or was killed",
}


class RecordedScene:
    """Scenes of a run's replicas.

    Parameters
    ----------
    folder
        Of the run.
    about
        The content of its ``run.json``.
    files
        Its files.

    Attributes
    ----------
    scene, partial
        What is shown of the replica of the last `build`, and what was read of its scenario, with the replica's map.

    Raises
    ------
    RunError
        If ``scenario.toml`` cannot be read, or holds no map or robot that can be shown.
    """

    def __init__(self, folder: Path, about: Mapping[str, Any], files: RecordedFiles) -> None:
        self._folder, self._about, self._files = folder, about, files
        path = folder / "scenario.toml"
        check_file(path)
        try:
            self._partial = open_document(path).partial()
        except AmorsimError as error:
            raise RunError(f"{path}: cannot be read ({error})") from None
        self._version = 0

    def build(self, replica: int) -> None:
        """Make the scene of a replica.

        Raises
        ------
        RunError
            If there is no map or robot to be shown.
        """
        self._version += 1
        partial, lacks = self._partial, self._lacks()
        if partial.map is None:
            raise RunError(self._unreadable("the map"))
        if origin_of(partial.map) is not None:
            world = map_of(partial.map, replica)
            partial = attrs.evolve(partial, map=world)
            was = self._about.get(KEY, {}).get(str(replica))
            if was is not None and world_fingerprint(world) != was:
                lacks.append("The map that was drawn is not that of the run: the generator has been changed since.")
        self.partial = partial
        name = self._folder.resolve().name
        self._builder = StillBuilder(partial, name, self._version)
        scene = self._builder.still["scene"]
        if not scene["robots"]:
            raise RunError(self._unreadable("no robot"))
        about = self._about
        self.scene: Scene = {
            **scene,
            "robots": sorted(scene["robots"], key=lambda robot: robot["name"]),  # in the order of a run's rows
            "dt": float(about["dt"]),
            "duration": float(about.get("duration", partial.duration)),
            "seed": about["seed"],
            "recorded": {
                "replica": replica,
                "replicas": about["replicas"],
                "log": str(about.get("log", "")),
                "facts": self._facts(partial),
                "lacks": lacks,
            },
        }

    def picture(self, name: str) -> bytes:
        """The PNG that a map's shape names; raises as `MapShapes.picture`."""
        return self._builder.picture(name)

    def _unreadable(self, what: str) -> str:
        faults = "; ".join(str(fault) for fault in self._partial.faults[:3])
        return f"{self._folder / 'scenario.toml'}: {what} cannot be read" + (f": {faults}" if faults else "")

    def _facts(self, partial: Partial) -> list[list[str]]:
        """The page's description of the run: names and values."""
        about = self._about
        last = self._files.last_tick * float(about["dt"])
        status = str(about["status"])
        found = [
            ["folder", str(self._folder)],
            ["recorded", f"{last:g} s of {float(about.get('duration', partial.duration)):g} s"],
            ["how it ended", _HOW.get(status, status)],
            ["log", str(about["log"])] if "log" in about else ["seed", str(about["seed"])],
            ["step", f"{about['dt']:g} s"],
            ["amorsim", str(about.get("amorsim", "not known"))],
        ]
        return found + ([["problem", str(about["problem"])]] if about.get("problem") else [])

    def _lacks(self) -> list[str]:
        """The parts that the folder does not hold, in sentences."""
        files, partial = self._files, self._partial
        found = []
        if "log" in self._about:
            found.append("Where the robot truly was: no log has that. The map is the one at the end.")
        sensors = {name for robot in partial.robots for name in robot.sensors}
        missing = sorted(name for name in sensors if not files.has(f"sensors/{name}"))
        if sensors and len(missing) == len(sensors):
            found.append("No readings were recorded: run with --set recording.sensors=all.")
        elif missing:
            found.append(f"There are no readings of {_listed(missing)}.")
        for name, what in (
            ("velocities", "velocities"),
            ("commands", "commands"),
            ("events", "events"),
        ):
            if not files.has(name):
                found.append(f"There are no {what}: {name}.csv is missing or damaged.")
        estimators = {name for robot in partial.robots for name in [*robot.estimators][:1] or ["none"]}
        for name in sorted(estimators):
            if not files.has(f"estimates/{name}"):
                found.append(f"There are no ellipses of {name}: estimates/{name}.csv is missing or damaged.")
        if partial.obstacles and not files.has("obstacles"):
            found.append("Obstacles are not shown: obstacles.csv is missing or damaged.")
        found += self._lacking_beliefs()
        found += [f"Not shown, since it cannot be read: {fault}" for fault in partial.faults]
        return found

    def _lacking_beliefs(self) -> list[str]:
        """Particles, maps and intentions, if robots may have some and the recorder `arrays` did not write them."""
        found = []
        estimators = [pair for robot in self._partial.robots for pair in robot.estimators.items()]
        names = sorted({name for name, one in estimators if type(one).beliefs is not Estimator.beliefs})
        if names and not self._files.has_arrays(names):
            found.append(
                f"Particles, maps and graphs, if {_listed(names)} had any, were not recorded: the scenario needs "
                'recording = { also = [{ use = "arrays" }] }.'
            )
        controllers = [robot.controller for robot in self._partial.robots]
        intend = any(type(one).beliefs is not Controller.beliefs for one in controllers if one is not None)
        if intend and not self._files.has_arrays(["controller"]):
            found.append(
                "Paths, searched cells and arcs, if controllers had any, were not recorded: the scenario needs "
                'recording = { also = [{ use = "arrays", of = ["controller"] }] }.'
            )
        return found


def _listed(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else ", ".join(names[:-1]) + f" and {names[-1]}"
