"""The names that a user may give a scenario: a file, also another program's, a bundled name, or a map alone."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import attrs

from amorsim.core.errors import AmorsimError, MapError
from amorsim.core.files.reading import is_file, is_there
from amorsim.core.parameters import ParameterError, check_value, describe

if TYPE_CHECKING:
    from collections.abc import Sequence

    from amorsim.core.maps.map import Map
    from amorsim.scenario.documents.document import Document
    from amorsim.scenario.spec import Scenario
    from amorsim.simulation.simulation import Simulation

__all__ = [
    "is_map_alone",
    "look_up",
    "look_up_world",
    "make_simulation",
    "placed",
    "read_any_world",
    "read_scenario",
    "read_world",
    "scenario_document",
    "with_options",
]


def is_map_alone(name: str) -> bool:
    """Whether `name` is that of a map, not of a scenario."""
    return _is_map(name)


def look_up(
    name: str,
    *,
    resolution: float | None = None,
    changes: Sequence[str] = (),
    seed: int | None = None,
    duration: float | None = None,
) -> None:
    """Raise the errors of `read_scenario` and `with_options` for these arguments, except those of a map's content.

    This compiles nothing: a new user learns of a typing mistake before the long first compilation, not after it.
    """
    from amorsim.scenario.reading.read import check_words

    options = _options(name, resolution)
    changes = _with_resolution(name, resolution, changes)
    for key, value in (("seed", seed), ("duration", duration)):
        if value is not None:
            _check_option(key, value)
    check_words(name, changes, of_map=options)


def with_options(scenario: Scenario, seed: int | None, duration: float | None = None) -> Scenario:
    """The scenario with the seed and duration that a user gave; None keeps the scenario's own."""
    given: dict[str, Any] = {"seed": seed, "duration": duration}
    given = {name: value for name, value in given.items() if value is not None}
    for name, value in given.items():
        _check_option(name, value)
    return attrs.evolve(scenario, **given)


def _check_option(name: str, value: float) -> None:
    from amorsim.scenario.spec import Scenario

    try:
        check_value(describe(Scenario)[name], value)
    except ParameterError as error:
        raise AmorsimError(f"--{error.name}: {error.problem}") from None


def _options(name: str, resolution: float | None) -> dict[str, Any] | None:
    """The options of the map with that `name`; None if it is a scenario's."""
    if _is_map(name):
        _check_map(Path(name))
        return {} if resolution is None else {"resolution": resolution}
    if resolution is not None and not _is_foreign(name):
        raise AmorsimError(
            "--resolution is for a map alone; a scenario says it in [world] (or --set world.resolution=)"
        )
    return None


def _check_map(path: Path) -> None:
    """Raise an error for a file that no map loader knows, worded for users who may have meant a scenario."""
    from amorsim.plugins.manager import default_registry
    from amorsim.scenario.files.foreign import loaders_of_extension
    from amorsim.scenario.files.maps import find_loader

    try:
        find_loader(path, None, default_registry())
    except MapError as error:
        if is_file(path):
            if names := loaders_of_extension(path, default_registry()):
                raise AmorsimError(
                    f"{path}: its first bytes are not those of a file that the scenario loader {names[0]!r} reads, "
                    "though its extension is"
                ) from None
            raise AmorsimError(f"{error}; a scenario is a .toml file") from None
        raise


def _is_map(name: str) -> bool:
    if not name.strip():
        raise AmorsimError("expected the name of a scenario or of a map, got nothing")
    return Path(name).suffix.lower() not in ("", ".toml") and not _is_foreign(name)


def _is_foreign(name: str) -> bool:
    """Whether a scenario loader reads the file of that name."""
    from amorsim.plugins.manager import default_registry
    from amorsim.scenario.files.foreign import find_scenario_loader

    return find_scenario_loader(Path(name), default_registry()) is not None


def _with_resolution(name: str, resolution: float | None, changes: Sequence[str]) -> Sequence[str]:
    """The changes of a scenario, with the resolution of its map where the file is another program's."""
    is_meant = resolution is not None and not _is_map(name)
    return [f"world.resolution={resolution}", *changes] if is_meant else changes


def read_scenario(name: str, *, resolution: float | None = None, changes: Sequence[str] = ()) -> Scenario:
    """The scenario that a user named."""
    from amorsim.scenario.reading.read import load, scenario_for_map

    options = _options(name, resolution)
    if options is not None:
        return scenario_for_map(Path(name), overrides=tuple(changes), **options)
    return load(name, overrides=tuple(_with_resolution(name, resolution, changes)))


