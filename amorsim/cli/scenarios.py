"""What a user may name as a scenario: a file, a bundled name, or a map alone."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from amorsim.core.errors import AmorsimError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from amorsim.scenario.spec import Scenario

__all__ = ["read_scenario"]


def read_scenario(name: str, *, resolution: float | None = None, changes: Sequence[str] = ()) -> Scenario:
    """The scenario that a user means by `name`."""
    from amorsim.scenario.read import load, scenario_for_map

    path = Path(name)
    is_map = path.suffix.lower() not in ("", ".toml")
    if is_map:
        options: dict[str, Any] = {} if resolution is None else {"resolution": resolution}
        return scenario_for_map(path, overrides=tuple(changes), **options)
    if resolution is not None:
        raise AmorsimError(
            "--resolution is for a map alone; a scenario says it in [world] (or --set world.resolution=)"
        )
    return load(name, overrides=tuple(changes))
