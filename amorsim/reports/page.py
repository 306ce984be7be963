"""A page of HTML in one file: headings, tables, pictures; it loads nothing and runs no script."""

from __future__ import annotations

import base64
import html
import io
import re
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from PIL import Image

from amorsim.render.words import with_interval

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Page", "interval_cell"]

_STYLE = """
:root { color-scheme: light dark; --line: #d1d5db; --faint: #6b7280; --ground: #ffffff; --ink: #111827; }
@media (prefers-color-scheme: dark) { :root { --line: #374151; --faint: #9ca3af; --ground: #111827; --ink: #f3f4f6; } }
body { font: 15px/1.5 system-ui, sans-serif; max-width: 62rem; margin: 2rem auto; padding: 0 1rem;
  background: var(--ground); color: var(--ink); }
h1 { font-size: 1.5rem; margin-bottom: 0.2rem; }
h2 { font-size: 1.15rem; margin-top: 2rem; border-bottom: 1px solid var(--line); padding-bottom: 0.2rem; }
p.about, figcaption { color: var(--faint); }
.wide { overflow-x: auto; }
.whole { white-space: nowrap; }
table { border-collapse: collapse; font-size: 0.9rem; }
th, td { padding: 0.25rem 0.7rem; border-bottom: 1px solid var(--line); text-align: right; vertical-align: top; }
th:first-child, td:first-child { text-align: left; }
table.facts td { text-align: left; overflow-wrap: anywhere; }
figure { margin: 1rem 0; }
img { max-width: 100%; height: auto; background: #ffffff; border-radius: 4px; }
pre { background: rgba(127, 127, 127, 0.12); padding: 0.7rem; border-radius: 4px; overflow-x: auto; font-size: 0.8rem; }
code { font-size: 0.9em; }
@media (max-width: 40rem) { table { font-size: 0.75rem; } th, td { padding: 0.2rem 0.3rem; } }
@media print { .wide { overflow: visible; } table { font-size: 0.7rem; } }
""".strip()
_POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"
_WIDEST = 1400  # [pixels]


class Page:
    """Collects the parts of a page, in order; `text` is the whole."""

    def __init__(self, title: str, about: str = "") -> None:
        self._title = title
        self._parts = [f"<h1>{_words(title)}</h1>"]
        if about:
            self._parts.append(f'<p class="about">{html.escape(about)}</p>')

    def heading(self, text: str) -> None:
        """Begin a section."""
        self._parts.append(f"<h2>{html.escape(text)}</h2>")

    def paragraph(self, text: str) -> None:
        """Add a paragraph."""
        self._parts.append(f"<p>{_words(text)}</p>")

    def facts(self, facts: Iterable[tuple[str, object]]) -> None:
        """Add a table of names and values."""
        rows = "".join(
            f'<tr><th scope="row">{_words(name)}</th><td>{html.escape(str(value))}</td></tr>' for name, value in facts
        )
        self._parts.append(f'<div class="wide"><table class="facts"><tbody>{rows}</tbody></table></div>')

    def table(self, head: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
        """Add a table."""
        top = "".join(f'<th scope="col">{_words(cell)}</th>' for cell in head)
        body = "".join(f"<tr>{''.join(f'<td>{_words(cell)}</td>' for cell in row)}</tr>" for row in rows)
        self._parts.append(f'<div class="wide"><table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table></div>')

    def picture(self, data: bytes, caption: str) -> None:
        """Add a PNG."""
        image = Image.open(io.BytesIO(data))
        if image.width > _WIDEST:
            made = io.BytesIO()
            size = (_WIDEST, max(1, round(image.height * _WIDEST / image.width)))
            image.convert("RGB").resize(size, Image.Resampling.LANCZOS).save(made, "PNG", optimize=True)
            data = made.getvalue()
        coded = base64.b64encode(data).decode("ascii")
        text = html.escape(caption)
        self._parts.append(
            f'<figure><img src="data:image/png;base64,{coded}" alt="{text}"><figcaption>{text}</figcaption></figure>'
        )

    def figure(self, figure: Figure, caption: str) -> None:
        """Add a figure of matplotlib."""
        drawn = io.BytesIO()
        figure.savefig(drawn, format="png", dpi=90, metadata={"Software": None})
        self.picture(drawn.getvalue(), caption)

    def listing(self, title: str, text: str) -> None:
        """Add a text that is folded away."""
        self._parts.append(f"<details><summary>{html.escape(title)}</summary><pre>{html.escape(text)}</pre></details>")

    def command(self, text: str) -> None:
        """Add a command to type."""
        self._parts.append(f"<pre><code>{html.escape(text)}</code></pre>")

    @property
    def text(self) -> str:
        """The page."""
        return (
            '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
            f"<title>{html.escape(self._title)}</title>\n"
            '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
            f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">\n<style>\n{_STYLE}\n</style>\n</head>\n'
            "<body>\n<main>\n" + "\n".join(self._parts) + "\n</main>\n</body>\n</html>\n"
        )


def _words(text: str) -> str:
    """A text in HTML: a long word, such as the path of an axis, may be broken after a dot, and an interval may not."""
    breakable = re.sub(r"\S{25,}", lambda word: re.sub(r"([._/](?!$))", r"\1<wbr>", word[0]), html.escape(text))
    return re.sub(r"\[\S+, \S+\]", r'<span class="whole">\g<0></span>', breakable)


def interval_cell(value: float, low: float, high: float) -> str:
    """A value with its interval, rounded to the places that it allows: ``0.030 [0.025, 0.036]``."""
    mean, first, last = with_interval(value, low, high)
    return f"{mean} [{first}, {last}]" if low < high else mean
