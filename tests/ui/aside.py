"""Coroutines in a thread of their own: Playwright keeps a loop running in the tests' thread once it was started."""

from __future__ import annotations

import asyncio
import concurrent.futures
from collections.abc import Coroutine
from typing import Any, TypeVar

__all__ = ["aside"]

T = TypeVar("T")


def aside(work: Coroutine[Any, Any, T]) -> T:
    """What a coroutine returns, or raises."""
    with concurrent.futures.ThreadPoolExecutor(1) as pool:
        return pool.submit(asyncio.run, work).result()
