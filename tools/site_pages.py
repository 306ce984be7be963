"""What the website shows differently from the files in `docs`; `docs/conf.py` calls it.

The pages on components and on Python are one file each, to be searched in the repository. On the site each component
and each public name has a page of its own, and the long page lists them. Pages that are lists of links become the
site's tables of contents.
"""

from __future__ import annotations

import functools
import posixpath
import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

__all__ = ["CONTENTS", "LONG_PAGES", "as_contents", "in_both_themes", "links_to_parts", "make_parts"]

LONG_PAGES = ("reference/components", "reference/python")
"""Pages whose sections of the third level become pages."""

CONTENTS = ("index", "explanation/errors/README", "labs/README")
"""Pages whose links are the site's tables of contents."""

SCENARIOS = "reference/scenarios"
"""The page of bundled scenarios, where each can be played."""

HANDOUTS = re.compile(r"^labs/(\d+)-[^/]*/handout$")
"""Pages of labs, where a run of the good solution can be played."""

_RUN = re.compile(r"^```sh\namorsim run (\S+)\n```$", re.MULTILINE)
_PLAY = r"""\g<0>

<p class="play"><a href="../runs/\1.html">Play a run of it</a></p>"""
_VIEW = re.compile(r"^```sh\namorsim view lab.toml\n```$", re.MULTILINE)
_PLAY_LAB = r"""\g<0>

<p class="play"><a href="../../runs/lab-{}.html#lecture">Play a run of the good solution, in large writing</a></p>"""
_ALONE = "---\norphan: true\n---\n\n"  # of a page that its own list leads to, and not the table beside every page

_LINK = re.compile(r"(!?\[[^\]]*\]\()([^)\s]+)(\))")
_PICTURE = re.compile(r"^!\[([^\]]*)\]\(([^)\s]+)\.png\)$", re.MULTILINE)
_CODE = re.compile(r"(^```.*?^```$)", re.MULTILINE | re.DOTALL)


class Part(NamedTuple):
    """A section of a long page."""

    group: str  # heading of the second level above it
    title: str
    anchor: str  # as GitHub makes it
    page: str  # name of its page, without folder and suffix
    text: str


def _parts(text: str) -> Iterator[Part]:
    """The sections of a long page, in order."""
    seen: dict[str, int] = {}
    pieces = re.split(r"^(##|###) (.+)$", "".join(_outside_code(text)), flags=re.MULTILINE)
    group = ""
    for level, title, body in zip(pieces[1::3], pieces[2::3], pieces[3::3], strict=True):
        slug = re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")
        count = seen[slug] = seen.get(slug, -1) + 1
        if level == "##":
            group = title
            continue
        page = re.sub(r"[^\w.]", "", title).lower().replace(".", "-").replace("_", "-")
        name = f"{page}-{count}" if count else page
        yield Part(group, title, f"{slug}-{count}" if count else slug, name, body.replace("\0", "#"))


def _outside_code(text: str) -> Iterator[str]:
    """The text in pieces, where code has another character for each number sign, as these are not headings."""
    for place, piece in enumerate(_CODE.split(text)):
        yield piece.replace("#", "\0") if place % 2 else piece


def _moved(text: str) -> str:
    """A page's text with its relative links as they are one folder further down."""

    def down(found: re.Match[str]) -> str:
        start, link, end = found.groups()
        is_relative = not link.startswith(("http:", "https:", "#"))
        return f"{start}{posixpath.join('..', link) if is_relative else link}{end}"

    return _LINK.sub(down, text)


def make_parts(docs: Path) -> None:
    """Write the pages of components and of public names into folders beside the long pages; others there go."""
    for long_page in LONG_PAGES:
        folder = docs / long_page
        folder.mkdir(exist_ok=True)
        written = set()
        whole = (docs / f"{long_page}.md").read_text(encoding="utf-8")
        title = whole.split("\n")[0].lstrip("# ")
        for part in _parts(whole):
            path = folder / f"{part.page}.md"
            above = f"[{title}](../{folder.name}.md) · {part.group}"
            text = f"{_ALONE}# {part.title}\n\n{above}\n{_moved(part.text)}"
            if not path.exists() or path.read_text(encoding="utf-8") != text:
                path.write_text(text, encoding="utf-8")
            written.add(path)
        for old in set(folder.glob("*.md")) - written:
            old.unlink()


