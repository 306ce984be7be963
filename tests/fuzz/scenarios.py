"""Small scenarios that have, all together, nearly every component that ships; and the files that they name."""

# ruff: noqa: E501 - an inline table of TOML is one line

ROOM = "width 4000\nheight 3000\n0 0 4000 0\n4000 0 4000 3000\n4000 3000 0 3000\n0 3000 0 0\nposition 1000 1500 90\n"
TRACK = "time,x,y,heading_deg\n0,3.5,2.0,0\n1,3.6,2.0,10\n2,3.5,2.0,0\n"

_HEAD = """
format = 1
[world]
map = "room.wld"
resolution = 0.01
[simulation]
dt = 0.1
duration = 1.0
"""

_SENSES = """
[[robots]]
name = "rover"
pose = { x = 1.0, y = 1.5, heading_deg = 30.0 }
shape = { polygon = [[-0.2, -0.15], [0.2, -0.15], [0.2, 0.15], [-0.2, 0.15]] }
drive = { use = "differential", wheel_radius_left = 0.08, wheel_radius_right = 0.08, track = 0.33, rate_max_deg = 700 }
controller = { use = "wander" }
estimators.odometry = { use = "dead_reckoning" }
on_collision = "continue"
ground = [{ use = "diffusion", variance_per_length = 1e-5 }, { use = "bump", height = 0.005, rate = 1.0 }]
[robots.sensors.encoder]
use = "encoder"
counts_per_revolution = 500.0
noise = [{ use = "quantize", step = 1.0, rounding = "floor" }]
[robots.sensors.laser]
use = "laser"
beams = 9
latency = 0.1
noise = [{ use = "gaussian", std = 0.01 }, { use = "outliers", probability = 0.1, std = 1.0 }, { use = "stuck", rate = 0.1, duration = 1.0 }, { use = "motion_distortion", sweep = 0.05 }]
[robots.sensors.sonar]
use = "sonar"
elements = [{ x = 0.2 }, { y = 0.1, heading_deg = 90.0 }]
medium = "air"
rate = 4.0
noise = [{ use = "aim_gaussian", std_deg = 1.0 }, { use = "specular_loss", critical_deg = 30.0 }, { use = "cross_talk" }]
"""

_TURNS = """
[[robots]]
name = "turner"
pose = { x = 1.0, y = 1.5 }
shape = { circle = 0.2 }
drive = { use = "differential", wheel_radius_left = 0.08, wheel_radius_right = 0.08, track = 0.33, rate_max_deg = 700 }
sensors.encoder = { use = "encoder", counts_per_revolution = 500.0 }
estimators.odometry = { use = "dead_reckoning" }
[robots.sensors.compass]
use = "compass"
noise = [{ use = "bias_instability", std_deg = 1.0, correlation_time = 10.0 }, { use = "compass_deviation" }, { use = "latency_jitter", spread = 0.05 }]
[robots.sensors.gyro]
use = "gyro"
noise = [{ use = "angle_random_walk", density_deg = 0.5 }, { use = "bias_random_walk", std_deg = 0.1 }, { use = "saturate" }]
[robots.errors]
drive.track = { scale = 1.02 }
drive.wheel_radius_left = { scale = { normal = [1.0, 0.01] } }
sensors.compass.mount.heading_deg = { add = 1.0 }
"""

_CAR = """
[[robots]]
name = "car"
pose = { x = 1.2, y = 1.5 }
shape = { rectangle = [0.7, 0.4], x = 0.2 }
drive = { use = "ackermann", wheel_radius = 0.1, wheelbase = 0.5, track = 0.3, steering_max_deg = 35, steering_rate_deg = 90, rate_max_deg = 1000, acceleration_max_deg = 1000, lag = 0.1 }
sensors.encoder = { use = "encoder", counts_per_revolution = 100 }
sensors.laser = { use = "laser", beams = 5, noise = [{ use = "beam_model", range_max = 8.0 }] }
controller = { use = "pursuit", waypoints = [[3.0, 1.5], [3.0, 2.0]], loop = true, lookahead = 0.3 }
on_collision = "continue"
"""

_CART = """
[[robots]]
name = "cart"
pose = { x = 2.0, y = 0.6 }
shape = { circle = 0.2 }
drive = { use = "tricycle", wheel_radius = 0.1, wheelbase = 0.4, steering_rate_deg = 100, rate_max_deg = 1000 }
sensors.encoder = { use = "encoder", counts_per_revolution = 100 }
controller = { use = "goto", x = 3.0, y = 0.6 }
"""

