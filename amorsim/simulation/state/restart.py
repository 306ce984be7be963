"""A fleet taken back: to the start of a new episode, or to a snapshot."""

from __future__ import annotations

import operator

import numpy as np

from amorsim.array_types import Bools
from amorsim.core.errors import SnapshotError
from amorsim.simulation import phases
from amorsim.simulation.fleet.fleet import Fleet
from amorsim.simulation.state.regroup import other_chains, regrouped
from amorsim.simulation.state.snapshot import Snapshot, fits, from_bytes, put_back, take_snapshot

__all__ = ["begin_episode", "fleet_fitting"]


def begin_episode(fleet: Fleet, which: Bools) -> None:
    """Begin a new episode in the replicas marked in `which` `(R,)`; the others stay as they are.

    Beginning costs as much for one replica as for all. So where some begin, the next episodes of all are begun at once
    and kept, and each replica takes its own when its turn comes: it is the same to the bit.
    """
    if which.all():
        _begin_all(fleet)
        fleet.events = []
        return
    if not _are_next(fleet, which):
        present = take_snapshot(fleet)
        _begin_all(fleet)
        fleet.upcoming = take_snapshot(fleet)
        put_back(fleet, present, np.ones_like(which))
    assert fleet.upcoming is not None
    put_back(fleet, fleet.upcoming, which)
    again = {fleet.replicas[number] for number in np.flatnonzero(which).tolist()}
    fleet.events = [event for event in fleet.events if event.replica not in again]


def _begin_all(fleet: Fleet) -> None:
    """Begin the next episode in every replica."""
    fleet.ticks = np.zeros_like(fleet.ticks)
    fleet.touching = fleet.contacts = frozenset()
    fleet.episodes = fleet.episodes + 1
    fleet.tell_time()  # initial beliefs are drawn at the start
    fleet.draw_starts(np.ones(len(fleet.replicas), dtype=bool))
    for group in fleet.everything:
        group.start()
    fleet.place()
    phases.first_look(fleet)


def _are_next(fleet: Fleet, which: Bools) -> bool:
    """Whether the kept episodes are the next ones of the replicas marked in `which`, with the present parameters."""
    kept = fleet.upcoming
    return (
        kept is not None
        and bool((kept.episodes[which] == fleet.episodes[which] + 1).all())
        and all(
            all(map(operator.is_, group.specified, held.specified))
            for group, held in zip(fleet.everything, kept.groups, strict=True)
        )
    )


def fleet_fitting(fleet: Fleet, snapshot: Snapshot | bytes) -> tuple[Fleet, Snapshot]:
    """A snapshot, and the fleet that it fits: the given one, or one with the chains of noise of that moment.

    Raises
    ------
    SnapshotError
        If it belongs to another simulation.
    """
    if isinstance(snapshot, bytes):
        snapshot = from_bytes(fleet, snapshot)
    if not isinstance(snapshot, Snapshot):
        raise SnapshotError(f"expected what Simulation.snapshot() gave, or its bytes, got {snapshot!r}")
    if not fits(fleet, snapshot) and (chains := other_chains(fleet, snapshot)):
        fleet = regrouped(fleet, chains)
    if not fits(fleet, snapshot):
        raise SnapshotError("this snapshot is of another simulation")
    return fleet, snapshot
