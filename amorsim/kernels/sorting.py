"""Sorting in place, by a heap, as a robot in a crowd may have hundreds of entries to sort."""

from __future__ import annotations

from amorsim.array_types import Array, Ints
from amorsim.kernels.compile import part

__all__ = ["sort"]


@part
def _comes_after(a: int, b: int, keys: Array, numbers: Ints) -> bool:
    """Whether entry a comes after entry b."""
    larger: bool = keys[a] > keys[b]
    as_large: bool = keys[a] == keys[b] and numbers[a] > numbers[b]
    return larger or as_large


@part
def sort(keys: Array, numbers: Ints) -> None:
    """Sort entries by their keys (Q,), and those of equal keys by their numbers (Q,)."""
    count = len(keys)
    begin = count // 2
    end = count
    while end > 1:
        if begin > 0:
            begin -= 1  # the heap is being made
        else:
            end -= 1
            keys[0], keys[end] = keys[end], keys[0]
            numbers[0], numbers[end] = numbers[end], numbers[0]
        top = begin
        while 2 * top + 1 < end:
            child = 2 * top + 1
            if child + 1 < end and _comes_after(child + 1, child, keys, numbers):
                child += 1
            if not _comes_after(child, top, keys, numbers):
                break
            keys[child], keys[top] = keys[top], keys[child]
            numbers[child], numbers[top] = numbers[top], numbers[child]
            top = child
