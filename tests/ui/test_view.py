"""`amorsim view` as a process: its address, its mistakes, its end."""

from __future__ import annotations

import html
import http.client
import importlib.util
import signal
import stat
import subprocess
import sys
import time
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit
from urllib.request import url2pathname

import pytest

import amorsim as am
from amorsim.cli import main
from tests.processes import command_line_of
from tests.ui.serve.test_gif import packed, png
from tests.ui.sessions import in_time, write_project
from tests.ui.views import View, children_of, cookie_of, drive, until_gone

pytest.importorskip("starlette", reason="the extra 'ui' is not installed")


def get(address: str, path: str, **headers: str) -> int:
    parts = urlsplit(address)
    connection = http.client.HTTPConnection(parts.hostname or "", parts.port or 0, timeout=10.0)
    connection.request("GET", path, headers=headers)
    status = connection.getresponse().status
    connection.close()
    return status


@pytest.mark.long
@pytest.mark.skipif(sys.platform != "linux", reason="processes are looked for in /proc")
@pytest.mark.parametrize(
    "number",
    [
        pytest.param(signal.SIGINT, id="ctrl-c"),
        pytest.param(signal.SIGHUP, id="closed terminal", marks=pytest.mark.long),
    ],
)
def test_it_ends_within_two_seconds_with_whole_files(tmp_path: Path, views: list[View], number: signal.Signals) -> None:
    scenario = write_project(tmp_path)
    view = View(scenario.name, "--out", "out", cwd=tmp_path, command="view" if number == signal.SIGINT else "runsim")
    views.append(view)
    assert len(view.children) == 1
    address = urlsplit(view.address)
    assert address.hostname == "127.0.0.1"
    used = view.address
    assert get(used, "/") == 401
    drive(view)
    assert get(used, f"{address.path}?{address.query}") == 401
    assert view.address != used
    assert view.lines[-1] == f"for another browser: {view.address}\n"
    seconds, said = view.end(number)
    assert seconds < in_time()
    if number == signal.SIGINT:
        assert view.process.returncode == 0
        assert "results: out" in said
    outcome = am.reproduce(tmp_path / "out")
    assert outcome.is_exact
    assert outcome.steps > 3


@pytest.mark.long
@pytest.mark.skipif(sys.platform != "linux", reason="a terminal is made as on Linux")
def test_it_ends_with_its_terminal(tmp_path: Path) -> None:
    import os
    import pty

    scenario = write_project(tmp_path)
    terminal, inside = pty.openpty()
    script = (
        "import fcntl, os, sys, termios; fcntl.ioctl(0, termios.TIOCSCTTY, 0); "
        f"os.execv(sys.executable, [sys.executable, '-m', 'amorsim', 'view', {scenario.name!r}, '--no-open'])"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", script],
        cwd=tmp_path,
        stdin=inside,
        stdout=inside,
        stderr=inside,
        start_new_session=True,
    )
    os.close(inside)
    try:
        said = b""
        while b"http://" not in said:
            said += os.read(terminal, 1000)
        pids = [process.pid, *(int(pid) for pid in children_of(process.pid))]
        assert len(pids) > 1
        os.close(terminal)
        process.wait(60.0)
        assert until_gone(pids) < 10.0 + in_time()
    finally:
        if process.poll() is None:
            process.kill()
            process.wait()


