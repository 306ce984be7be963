"""Fingerprints of what all bundled scenarios compute, for `tests/runs/test_digests.py`; to write them again::

    python tests/golden/digests.py

A change that should compute the same must leave them as they are. Commit others by themselves, with the reason. The
bits hold for one kind of processor and one version of each library.
"""

from __future__ import annotations

import hashlib
import json
import tempfile
from pathlib import Path

import numpy as np

import amorsim as am
from amorsim.plugins.manager import default_registry
from tests.golden.regenerate import tables

__all__ = ["KEPT", "MAPS", "SCENARIOS", "SEEDS", "digests_of", "rays_of"]

KEPT = Path(__file__).resolve().with_name("digests.json")
DURATION = 20.0  # [s]
SEEDS = (1, 2)
# Not that of a policy: ONNX Runtime's last bits depend on the processor.
SCENARIOS = tuple(sorted({*default_registry().names("scenario")} - {"learned"}))
MAPS = ("arena", "car-park", "concourse", "hall", "maze", "office", "rooms", "yard")


def digests_of(name: str, seed: int) -> dict[str, str]:
    """Of replica 0 alone, of replicas 0 to 7, with one thread and with two, and of the text files of replica 0."""
    scenario = am.load(name)
    found = {}
    for what, replicas, threads in (("alone", 1, 1), ("eight", 8, 1), ("eight, two threads", 8, 2)):
        simulation = am.Simulation(scenario, seed=seed, replicas=replicas, threads=threads)
        simulation.run(DURATION)
        found[what] = simulation.digest()
        found[f"{what}: 0"] = simulation.digest(0)
    whole = hashlib.blake2b(digest_size=16)
    with tempfile.TemporaryDirectory() as folder:
        am.run(scenario, Path(folder) / "run", seed=seed, duration=DURATION)
        for table, path in sorted(tables(Path(folder) / "run").items()):
            whole.update(table.encode() + path.read_bytes())
    return found | {"files": whole.hexdigest()}


def rays_of(name: str) -> str:
    """Of 181 beams from each of 2,000 poses in the map of a bundled scenario, and around it."""
    place = am.load_map(default_registry().file("scenario", "demo").with_name(f"{name}.wld"))
    rng = np.random.default_rng(1)
    low, size = np.array(place.origin[:2]) - 1.0, np.array(place.size) + 2.0
    poses = np.c_[low + rng.random((2000, 2)) * size, rng.uniform(-np.pi, np.pi, 2000)]
    ranges = place.cast_rays(poses, np.linspace(-np.pi / 2, np.pi / 2, 181), 8.0)
    return hashlib.blake2b(ranges.tobytes(), digest_size=16).hexdigest()


if __name__ == "__main__":
    kept: dict[str, object] = {f"{name}, seed {seed}": digests_of(name, seed) for name in SCENARIOS for seed in SEEDS}
    kept["rays"] = {name: rays_of(name) for name in MAPS}
    KEPT.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
