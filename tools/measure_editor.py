"""Measure the Editor's window in headless Chromium: how long from one frame to the next, and what a frame costs.

``python tools/measure_editor.py``; needs the extra "dev", Linux and Debian's chromium. A world of 5,000 walls is panned
and 500 things are dragged in it; a bitmap of 4,000 x 4,000 cells is panned and painted on. A frame is in time where the
next comes within two of the screen's moments (33 ms), which depends on what else the machine does: the load is printed.
The processor time of a frame does not: that of the page's thread (scripts, layout and drawing), and that of all
processes of the browser (which put the page on the screen, too). With ``--check`` the status is 1 where the page's
thread needs more than `MOST` ms for a frame, on average; ``--seconds`` says how long each is measured.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from PIL import Image

sys.path.insert(0, str(Path(__file__).parent.parent))
from tests.ui.test_window_editor import PAGE, Editor
from tests.ui.windows import CHROMIUM, FLAGS

IN_TIME = 33.4 + 0.6  # [ms] two moments of the screen, and what its clock is off
MOST = 25.0  # [ms] of processor time a frame: it has 33, and a slow machine needs twice as long
WALLS, THINGS, CELLS = 5000, 500, 4000

TICK = os.sysconf("SC_CLK_TCK")

FRAMES = """(seconds) => {
    const editor = PAGE;
    const { stage } = editor;
    const times = [];
    BEGIN
    const started = performance.now();
    let before = started;
    return new Promise((done) => requestAnimationFrame(function tick(now) {
        times.push(now - before);
        before = now;
        const t = (now - started) / 1000;
        EACH
        if (t < seconds) return requestAnimationFrame(tick);
        END
        done(times.slice(2));
    }));
}"""
PAN = "stage.camera.pan(4 * Math.sin(2 * t), 3 * Math.cos(2 * t));"


def write_walls(folder: Path) -> Path:
    """A world of many walls and many obstacles."""
    side = int(np.sqrt(WALLS))
    lines = [
        f"{1000 * (n % side)} {1000 * (n // side)} {1000 * (n % side) + 700} {1000 * (n // side)}" for n in range(WALLS)
    ]
    (folder / "walls.wld").write_text("\n".join(lines) + "\n")
    parts = ['format = 1\n[world]\nmap = "walls.wld"\nresolution = 0.05\n']
    for n in range(THINGS):
        pose = f"{{ x = {n % 25 + 0.5}, y = {n // 25 + 0.5} }}"
        parts.append(f'[[obstacles]]\nname = "o{n}"\nshape = {{ circle = 0.1 }}\npose = {pose}\n')
    file = folder / "walls.toml"
    file.write_text("".join(parts))
    return file


def write_cells(folder: Path) -> Path:
    """A bitmap with rooms."""
    levels = np.full((CELLS, CELLS), 255, dtype=np.uint8)
    levels[::100, :] = 0
    levels[:, ::100] = 0
    levels[:, 40::100] = 255
    levels[50::100, :] = 255
    Image.fromarray(levels).convert("1").save(folder / "cells.png")
    file = folder / "cells.toml"
    file.write_text('format = 1\n[world]\nmap = "cells.png"\nresolution = 0.02\n')
    return file


class Measured(NamedTuple):
    """Milliseconds from one frame to the next, and of processor time a frame; how often the bitmap was drawn."""

    times: np.ndarray
    thread: float
    browser: float
    drawings: int


def processor_time(page: Any) -> tuple[float, float]:
    """Seconds of processor time of the page's thread, and of all processes of the browser."""
    metrics = page.send("Performance.getMetrics")["metrics"]
    thread = next(one["value"] for one in metrics if one["name"] == "TaskDuration")
    return thread, sum(_seconds_of(Path(f"/proc/{number}")) for number in _family(os.getpid()))


