"""How wrong may the track be before the square fails?

The robot drives a square of 2 m by dead reckoning, on a floor that lets its wheels slip a little. The square has failed
if the robot was ever more than 20 cm from where it believed to be. A study tries several errors of the track.
"""

from pathlib import Path

import amorsim as am

TRACK = "robots.rover.errors.drive.track.scale"

am.save_map(am.Map.from_segments([(0, 0, 6, 0), (6, 0, 6, 6), (6, 6, 0, 6), (0, 6, 0, 0)], resolution=0.01), "room.wld")
Path("square.toml").write_text("""
format = 1
world = { map = "room.wld" }
simulation = { dt = 0.1, duration = 45.0, seed = 5 }

[[robots]]
name = "rover"
model = "pioneer2dx"
pose = { x = 2.0, y = 2.0 }
controller = { use = "square", side = 2.0 }
sensors = { laser = false, sonar = false }
ground = [{ use = "diffusion", variance_per_length = 1e-5 }]
errors = { drive = { track = { scale = 1.0 } } }
""")

study = am.sweep(
    {
        "format": 1,
        "scenario": "square.toml",
        "replicas": 50,
        "stop": "still",
        "axes": {TRACK: [1.0, 1.02, 1.04, 1.06, 1.08]},
        "metrics": {"worst": {"use": "position_error", "at": "max"}},
    },
    "results",
)

print("track     worst, on the mean   squares that fail")
for scale in study.about["axes"][TRACK]:
    worst = study["worst"][study[TRACK] == scale]
    print(f"x {scale:.2f}    {100.0 * worst.mean():10.1f} cm    {100.0 * (worst > 0.2).mean():12.0f} %")
