"""Which estimator a metric judges, and which metrics are the same but for their estimator."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from amorsim.contracts import Metric
from amorsim.core.errors import AmorsimError, StudyError, did_you_mean
from amorsim.core.parameters import describe
from amorsim.plugins.manager import default_registry
from amorsim.scenario.spec import Robot, Scenario
from amorsim.simulation.kept_quantities import Keeper
from amorsim.simulation.simulation import Simulation
from amorsim.sweeps.plan import Measured

__all__ = ["about_metric", "metrics_of_shared"]


def _estimator_field(kind: type[Metric]) -> str:
    """The name of the metric's field that names an estimator; empty if it judges none."""
    return next((name for name, field in describe(kind).items() if field.refers == "estimators"), "")


def about_metric(measured: Measured, use: str, robots: Sequence[Robot]) -> dict[str, Any]:
    """The record of a metric in a study's folder.

    ``estimator`` is the one that it judges; empty if it judges none. ``measure`` is the same for metrics that differ in
    the estimator alone.
    """
    metric = measured.metric
    field = _estimator_field(type(metric))
    estimator = ""
    if field:
        own = [robot for robot in robots if robot.name == measured.robot or len(robots) == 1]
        first = next((name for robot in own for name in robot.estimators), "")
        estimator = getattr(metric, field) or first
    fields = [
        f"{name} = {getattr(metric, name)}"
        for name, each in describe(type(metric)).items()
        if name != field and getattr(metric, name) != each.default
    ]
    fields += [f"robot = {measured.robot}"] if measured.robot else []
    return {
        "unit": metric.unit,
        "better": metric.better,
        "robot": measured.robot,
        "estimator": estimator,
        "measure": f"{use} ({', '.join(fields)})" if fields else use,
    }


def metrics_of_shared(
    scenarios: Mapping[str, Scenario], metrics: Sequence[str], estimators: Sequence[str] = (), robot: str = ""
) -> dict[str, dict[str, str]]:
    """The ``[metrics]`` for studies of several scenarios: one for each estimator that all of them have.

    Metrics that judge no estimator, and all of them where no estimator is shared, have their defaults.

    Parameters
    ----------
    scenarios
        By name.
    metrics
        Names of components of the kind `metric`.
    estimators
        Which; without them, all that have what the metric needs.
    robot
        Whose; may be empty where each scenario has one robot.

    Raises
    ------
    StudyError
        If a scenario has no such robot, not all have such an estimator, or none has what a metric needs.
    """
    robots = [_robot(name, scenario, robot) for name, scenario in scenarios.items()]
    shared = [name for name in robots[0].estimators if all(name in each.estimators for each in robots)]
    for name in estimators:
        if name not in shared:
            where = "that all scenarios have" if len(robots) > 1 else f"of {robots[0].name}"
            raise StudyError(
                f"no estimator {name!r} {where}; known: {', '.join(shared) or 'none'}.{did_you_mean(name, shared)}"
            )
    registry = default_registry()
    found: dict[str, dict[str, str]] = {}
    for use in metrics:
        base = {"use": use} | ({"robot": robot} if robot else {})
        field = _estimator_field(registry.get("metric", use)) if use in registry.names("metric") else ""
        judged = list(estimators or shared) if field else []
        if judged and not estimators:
            judged = [name for name in judged if _can_judge(registry.get("metric", use), field, name, scenarios)]
            if not judged:
                raise StudyError(f"{use}: none of the estimators has what this metric needs: {', '.join(shared)}")
        found |= {f"{use} of {name}": base | {field: name} for name in judged} or {use: base}
    return found


def _robot(name: str, scenario: Scenario, robot: str) -> Robot:
    known = [each.name for each in scenario.robots]
    if not robot and len(known) > 1:
        raise StudyError(f"{name}: there are several robots; name one with --robot: {', '.join(known)}")
    if robot and robot not in known:
        raise StudyError(f"{name}: no robot {robot!r}; known: {', '.join(known)}.{did_you_mean(robot, known)}")
    return next(each for each in scenario.robots if each.name == (robot or known[0]))


def _can_judge(kind: type[Metric], field: str, estimator: str, scenarios: Mapping[str, Scenario]) -> bool:
    """Whether the estimator has what the metric needs; its beliefs are known in a simulation only."""
    needs = kind(**{field: estimator}).needs()
    if not any("beliefs." in name for name in needs):
        return True
    try:
        for scenario in scenarios.values():
            Keeper(Simulation(scenario, replicas=[0]), needs, 1)
    except AmorsimError:
        return False
    return True
