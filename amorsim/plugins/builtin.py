"""What amorsim itself registers, through the hook that every plugin uses.

Components are named, not imported: each is imported when it is first asked for.
"""

from __future__ import annotations

from pathlib import Path

from amorsim.plugins.hooks import hookimpl
from amorsim.plugins.registry import Registry

__all__ = ["amorsim_register"]

_PACKAGE = Path(__file__).parents[1]


@hookimpl
def amorsim_register(registry: Registry) -> None:
    """Register the built-in components, robots and scenarios."""
    registry.drive("differential", "amorsim.drives.differential:Differential")

    registry.sensor("encoder", "amorsim.sensors.encoder:Encoder")
    registry.sensor("laser", "amorsim.sensors.laser:Laser")
    registry.sensor("sonar", "amorsim.sensors.sonar:Sonar")
    registry.sensor("compass", "amorsim.sensors.compass:Compass")
    registry.sensor("gyro", "amorsim.sensors.gyro:Gyro")

    registry.noise("gaussian", "amorsim.noise.gaussian:Gaussian")
    registry.noise("aim_gaussian", "amorsim.noise.aim_gaussian:AimGaussian")
    registry.noise("bias", "amorsim.noise.bias:Bias")
    registry.noise("scale", "amorsim.noise.scale:Scale")
    registry.noise("quantize", "amorsim.noise.quantize:Quantize")
    registry.noise("saturate", "amorsim.noise.saturate:Saturate")
    registry.noise("diffusion", "amorsim.noise.diffusion:Diffusion")

    registry.map_loader("wld", "amorsim.maps.wld:Wld")
    registry.map_loader("bmp", "amorsim.maps.bmp:Bitmap")

    registry.estimator("dead_reckoning", "amorsim.estimators.dead_reckoning:DeadReckoning")

    registry.controller("wander", "amorsim.controllers.wander:Wander")
    registry.controller("goto", "amorsim.controllers.goto:GoTo")
    registry.controller("square", "amorsim.controllers.square:Square")
    registry.controller("manual", "amorsim.controllers.manual:Manual")

    registry.recorder("text", "amorsim.recorders.text:Text")

    registry.robot("pioneer2dx", _PACKAGE / "robots" / "pioneer2dx.toml")
    registry.scenario("demo", _PACKAGE / "scenarios" / "demo.toml")
