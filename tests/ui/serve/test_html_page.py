"""A page with its scripts: what its import map holds."""

from __future__ import annotations

import base64
import json
import re

import pytest

from amorsim.ui.serve.html_page import closed_document, document
from amorsim.ui.serve.pages import KINDS, WEB

IMPORTED = re.compile(r'(?:^import|\bfrom) "([^"]+)";$', re.MULTILINE)
DATA = "data:text/javascript;base64,"


def scripts_in(page: str) -> dict[str, str]:
    """The scripts in a page, by name."""
    found = re.search(r'<script type="importmap"[^>]*>(.*?)</script>', page)
    assert found is not None
    imports = json.loads(found[1])["imports"]
    assert imports.pop("amorsim/") == "/amorsim/web/"  # what is asked for later
    return {name: base64.b64decode(address.removeprefix(DATA)).decode() for name, address in imports.items()}


@pytest.mark.parametrize("kind", KINDS)
def test_a_page_has_its_scripts_and_all_that_they_import_by_name(kind: str) -> None:
    start, styles = KINDS[kind]
    page = document(start, styles, "a-nonce")
    scripts = scripts_in(page)
    assert f'import "amorsim/{start}";' in page
    assert f"amorsim/{start}" in scripts
    for name, text in scripts.items():
        for other in IMPORTED.findall(text):
            assert other in scripts, f"{name} imports {other}"
        file = (WEB / name.removeprefix("amorsim/")).read_text()
        assert len(text.splitlines()) == len(file.splitlines()) + 2  # lines are those of the file, in a debugger too
        assert text.endswith(f"//# sourceURL={name}\n")
    assert len(scripts) > 5


def test_a_page_has_nothing_that_it_does_not_use() -> None:
    faults = scripts_in(document(*KINDS["faults"], "a-nonce"))
    editor = scripts_in(document(*KINDS["edit"], "a-nonce"))
    assert not any(name.startswith("amorsim/editor/") for name in faults)
    assert "amorsim/vendor/codemirror/codemirror.js" not in editor


def test_the_nonce_of_a_page_without_a_server_depends_on_what_is_in_it() -> None:
    pages = [closed_document("simulator/notebook.js", contents=contents) for contents in ("one", "two", "one")]
    nonces = [set(re.findall(r'nonce="([^"]+)"', page)) for page in pages]
    assert all(len(nonce) == 1 for nonce in nonces)
    assert nonces[0] != nonces[1]
    assert pages[0] == pages[2]
    assert "data:" not in pages[0].split("script-src", 1)[1].split(";", 1)[0]


def test_a_title_is_text() -> None:
    assert "<title>&lt;b&gt;</title>" in closed_document("simulator/notebook.js", title="<b>")
