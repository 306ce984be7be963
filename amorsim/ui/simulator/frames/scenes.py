"""The scene of a simulation: what a window draws and does not change while it runs."""

from __future__ import annotations

from amorsim.runs.session import run_name
from amorsim.simulation.simulation import Simulation
from amorsim.ui.scene.bodies import body_of, floor_of
from amorsim.ui.scene.drawn_robots import RobotShapes
from amorsim.ui.scene.maps import MapShapes
from amorsim.ui.scene.wire import Scene

__all__ = ["SceneBuilder"]


class SceneBuilder:
    """The scene of a simulation, and the pictures of maps that it names."""

    def __init__(self, simulation: Simulation, version: int = 1) -> None:
        scenario = simulation.scenario
        self._maps = MapShapes()
        world = self._maps.add(simulation.map_of(simulation.replicas[0]))
        robots = RobotShapes(scenario.robots, self._maps)
        handles = [simulation.robot(name) for name in simulation.names]
        self.scene: Scene = {
            "version": version,
            "scenario": run_name(scenario),
            "dt": simulation.dt,
            "duration": scenario.duration,
            "seed": simulation.seed,
            "map": world,
            "robots": [robots.entry(handle.nominal) for handle in handles],
            "maps": self._maps.shapes,
            "kinds": robots.kinds,
            "obstacles": [
                body_of(obstacle.name, obstacle.shape, obstacle.colour, moves=obstacle.motion is not None)
                for obstacle in sorted(scenario.obstacles, key=lambda obstacle: obstacle.name)
            ]
            + [part for handle in handles for part in robots.parts(handle.true)],
            "floor": floor_of(scenario.landmarks, scenario.lights, scenario.zones, scenario.floor),
        }

    def picture(self, name: str) -> bytes:
        """The PNG that a map's shape names; raises as `MapShapes.picture`."""
        return self._maps.picture(name)
