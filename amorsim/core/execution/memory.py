"""The available memory, so that what cannot fit is rejected before it is allocated."""

from __future__ import annotations

import os
import types
from pathlib import Path

resource: types.ModuleType | None
try:
    import resource
except ImportError:  # not on Windows
    resource = None

__all__ = ["memory_of_machine", "too_large"]

_LIMIT = Path("/sys/fs/cgroup/memory.max")  # of a container


def memory_of_machine() -> int | None:
    """The most bytes of memory that this process can have; None if that is not known (on Windows)."""
    try:
        whole = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, OSError, ValueError):
        return None
    if resource is not None:
        limits = (resource.getrlimit(kind)[0] for kind in (resource.RLIMIT_AS, resource.RLIMIT_DATA))
        whole = min(whole, *(limit for limit in limits if limit != resource.RLIM_INFINITY), whole)
    try:
        return min(whole, int(_LIMIT.read_text()))
    except (OSError, ValueError):  # no such file, or it holds "max"
        return whole


def too_large(count: int, each: int) -> str:
    """A message if `count` things of `each` bytes do not fit into memory, with the number that does; else empty."""
    there = memory_of_machine()
    if there is None or count * each <= there:
        return ""
    most = f": expected {there // each} at most" if each <= there else ""
    return f"would take {count * each / 1e9:.3g} GB of memory at least, and this machine has {there / 1e9:.3g} GB{most}"
