"""Where chunks are computed: in this process, in processes of this machine, or on a Dask cluster."""

from __future__ import annotations

import contextlib
import itertools
import os
import re
import tempfile
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import attrs

from amorsim.core.errors import StudyError
from amorsim.core.execution.processes import end_with_parent
from amorsim.sweeps.chunk import Outcome, ignore_interrupts, run_chunk, without_interrupts
from amorsim.sweeps.plan import Plan

__all__ = ["Work", "check_cluster", "in_processes", "in_this_process", "on_cluster"]

_PATIENCE = 60.0  # [s] that a cluster may be without any worker
_TRIES = 3
_ADDRESS = re.compile(r"inproc://\S+|(\w+://)?\S+:\d+")
_LOOK = 2.0  # [s] after which a cluster is looked at again


@attrs.frozen(kw_only=True)
class Work:
    """A chunk to compute: its number, a file that marks that it was begun, and the folder of its run, if kept."""

    index: int
    begun: str = ""
    folder: str = ""


MakeWork = Callable[[int], Work]


def in_this_process(plan: Plan, todo: Sequence[int], work_of: MakeWork) -> Iterator[Outcome]:
    """Compute chunks one after another."""
    for index in todo:
        yield run_chunk(plan, index, work_of(index).folder)


def _in_worker(plan: Plan, work: Work, parent: int) -> Outcome:
    end_with_parent(parent)
    ignore_interrupts()
    if work.begun:
        with contextlib.suppress(OSError):  # what cannot be written is reported when the outcome is
            Path(work.begun).touch()
    return run_chunk(plan, work.index, work.folder)


def in_processes(plan: Plan, todo: Sequence[int], work_of: MakeWork, jobs: int) -> Iterator[Outcome]:
    """Compute chunks in processes of this machine.

    If one dies, its chunk is computed again, in a process of its own: if that dies too, the chunk has failed.
    """
    waiting, tries = dict.fromkeys(todo), 0
    while waiting:
        try:
            for outcome in _parallel(plan, map(work_of, list(waiting)), jobs):
                del waiting[outcome.index]
                yield outcome
        except _DiedError:
            suspects = [work for work in map(work_of, waiting) if Path(work.begun).exists()]
            tries = 0 if suspects else tries + 1
            if tries == _TRIES:
                raise StudyError("processes of this machine die before they compute anything; try jobs=1") from None
            for work in suspects:
                try:
                    (outcome,) = _parallel(plan, iter([work]), 2)
                except _DiedError:
                    text = "the process that computed it died, twice; it may need more memory than there is"
                    outcome = Outcome(index=work.index, error=text)
                del waiting[work.index]
                yield outcome


class _DiedError(Exception):
    """A process died."""


def _parallel(plan: Plan, todo: Iterator[Work], jobs: int) -> Iterator[Outcome]:
    joblib = _extra("joblib")
    from joblib.externals.loky.process_executor import TerminatedWorkerError

    run = joblib.Parallel(
        n_jobs=jobs,
        backend="loky",
        return_as="generator_unordered",
        batch_size=1,
        pre_dispatch="2*n_jobs",
        max_nbytes=None,  # no array is shared by a file, and with a folder named, none is made in advance in /dev/shm
        temp_folder=tempfile.gettempdir(),
    )
    with warnings.catch_warnings():
        # Of workers that stopped: the outcomes of their chunks show it.
        warnings.filterwarnings("ignore", module="joblib")
        try:
            with without_interrupts():
                outcomes = run(joblib.delayed(_in_worker)(plan, work, os.getpid()) for work in todo)
            yield from outcomes
        except TerminatedWorkerError:
            raise _DiedError from None


def check_cluster(cluster: Any) -> Any:
    """The library that speaks to a Dask cluster; raises `StudyError` without it, or if no cluster can be meant."""
    distributed = _extra("distributed", "dask[distributed]")
    # A client for something else than an address takes long to be deleted, and complains then: it is not made.
    is_meant = _ADDRESS.fullmatch(cluster) if isinstance(cluster, str) else isinstance(cluster, distributed.Client)
    if not is_meant:
        raise StudyError(f"dask: expected the address of a scheduler, as tcp://host:8786, or a client, got {cluster!r}")
    return distributed


