"""The process that reads for the Editor: what hangs in it is ended, and the next request is answered."""

from __future__ import annotations

import os
import signal
from pathlib import Path
from typing import Any

import pytest

import amorsim as am
from amorsim.core.errors import AmorsimError
from amorsim.ui.editor.reader import Reader, ReaderError


def of_demo(folder: Path) -> dict[str, Any]:
    document = am.open_document("demo")
    text = document.text
    return {"text": text, "path": document.path, "shown": text, "name": "demo.toml", "folder": folder}


@pytest.mark.long
@pytest.mark.skipif(os.name == "nt", reason="there is no SIGSTOP")
def test_a_process_that_hangs_is_ended_and_another_answers(tmp_path: Path) -> None:
    reader = Reader(time_limit=20.0)
    try:
        assert reader.ask("look", **of_demo(tmp_path)).faults == []
        process = reader._process
        assert process is not None
        reader.time_limit = 0.3
        os.kill(process.pid, signal.SIGSTOP)
        with pytest.raises(ReaderError, match=r"took longer than 0\.3 s"):
            reader.ask("look", **of_demo(tmp_path))
        assert process.poll() is not None
        reader.time_limit = 20.0
        assert reader.ask("look", **of_demo(tmp_path)).faults == []
        other = reader._process
        assert other is not None
        other.kill()
        other.wait()
        assert reader.ask("look", **of_demo(tmp_path)).things  # it is not even noticed
    finally:
        reader.close()
    with pytest.raises(ReaderError, match="closed"):
        reader.ask("look", **of_demo(tmp_path))


def test_what_a_function_raises_is_said_in_its_words(reader: Reader) -> None:
    with pytest.raises(AmorsimError, match="there is no picture 'x'"):
        reader.ask("picture", name="x")
