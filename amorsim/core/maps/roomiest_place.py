"""The middle of the roomiest free part of an array of cells, inside a building rather than around it."""

from __future__ import annotations

import numpy as np

from amorsim.array_types import Bools, Ints

__all__ = ["inside", "joined", "joined_to", "room_about", "roomiest"]


def roomiest(free: Bools) -> tuple[int, int, int] | None:
    """`(row, col, room)` of the free cell with most room: in the middle of a free square of 2 room - 1 cells.

    None if nothing is free.
    """
    left = np.pad(inside(free), 1)
    room = 0
    middle = left
    while left.any():
        room += 1
        middle = left
        left = _eroded(left)
    if room == 0:
        return None
    places = np.argwhere(middle)
    # Of equally roomy cells, the one nearest to their mean: the middle of a long hall, not its end.
    row, col = places[np.argmin(((places - places.mean(axis=0)) ** 2).sum(axis=1))]
    return int(row) - 1, int(col) - 1, room


def joined(free: Bools) -> Bools:
    """The free cells connected to the roomiest place by free cells; none if no cell is free."""
    found = roomiest(free)
    return np.zeros_like(free) if found is None else joined_to(free, found[0], found[1])


def joined_to(free: Bools, row: int, col: int) -> Bools:
    """The free cells connected to a given free cell by free cells that share a side."""
    padded = np.pad(free, 1)
    reached = np.zeros_like(padded)
    reached[row + 1, col + 1] = True
    reached, _ = _spread(padded, reached, padded.size)
    return reached[1:-1, 1:-1]


def inside(free: Bools) -> Bools:
    """The free cells that are inside a building, or all free cells if there is none."""
    padded = np.pad(free, 1)
    enclosed = _enclosed(padded)
    # A hollow pillar is enclosed too. Only if much of the free area is enclosed, the walls count as a building.
    left = enclosed if 4 * np.count_nonzero(enclosed) >= np.count_nonzero(padded) else padded
    return left[1:-1, 1:-1]


def room_about(free: Bools) -> Ints:
    """For each cell the `room` of the largest free square of 2 room - 1 cells around it; 0 if it is not free."""
    left = np.pad(free, 1)
    room = np.zeros(left.shape, dtype=np.int64)
    while left.any():
        room += left
        left = _eroded(left)
    return room[1:-1, 1:-1]


def _eroded(left: Bools) -> Bools:
    """The cells of a padded array whose eight neighbours are true as well."""
    across = np.zeros_like(left)
    across[:, 1:-1] = left[:, :-2] & left[:, 1:-1] & left[:, 2:]
    eroded = np.zeros_like(left)
    eroded[1:-1] = across[:-2] & across[1:-1] & across[2:]
    return eroded


def _enclosed(padded: Bools) -> Bools:
    """Free cells of a padded array that are not connected to its border; none if the search takes too long."""
    reached = np.zeros_like(padded)
    for edge in (np.s_[1], np.s_[-2], np.s_[:, 1], np.s_[:, -2]):
        reached[edge] = padded[edge]
    reached, is_whole = _spread(padded, reached, 64 if padded.size < 2 * 10**6 else 8)
    return padded & ~reached if is_whole else np.zeros_like(padded)


def _spread(padded: Bools, reached: Bools, rounds: int) -> tuple[Bools, bool]:
    """The free cells of a padded array connected to `reached`, and whether `rounds` were enough to find all."""
    # Each blocked cell begins a run of its row (or column); what reaches one free cell of a run reaches all
    # of it.
    row_runs = np.cumsum(~padded.ravel()).reshape(padded.shape)
    col_runs = np.cumsum(~padded.T.ravel()).reshape(padded.T.shape).T
    runs = int(row_runs[-1, -1]) + 1
    count = -1
    for _ in range(rounds):
        for numbers in (row_runs, col_runs):
            hit = np.zeros(runs, dtype=np.bool_)
            hit[numbers[reached]] = True
            reached = hit[numbers] & padded
        before, count = count, int(np.count_nonzero(reached))
        if count == before:
            return reached, True
    return reached, False
