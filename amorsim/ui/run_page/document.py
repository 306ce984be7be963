"""The file of a run's page: scripts and styles of the Simulator's window, and the run, in one HTML document."""

from __future__ import annotations

import base64
import gzip
import hashlib
import html
import json
import os
import posixpath
import re
from pathlib import Path

from amorsim.core.arguments import checked, path_of
from amorsim.core.atomic_files import write_text
from amorsim.ui.run_page.contents import contents_of
from amorsim.ui.serve.pages import WEB
from amorsim.ui.simulator.sources.recording import Recording

__all__ = ["run_page"]

_START = "simulator/run_page.js"
_STYLES = ("vendor/uplot/uPlot.min.css", "shared/look.css", "simulator/page.css")
_IMPORT = re.compile(r'(^import\s[^"]*?|^export\s[^"]*?\sfrom\s)"(\.{1,2}/[^"]+)"', re.MULTILINE)
_PREFIX = "amorsim/"  # of a script's name in the page


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
        If the folder is none of a run, or has no such replica; or if a file in it cannot be read, or the page cannot be
        written.
    """
    folder = path_of(run, "run")
    path = folder / "export" / f"{folder.resolve().name}.html" if out is None else path_of(out, "out")
    recording = Recording(folder)
    try:
        if replica is not None:
            recording.choose(replica)
        page = _document(recording.scene["scenario"], gzip.compress(contents_of(recording), 9, mtime=0))
    finally:
        recording.close()
    write_text(path, page, within=folder if out is None else None)
    return path


def _document(title: str, run: bytes) -> str:
    scripts = json.dumps({"imports": _scripts()}, separators=(",", ":"))
    start = f'import "{_PREFIX}{_START}";'
    styles = "\n".join((WEB / name).read_text(encoding="utf-8") for name in _STYLES)
    # No address may be asked for anything, and no script may run but these: a scenario's names are text, never markup.
    allowed = " ".join(f"'sha256-{_hash(text)}'" for text in (scripts, start))
    policy = (
        f"default-src 'none'; script-src {allowed} data:; style-src 'unsafe-inline'; img-src data: blob:; "
        "base-uri 'none'; form-action 'none'"
    )
    icon = base64.b64encode((WEB / "shared/icon.svg").read_bytes()).decode()
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{policy}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{html.escape(title)} · amorsim</title>
<link rel="icon" href="data:image/svg+xml;base64,{icon}">
<style>
{styles}
</style>
<script type="importmap">{scripts}</script>
</head>
<body>
<main class="amorsim"><noscript>This page plays a run of amorsim, by JavaScript.</noscript></main>
<script type="text/plain" id="run">{base64.b64encode(run).decode()}</script>
<script type="module">{start}</script>
</body>
</html>
"""


def _hash(text: str) -> str:
    return base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()


def _scripts() -> dict[str, str]:
    """The script that a page starts with and all that it imports, by name, as addresses that hold them."""
    found: dict[str, str] = {}
    waiting = [_START]
    while waiting:
        name = waiting.pop()
        if _PREFIX + name in found:
            continue
        text = (WEB / name).read_text(encoding="utf-8")
        folder = posixpath.dirname(name)
        waiting += [posixpath.normpath(posixpath.join(folder, other)) for _, other in _IMPORT.findall(text)]
        text = _IMPORT.sub(lambda match, at=folder: _named(match, at), text)  # type: ignore[misc]
        found[_PREFIX + name] = "data:text/javascript;base64," + base64.b64encode(text.encode()).decode()
    return dict(sorted(found.items()))


def _named(match: re.Match[str], folder: str) -> str:
    """An import of a relative path as one of a name."""
    return f'{match[1]}"{_PREFIX}{posixpath.normpath(posixpath.join(folder, match[2]))}"'