def on_cluster(plan: Plan, todo: Sequence[int], work_of: MakeWork, cluster: Any) -> Iterator[Outcome]:
    """Compute chunks on a Dask cluster: the address of its scheduler, or a client.

    A chunk whose worker dies goes to another one. The workers must find the study's files under the same paths.

    Raises
    ------
    StudyError
        If the cluster cannot be reached, or goes away.
    """
    distributed = check_cluster(cluster)
    try:
        client = distributed.Client(cluster, timeout=10, set_as_default=False) if isinstance(cluster, str) else cluster
    except (OSError, ValueError) as error:
        raise StudyError(f"{cluster}: there is no Dask cluster that can be reached ({error})") from None
    try:
        yield from _through(client, distributed, plan, map(work_of, todo))
    finally:
        if isinstance(cluster, str):
            client.close(timeout=2)


def _through(client: Any, distributed: Any, plan: Plan, todo: Iterator[Work]) -> Iterator[Outcome]:
    under_way: dict[Any, Work] = {}
    lonely = 0.0
    while True:
        threads = _threads(client)
        lonely = 0.0 if threads else lonely + _LOOK
        if client.status not in ("running", "connecting") or lonely > _PATIENCE:
            raise _gone(client)
        # Some in advance, so that no worker waits; not all, so that this process stays small.
        for work in itertools.islice(todo, max(0, max(2, 2 * threads) - len(under_way))):
            with _speaking_to(client):
                future = client.submit(run_chunk, plan, work.index, work.folder, pure=False, retries=1)
            under_way[future] = work
        if not under_way:
            return
        with _speaking_to(client):
            done = _done(client, distributed, list(under_way))
        for future in done:
            with _speaking_to(client):
                outcome = _outcome(client, distributed, future, under_way[future])
            if outcome is not None:
                del under_way[future]
                yield outcome


@contextlib.contextmanager
def _speaking_to(client: Any) -> Iterator[None]:
    """A block whose errors are the connection's: chunks report their own, and a client raises many kinds."""
    try:
        yield
    except Exception as error:
        raise _gone(client) from error


def _done(client: Any, distributed: Any, futures: list[Any]) -> Iterable[Any]:
    """Those of the futures that are done within a moment."""
    try:
        with client.as_current():  # wait() looks for it there
            done: Iterable[Any] = distributed.wait(futures, timeout=_LOOK, return_when="FIRST_COMPLETED").done
    except TimeoutError:
        return ()
    return done


def _threads(client: Any) -> int:
    try:
        return sum(client.nthreads().values())
    except Exception:  # of many kinds, when the scheduler has gone
        return 0


def _outcome(client: Any, distributed: Any, future: Any, work: Work) -> Outcome | None:
    """The outcome of a chunk; None if its worker died with it, for then another one computes it again."""
    status = future.status  # it may change at any moment
    if status in ("lost", "pending"):
        return None
    if status == "finished":
        outcome: Outcome = future.result()
        return outcome
    if status == "error":
        error = future.exception()
        if isinstance(error, distributed.KilledWorker):
            text = "the workers that computed it died, again and again; it may need more memory than there is"
            return Outcome(index=work.index, error=text)
        return Outcome(index=work.index, error=f"{type(error).__name__}: {error}")
    raise _gone(client)


def _gone(client: Any) -> StudyError:
    where = getattr(client.scheduler, "address", "") if client.scheduler is not None else ""
    return StudyError(f"the Dask cluster {where} has gone away, or has no workers any more".replace("  ", " "))


def _extra(name: str, package: str = "") -> Any:
    import importlib

    try:
        return importlib.import_module(name)
    except ModuleNotFoundError:
        raise StudyError(
            f'this needs {package or name}: python -m pip install "amorsim[sweep]"; without it, one process does all'
        ) from None
