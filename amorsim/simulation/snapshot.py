"""Copies of all that changes in a simulation, to go back to."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Mapping
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.core.errors import SnapshotError

__all__ = ["GroupSnapshot", "Snapshot", "copy_arrays", "copy_state"]

Arrays = dict[str, npt.NDArray[Any]]


@attrs.frozen(kw_only=True)
class GroupSnapshot:
    """All that changes of one group."""

    specified: tuple[Any, ...]
    tick: npt.NDArray[np.int64]
    episode: npt.NDArray[np.int64]
    arrays: dict[str, Arrays]
    states: dict[str, Arrays]


@attrs.frozen(kw_only=True)
class Snapshot:
    """All that changes of a simulation; made by `Simulation.snapshot`, taken by `Simulation.restore`."""

    seed: int
    replicas: tuple[int, ...]
    tick: npt.NDArray[np.int64]
    poses: npt.NDArray[np.float64]
    groups: tuple[GroupSnapshot, ...]
    obstacles: tuple[dict[str, Arrays], ...]
    events: tuple[Any, ...]


def copy_arrays(arrays: Mapping[str, Mapping[str, npt.NDArray[Any]]]) -> dict[str, Arrays]:
    """A copy, two tables deep."""
    return {unit: {name: array.copy() for name, array in held.items()} for unit, held in arrays.items()}


def copy_state(where: str, state: Mapping[str, npt.NDArray[Any]]) -> Arrays:
    """A copy of a component's state; objects in it (a user's controllers) are copied each.

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
            # Classes of a file that was loaded by path cannot be pickled by name, but can be copied.
            return copy.deepcopy(thing)
        except Exception:
            raise SnapshotError(
                f"{where}: {type(thing).__name__} cannot be copied ({error}); give it get_state() and set_state()"
            ) from error
