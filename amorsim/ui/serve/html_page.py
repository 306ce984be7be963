"""A page as one HTML document: its scripts, in an import map, and its styles come with it.

A browser that fetches the scripts one by one has 80 requests to make, and shows the page a second later.
"""

from __future__ import annotations

import base64
import hashlib
import html
import json
import posixpath
import re
from collections.abc import Sequence

from amorsim.ui.serve.pages import SIMULATOR_STYLES, WEB

__all__ = ["closed_document", "document"]

_IMPORT = re.compile(r'(^import\s[^"]*?|^export\s[^"]*?\sfrom\s)"(\.{1,2}/[^"]+)"', re.MULTILINE)
_PREFIX = "amorsim/"  # of a script's name in the page
_SERVED = "/amorsim/web/"  # where a server has the scripts that a page does not bring along, but asks for later


def document(
    start: str, styles: Sequence[str], nonce: str, *, title: str = "amorsim", policy: str = "", contents: str = ""
) -> str:
    """A page that is started by the script `start`.

    Parameters
    ----------
    start, styles
        Names of files in the folder of scripts.
    nonce
        Of scripts and styles: those without it may not run, if a policy says so.
    policy
        The content security policy; leave it out where an HTTP header has it.
    contents
        Text for the page's scripts, without markup.
    """
    held = f'<script type="text/plain" id="contents">{contents}</script>\n' if contents else ""
    allowed = f'<meta http-equiv="Content-Security-Policy" content="{policy}">\n' if policy else ""
    scripts = json.dumps({"imports": {_PREFIX: _SERVED, **_scripts(start)}}, separators=(",", ":"))
    sheets = "\n".join((WEB / name).read_text(encoding="utf-8") for name in styles)
    icon = base64.b64encode((WEB / "shared/icon.svg").read_bytes()).decode()
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
{allowed}<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{html.escape(title)}</title>
<link rel="icon" href="data:image/svg+xml;base64,{icon}">
<style nonce="{nonce}">
{sheets}
</style>
<script type="importmap" nonce="{nonce}">{scripts}</script>
</head>
<body>
<main class="amorsim"><noscript>This page of amorsim needs JavaScript.</noscript></main>
{held}<script type="module" nonce="{nonce}">import "{_PREFIX}{start}";</script>
</body>
</html>
"""


def closed_document(start: str, *, title: str = "amorsim", contents: str = "") -> str:
    """A page of the Simulator that may ask no address for anything, for use without a server; see `document`."""
    # Names in the contents are text, never markup: if one became it, it could not have a nonce that depends on itself.
    nonce = hashlib.sha256((start + contents).encode()).hexdigest()
    policy = (
        f"default-src 'none'; script-src 'nonce-{nonce}'; style-src 'nonce-{nonce}'; img-src data: blob:; "
        "base-uri 'none'; form-action 'none'"
    )
    return document(start, SIMULATOR_STYLES, nonce, title=title, policy=policy, contents=contents)


def _scripts(start: str) -> dict[str, str]:
    """The script that a page starts with and all that it imports, by name, as addresses that hold them."""
    found: dict[str, str] = {}
    waiting = [start]
    while waiting:
        name = waiting.pop()
        if _PREFIX + name in found:
            continue
        text, imported = _with_names(name, (WEB / name).read_text(encoding="utf-8"))
        waiting += imported
        text += f"\n//# sourceURL={_PREFIX}{name}\n"  # its name in a debugger
        found[_PREFIX + name] = "data:text/javascript;base64," + base64.b64encode(text.encode()).decode()
    return dict(sorted(found.items()))


def _with_names(name: str, text: str) -> tuple[str, list[str]]:
    """A script's text, which imports others by their names in place of relative paths; and these names."""
    imported: list[str] = []

    def named(match: re.Match[str]) -> str:
        imported.append(posixpath.normpath(posixpath.join(posixpath.dirname(name), match[2])))
        return f'{match[1]}"{_PREFIX}{imported[-1]}"'

    return _IMPORT.sub(named, text), imported