_SYNCHRO = """
[[robots]]
name = "synchro"
pose = { x = 0.5, y = 0.5 }
shape = { circle = 0.2 }
drive = { use = "synchro", wheel_radius = 0.06, rate_max_deg = 1000, steering_rate_max_deg = 100, turret = "driven" }
controller = { use = "square", side = 0.5 }
"""

_TOWED = """
[[robots]]
name = "tug"
pose = { x = 2.5, y = 1.0 }
shape = { circle = 0.2 }
drive = { use = "tractor", wheel_radius_left = 0.08, wheel_radius_right = 0.08, track = 0.3, rate_max_deg = 700, trailer_length = 0.6, trailer_width = 0.3, trailer_front = 0.2, trailer_rear = 0.2 }
sensors.encoder = { use = "encoder", counts_per_revolution = 100 }
controller = { use = "pursuit", waypoints = [[3.4, 1.0], [3.4, 2.0]] }
on_collision = "continue"
"""

_OMNI = """
[[robots]]
name = "omni"
pose = { x = 1.0, y = 2.3 }
shape = { rectangle = [0.5, 0.4] }
drive = { use = "mecanum", wheel_radius_front_left = 0.05, wheel_radius_front_right = 0.05, wheel_radius_rear_left = 0.05, wheel_radius_rear_right = 0.05, wheelbase = 0.3, track = 0.25, rate_max_deg = 1000 }
sensors.infrared = { use = "infrared", elements = [{ x = 0.25 }] }
sensors.bumper = { use = "bumper" }
sensors.light = { use = "light" }
sensors.gps = { use = "gps" }
sensors.imu = { use = "imu" }
controller = { use = "braitenberg", left = [0.001], right = [-0.001] }
on_collision = "continue"
ground = [{ use = "velocity_model", a1 = 0.01, a4 = 0.01 }, { use = "slip", at = 0.1, duration = 0.1, factor = 0.5 }]
[[lights]]
x = 2.0
y = 1.5
[[zones]]
name = "mud"
shape = { rectangle = [1.0, 1.0] }
pose = { x = 1.0, y = 2.0 }
ground = [{ use = "slip", at = 0.0, duration = 10.0, factor = 0.5 }]
"""

_GUIDE = """
[[robots]]
name = "guide"
fiducial = 1
pose = { x = 2.0, y = 1.5 }
shape = { circle = 0.2 }
drive = { use = "differential", wheel_radius_left = 0.08, wheel_radius_right = 0.08, track = 0.33, rate_max_deg = 700 }
sensors.encoder = { use = "encoder", counts_per_revolution = 100 }
sensors.laser = { use = "laser", beams = 19 }
controller = { use = "follow_wall" }
"""

_CAMERA = """
[[robots]]
name = "camera"
count = 2
start = { random = [0.3, 0.3, 1.5, 2.7], clearance = 0.05 }
shape = { circle = 0.15 }
drive = { use = "differential", wheel_radius_left = 0.08, wheel_radius_right = 0.08, track = 0.25, rate_max_deg = 700 }
sensors.encoder = { use = "encoder", counts_per_revolution = 100 }
sensors.fiducial = { use = "fiducial", noise = [{ use = "missed" }] }
sensors.camera = { use = "camera", width = 16, height = 12 }
estimators.odometry = { use = "dead_reckoning" }
controller = { use = "follow", leader = 1 }
[[landmarks]]
id = 7
x = 3.0
y = 1.0
colour = "red"
"""

_COMPANY = """
[[obstacles]]
name = "walker"
shape = { circle = 0.15 }
pose = { x = 2.6, y = 0.5 }
motion = { use = "pedestrian", goals = [[3.0, 2.5]] }
[[obstacles]]
name = "patrol"
shape = { circle = 0.1 }
motion = { use = "loop", waypoints = [[3.0, 0.5], [3.5, 0.5]] }
[[obstacles]]
name = "drunk"
shape = { polygon = [[-0.1, -0.1], [0.1, -0.1], [0.0, 0.1]], rounding = 0.02 }
pose = { x = 2.0, y = 2.6 }
motion = { use = "wander" }
[[obstacles]]
name = "door"
shape = { rectangle = [0.5, 0.04], x = 0.27 }
pose = { x = 2.7, y = 2.0 }
motion = { use = "swing_door", timetable = [[0, 1]] }
[[obstacles]]
name = "ghost"
shape = { circle = 0.05 }
motion = { use = "track", file = "track.csv" }
"""

_ROBOTS = (_SENSES, _TURNS, _CAR, _CART, _SYNCHRO, _TOWED, _OMNI, _CAMERA, _GUIDE + _COMPANY)
BASES = tuple(_HEAD + robots for robots in _ROBOTS)
