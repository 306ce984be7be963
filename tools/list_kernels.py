"""Write the list of kernels to compile ahead, from a run of the demo with an empty cache: amorsim/kernels/ahead.jsonl.

Run it after kernels or the types of their arguments have changed; a test says when that is due.
"""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve()


def record() -> None:
    """Run the demo in this process, and print what it had compiled, a line for each function."""
    import amorsim as am
    from amorsim.kernels import compile as compiling
    from amorsim.kernels.ahead import describe
    from amorsim.kernels.folder import mark_warm

    mark_warm()  # so that nothing is compiled but what is asked for
    rows: set[str] = set()
    tuples: dict[str, list[Any]] = {}
    compile_ = compiling._Dispatcher.compile

    def compile_and_note(self: Any, signature: Any) -> Any:
        function = self.py_func
        way = "part" if "no_cpython_wrapper" in self.targetoptions else "kernel"
        with contextlib.suppress(ValueError):  # left out: it is compiled with its caller
            described = [describe(each, tuples) for each in signature]
            rows.add(json.dumps([function.__module__, function.__qualname__, way, *described]))
        return compile_(self, signature)

    compiling._Dispatcher.compile = compile_and_note  # type: ignore[method-assign]
    with tempfile.TemporaryDirectory() as folder:
        am.run(am.load("demo"), Path(folder) / "run", duration=1.0)
    print(*sorted(rows), *sorted(json.dumps(["tuple", *each]) for each in tuples.items()), sep="\n")


def main() -> None:
    """Record in a process of its own, for kernels that are loaded are not compiled."""
    from amorsim.kernels.ahead import LIST, read_list

    with tempfile.TemporaryDirectory() as cache:
        environment = os.environ | {"NUMBA_CACHE_DIR": cache}
        told = subprocess.run(
            [sys.executable, str(HERE), "record"], env=environment, check=True, stdout=subprocess.PIPE, text=True
        ).stdout
    LIST.write_text(told[told.index("[") :], encoding="utf-8")
    print(f"{LIST}: {len(read_list())} functions")


if __name__ == "__main__":
    record() if sys.argv[1:] == ["record"] else main()
