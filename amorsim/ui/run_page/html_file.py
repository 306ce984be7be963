"""The file of a run's page: scripts and styles of the Simulator's window, and the run, in one HTML document."""

from __future__ import annotations

import base64
import gzip
import os
from pathlib import Path

from amorsim.core.arguments import checked, path_of
from amorsim.core.files.atomic_files import write_text
from amorsim.ui.run_page.packed_run import contents_of
from amorsim.ui.serve.html_page import closed_document
from amorsim.ui.simulator.sources.recording import Recording

__all__ = ["run_page"]

_START = "simulator/run_page.js"


@checked
def run_page(
    run: str | os.PathLike[str], out: str | os.PathLike[str] | None = None, *, replica: int | None = None
) -> Path:
    """Write a recorded run as one HTML file that plays in any browser, without amorsim and without a network.

    It is the window of `amorsim replay`: both panes, time line, table, plot, events and beliefs. It has at most 20
    moments of a second and 6000 in all, and of fleets the readings of the first 8 robots; the page lists what it lacks.

    Parameters
    ----------
    run
        The run's folder. Particles, maps and intentions are shown if the recorder ``arrays`` wrote them.
    out
        The file, replaced if it is there; without it, ``export/NAME.html`` in the run's folder.
    replica
        The number of the replica that is shown; without it, the first.

    Returns
    -------
    Path
        Of the page.

    Raises
    ------
    RunError
        If the folder is not a run's, or has no such replica; or if a file in it cannot be read, or the page cannot be
        written.
    """
    folder = path_of(run, "run")
    path = folder / "export" / f"{folder.resolve().name}.html" if out is None else path_of(out, "out")
    recording = Recording(folder)
    try:
        if replica is not None:
            recording.choose(replica)
        contents = base64.b64encode(gzip.compress(contents_of(recording), 9, mtime=0)).decode()
        title = f"{recording.scene['scenario']} · amorsim"
        page = closed_document(_START, title=title, contents=contents)
    finally:
        recording.close()
    write_text(path, page, within=folder if out is None else None)
    return path
