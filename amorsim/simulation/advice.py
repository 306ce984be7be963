"""What is not wrong with a scenario, but hardly meant."""

from __future__ import annotations

import numpy as np

from amorsim.scenario.spec import Scenario

__all__ = ["advice"]

_TURN = np.arange(32) * (np.pi / 16.0)


def advice(scenario: Scenario) -> list[str]:
    """Remarks on a scenario that runs, each with the path it is about."""
    remarks = []
    for robot in scenario.robots:
        for name, unit in robot.sensors.items():
            path = f"robots.{robot.name}.sensors.{name}"
            if unit.rate is not None and unit.rate * scenario.dt > 1.0 + 1e-9:
                remarks.append(
                    f"{path}.rate: {unit.rate:g} Hz is faster than the steps ({1.0 / scenario.dt:g} Hz); "
                    "it reads once every step"
                )
            ticks = unit.latency / scenario.dt
            if abs(ticks - round(ticks)) > 1e-6:
                remarks.append(
                    f"{path}.latency: {unit.latency:g} s is no multiple of dt ({scenario.dt:g} s); "
                    "readings arrive at the first step after it"
                )
        if robot.controller is None:
            remarks.append(f"robots.{robot.name}.controller: there is none, so the robot stands still")
    for i, mark in enumerate(scenario.landmarks):
        x, y = mark.x + mark.radius * np.cos(_TURN), mark.y + mark.radius * np.sin(_TURN)
        if scenario.map.occupied(np.stack((np.append(x, mark.x), np.append(y, mark.y)), axis=1)).all():
            remarks.append(
                f"landmarks.{i}: ({mark.x:g}, {mark.y:g}) m and all within its radius of {mark.radius:g} m is wall, or "
                "outside the map; nobody can see it"
            )
    for i, light in enumerate(scenario.lights):
        if scenario.map.occupied([[light.x, light.y]])[0]:
            remarks.append(
                f"lights.{i}: ({light.x:g}, {light.y:g}) m is in a wall or outside the map; the lamp lights nothing"
            )
    return remarks
