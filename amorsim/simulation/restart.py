"""A fleet taken back: to the start of a new episode, or to a snapshot."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from amorsim.core.errors import SnapshotError
from amorsim.simulation import phases
from amorsim.simulation.fleet import Fleet
from amorsim.simulation.regroup import other_chains, regrouped
from amorsim.simulation.snapshot import Snapshot, fits, from_bytes, put_back, take_snapshot

__all__ = ["begin_episode", "fleet_fitting"]


def begin_episode(fleet: Fleet, which: npt.NDArray[np.bool_]) -> None:
    """Begin a new episode in the replicas marked in `which` `(R,)`; the others stay as they are."""
    kept = take_snapshot(fleet)
    fleet.ticks = np.zeros_like(fleet.ticks)
    fleet.touching = fleet.contacts = frozenset()
    fleet.episodes = fleet.episodes + which
    fleet.tell_time()  # initial beliefs are drawn at the start
    for group in fleet.everything:
        group.start()
    fleet.place()
    phases.first_look(fleet)
    put_back(fleet, kept, ~which)
    fleet.events = [event for event in kept.events if not which[fleet.replicas.index(event.replica)]]


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