def scenario_document(
    name: str, target: Path, scenario: Scenario, *, resolution: float | None = None, changes: Sequence[str] = ()
) -> Document:
    """The document of the scenario that a user named and that was read as `scenario`, to save at `target`."""
    from amorsim.plugins.manager import default_registry
    from amorsim.scenario.documents.converted import converted

    options, settings = _options(name, resolution), _with_resolution(name, resolution, changes)
    return converted(name, target, scenario, of_map=options, changes=settings, registry=default_registry())


def read_world(name: str, *, resolution: float | None = None, changes: Sequence[str] = ()) -> Map:
    """The map that a user named: its own, or that of the scenario of that name."""
    from amorsim.scenario.reading.read import load, read_map_alone

    options = _options(name, resolution)
    if options is not None:
        return read_map_alone(Path(name), overrides=tuple(changes), **options)
    return load(name, overrides=tuple(changes)).map


def look_up_world(name: str, *, seed: int = 0, resolution: float | None = None, changes: Sequence[str] = ()) -> None:
    """Raise the errors of `read_any_world` for these arguments, except those of a map's content; compiles nothing."""
    from amorsim.scenario.reading.read import read_generated_alone

    if _is_generator(name):
        read_generated_alone(name, seed, _of_generator(resolution, changes), is_made=False)
    else:
        look_up(name, resolution=resolution, changes=changes)


def read_any_world(name: str, *, seed: int = 0, resolution: float | None = None, changes: Sequence[str] = ()) -> Map:
    """As `read_world`; or else the world, with this seed, of the generator of that name.

    Changes of a generator's fields are spelt as those of a world: ``world.corridor=1.5``.
    """
    from amorsim.scenario.reading.read import read_generated_alone

    if not _is_generator(name):
        return read_world(name, resolution=resolution, changes=changes)
    world = read_generated_alone(name, seed, _of_generator(resolution, changes))
    assert world is not None  # or there would be faults
    return world


def _is_generator(name: str) -> bool:
    """Whether a name is that of a world generator, and of no scenario and no file."""
    from amorsim.plugins.manager import default_registry

    registry = default_registry()
    is_other = name in registry.names("scenario") or is_there(name)
    return name in registry.names("world_generator") and not is_other


def _of_generator(resolution: float | None, changes: Sequence[str]) -> list[str]:
    cell = [] if resolution is None else [f"cell={resolution!r}"]
    return [*cell, *(change.removeprefix("world.") for change in changes)]


def make_simulation(scenario: Scenario, replicas: int | Sequence[int] = 1, threads: int = 1) -> tuple[Simulation, str]:
    """The simulation of a scenario, and a remark for the user, or empty."""
    from amorsim.scenario.reading.worlds import is_free_at
    from amorsim.simulation.simulation import Simulation

    simulation = Simulation(scenario, replicas=replicas, threads=threads)
    world, first = scenario.map, scenario.robots[0]
    places_itself = scenario.source is not None and scenario.source.suffix.lower() == ".toml"
    if places_itself or world.start is None or first.pose is None:
        return simulation, ""
    if is_free_at(world, first, world.start):
        return simulation, ""
    (x, y, _), pose = world.start, first.pose
    return simulation, (
        f"the map's start ({x:.3f}, {y:.3f}) m leaves the robot no room; it starts at ({pose.x:.3f}, {pose.y:.3f}) m"
    )


def placed(scenario: Scenario) -> Scenario:
    """The scenario with the poses at which replica 0 begins, in place of random starts."""
    import attrs

    from amorsim.contracts import Frame, ObstacleFrame
    from amorsim.scenario.programs.programs import without_programs
    from amorsim.scenario.spec import Obstacle, Pose, Robot
    from amorsim.simulation.simulation import Simulation

    bodies: list[Robot | Obstacle] = [*scenario.robots, *scenario.obstacles]
    if all(body.start is None and body.pose is not None for body in bodies):
        return scenario
    simulation = Simulation(without_programs(scenario))
    poses: dict[str, Pose] = {}
    frames: list[Frame | ObstacleFrame] = [*simulation.frames(), *simulation.obstacle_frames()]
    for frame in frames:
        for name, (x, y, heading) in zip(frame.names, frame.true_pose.tolist(), strict=True):
            poses[name] = Pose(x=x, y=y, heading=heading)
    robots = [attrs.evolve(robot, pose=poses[robot.name], start=None) for robot in scenario.robots]
    obstacles = [attrs.evolve(one, pose=poses[one.name], start=None) for one in scenario.obstacles]
    return attrs.evolve(scenario, robots=robots, obstacles=obstacles)
