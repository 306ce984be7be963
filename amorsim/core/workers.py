"""Threads that share the rows of a kernel's work.

Kernels release Python's global lock and write each row by itself, so slices of rows can be worked on side by side and
give the bits that one thread gives. No kernel is compiled a second time for it, and no pool is shared between
simulations, so there is nothing to lock.
"""

from __future__ import annotations

import concurrent.futures
import itertools
from collections.abc import Callable

__all__ = ["Workers"]

# Handing a slice to a thread and waiting for it took about 20 us when measured (two cores, nothing to do in the slice),
# which is what seven hundred rays or some thousand draws take; so smaller work is not parted. In rays, or what costs
# about as much.
LEAST_WORK = 2_000


class Workers:
    """So many threads; one of them is the caller's own."""

    def __init__(self, threads: int = 1) -> None:
        self.threads = threads
        self._pool: concurrent.futures.ThreadPoolExecutor | None = None

    def share(self, rows: int, work_per_row: int, work: Callable[[int, int], None]) -> None:
        """Call ``work(first, end)`` for slices that make up all `rows`; side by side where it pays.

        An error in any slice is raised once all have ended.
        """
        parts = min(self.threads, rows, 1 + rows * work_per_row // LEAST_WORK)
        if parts <= 1:
            work(0, rows)
            return
        if self._pool is None:
            self._pool = concurrent.futures.ThreadPoolExecutor(self.threads - 1, thread_name_prefix="amorsim")
        ends = [rows * (part + 1) // parts for part in range(parts)]
        others = [self._pool.submit(work, first, end) for first, end in itertools.pairwise(ends)]
        try:
            work(0, ends[0])
        finally:
            # Each tells when it has ended; to wait for all at once took half as long again.
            errors = [other.exception() for other in others]
        for error in errors:
            if error is not None:
                raise error
