"""Snapshot and restore: try what would happen, go back to the bit, and go on as if nothing had been tried."""

import amorsim as am

sim = am.Simulation(am.load("demo"))
sim.run(10.0)
before = sim.snapshot()

sim.run(10.0)
straight_on = sim.digest()

# Back, and the same ten seconds with a left wheel that has worn by a hundredth.
sim.restore(before)
sim.set("rover", "errors.drive.wheel_radius_left.scale", 0.99)
sim.run(10.0)
print("with another wheel the same:", sim.digest() == straight_on)

# Back once more: the wheel is as it was, and so is all that follows.
sim.restore(before)
sim.run(10.0)
print("without it the same:", sim.digest() == straight_on)
print(f"after {sim.time:g} s in {sim.tick} steps, with {len(sim.events)} events")
