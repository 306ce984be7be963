"""The widget: its script in a browser with a kernel's model that is stood in for, and (nightly) in JupyterLab."""

from __future__ import annotations

import base64
import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

import amorsim as am
from tests.ui import windows

pytest.importorskip("anywidget", reason="the extra 'notebook' is not installed")
PlaywrightError = pytest.importorskip("playwright.sync_api", reason="Playwright is not installed").Error

SIMULATOR = "document.querySelector('.amorsim')?.simulator"
HOST = """<!doctype html><meta charset="utf-8"><body data-jp-theme-light="false"><div id="cell"></div>
<script type="module">
const heard = new Set();
window.model = {
  get: (name) => window.traits[name],
  send: (message) => window.toKernel(message),
  on: (_, listener) => heard.add(listener),
  off: (_, listener) => heard.delete(listener),
};
window.fromKernel = (message, frame) => {
  const bytes = frame && Uint8Array.from(atob(frame), (letter) => letter.charCodeAt(0));
  for (const listener of heard) listener(message, bytes ? [new DataView(bytes.buffer)] : []);
};
window.show = async (script) => {
  const address = URL.createObjectURL(new Blob([script], { type: "text/javascript" }));
  window.gone = (await import(address)).default.render({ model, el: document.querySelector("#cell") });
};
</script>"""


def test_it_shows_itself_and_a_picture_beside_it() -> None:
    sim = am.Simulation(am.load("demo"))
    made = am.widget(sim)
    data, _ = made._repr_mimebundle_()
    assert "application/vnd.jupyter.widget-view+json" in data
    assert len(data["image/png"]) > 1000
    assert len(made.page) < 300_000
    assert "demo" in repr(made)


def test_without_anywidget_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda _: None)
    with pytest.raises(am.AmorsimError, match=r"amorsim\[notebook\]"):
        am.widget(am.Simulation(am.load("demo")))


@pytest.mark.long
def test_its_page_plays_the_kernel_s_simulation(browser: Any) -> None:
    sim = am.Simulation(am.load("demo"))
    made = am.widget(sim)
    page = browser.new_page()
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    inbox: list[Any] = []
    page.expose_function("toKernel", lambda message: inbox.append(message))
    made.send = lambda message, buffers=(): outbox.append((message, buffers))
    outbox: list[Any] = []

    def pump() -> None:
        page.wait_for_timeout(20)
        while inbox:
            made._heard(None, inbox.pop(0), None)
        while outbox:
            message, buffers = outbox.pop(0)
            page.evaluate(
                "([message, frame]) => fromKernel(message, frame)",
                [message, base64.b64encode(bytes(buffers[0])).decode() if buffers else None],
            )

    page.set_content(HOST)
    page.evaluate("traits => { window.traits = traits }", {"page": made.page, "height": 500})
    script = (Path(am.__file__).parent / "ui" / "web" / "notebook" / "widget.js").read_text(encoding="utf-8")
    page.evaluate("script => show(script)", script)

    def until(holds: Any) -> None:
        end = time.monotonic() + windows.PATIENCE
        while not holds():
            assert time.monotonic() < end
            pump()

    def is_shown() -> bool:
        try:
            return len(page.frames) > 1 and page.frames[1].evaluate(f"{SIMULATOR}?.scene?.scenario") == "demo"
        except PlaywrightError:  # the frame's page is being loaded
            return False

    until(is_shown)
    inner = page.frames[1]
    until(lambda: inner.evaluate("document.documentElement.dataset.theme") == "dark")
    inner.evaluate(f"void {SIMULATOR}.ask({{do: 'step', steps: 7}})")
    until(lambda: inner.evaluate(f"{SIMULATOR}.newest?.tick") == 7)
    assert sim.tick == 7
    sim.run(2.0)  # the next cell
    inner.evaluate(f"void {SIMULATOR}.reader.readState()")
    until(lambda: inner.evaluate(f"{SIMULATOR}.newest.tick") == sim.tick)
    before = sim.robot("rover").true.drive.track
    inner.evaluate(f"void {SIMULATOR}.ask({{do: 'set', robot: 'rover', path: 'drive.track', value: {before * 1.05}}})")
    until(lambda: sim.robot("rover").true.drive.track != before)
    assert inner.evaluate("window.origin") == "null"  # it is not part of the notebook's page
    assert inner.locator("text=save run").is_hidden()
    page.evaluate("gone()")
    pump()
    assert not made._live._windows
    assert not errors
    page.close()