def _table(caption: str, pages: list[str]) -> str:
    head = f":caption: {caption}\n" if caption else ""
    return "\n```{toctree}\n:hidden:\n" + head + "\n" + "\n".join(pages) + "\n```\n"


def as_contents(page: str, text: str) -> str:
    """The text of a page with the tables of contents that it is for the site."""
    if page in LONG_PAGES:
        return _list_of_parts(page, text)
    if page == SCENARIOS:
        return _RUN.sub(_PLAY, text)
    if lab := HANDOUTS.match(page):
        return _VIEW.sub(_PLAY_LAB.format(lab[1]), text, count=1)
    if page.startswith("decisions/"):
        return _ALONE + text
    if page not in CONTENTS:
        return text
    tables = []
    for paragraph in re.split(r"^(?=\*\*)", text, flags=re.MULTILINE):
        caption = re.match(r"\*\*(.+?)[. …]*\*\*", paragraph)
        links = dict.fromkeys(link for _, link, _ in _LINK.findall(paragraph) if _is_below(link))
        within = [link for link in links if page != "index" or caption]
        if within:
            tables.append(_table(caption[1] if caption and page == "index" else "", within))
    return text + "".join(tables)


def _is_below(link: str) -> bool:
    """Whether a link leads to a page of the site that is not elsewhere."""
    return link.endswith(".md") and not link.startswith("../")


def _list_of_parts(page: str, text: str) -> str:
    """A long page as the contents of its parts: its head, and under each group a list of links."""
    folder = page.rpartition("/")[2]
    shown = "".join(_outside_code(text))
    lines = re.split(r"^(?=## )", shown, flags=re.MULTILINE)
    parts = list(_parts(text))
    kept = [lines[0]]
    for section in lines[1:]:
        group = section.split("\n")[0].removeprefix("## ")
        kept.append(re.split(r"^### ", section, flags=re.MULTILINE)[0])
        kept += [
            f"- [{part.title}]({folder}/{part.page}.md): {_first_line(part.text)}\n"
            for part in parts
            if part.group == group
        ]
        kept.append("\n")
    return "".join(kept).replace("\0", "#")


def _first_line(text: str) -> str:
    """The first sentence of a section's prose."""
    prose = _CODE.sub("", text).strip().split("\n\n")[0]
    return " ".join(prose.split()) if not prose.startswith(("|", "-", "!")) else ""


@functools.cache
def _pages_of_parts(docs: Path) -> dict[tuple[str, str], str]:
    """The page of each part, by long page and anchor."""
    pages = {}
    for long_page in LONG_PAGES:
        for part in _parts((docs / f"{long_page}.md").read_text(encoding="utf-8")):
            pages[long_page, part.anchor] = part.page
    return pages


def links_to_parts(page: str, text: str, docs: Path) -> str:
    """A page's text with its links into the long pages leading to the pages of their parts."""
    pages = _pages_of_parts(docs)
    here = posixpath.dirname(page)

    def to_part(found: re.Match[str]) -> str:
        start, link, end = found.groups()
        target, _, anchor = link.partition("#")
        full = posixpath.normpath(posixpath.join(here, target)).removesuffix(".md") if target else page
        name = pages.get((full, anchor))
        if name is None:
            return found[0]
        return f"{start}{posixpath.relpath(f'{full}/{name}.md', here or '.')}{end}"

    return _LINK.sub(to_part, text)


def in_both_themes(page: str, text: str, docs: Path) -> str:
    """A page's text where each picture ``X.png`` with an ``X-dark.png`` beside it is the latter in the dark theme."""
    folder = (docs / page).parent

    def both(found: re.Match[str]) -> str:
        words, name = found.groups()
        if not (folder / f"{name}-dark.png").exists():
            return found[0]
        images = (("", "only-light"), ("-dark", "only-dark"))
        return "\n\n".join(
            f"```{{image}} {name}{end}.png\n:alt: {words}\n:class: {shown}\n```" for end, shown in images
        )

    return _PICTURE.sub(both, text)
