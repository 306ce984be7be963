"""The sources of a scenario's estimators, as a table for users."""

from __future__ import annotations

from amorsim.core.error_text import RAISED, error_in_words
from amorsim.core.errors import ComponentError
from amorsim.scenario.spec import Scenario

__all__ = ["source_lines"]


def source_lines(scenario: Scenario) -> list[str]:
    """A heading and a line for each source (`Estimator.sources`) of each estimator that names any.

    Robots whose estimators of one name use the same share a table.
    """
    tables: dict[tuple[str, tuple[tuple[str, str, str], ...]], list[str]] = {}
    for robot in scenario.robots:
        for name, estimator in robot.estimators.items():
            try:
                rows = tuple((str(who), str(does), str(trust)) for who, does, trust in estimator.sources())
            except RAISED as error:
                what = f"estimator {name!r} ({type(estimator).__name__}) of robot {robot.name!r}"
                raise ComponentError(f"{what}: sources() raised {error_in_words(error)}") from error
            if rows:
                tables.setdefault((name, rows), []).append(robot.name)
    lines = []
    for (name, rows), robots in tables.items():
        whose = ", ".join(robots[:4]) + (f" and {len(robots) - 4} more" if len(robots) > 4 else "")
        lines.append(f"estimator {name} of {whose}:")
        wide = [max(len(source[column]) for source in rows) for column in range(2)]
        lines += [f"  {who:<{wide[0]}}  {does:<{wide[1]}}  {trust}".rstrip() for who, does, trust in rows]
    return lines
