"""Hypothesis tests few examples every day, and all of them among the long tests: see `tests.conftest`."""

from __future__ import annotations

from typing import Any

import hypothesis

__all__ = ["settings"]

LEAST = 8


def settings(
    parent: hypothesis.settings | None = None, *, max_examples: int = 100, **others: Any
) -> hypothesis.settings:
    """Hypothesis's settings; of the examples as many hundredths as the profile has examples."""
    share = hypothesis.settings.default.max_examples  # type: ignore[union-attr]
    count = min(max_examples, max(LEAST, max_examples * share // 100))
    return hypothesis.settings(parent, max_examples=count, **others)
