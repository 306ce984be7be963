"""Write the list of kernels to compile ahead, from a run of the demo with an empty cache: amorsim/kernels/ahead.json.

Run it after kernels or the types of their arguments have changed; a test says when that is due.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve()

Key = tuple[str, str, bool, str]  # module, name, whether it is a part, types of its arguments


def record() -> None:
    """Run the demo in this process, and print what it had compiled, callees before callers."""
    import amorsim as am
    from amorsim.kernels import compile as compiling

    calls: dict[Key, set[Key]] = {}
    took: dict[Key, float] = {}
    stacks: dict[
        int, list[tuple[Key, list[float]]]
    ] = {}  # what a thread compiles, and the seconds that its callees took
    compile_ = compiling._Dispatcher.compile

    def compile_and_note(self: Any, signature: Any) -> Any:
        stack = stacks.setdefault(threading.get_ident(), [])
        key = _key(self, signature)
        if stack:
            calls[stack[-1][0]].add(key)
        calls.setdefault(key, set())
        stack.append((key, [0.0]))
        started = time.thread_time()
        result = compile_(self, signature)
        seconds = time.thread_time() - started
        _, inner = stack.pop()
        took[key] = took.get(key, 0.0) + seconds - inner[0]
        if stack:
            stack[-1][1][0] += seconds
        return result

    compiling._Dispatcher.compile = compile_and_note  # type: ignore[method-assign]
    with tempfile.TemporaryDirectory() as folder:
        am.run(am.load("demo"), Path(folder) / "run", duration=1.0)
    print(_as_text(calls, took))


def _key(dispatcher: Any, signature: Any) -> Key:
    from amorsim.kernels.ahead import describe

    function = dispatcher.py_func
    try:
        types = json.dumps([describe(each) for each in signature])
    except ValueError:  # left out: it is compiled with its caller
        types = f"? {signature}"
    return function.__module__, function.__qualname__, "no_cpython_wrapper" in dispatcher.targetoptions, types


def _as_text(calls: dict[Key, set[Key]], took: dict[Key, float]) -> str:
    ranks: dict[Key, float] = {}

    def rank(key: Key) -> float:
        """The seconds from the beginning of this function to the end of the last that needs it."""
        if key not in ranks:
            ranks[key] = took[key] + max((rank(caller) for caller in calls if key in calls[caller]), default=0.0)
        return ranks[key]

    keys = sorted((key for key in calls if not key[3].startswith("?")), key=lambda key: (-rank(key), key))
    places = {key: place for place, key in enumerate(keys)}
    rows = [
        {
            "module": key[0],
            "name": key[1],
            "part": key[2],
            "callees": sorted(places[callee] for callee in calls[key] if callee in places),
            "types": json.loads(key[3]),
        }
        for key in keys
    ]
    return "[\n" + ",\n".join(json.dumps(row) for row in rows) + "\n]"


def main() -> None:
    """Record in a process of its own, for kernels that are loaded are not compiled."""
    from amorsim.kernels.ahead import LIST

    with tempfile.TemporaryDirectory() as cache:
        environment = os.environ | {"NUMBA_CACHE_DIR": cache}
        told = subprocess.run(
            [sys.executable, str(HERE), "record"], env=environment, check=True, stdout=subprocess.PIPE, text=True
        ).stdout
    LIST.write_text(told[told.index("[") :], encoding="utf-8")
    print(f"{LIST}: {len(json.loads(LIST.read_text(encoding='utf-8')))} functions")


if __name__ == "__main__":
    record() if sys.argv[1:] == ["record"] else main()
