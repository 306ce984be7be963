"""Noise chains exchanged in the middle of a run: a new fleet goes on from the state of the old one.

Elements come and go while everything else goes on: poses, joints, readings and the states of all components that are
the same in both. Draws depend on names, so no other component's draws change.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import attrs
import numpy as np

from amorsim.array_types import AnyArray
from amorsim.contracts import Estimate, Frame, Measurement
from amorsim.core.rows import signature
from amorsim.scenario.reading.chains import chain_at, paths_of_chains, with_chain
from amorsim.scenario.spec import NoiseElement, Robot
from amorsim.simulation.fleet.fleet import Fleet
from amorsim.simulation.fleet.group import Group
from amorsim.simulation.fleet.grouping import group_key, robot_model
from amorsim.simulation.fleet.obstacles import ObstacleGroup
from amorsim.simulation.state.snapshot import Snapshot

__all__ = ["Chains", "chains_of", "frames_as", "other_chains", "regrouped"]

Chains = Mapping[str, tuple[NoiseElement, ...]]
Tables = Mapping[str, Mapping[str, AnyArray]]


def chains_of(robot: Robot) -> Chains:
    """All chains of a robot, by path."""
    return {path: chain_at(robot, path) for path in paths_of_chains(robot)}


def other_chains(fleet: Fleet, snapshot: Snapshot) -> dict[str, Chains]:
    """The chains of robots that had others at a snapshot than they have now; none where other robots are in it."""
    then = {
        name: robot
        for held in snapshot.groups
        for name, robot in zip(held.names, held.specified, strict=False)
        if isinstance(robot, Robot)
    }
    now = {name: robot for group in fleet.groups for name, robot in zip(group.names, group.specified, strict=True)}
    if then.keys() != now.keys() or any(then[name].sensors.keys() != now[name].sensors.keys() for name in now):
        return {}
    return {name: chains_of(robot) for name, robot in then.items() if group_key(robot) != group_key(now[name])}


def _with_chains(robot: Robot, chains: Chains) -> Robot:
    for path, elements in chains.items():
        if chain_at(robot, path) is not elements:
            robot = with_chain(robot, path, elements)
    return robot


def regrouped(old: Fleet, chains: Mapping[str, Chains]) -> Fleet:
    """A fleet at the same moment, in which the robots of these names have other chains.

    What is under way to a robot is lost where a sensor's longest delay changes. The old fleet must not be used again.
    """
    present = {group.names[row]: chains_of(group.specified[row]) for group in old.groups for row in _first_rows(group)}
    wanted = {**present, **chains}
    robots = [_with_chains(robot, wanted[robot.name]) for robot in old.scenario.robots]
    threads = old.world.workers.threads
    new = Fleet(attrs.evolve(old.scenario, robots=robots), old.seed, old.replicas, threads, old.terrains)
    new.ticks, new.episodes, new.events = old.ticks, old.episodes, old.events
    new.touching, new.contacts = old.touching, old.contacts
    for group in new.everything:
        sources = [old.row_of(int(body)) for body in group.bodies]
        if isinstance(group, Group):
            specified = [source.specified[row] for source, row in sources if isinstance(source, Group)]
            group.specified = [_with_chains(robot, wanted[robot.name]) for robot in specified]
            group.set_parameters()
        for source in {id(source): source for source, _ in sources}.values():
            rows = np.array([i for i, (one, _) in enumerate(sources) if one is source])
            _carry(source, np.array([sources[i][1] for i in rows]), group, rows)
    new.place()
    new.tell_time()
    for group in new.groups:  # now, so that readings are in their places at once
        group.bind()
    return new


def _first_rows(group: Group) -> list[int]:
    """A row of each robot of a group: replicas of one have the same chains."""
    return list({name: row for row, name in enumerate(group.names)}.values())


def _carry(source: Group | ObstacleGroup, from_rows: Any, group: Group | ObstacleGroup, rows: Any) -> None:
    """Copy the changing arrays of rows of one group into rows of another, where they have the same form."""
    arrays = group.arrays()
    for unit, held in source.arrays().items():
        fits = _is_alike(held, arrays[unit])
        for name, array in held.items():
            # Samples that wait for another longest delay do not fit; the reading at hand stays.
            if name in arrays[unit] and (fits or not name.startswith(".")):
                arrays[unit][name][rows] = array[from_rows]
    others = _other_elements(source, group)
    states = group.states()
    for where, state in source.states().items():
        if where in states and where not in others and _is_alike(state, states[where]):
            for name, array in state.items():
                states[where][name] = _with_rows(states[where][name], rows, array[from_rows])


def _is_alike(held: Mapping[str, AnyArray], other: Mapping[str, AnyArray]) -> bool:
    """Whether two tables have the same arrays; the numbers of rows may differ."""
    return held.keys() == other.keys() and all(
        array.shape[1:] == other[name].shape[1:] and array.dtype == other[name].dtype for name, array in held.items()
    )


def _with_rows(array: AnyArray, rows: Any, values: AnyArray) -> AnyArray:
    changed = array.copy()
    changed[rows] = values
    return changed


def _other_elements(source: Group | ObstacleGroup, group: Group | ObstacleGroup) -> set[str]:
    """The positions of states whose element is another one than before, though it has the same name."""
    if not isinstance(source, Group) or not isinstance(group, Group):
        return set()
    before, after = chains_of(source.specified[0]), chains_of(group.specified[0])
    changed = set()
    for path, elements in after.items():
        known = {element.name: element for element in before[path]}
        where = "ground" if path == "ground" else f"sensor {path.split('.')[1]} noise"
        for element in elements:
            old = known.get(element.name)
            if old is None or old.column != element.column or signature(old.noise) != signature(element.noise):
                changed.add(f"{where} {element.name}")
    return changed


def frames_as(partition: tuple[tuple[str, ...], ...], fleet: Fleet) -> list[Frame]:
    """The present step of all robots, a frame for each part of a partition: those of the groups in the beginning.

    Recorders learn the groups once, so they keep them even if the chains of robots in one group come to differ.
    """
    groups = {group.names[0]: group for group in fleet.groups}
    frames = []
    for names in partition:
        group = groups.get(names[0])
        if group is not None and tuple(group.names) == names:
            frames.append(group.frame())
        else:
            frames.append(_merged(names, [one for one in fleet.groups if set(one.names) & set(names)]))
    return frames


def _merged(names: tuple[str, ...], groups: list[Group]) -> Frame:
    """One frame of some robots, which may be in several groups, in the order of their bodies."""
    wanted = set(names)
    bodies = np.concatenate([group.bodies for group in groups])
    order = [i for i in np.argsort(bodies) if _name_at(groups, int(i)) in wanted]
    frames = [group.frame() for group in groups]
    first = frames[0]

    def rows(parts: Sequence[AnyArray]) -> AnyArray:
        return np.concatenate(parts)[order]

    specified = [robot for group in groups for robot in group.specified]
    sizes = {name: unit.size for name, unit in groups[0].sensors.items()}
    readings = {}
    for name in first.readings:
        held = [frame.readings[name] for frame in frames]
        parts = zip(*(measurement for _, measurement in held), strict=True)
        readings[name] = rows([true for true, _ in held]), Measurement(*map(rows, parts))
    estimates = {
        name: Estimate(*map(rows, zip(*(frame.estimates[name] for frame in frames), strict=True)))
        for name in first.estimates
    }
    return Frame(
        names=names,
        replica=rows([frame.replica for frame in frames]),
        tick=rows([frame.tick for frame in frames]),
        time=rows([frame.time for frame in frames]),
        true_pose=rows([frame.true_pose for frame in frames]),
        true_twist=rows([frame.true_twist for frame in frames]),
        joint_names=first.joint_names,
        joint_rates=rows([frame.joint_rates for frame in frames]),
        estimates=estimates,
        readings=readings,
        channels=first.channels,
        command=rows([frame.command for frame in frames]),
        robot=robot_model([specified[i] for i in order], sizes, groups[0].channels, groups[0].dt),
        parts=first.parts,
        part_pose=rows([frame.part_pose for frame in frames]),
    )


def _name_at(groups: list[Group], number: int) -> str:
    """The name of a row, counted over all groups."""
    for group in groups:
        if number < group.rows:
            return group.names[number]
        number -= group.rows
    raise IndexError(number)