def test_a_process_that_is_still_being_loaded_ends_with_its_session(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from amorsim.ui.simulator.process.pipes import python_for

    # As numpy and numba on a machine that has much else to do, only longer.
    (tmp_path / "heavy.py").write_text("import time\nprint('loading', flush=True)\ntime.sleep(3600)\n")
    monkeypatch.syspath_prepend(tmp_path)
    with subprocess.Popen(python_for("heavy"), stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        assert process.stdout.readline() == b"loading\n"
        process.stdin.write(b"an order that nobody reads any more")
        process.stdin.flush()
        assert process.poll() is None
        process.stdin.close()
        try:
            assert process.wait(60.0) == 1
        finally:
            process.kill()


@pytest.mark.long
def test_a_gif_that_is_being_made_does_not_hold_up_the_end(tmp_path: Path, views: list[View]) -> None:
    scenario = write_project(tmp_path)
    first = (
        "import pathlib, time\n"
        "import amorsim.ui.serve.server as server\n"
        "server.gif_of = lambda film: (pathlib.Path('begun').touch(), time.sleep(3600))"
    )
    view = View(scenario.name, "--out", "out", cwd=tmp_path, first=first)
    views.append(view)
    drive(view)
    cookie, parts = cookie_of(view), urlsplit(view.address)
    connection = http.client.HTTPConnection(parts.hostname or "", parts.port or 0, timeout=60.0)
    body = packed(png((0, 0, 0)))
    headers = {"Cookie": cookie, "Origin": f"http://{parts.netloc}"}
    connection.request("POST", "/amorsim/gif?every=100", body=body, headers=headers)
    end = time.monotonic() + 60.0
    while not (tmp_path / "begun").exists():
        assert time.monotonic() < end
        time.sleep(0.01)
    seconds, said = view.end(signal.SIGINT)
    connection.close()
    assert seconds < 10.0 + in_time()
    assert view.process.returncode == 0
    assert said.count("results: out") == 1
    assert am.reproduce(tmp_path / "out").is_exact


@pytest.fixture
def amorsim(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Any:
    def command(*arguments: str) -> tuple[Any, str]:
        monkeypatch.setattr(sys, "argv", ["amorsim", *arguments])
        with pytest.raises(SystemExit) as end:
            main()
        return end.value.code, capsys.readouterr().err

    return command


OPENED = """#!{python}
import os, pathlib, sys
pathlib.Path("opened.part").write_text(sys.argv[1])
os.rename("opened.part", "opened")
"""


@pytest.mark.long
@pytest.mark.skipif(sys.platform != "linux", reason="the list of processes is read in /proc")
def test_the_browser_is_opened_on_a_file_that_only_the_user_can_read(
    tmp_path: Path, views: list[View], monkeypatch: pytest.MonkeyPatch
) -> None:
    scenario = write_project(tmp_path)
    browser = tmp_path / "browser"
    browser.write_text(OPENED.format(python=sys.executable))
    browser.chmod(0o755)
    monkeypatch.setenv("BROWSER", f"{browser} %s")
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    view = View(scenario.name, cwd=tmp_path, is_opened=True)
    views.append(view)
    end = time.monotonic() + 60.0
    while not (tmp_path / "opened").exists():
        assert time.monotonic() < end
        time.sleep(0.01)
    opened = (tmp_path / "opened").read_text()
    assert opened.startswith("file:///")
    file = Path(url2pathname(urlsplit(opened).path))
    assert stat.S_IMODE(file.stat().st_mode) == 0o600
    assert stat.S_IMODE(file.parent.stat().st_mode) == 0o700
    address = html.unescape(file.read_text().partition("url=")[2].partition('"')[0])
    token = address.partition("token=")[2]
    assert len(token) > 20
    assert token not in view.address
    assert command_line_of(view.process.pid)
    for pid in [view.process.pid, *view.children]:  # the one that opens the browser may end meanwhile
        assert token.encode() not in command_line_of(pid)
    # It works once, and then the file is gone, while the printed address is still good.
    path = f"/?token={token}"
    assert get(address, path) == 200
    assert get(address, path) == 401
    assert not file.parent.exists()
    assert cookie_of(view)


@pytest.mark.long
def test_it_removes_the_browsers_file_when_it_ends(
    tmp_path: Path, views: list[View], monkeypatch: pytest.MonkeyPatch
) -> None:
    scenario = write_project(tmp_path)
    monkeypatch.setenv("BROWSER", "true %s")
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    view = View(scenario.name, "--host", "0.0.0.0", cwd=tmp_path, is_opened=True)
    views.append(view)
    end = time.monotonic() + 60.0
    while not list(tmp_path.glob("amorsim-open-*/*.html")):
        assert time.monotonic() < end
        time.sleep(0.01)
    view.process.send_signal(signal.SIGINT)
    _, complained = view.process.communicate(timeout=60.0)
    assert not list(tmp_path.glob("amorsim-open-*"))
    assert "served on 0.0.0.0 without encryption" in complained


def test_without_the_extra_one_line_says_what_to_install(amorsim: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    find = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name, *rest: None if name == "starlette" else find(name, *rest)
    )
    status, said = amorsim("view", "demo")
    assert status == 2
    assert said.splitlines() == ['the window needs the extra "ui": python -m pip install "amorsim[ui]"']


@pytest.mark.long
def test_mistakes_are_reported_as_run_reports_them(
    amorsim: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    write_project(tmp_path)
    wrong = ("scenario.toml", "--set", "robots.rover.sensors.laser.beems=3", "--set", "robots.rover.pose.x=left")
    assert amorsim("view", *wrong, "--no-open") == amorsim("run", *wrong, "--quiet")
    (tmp_path / "taken").mkdir()
    (tmp_path / "taken" / "file").touch()
    for arguments, says in (
        (("nothing.toml",), "nothing.toml"),
        (("demo", "--out", "taken"), "the folder holds files already"),
        (("demo", "--port", "70000"), "--port: expected a whole number from 0 to 65535"),
        (("demo", "--duration", "-1"), "--duration: expected a number"),
    ):
        status, said = amorsim("view", *arguments, "--no-open")
        assert status == 2, said
        assert says in said
        assert "Traceback" not in said
    assert sorted(path.name for path in tmp_path.iterdir()) == ["own.py", "room.wld", "scenario.toml", "taken"]
