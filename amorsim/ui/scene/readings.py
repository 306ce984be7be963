"""How to draw the readings of a sensor: what a window needs besides the mount.

A few kinds of sensor are known here by name. All others are recognised by their fields and columns: a sensor in metres
with bearings and a range has beams, one whose table has a range and a bearing finds things; so those of plugins are
drawn too.
"""

from __future__ import annotations

from PIL import ImageColor

from amorsim.contracts import Mount, Sensor
from amorsim.core.shapes import Shape
from amorsim.sensors.bumper import Bumper
from amorsim.sensors.camera import Camera
from amorsim.sensors.compass import Compass
from amorsim.sensors.gps import Gps
from amorsim.sensors.infrared import Infrared
from amorsim.sensors.light import Light
from amorsim.ui.scene.wire import Drawing

__all__ = ["drawing_of"]


def drawing_of(sensor: Sensor, mount: Mount, shape: Shape, *, has_bearings: bool) -> Drawing | None:
    """How to draw a sensor's readings, by its parameters for one robot; None if they are not drawn.

    Parameters
    ----------
    mount, shape
        Where it sits on the robot, and the robot's footprint.
    has_bearings
        Whether it has a direction for each of its values.
    """
    columns = sensor.columns()
    match sensor:
        case Infrared():
            reach = max(sensor.distances[-1], sensor.side_distances[-1])
            return {"style": "glow", "half_angle": sensor.spread, "reach": reach, "span": [0.0, sensor.saturation]}
        case Light():
            return {"style": "sticks", "span": [sensor.dark, *([] if sensor.bright is None else [sensor.bright])]}
        case Bumper():
            lines = [[[*p, *q] for p, q in segment] for segment in sensor.outlines(mount, shape)]
            return {"style": "contacts", "lines": lines}
        case Camera():
            colours = ["#{:02x}{:02x}{:02x}".format(*ImageColor.getrgb(colour)[:3]) for colour in sensor.colours]
            return {"style": "things", "colours": colours, "names": list(sensor.colours)}
        case Gps():
            return {"style": "fix"}
        case Compass():
            return {"style": "needle"}
        case _ if "range" in columns and "bearing" in columns:
            return {"style": "things"}
        case _ if sensor.unit == "m" and has_bearings and getattr(sensor, "range_max", None) is not None:
            return {"style": "cones" if getattr(sensor, "half_angle", None) else "beams"}
    return None
