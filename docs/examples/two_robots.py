"""Two robots drive towards each other, see each other, and meet: events tell when, where and how fast."""

import amorsim as am


def robot(name: str, pose: am.Pose) -> am.Robot:
    """A disc with a laser that looks straight ahead."""
    return am.Robot(
        name=name,
        shape=am.Shape.circle(0.25),
        drive=am.drives.Differential(wheel_radius_left=0.08, wheel_radius_right=0.08, track=0.33, rate_max=20.0),
        sensors={
            "encoder": am.sensors.Encoder(counts_per_revolution=39400.0),
            "laser": am.sensors.Laser(beams=3, fov=0.2, range_max=8.0),
        },
        estimators={"dead_reckoning": am.estimators.DeadReckoning()},
        controller=am.controllers.Manual(),
        pose=pose,
    )


field = am.Map.from_segments([], resolution=0.01, extent=(-5, -5, 5, 5))
robots = [robot("anna", am.Pose(x=-2.0)), robot("bert", am.Pose(x=2.0, heading=3.141592653589793))]
sim = am.Simulation(am.Scenario(map=field, robots=robots, dt=0.1))
sim.robot("anna").drive(forward=0.4)
sim.robot("bert").drive(forward=0.2)

while not sim.events:
    if sim.tick % 20 == 0:
        ahead = sim.robot("anna").readings["laser"].measured[1]
        print(f"{sim.time:4.1f} s: anna sees something {ahead:.3f} m ahead")
    sim.step()
for event in sim.events:
    print(event)
for name in sim.names:
    x, y, _ = sim.robot(name).true_pose
    print(f"{name} stands at ({x:.3f}, {abs(y):.3f}) m")
