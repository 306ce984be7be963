"""A thousand replicas of a straight drive over rough ground: the spread of their ends against the formulas.

Each wheel's travel is disturbed with a variance of k for every metre, where encoders cannot see it. With
q = 2 k / track², headings at the end of a way S spread with variance q S, and positions to the side with
q S³ / 3. The robot knows the same k, and its own covariance says the same.
"""

import numpy as np

import amorsim as am

K, TRACK, WAY, REPLICAS = 1e-5, 0.33, 3.0, 1000  # m²/m, m, m

robot = am.Robot(
    name="rover",
    shape=am.Shape.circle(0.3),
    drive=am.drives.Differential(wheel_radius_left=0.08, wheel_radius_right=0.08, track=TRACK, rate_max=20.0),
    sensors={"encoder": am.sensors.Encoder(counts_per_revolution=39400.0)},
    estimators={"dead_reckoning": am.estimators.DeadReckoning(wheel_variance=K)},
    controller=am.controllers.Manual(),
    ground=(am.NoiseElement(name="slip", noise=am.noise.Diffusion(variance_per_length=K)),),
    pose=am.Pose(),
)
field = am.Map.from_segments([], resolution=0.01, extent=(-10, -10, 10, 10))
sim = am.Simulation(am.Scenario(map=field, robots=[robot], dt=0.1, seed=2), replicas=REPLICAS)
for replica in sim.replicas:
    sim.robot("rover", replica).drive(forward=0.3)
sim.run(WAY / 0.3)

spread = np.var(sim.true_pose - sim.estimated_pose, axis=0)
believed = sim.covariance[0]
q = 2.0 * K / TRACK**2
print("standard deviation of    simulated    formula   believed")
for name, column, variance in (("heading [°]", 2, q * WAY), ("y [m]", 1, q * WAY**3 / 3.0)):
    unit = np.degrees(1.0) if column == 2 else 1.0
    values = unit * np.sqrt([spread[column], variance, believed[column, column]])
    print(f"{name:22} " + " ".join(f"{value:10.4f}" for value in values))
