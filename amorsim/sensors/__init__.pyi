from amorsim.sensors.bumper import Bumper, Sector
from amorsim.sensors.camera import Camera
from amorsim.sensors.cliff import Cliff
from amorsim.sensors.compass import Compass
from amorsim.sensors.encoder import Encoder
from amorsim.sensors.fiducial import Fiducial
from amorsim.sensors.gps import Gps
from amorsim.sensors.gyro import Gyro
from amorsim.sensors.imu import Imu
from amorsim.sensors.infrared import Infrared
from amorsim.sensors.laser import Laser
from amorsim.sensors.light import Light
from amorsim.sensors.line import Line
from amorsim.sensors.neighbours import Neighbours
from amorsim.sensors.sonar import Sonar

__all__ = [
    "Bumper",
    "Camera",
    "Cliff",
    "Compass",
    "Encoder",
    "Fiducial",
    "Gps",
    "Gyro",
    "Imu",
    "Infrared",
    "Laser",
    "Light",
    "Line",
    "Neighbours",
    "Sector",
    "Sonar",
]
