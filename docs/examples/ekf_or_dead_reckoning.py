"""Is the EKF better than dead reckoning, and is it consistent?

Both estimators run side by side on the same robot, so that each replica gives a pair: the same drive, the same
readings. The filter is consistent if its errors are as large as its own covariance says.
"""

import numpy as np

import amorsim as am

ESTIMATORS = ("wheels", "ekf")

sim = am.Simulation(am.load("landmarks"), replicas=40)
keep = ["true_pose", "estimates.ekf.covariance", *(f"estimates.{name}.pose" for name in ESTIMATORS)]
kept = sim.run(30.0, keep=keep)  # (steps, replicas, ...)

true = kept["true_pose"][-1]
errors = {}
for name in ESTIMATORS:
    off = kept[f"estimates.{name}.pose"][-1] - true
    errors[name] = np.hypot(off[:, 0], off[:, 1])
    print(f"{name:7} off by {1000.0 * errors[name].mean():5.1f} mm on the mean after 30 s")

differences = errors["ekf"] - errors["wheels"]
found = am.analysis.mean_interval(differences)
print(f"EKF less dead reckoning: {1000.0 * found.low:.0f} to {1000.0 * found.high:.0f} mm (95 %)")
print(f"p of no difference: {found.p:.1g}")

off = kept["estimates.ekf.pose"][-1] - true
off[:, 2] = am.wrap_angle(off[:, 2])
found = am.analysis.verdict(am.analysis.nees(off, kept["estimates.ekf.covariance"][-1]), 3)
print(f"the EKF is {found.verdict}: mean NEES {found.mean:.2f}, expected {found.low:.2f} to {found.high:.2f}")