def until(page: Any, holds: Any) -> None:
    """Wait; the page's own policy forbids Playwright's `wait_for_function`."""
    end = time.monotonic() + windows.PATIENCE
    while not holds():
        assert time.monotonic() < end
        page.wait_for_timeout(50)


CELLS = (
    "import amorsim as am\nsim = am.Simulation(am.load('demo'))\nam.widget(sim)",
    "print('at', sim.tick, sim.robot('rover').true.drive.track)",
)


@pytest.mark.nightly
def test_it_lives_in_jupyterlab(browser: Any, tmp_path: Path) -> None:
    pytest.importorskip("jupyterlab", reason="JupyterLab is not installed")
    cells = [
        {"cell_type": "code", "id": str(i), "metadata": {}, "source": text, "outputs": [], "execution_count": None}
        for i, text in enumerate(CELLS)
    ]
    kernel = {"kernelspec": {"name": "python3", "display_name": "Python 3", "language": "python"}}
    book = {"cells": cells, "metadata": kernel, "nbformat": 4, "nbformat_minor": 5}
    (tmp_path / "book.ipynb").write_text(json.dumps(book), encoding="utf-8")
    command = [sys.executable, "-m", "jupyter", "lab", "--no-browser", "--ServerApp.token=t", "--ServerApp.port=0"]
    command += [f"--ServerApp.root_dir={tmp_path}", "--LabApp.news_url=", "--allow-root"]
    environment = os.environ | {"JUPYTER_CONFIG_DIR": str(tmp_path / "config"), "JUPYTER_NO_CONFIG": "1"}
    lab = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=environment)
    try:
        assert lab.stderr is not None
        line = next(line for line in lab.stderr if "http://127.0.0.1:" in line or "http://localhost:" in line)
        address = line[line.index("http://") :].partition("/lab")[0]
        page = browser.new_page(viewport={"width": 1400, "height": 1000})
        page.set_default_timeout(windows.PATIENCE * 1000)
        page.goto(f"{address}/lab/tree/book.ipynb?token=t")
        page.click(".jp-Cell >> nth=0")
        page.wait_for_selector(".jp-Notebook-ExecutionIndicator[data-status=idle]")
        page.keyboard.press("Shift+Enter")
        page.frame_locator("iframe[title^=amorsim]").locator("canvas").first.wait_for()
        inner = page.frames[-1]
        until(page, lambda: inner.evaluate(f"Boolean({SIMULATOR}?.newest)"))
        inner.evaluate(f"{SIMULATOR}.ask({{do: 'speed', factor: 10}}).then(() => {SIMULATOR}.ask({{do: 'run'}}))")
        until(page, lambda: inner.evaluate(f"{SIMULATOR}.newest.tick") > 100)
        inner.evaluate(f"{SIMULATOR}.ask({{do: 'set', robot: 'rover', path: 'drive.track', value: 0.5}})")
        inner.evaluate(f"{SIMULATOR}.ask({{do: 'pause'}})")
        page.click(".jp-Cell >> nth=1")
        page.keyboard.press("Shift+Enter")
        printed = page.inner_text(".jp-Cell >> nth=1 >> .jp-OutputArea-output").split()
        assert int(printed[1]) > 100
        assert float(printed[2]) == pytest.approx(0.51, abs=0.02)  # 0.5, and 1.02 of it is true
        page.close()
    finally:
        lab.terminate()
        lab.communicate(timeout=30)