def _family(parent: int) -> list[int]:
    """The processes of the browser: those named so under a process."""
    children = [
        int(one) for task in Path(f"/proc/{parent}/task").glob("*") for one in (task / "children").read_text().split()
    ]
    grown = [one for child in children for one in _family(child)]
    return [one for one in children if Path(f"/proc/{one}/comm").read_text().startswith("chrom")] + grown


def _seconds_of(process: Path) -> float:
    user, system = (process / "stat").read_text().rsplit(")", 1)[1].split()[11:13]
    return (int(user) + int(system)) / TICK


def measure(browser: Any, write: Any, does: dict[str, tuple[str, str, str]], seconds: float) -> dict[str, Measured]:
    """What is measured while each of these is done."""
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        file = write(Path(folder))
        editor = Editor(browser, Path(folder), file.name)
        try:
            editor.page.wait_for_timeout(1500.0)
            page = editor.page.context.new_cdp_session(editor.page)
            page.send("Performance.enable", {"timeDomain": "threadTicks"})
            for name, (begin, each, end) in does.items():
                editor.page.wait_for_timeout(500.0)
                code = FRAMES.replace("PAGE", PAGE).replace("BEGIN", begin).replace("EACH", each).replace("END", end)
                drawn, before = drawings(editor), processor_time(page)
                times = np.array(editor.page.evaluate(code, seconds))
                costs = [1000 * (b - a) / len(times) for a, b in zip(before, processor_time(page), strict=True)]
                found[name] = Measured(times, costs[0], costs[1], drawings(editor) - drawn)
        finally:
            editor.server.close()
            editor.page.context.close()
    return found


def drawings(editor: Editor) -> int:
    """How often what stands still was drawn into a bitmap."""
    return int(editor.see("stage.pane.bitmaps.reduce((sum, { drawings }) => sum + drawings, 0)"))


def main() -> int:
    """Print a table; the status."""
    from playwright.sync_api import sync_playwright

    reading = argparse.ArgumentParser(description="Measure the Editor's window.")
    reading.add_argument("--check", action="store_true")
    reading.add_argument("--seconds", type=float, default=6.0)
    options = reading.parse_args()
    is_slow = False
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=str(CHROMIUM), args=FLAGS)
        print(f"Chromium {browser.version}, headless; {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}")
        print("                                      milliseconds between frames        processor ms a frame  bitmaps")
        print("                               frames   p50   p95 longest  in time      page  whole browser    drawn")
        drag = (
            "stage.selection.set(stage.things.filter(({pose}) => pose).map((one) => stage.chosenOf(one)));",
            "editor.tools.select.shift(Math.sin(2 * t), Math.cos(2 * t), true);",
            "stage.putBack();",
        )
        paint = (
            "editor.take('brush'); editor.tools.brush.down({x: 30, y: 20}, {button: 0});",
            "editor.tools.brush.move({x: 20 + 10 * Math.cos(t), y: 20 + 10 * Math.sin(t)});",
            "editor.tools.brush.cancel();",
        )
        for write, does in (
            (write_walls, {"panning 5,000 walls": ("", PAN, ""), "dragging 500 things": drag}),
            (write_cells, {"panning 4,000 x 4,000 cells": ("", PAN, ""), "brushing": paint}),
        ):
            for name, (times, thread, whole, drawn) in measure(browser, write, does, options.seconds).items():
                half, most = np.percentile(times, (50, 95))
                in_time = float(np.mean(times <= IN_TIME))
                is_slow = is_slow or thread > MOST
                frames = f"{name:30} {len(times):6} {half:5.1f} {most:5.1f} {times.max():7.0f} {100 * in_time:6.1f} %"
                print(f"{frames} {thread:9.2f} {whole:14.2f} {drawn:8}")
        browser.close()
        print(f"load at the end {os.getloadavg()[0]:.1f}")
    return 1 if is_slow and options.check else 0


if __name__ == "__main__":
    sys.exit(main())
