"""A page of the window in one HTML document, with its scripts and styles, which loads nothing."""

from __future__ import annotations

import base64
import hashlib
import html
import json
import posixpath
import re

from amorsim.ui.serve.pages import WEB

__all__ = ["single_file"]

_STYLES = ("vendor/uplot/uPlot.min.css", "shared/look.css", "simulator/page.css")
_IMPORT = re.compile(r'(^import\s[^"]*?|^export\s[^"]*?\sfrom\s)"(\.{1,2}/[^"]+)"', re.MULTILINE)
_PREFIX = "amorsim/"  # of a script's name in the page


def single_file(title: str, start: str, contents: str = "") -> str:
    """The Simulator's page, started by the script `start`; `contents` is text for it, without markup."""
    scripts = json.dumps({"imports": _scripts(start)}, separators=(",", ":"))
    start = f'import "{_PREFIX}{start}";'
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
<main class="amorsim"><noscript>This page of amorsim needs JavaScript.</noscript></main>
<script type="text/plain" id="run">{contents}</script>
<script type="module">{start}</script>
</body>
</html>
"""


def _hash(text: str) -> str:
    return base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()


def _scripts(start: str) -> dict[str, str]:
    """The script that a page starts with and all that it imports, by name, as addresses that hold them."""
    found: dict[str, str] = {}
    waiting = [start]
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
