"""A study's table does not depend on where it was computed, nor on what died meanwhile."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import amorsim as am
from amorsim.sweeps import executors
from amorsim.sweeps.chunk import Outcome
from amorsim.sweeps.read import read_plan
from tests.processes import is_running
from tests.sweeps.studies import TRACK, needs_extra, study_file, tables

pytestmark = needs_extra

POINTS = {"from": 1.0, "to": 1.1, "count": 200}


def table_of(folder: Path) -> bytes:
    (table,) = folder.glob("table.*")
    return table.read_bytes()


def small(folder: Path, count: int, **changes: Any) -> dict[str, Any]:
    return tables(folder, axes={TRACK: POINTS | {"count": count}}, replicas=2, duration=0.3, **changes)


@pytest.mark.long
@pytest.mark.filterwarnings("default")
def test_two_processes_give_the_same_table(tmp_path: Path) -> None:
    given = small(tmp_path / "s", 6)
    am.sweep(given, tmp_path / "one")
    am.sweep(given, tmp_path / "two", jobs=2)
    assert table_of(tmp_path / "one") == table_of(tmp_path / "two")


@pytest.mark.long
@pytest.mark.skipif(not Path("/dev/shm").is_dir(), reason="as Linux has it")
def test_workers_of_a_study_that_is_killed_end_too(tmp_path: Path) -> None:
    given = small(tmp_path / "s", 4)
    (tmp_path / "s" / "slow.py").write_text(
        "import os, time\nfrom pathlib import Path\n\n\n"
        "def step(readings, estimate, clock):\n"
        f"    Path({str(tmp_path)!r}, f'pid-{{os.getpid()}}').touch()\n"
        "    time.sleep(60.0)\n"
    )
    scenario = tmp_path / "s" / "small.toml"
    scenario.write_text(scenario.read_text().replace('use = "square", side = 2.0', 'use = "slow.py:step"'))
    path = study_file(tmp_path / "s" / "study.toml", given)
    command = [sys.executable, "-m", "amorsim", "sweep", path, "--jobs", "2", "--out", tmp_path / "out"]
    with subprocess.Popen(list(map(str, command)), cwd=tmp_path, stdout=subprocess.DEVNULL) as process:
        wait_until(lambda: len(list(tmp_path.glob("pid-*"))) >= 2)
        workers = {int(found.name.removeprefix("pid-")) for found in tmp_path.glob("pid-*")}
        assert len(workers) == 2
        process.kill()
    wait_until(lambda: not any(map(is_running, workers)))
    for place in ("/dev/shm", tempfile.gettempdir()):
        assert list(Path(place).glob(f"joblib_memmapping_folder_{process.pid}_*")) == []


def wait_until(is_so: Callable[[], bool], seconds: float = 60.0) -> None:
    end = time.monotonic() + seconds
    while not is_so():
        assert time.monotonic() < end
        time.sleep(0.1)


@pytest.mark.long
@pytest.mark.parametrize("always", [False, True])
@pytest.mark.filterwarnings("default")
def test_a_process_that_dies_costs_its_chunk_only(tmp_path: Path, always: bool) -> None:
    given = small(tmp_path / "s", 1)
    (tmp_path / "s" / "killer.py").write_text(
        "import os\nfrom pathlib import Path\n\nimport amorsim as am\n\nMARK = Path("
        + repr(str(tmp_path / "mark"))
        + ")\n\n\n"
        "def step(readings, estimate, clock):\n"
        f"    if {always} or not MARK.exists():\n"
        "        MARK.touch()\n"
        "        os.kill(os.getpid(), 9)\n"
        "    return am.Twist(0.0, 0.0)\n"
    )
    controllers = [{"use": "square", "side": side} for side in (1.0, 1.1, 1.2)]
    given["axes"] = {"robots.rover.controller": [*controllers, {"use": "killer.py:step"}]}
    path = study_file(tmp_path / "s" / "study.toml", given)
    study = am.sweep(path, tmp_path / "out", jobs=2)
    assert study.is_complete
    assert [point for point, _ in study.failures] == ([3] if always else [])
    if always:
        assert "died, twice" in study.failures[0][1]


@pytest.mark.long
@pytest.mark.filterwarnings("default")
def test_eighty_points_give_one_table_however_they_are_computed(tmp_path: Path) -> None:
    from distributed import Client, LocalCluster

    given = small(tmp_path / "s", 80)
    am.sweep(given, tmp_path / "one")
    am.sweep(given, tmp_path / "two", jobs=2)
    with (
        LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as cluster,
        Client(cluster) as client,
    ):
        workers = [worker.pid for worker in cluster.workers.values()]

        def kill(progress: Any) -> None:
            if progress.done == 40:
                os.kill(workers[0], signal.SIGKILL)

        study = am.sweep(given, tmp_path / "dask", dask=client, progress=kill)
    assert study.failures == []
    assert table_of(tmp_path / "one") == table_of(tmp_path / "two") == table_of(tmp_path / "dask")


@pytest.mark.long
@pytest.mark.filterwarnings("default")
def test_an_outcome_that_is_lost_with_its_worker_is_computed_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from distributed import Client, LocalCluster

    given = small(tmp_path / "s", 12)
    am.sweep(given, tmp_path / "one")
    is_done, killed = executors._done, []
    with (
        LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as cluster,
        Client(cluster) as client,
    ):

        def kill_its_worker(client: Any, distributed: Any, futures: list[Any]) -> list[Any]:
            """A worker dies after its chunk is done and before the outcome is fetched, while the other one is busy."""
            done = list(is_done(client, distributed, futures))
            if done and not killed:
                ((holder, *_),) = client.who_has(done[:1]).values()
                workers = {worker.worker_address: worker.pid for worker in cluster.workers.values()}
                killed.append(workers.pop(holder))
                (other,) = workers.values()
                os.kill(other, signal.SIGSTOP)
                os.kill(killed[0], signal.SIGKILL)
                wait_until(lambda: done[0].status != "finished")
                os.kill(other, signal.SIGCONT)
            return done

        monkeypatch.setattr(executors, "_done", kill_its_worker)
        study = am.sweep(given, tmp_path / "dask", dask=client)
    assert len(killed) == 1
    assert study.failures == []
    assert table_of(tmp_path / "one") == table_of(tmp_path / "dask")


@pytest.mark.long
@pytest.mark.filterwarnings("default")
def test_a_cluster_may_be_given_by_its_address(tmp_path: Path) -> None:
    from distributed import LocalCluster

    given = small(tmp_path / "s", 5)
    am.sweep(given, tmp_path / "one")
    local = {"processes": False, "protocol": "tcp://", "dashboard_address": None}
    with LocalCluster(n_workers=1, threads_per_worker=1, **local) as cluster:
        assert am.sweep(given, tmp_path / "dask", dask=cluster.scheduler_address).is_complete
    assert table_of(tmp_path / "one") == table_of(tmp_path / "dask")


@pytest.mark.long
@pytest.mark.filterwarnings("default")
def test_a_cluster_that_goes_away_leaves_what_was_done(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(executors, "_PATIENCE", 6.0)
    given = small(tmp_path / "s", 60)
    code = (
        "import time\nfrom distributed import LocalCluster\n"
        "with LocalCluster(n_workers=1, processes=False, protocol='tcp://', dashboard_address=None) as cluster:\n"
        "    print(cluster.scheduler_address, flush=True)\n    time.sleep(120.0)\n"
    )
    with subprocess.Popen([sys.executable, "-W", "ignore", "-c", code], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        address = process.stdout.readline().strip()

        def kill(progress: Any) -> None:
            if progress.done == 8:
                process.kill()

        try:
            with pytest.raises(am.StudyError, match=r"the Dask cluster .*has gone away, or has no workers any more"):
                am.sweep(given, tmp_path / "out", dask=address, progress=kill)
        finally:
            process.kill()
    part = am.read_study(tmp_path / "out")
    assert 8 <= len(set(part["point"])) < 60
    whole = am.sweep(given, tmp_path / "out")
    assert whole.is_complete
    assert len(set(whole["point"])) == 60


@pytest.mark.parametrize("what", ["result", "exception"])
@pytest.mark.filterwarnings("default")
def test_a_cluster_that_goes_away_while_it_answers_is_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, what: str
) -> None:
    import distributed

    def break_off(future: Any) -> None:
        raise distributed.comm.CommClosedError("Connection reset by peer")

    monkeypatch.setattr(distributed.Future, what, break_off)
    monkeypatch.setattr(distributed.Future, "status", "finished" if what == "result" else "error")
    with (
        distributed.Client(n_workers=1, processes=False, dashboard_address=None, set_as_default=False) as client,
        pytest.raises(am.StudyError, match=r"the Dask cluster .*has gone away") as error,
    ):
        am.sweep(small(tmp_path / "s", 2), tmp_path / "out", dask=client)
    assert isinstance(error.value.__cause__, distributed.comm.CommClosedError)


@pytest.mark.long
def test_after_ctrl_c_the_same_command_goes_on(tmp_path: Path) -> None:
    given = small(tmp_path / "s", 40)
    path = study_file(tmp_path / "s" / "study.toml", given)
    am.sweep(path, tmp_path / "whole")
    command = [sys.executable, "-m", "amorsim", "sweep", str(path), "--jobs", "2", "--out", str(tmp_path / "out")]
    env = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    with subprocess.Popen(
        command, env=env, start_new_session=True, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
    ) as process:
        until = time.monotonic() + 50.0
        while len(list((tmp_path / "out").glob("chunks/*/*.json"))) < 5 and time.monotonic() < until:
            time.sleep(0.05)
        os.killpg(process.pid, signal.SIGINT)
        _, problems = process.communicate(timeout=90)
    assert process.returncode == 130, problems
    assert "Traceback" not in problems.decode()
    part = am.read_study(tmp_path / "out")
    assert 5 <= len(set(part["point"])) < 40
    assert am.sweep(path, tmp_path / "out", jobs=2).is_complete
    assert table_of(tmp_path / "whole") == table_of(tmp_path / "out")


@pytest.mark.long
@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_processes_ignore_ctrl_c_from_their_first_line_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from joblib.externals.loky import get_reusable_executor

    get_reusable_executor().shutdown(wait=True)  # another test's processes may ignore it already
    before = signal.getsignal(signal.SIGINT)
    monkeypatch.setattr(executors, "_in_worker", lambda plan, work, parent: signal.getsignal(signal.SIGINT))
    plan = read_plan(small(tmp_path / "s", 4))
    answers: list[Any] = list(executors._parallel(plan, (executors.Work(index=index) for index in range(4)), 2))
    assert answers == [signal.SIG_IGN] * 4
    assert signal.getsignal(signal.SIGINT) is before


def test_a_cluster_that_is_not_there_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import distributed

    def refuse(*args: Any, **kwargs: Any) -> None:
        raise OSError("Timed out trying to connect")

    monkeypatch.setattr(distributed, "Client", type("Client", (), {"__init__": refuse}))
    with pytest.raises(am.StudyError, match=r"tcp://127.0.0.1:9: there is no Dask cluster that can be reached"):
        am.sweep(small(tmp_path / "s", 2), tmp_path / "out", dask="tcp://127.0.0.1:9")
    with pytest.raises(am.StudyError, match=r"dask: expected the address of a scheduler"):
        am.sweep(small(tmp_path / "s", 2), tmp_path / "out2", dask=3)


@pytest.mark.parametrize("address", ["nonsense", "tcp://host", ""])
def test_what_is_no_address_is_refused_at_once(tmp_path: Path, address: str) -> None:
    # A client of such an address takes 20 s to be deleted, and complains then.
    with pytest.raises(am.StudyError, match=r"dask: expected the address of a scheduler, as tcp://host:8786"):
        am.sweep(small(tmp_path / "s", 2), tmp_path / "out", dask=address)
    assert not (tmp_path / "out").exists()


def test_a_worker_computes_even_if_it_cannot_leave_its_mark(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # The disk may be full; the process that spreads the work says so when it writes.
    monkeypatch.setattr(executors, "ignore_interrupts", lambda: None)
    monkeypatch.setattr(executors, "run_chunk", lambda plan, index, folder: Outcome(index=index))
    work = executors.Work(index=3, begun=str(tmp_path / "none" / "00000003.begun"))
    assert executors._in_worker(read_plan(small(tmp_path / "s", 4)), work, os.getppid()).index == 3


def test_without_the_extra_it_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, options in (("joblib", {"jobs": 2}), ("distributed", {"dask": "tcp://127.0.0.1:9"})):
        monkeypatch.setitem(sys.modules, name, None)
        with pytest.raises(am.StudyError, match=rf"this needs .*{name}.*amorsim\[sweep\]"):
            am.sweep(small(tmp_path / "s", 2), tmp_path / name, **options)
