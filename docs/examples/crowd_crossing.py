"""Which avoider crosses the crowd best?

A robot crosses a concourse among sixty people on foot: straight on, braking for what is near, or steering to the freer
side. Each meets the same people, who start and go in the same way until the robot itself makes a difference. The table
looks as if braking were best; ten replicas do not prove it. Take more of them to find out.
"""

from pathlib import Path

import amorsim as am

GOAL = (20.7, 11.2)

Path("avoiders.py").write_text('''
import math

import amorsim as am

GOAL = (20.7, 11.2)


def towards(estimate):
    """Bearing of the goal [rad], as the robot believes."""
    x, y, heading = estimate.pose
    return math.remainder(math.atan2(GOAL[1] - y, GOAL[0] - x) - heading, 2.0 * math.pi)


def straight(readings, estimate, clock):
    """Go to the goal, whatever is there."""
    return am.Twist(0.6, towards(estimate))


def brake(readings, estimate, clock):
    """The same, but wait while something is near ahead."""
    ahead = readings["laser"].measured[60:121].min()
    return am.Twist(0.6 if ahead > 0.8 else 0.0, towards(estimate))


def steer(readings, estimate, clock):
    """The same, but turn to the freer side, and go slower the nearer things are."""
    ranges = readings["laser"].measured
    right, ahead, left = ranges[45:80].min(), ranges[70:111].min(), ranges[101:136].min()
    if min(right, ahead, left) > 1.2:
        return am.Twist(0.6, towards(estimate))
    return am.Twist(0.6 * min(1.0, max(0.0, ahead - 0.4)), 0.8 if left > right else -0.8)
''')

study = am.sweep(
    {
        "format": 1,
        "scenario": "crowd",
        "replicas": 10,
        "duration": 25.0,
        "axes": {
            "robots.rover.controller": [{"use": f"avoiders.py:{name}"} for name in ("straight", "brake", "steer")]
        },
        "metrics": {
            "arrived": {"use": "success", "goal": GOAL, "collisions": 1000},
            "collisions": {"use": "collisions"},
        },
    },
    "results",
)

print("             arrived   collisions")
for name in study.about["axes"]["robots.rover.controller"]:
    chosen = study["robots.rover.controller"] == name
    arrived, collisions = (study[metric][chosen].mean() for metric in study.metrics)
    print(f"{name.rpartition(':')[2]:10}  {100.0 * arrived:5.0f} %   {collisions:8.1f}")
for difference in am.analysis.compare(study, axis="robots.rover.controller", metrics=["collisions"]).differences:
    print(f"{difference.second.rpartition(':')[2]} less {difference.first.rpartition(':')[2]}:", end=" ")
    print("may be claimed" if difference.is_significant else "may not be claimed")
