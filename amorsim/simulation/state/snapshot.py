"""Snapshots: copies of all that changes in a simulation."""

from __future__ import annotations

import copy
import operator
import pickle
from collections.abc import Mapping
from typing import Any

import attrs
import numpy as np

from amorsim.array_types import AnyArray, Bools, Ints
from amorsim.core.errors import SnapshotError
from amorsim.simulation.fleet.fleet import Fleet
from amorsim.simulation.fleet.group import Group
from amorsim.simulation.fleet.grouping import group_key

__all__ = ["Snapshot", "copy_state", "fits", "from_bytes", "put_back", "take_snapshot"]

Arrays = dict[str, AnyArray]


@attrs.frozen(kw_only=True)
class GroupSnapshot:
    """All that changes of one group of robots or obstacles."""

    names: tuple[str, ...]  # of the rows' robots or obstacles
    specified: tuple[Any, ...]
    arrays: dict[str, Arrays]
    states: dict[str, Arrays]


@attrs.frozen(kw_only=True)
class Snapshot:
    """All that changes of a simulation; made by `Simulation.snapshot`, restored by `Simulation.restore`."""

    seed: int
    replicas: tuple[int, ...]
    ticks: Ints
    episodes: Ints
    groups: tuple[GroupSnapshot, ...]
    touching: frozenset[tuple[int, int]]
    contacts: frozenset[tuple[int, int]]
    events: tuple[Any, ...]

    def to_bytes(self) -> bytes:
        """The snapshot as bytes, for `Simulation.restore` in another process that simulates the same scenario.

        It does not hold parameters that were set: set them there before restoring.

        Raises
        ------
        SnapshotError
            If a user's controller cannot be pickled.
        """
        bare = attrs.evolve(self, groups=tuple(attrs.evolve(group, specified=()) for group in self.groups))
        try:
            return pickle.dumps(bare, pickle.HIGHEST_PROTOCOL)
        except Exception as error:  # a user's object may raise anything
            raise SnapshotError(f"a controller cannot be carried to another process: {error}") from error


def from_bytes(fleet: Fleet, data: bytes) -> Snapshot:
    """The snapshot in bytes from `Snapshot.to_bytes`, with the parameters of a fleet.

    Raises
    ------
    SnapshotError
        If these are not such bytes, or their objects cannot be made here.
    """
    try:
        bare = pickle.loads(data)
    except Exception as error:
        raise SnapshotError(f"a snapshot cannot be read: {error}") from error
    if not isinstance(bare, Snapshot) or len(bare.groups) != len(fleet.everything):
        raise SnapshotError("this snapshot is of another simulation")
    groups = tuple(
        attrs.evolve(held, specified=tuple(group.specified))
        for group, held in zip(fleet.everything, bare.groups, strict=True)
    )
    return attrs.evolve(bare, groups=groups)


def take_snapshot(fleet: Fleet) -> Snapshot:
    """Copy all that changes of a fleet."""
    return Snapshot(
        seed=fleet.seed,
        replicas=fleet.replicas,
        ticks=fleet.ticks.copy(),
        episodes=fleet.episodes.copy(),
        groups=tuple(
            GroupSnapshot(
                names=tuple(group.names),
                specified=tuple(group.specified),
                arrays=_copy_arrays(group.arrays()),
                states={
                    where: copy_state(f"{where} of {group.names[0]!r}", state)
                    for where, state in group.states().items()
                },
            )
            for group in fleet.everything
        ),
        touching=fleet.touching,
        contacts=fleet.contacts,
        events=tuple(fleet.events),
    )


def fits(fleet: Fleet, snapshot: Snapshot) -> bool:
    """Whether a snapshot fits a fleet: the same replicas, bodies in the same groups, and the same form of state."""
    return (
        fleet.replicas == snapshot.replicas
        and len(fleet.everything) == len(snapshot.groups)
        and all(
            tuple(group.names) == held.names
            and _have_same_chains(group, held)
            and _form(group.arrays()) == _form(held.arrays)
            and _form(group.states()) == _form(held.states)
            for group, held in zip(fleet.everything, snapshot.groups, strict=True)
        )
    )


def _have_same_chains(group: Any, held: GroupSnapshot) -> bool:
    """Whether the elements of noise are of the same classes: states need not differ in form where classes do."""
    if not isinstance(group, Group) or not held.specified or group.specified[0] is held.specified[0]:
        return True
    return group_key(group.specified[0]) == group_key(held.specified[0])


def _form(tables: Mapping[str, Mapping[str, AnyArray]]) -> dict[str, dict[str, tuple[Any, ...]]]:
    return {where: {name: (array.shape, array.dtype) for name, array in held.items()} for where, held in tables.items()}


def put_back(fleet: Fleet, snapshot: Snapshot, which: Bools) -> None:
    """Restore the replicas marked in `which` `(R,)`, without the events; the others stay as they are."""
    fleet.ticks = np.where(which, snapshot.ticks, fleet.ticks)
    fleet.episodes = np.where(which, snapshot.episodes, fleet.episodes)
    of = fleet.world.replica_index
    for name in ("touching", "contacts"):
        back = {pair for pair in getattr(snapshot, name) if which[of[pair[0]]]}
        kept = {pair for pair in getattr(fleet, name) if not which[of[pair[0]]]}
        setattr(fleet, name, frozenset(back | kept))
    for group, held in zip(fleet.everything, snapshot.groups, strict=True):
        if isinstance(group, Group) and not all(map(operator.is_, group.specified, held.specified)):
            group.specified = list(held.specified)
            group.set_parameters()
        rows = np.flatnonzero(which[fleet.world.replica_index[group.bodies]])
        for unit, arrays in group.arrays().items():
            for name, array in arrays.items():
                array[rows] = held.arrays[unit][name][rows]
        for where, state in group.states().items():
            chosen = {name: array[rows] for name, array in held.states[where].items()}
            for name, array in copy_state(where, chosen).items():
                state[name][rows] = array  # in its place: what a step calls is bound to it
    fleet.place()
    fleet.tell_time()


def _copy_arrays(arrays: Mapping[str, Mapping[str, AnyArray]]) -> dict[str, Arrays]:
    """A copy, two tables deep."""
    return {unit: {name: array.copy() for name, array in held.items()} for unit, held in arrays.items()}


def copy_state(where: str, state: Mapping[str, AnyArray]) -> Arrays:
    """A copy of a component's state; each object in it (a user's controllers) is copied.

    Raises
    ------
    SnapshotError
        If an object has no `get_state` and `set_state` and cannot be pickled.
    """
    copied = {}
    for name, array in state.items():
        if array.dtype == object:
            objects = np.empty_like(array)
            for i, thing in enumerate(array.flat):
                objects.flat[i] = _copy_object(where, thing)
            copied[name] = objects
        else:
            copied[name] = array.copy()
    return copied


def _copy_object(where: str, thing: Any) -> Any:
    if hasattr(thing, "get_state") and hasattr(thing, "set_state"):
        twin = copy.copy(thing)
        twin.set_state(copy.deepcopy(thing.get_state()))
        return twin
    try:
        return pickle.loads(pickle.dumps(thing))
    except Exception as error:
        try:
            # Classes from a file that was loaded by path can be copied, but not pickled by name.
            return copy.deepcopy(thing)
        except Exception:
            raise SnapshotError(
                f"{where}: {type(thing).__name__} cannot be copied ({error}); give it get_state() and set_state()"
            ) from error
