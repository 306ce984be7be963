"""Makes the pictures of the environments for learners: each some seconds after its start, driven by a classical rule.

One is of all environments, one of the window in which one is watched. They are looked at and not compared, so make them
again only where they should look different::

    python tools/make_environment_pictures.py

Needs the extra "dev" and Debian's chromium.
"""

from __future__ import annotations

import contextlib
import io
import sys
import threading
import time
import webbrowser
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "docs" / "examples" / "learning")]
import controllers  # noqa: E402 - beside the docs, not installed
import free_headings  # noqa: E402

from amorsim.learning import load_environment, make_parallel, make_vec  # noqa: E402
from tests.ui.windows import CHROMIUM, FLAGS, Window  # noqa: E402

PICTURES = ROOT / "docs" / "pictures"
SIDE, GAP, HEADING, COLUMNS = 380, 16, 34, 4  # [px]
ACTIONS = {"Barn": 150, "Line": 250, "Dock": 110, "Trailer": 200}  # before the picture; others 60
SEEDS = {"Maze": 6, "Doors": 7, "Dock": 4}  # others 2


def picture_of(name: str) -> Image.Image:
    """An environment, driven for a while."""
    short = name.removeprefix("amorsim/").removesuffix("-v0")
    count = ACTIONS.get(short, 60)
    if short == "Crossing":
        world = make_parallel(name, render_mode="rgb_array")
        seen, _ = world.reset(seed=1)
        for _ in range(count):
            world.render()  # from which the trails are
            agents = list(world.agents)
            acts = free_headings.act(np.stack([seen[agent] for agent in agents]))
            seen, *_ = world.step(dict(zip(agents, acts, strict=True)))
        return Image.fromarray(world.render())
    controller, knows_map = controllers.DRIVERS.get(name, (None, False))
    scenario = controllers.with_map(load_environment(name)) if knows_map else name
    envs = make_vec(scenario, 1, controller=controller, render_mode="rgb_array")
    seen, _ = envs.reset(seed=SEEDS.get(short, 2))
    for _ in range(count):
        envs.render()
        seen, *_ = envs.step(np.zeros((1, 2)) if controller else free_headings.act(seen))
    return Image.fromarray(envs.render()[0])


def make() -> None:
    """Write the picture: a grid of all."""
    names = [*free_headings.TASKS, "amorsim/Crossing-v0", *controllers.DRIVERS]
    pictures = [picture_of(name) for name in names]
    for picture in pictures:
        picture.thumbnail((SIDE, SIDE), Image.Resampling.LANCZOS)
    lines = [range(first, min(first + COLUMNS, len(names))) for first in range(0, len(names), COLUMNS)]
    heights = [HEADING + GAP + max(pictures[number].height for number in line) for line in lines]
    sheet = Image.new("RGB", (GAP + COLUMNS * (SIDE + GAP), GAP + sum(heights)), "white")
    pen, font = ImageDraw.Draw(sheet), ImageFont.load_default(20)
    for row, line in enumerate(lines):
        top = GAP + sum(heights[:row])
        for column, number in enumerate(line):
            left = GAP + column * (SIDE + GAP)
            pen.text((left, top), names[number].removeprefix("amorsim/").removesuffix("-v0"), "black", font)
            sheet.paste(pictures[number], (left, top + HEADING))
    sheet.quantize(128, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE).save(
        PICTURES / "environments.png", optimize=True
    )


def make_window() -> None:
    """Write the picture of the window, some seconds after it was opened."""
    from playwright.sync_api import sync_playwright

    webbrowser.open = lambda *_, **__: True
    printed, is_over = io.StringIO(), threading.Event()

    def drive() -> None:
        with contextlib.redirect_stdout(printed):
            env = make_vec("amorsim/Maze-v0", 1, render_mode="human")
            seen, _ = env.reset(seed=6)
            while not is_over.is_set():
                seen, *_ = env.step(free_headings.act(seen))
            env.close()

    driving = threading.Thread(target=drive)
    driving.start()
    while "http" not in printed.getvalue():
        time.sleep(0.1)
    try:
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=str(CHROMIUM), args=FLAGS)
            page = browser.new_page(viewport={"width": 1366, "height": 768})
            Window(page).open(printed.getvalue().split()[0])
            page.wait_for_timeout(3000)  # pictures of maps and forms come after the first frames
            picture = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
            browser.close()
    finally:
        is_over.set()
        driving.join()
    picture.quantize(128, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE).save(
        PICTURES / "environment-window.png", optimize=True
    )


if __name__ == "__main__":
    make()
    make_window()
