"""Makes the pictures of the labs: a good solution, light and dark, and each mistake, in headless Chromium.

They are looked at and not compared, so make them again only where they should look different::

    python tools/make_lab_pictures.py [NUMBER ...]

Needs the extra "dev" and Debian's chromium.
"""

from __future__ import annotations

import heapq
import re
import runpy
import shutil
import sys
import tempfile
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
from PIL import Image
from playwright.sync_api import Browser, sync_playwright

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tools")]
from make_screenshots import save  # noqa: E402 - beside us, not installed

import amorsim as am  # noqa: E402
from amorsim.contracts.planner import Plan  # noqa: E402
from amorsim.labs import Lab, find_labs  # noqa: E402
from tests.ui.windows import CHROMIUM, FLAGS, Server, Window  # noqa: E402

__all__ = ["make"]

WIDTH, HEIGHT = 1280, 720
PICTURE, DARK = "expected.png", "expected-dark.png"
# By number: the time that is shown [s], what is plotted, and changes to the lab's files (pattern, replacement).
SHOWN: dict[int, tuple[float, str, list[tuple[str, str]]]] = {
    1: (60.0, "apart", []),
    2: (21.0, "apart", [(r"rate = 0\.1", "rate = 0.02"), ("2e-4", "8e-4")]),
    3: (60.0, "heading", []),
    4: (40.0, "y", []),
    5: (90.0, "heading", []),
    6: (60.0, "apart", []),
    7: (6.0, "apart", []),
    8: (180.0, "apart", []),
    9: (60.0, "apart", []),
    10: (80.0, "apart", []),
    12: (20.0, "apart", []),
    13: (20.0, "apart", []),
}
SEEDS = {"sharp": 2}  # in which a mistake is one, where not in the scenario's


def make(browser: Browser, lab: Lab) -> None:
    """Write a lab's pictures beside its handout, and those of mistakes beside these."""
    solutions = lab.folder / "solutions"
    photograph(browser, lab, solutions / "good.py", {"light": lab.folder / PICTURE, "dark": lab.folder / DARK})
    for mistake in sorted(solutions.glob("*.py")):
        if mistake.stem not in ("good", "cheating"):
            photograph(browser, lab, mistake, {"light": mistake.with_suffix(".png")})


def photograph(browser: Browser, lab: Lab, program: Path, targets: dict[str, Path]) -> None:
    """Write pictures, by their themes, of the window after a program has driven in a lab."""
    seconds, plotted, changes = SHOWN[lab.number]
    with tempfile.TemporaryDirectory() as work:
        for file in lab.handed_out:
            shutil.copy(file, work)
        shutil.copy(program, Path(work) / lab.handed_in.name)
        for network in program.parent.glob("*.onnx"):
            shutil.copy(network, work)
        for name in ("lab.toml", lab.handed_in.name):
            path = Path(work) / name
            text = path.read_text(encoding="utf-8")
            for pattern, replacement in [*changes, (r"seed = 1\n", f"seed = {SEEDS.get(program.stem, 1)}\n")]:
                text = re.sub(pattern, replacement, text)
            path.write_text(text, encoding="utf-8")
        server = Server(Path(work) / "lab.toml")
        try:
            page = browser.new_page(viewport={"width": WIDTH, "height": HEIGHT}, color_scheme="light")
            window = Window(page).open(server.address)
            left = round(10.0 * seconds)
            while left > 0:
                window.do(do="step", steps=min(left, 100))
                left -= 100
            window.until(f"newest.tick >= {round(10.0 * seconds)}", seconds=240.0)
            window.open(page.url)  # whose trails are of each step
            page.keyboard.press("c")
            window.see(f"plots.choose({plotted!r})")
            page.wait_for_timeout(6000)  # until the hint is gone
            for theme, target in targets.items():
                page.emulate_media(color_scheme=theme)
                page.wait_for_timeout(1000)
                save(page.screenshot(), target)
            page.close()
        finally:
            server.close()


def draw_search(lab: Lab) -> None:
    """Draw the cells that the good solution of lab 11 takes out of its queue, and the way that it finds."""
    solution: dict[str, Any] = runpy.run_path(str(lab.folder / "solutions" / "good.py"))
    taken_out = []

    def pop(queue: list[Any]) -> Any:
        taken_out.append(heapq.heappop(queue))
        return taken_out[-1]

    start, goal = (1.0, 1.0), solution["GOAL"]
    find_path, cell_at = solution["find_path"], solution["cell_at"]
    find_path.__globals__["heapq"] = SimpleNamespace(heappush=heapq.heappush, heappop=pop)
    cells = find_path(solution["free_cells"](), cell_at(*start), cell_at(*goal))
    searched, path = (
        (np.array(places)[:, ::-1] + 0.5) * solution["SIDE"]
        for places in (list(dict.fromkeys(c for _, c in taken_out)), cells)
    )
    plan = Plan(
        status="found", poses=np.column_stack((path, np.zeros(len(path)))), expanded=len(searched), searched=searched
    )
    light = np.asarray(am.draw_plan(am.load_map(lab.folder / "house.wld"), plan, start, goal, size=1200)) / 255.0
    # The same hues, with light and dark exchanged.
    dark = light + (1.0 - light.max(axis=2, keepdims=True) - light.min(axis=2, keepdims=True))
    for name, picture in ((PICTURE, light), (DARK, 0.09 + 0.86 * dark)):
        Image.fromarray(np.round(255.0 * picture).astype(np.uint8)).save(lab.folder / name, optimize=True)


if __name__ == "__main__":
    wanted = [int(number) for number in sys.argv[1:]] or [*SHOWN, 11]
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=str(CHROMIUM), args=FLAGS)
        for each in find_labs():
            if each.number in wanted:
                (make(chromium, each) if each.number in SHOWN else draw_search(each))
        chromium.close()
