"""One wheel is a hundredth larger than the robot believes: the drift, simulated and in closed form.

The robot gives both wheels the same rate and believes that it drives straight. In truth the wheels roll over
different ways, so it drives along a circle, whose radius follows from the two ways and the track.
"""

import math

import amorsim as am

RADIUS, TRACK, RATE, TIME = 0.0825, 0.33, 4.0, 10.0  # m, m, rad/s, s

robot = am.Robot(
    name="rover",
    shape=am.Shape.circle(0.3),
    drive=am.drives.Differential(wheel_radius_left=RADIUS, wheel_radius_right=RADIUS, track=TRACK, rate_max=20.0),
    sensors={"encoder": am.sensors.Encoder(counts_per_revolution=39400.0)},
    estimators={"dead_reckoning": am.estimators.DeadReckoning()},
    controller=am.controllers.Manual(),
    errors={"drive.wheel_radius_left": am.Deviation(scale=1.01)},
    pose=am.Pose(),
)
field = am.Map.from_segments([], resolution=0.01, extent=(-10, -10, 10, 10))
sim = am.Simulation(am.Scenario(map=field, robots=[robot], dt=0.1))
sim.robot("rover").command(RATE, RATE)
sim.run(TIME)

left, right = 1.01 * RADIUS * RATE * TIME, RADIUS * RATE * TIME  # the ways of the wheels [m]
way, turn = (left + right) / 2.0, (right - left) / TRACK
radius = way / turn
x, y = radius * math.sin(turn), radius * (1.0 - math.cos(turn))

print("                    x [m]     y [m]   heading [°]")
for name, pose in (
    ("true", sim.true_pose[0]),
    ("closed form", (x, y, turn)),
    ("estimated", sim.estimated_pose[0]),
):
    print(f"{name:12}  {pose[0]:11.6f} {pose[1]:9.6f} {math.degrees(pose[2]):13.6f}")
