"""Measure the Simulator's window in headless Chromium: how long a frame takes to draw, and how long between frames.

``python tools/measure_window.py``; needs the extra "dev" and Debian's chromium. Two scenes: the demo, whose robot has
181 beams and 16 cones, and a thousand robots without beams. Both run at four times real time, 40 steps in a second,
so that there is always something new to show. A frame is shown at one of the screen's 60 moments in a second; it is in
time where the next comes within two of these (33 ms). With ``--check`` the status is 1 where fewer than 95 % are, which
says something on a quiet machine alone: the load is printed.
"""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))
from tests.ui.windows import CHROMIUM, FLAGS, Server, Window

SECONDS = 20.0
IN_TIME = 33.4 + 0.6  # [ms] two moments of the screen, and what its clock is off
WANTED = 0.95
SPEED = 4.0  # 40 steps of 0.1 s in a second: more than frames go out
COLUMNS, ROBOTS = 40, 1000
MODEL = """format = 1
description = "a small round robot with encoders"
shape = { circle = 0.15 }

[drive]
use = "differential"
wheel_radius_left = 0.05
wheel_radius_right = 0.05
track = 0.2
rate_max_deg = 1000.0

[sensors.encoder]
use = "encoder"
counts_per_revolution = 4000.0

[estimators.dead_reckoning]
use = "dead_reckoning"
encoder = "encoder"
"""


def write_crowd(folder: Path) -> Path:
    """A hall with a thousand robots, each of which drives squares with wheels of its own."""
    (folder / "hall.wld").write_text("0 0 42000 0\n42000 0 42000 27000\n42000 27000 0 27000\n0 27000 0 0\n")
    (folder / "small.toml").write_text(MODEL)
    parts = ['format = 1\n[world]\nmap = "hall.wld"\n[simulation]\ndt = 0.1\nduration = 600.0\n']
    for i in range(ROBOTS):
        pose = f"{{ x = {i % COLUMNS + 1.0}, y = {i // COLUMNS + 1.0}, heading_deg = {(i * 41) % 360}.0 }}"
        parts.append(
            f'[[robots]]\nname = "r{i:03d}"\nmodel = "small.toml"\npose = {pose}\n'
            f'controller = {{ use = "square", side = 0.3 }}\n'
            f"[robots.errors.drive]\nwheel_radius_left = {{ scale = {1.0 + 0.0005 * (i % 20):.4f} }}\n"
        )
    file = folder / "crowd.toml"
    file.write_text("\n".join(parts))
    return file


def write_demo(folder: Path) -> Path:
    """The demo."""
    import amorsim

    scenarios = Path(amorsim.__file__).parent / "scenarios"
    (folder / "office.wld").write_text((scenarios / "office.wld").read_text())
    file = folder / "demo.toml"
    file.write_text((scenarios / "demo.toml").read_text())
    return file


def measure(browser: Any, scenario: Path) -> dict[str, np.ndarray]:
    """Milliseconds of drawing each frame, and between one and the next."""
    server = Server(scenario)
    try:
        page = browser.new_page(viewport={"width": 1366, "height": 768})
        window = Window(page).open(server.address)
        window.do(do="speed", factor=SPEED)
        window.do(do="run")
        window.until("newest.tick > 40", seconds=300.0)  # kernels are compiled by then
        page.wait_for_timeout(2000.0)
        window.see("timings.draws.splice(0)")
        window.see("timings.intervals.splice(0)")
        page.wait_for_timeout(1000.0 * SECONDS)
        found = window.see("timings")
        achieved = window.see("newest.achieved")
        page.close()
    finally:
        server.close()
    return {name: np.array(values) for name, values in found.items()} | {"achieved": np.array([achieved])}


def main() -> int:
    """Print a table; the status."""
    from playwright.sync_api import sync_playwright

    late = False
    with sync_playwright() as playwright, tempfile.TemporaryDirectory() as folder:
        browser = playwright.chromium.launch(executable_path=str(CHROMIUM), args=FLAGS)
        print(f"Chromium {browser.version}, headless; {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}")
        print("milliseconds                 frames  draw p50    p95  between p50    p95 longest  in time  speed")
        for name, write in (("1 robot, 181 beams, 16 cones", write_demo), (f"{ROBOTS} robots, no beams", write_crowd)):
            at = Path(folder) / write.__name__
            at.mkdir()
            found = measure(browser, write(at))
            draws, between = (np.percentile(found[key], (50, 95)) for key in ("draws", "intervals"))
            in_time = float(np.mean(found["intervals"] <= IN_TIME))
            late = late or in_time < WANTED
            figures = f"{draws[0]:9.1f} {draws[1]:6.1f} {between[0]:12.1f} {between[1]:6.1f}"
            figures += f" {found['intervals'].max():7.0f} {100 * in_time:6.1f} %"
            print(f"{name:28} {len(found['draws']):6} {figures} {found['achieved'][0]:5.2f}×")
        browser.close()
        print(f"load at the end {os.getloadavg()[0]:.1f}")
    return 1 if late and "--check" in sys.argv[1:] else 0


if __name__ == "__main__":
    sys.exit(main())
