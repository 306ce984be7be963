"""Notebooks of the labs: the handout's text and commands, run cell by cell as they are written."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from amorsim.labs import NOTEBOOK, find_lab, find_labs, start_lab, write_notebook
from tests.grading.courses import fence_problem

RUN = """
import json, sys
from IPython.core.interactiveshell import InteractiveShell

shell = InteractiveShell.instance()
for cell in json.load(open("handout.ipynb", encoding="utf-8"))["cells"]:
    if cell["cell_type"] == "code":
        done = shell.run_cell("".join(cell["source"]))
        assert done.success, cell["source"]
        assert shell.user_ns.get("_exit_code", 0) == 0, cell["source"]
"""


def cells_of(number: int, folder: Path) -> list[dict[str, Any]]:
    start_lab(find_lab(number), folder)
    write_notebook(find_lab(number), folder)
    found: list[dict[str, Any]] = json.loads((folder / NOTEBOOK).read_text(encoding="utf-8"))["cells"]
    return found


@pytest.mark.parametrize("number", [lab.number for lab in find_labs()])
def test_a_notebook_holds_handout_and_program(number: int, tmp_path: Path) -> None:
    cells = cells_of(number, tmp_path / "lab")
    text = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "markdown"]
    code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    assert text[0].startswith(f"# Lab {number}: ")
    assert len({cell["id"] for cell in cells}) == len(cells)
    assert "am.widget(sim)" in code[0]
    program = find_lab(number).handed_in
    assert f"%%writefile {program.name}\n{program.read_text(encoding='utf-8').rstrip()}" == code[1]
    assert code[-1] == "!amorsim lab check"
    # Nothing of the handout is lost: all of its paragraphs are there, in order.
    handout = (tmp_path / "lab" / "handout.md").read_text(encoding="utf-8")
    there = "\n".join(text)
    for paragraph in handout.split("\n\n"):
        if "```" not in paragraph:
            assert paragraph.strip() in there


@pytest.mark.long
@pytest.mark.parametrize("number", [lab.number for lab in find_labs()])
def test_a_notebook_runs_as_written(number: int, tmp_path: Path) -> None:
    pytest.importorskip("anywidget", reason="the extra 'notebook' is not installed")
    cells_of(number, tmp_path / "lab")
    if fence_problem():
        notebook = tmp_path / "lab" / NOTEBOOK
        notebook.write_text(notebook.read_text(encoding="utf-8").replace("lab check", "lab check --no-fence"))
    done = subprocess.run(
        [sys.executable, "-c", RUN], cwd=tmp_path / "lab", capture_output=True, text=True, timeout=600, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "of 10 points, the mean of 3 runs" in done.stdout or "the mean of 6 runs" in done.stdout
