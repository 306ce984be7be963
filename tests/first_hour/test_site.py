"""What the website shows differently from the files in `docs`: a page for each component and each public name."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

from amorsim.labs import find_labs
from amorsim.plugins.manager import make_registry
from amorsim.plugins.registry import KINDS
from tests.first_hour.conftest import ROOT
from tests.first_hour.test_docs import _tool

site_pages = _tool("site_pages")
LINK = re.compile(r"\]\(([^)\s#]+\.md)(?:#[^)]*)?\)")


@pytest.fixture(scope="module")
def docs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the docs with the pages that the site adds."""
    copy = tmp_path_factory.mktemp("site") / "docs"
    shutil.copytree(ROOT / "docs", copy, ignore=shutil.ignore_patterns("pictures", "components", "python"))
    site_pages.make_parts(copy)
    return copy


def test_each_component_has_a_page(docs: Path) -> None:
    registry = make_registry(entry_points=[])
    names = [entry.name for kind in KINDS for entry in registry.entries(kind)]
    pages = {path.stem: path.read_text(encoding="utf-8") for path in (docs / "reference" / "components").glob("*.md")}
    assert len(pages) == len(names)  # two of one name are two pages
    for name in names:
        assert f"# `{name}`\n" in pages[name.replace("_", "-")]


def test_each_section_on_python_is_a_page(docs: Path) -> None:
    text = (docs / "reference" / "python.md").read_text(encoding="utf-8")
    titles = re.findall(r"^### (.+)$", text, re.MULTILINE)
    pages = [path.read_text(encoding="utf-8") for path in (docs / "reference" / "python").glob("*.md")]
    assert sorted(titles) == sorted(re.findall(r"^# (.+)$", "\n".join(page.split("\n\n")[1] for page in pages), re.M))


def test_pages_of_the_site_link_to_pages(docs: Path) -> None:
    for path in sorted(docs.rglob("*.md")):
        page = str(path.relative_to(docs).with_suffix(""))
        text = site_pages.links_to_parts(page, path.read_text(encoding="utf-8"), docs)
        text = site_pages.as_contents(page, site_pages.in_both_themes(page, text, docs))
        for link in LINK.findall(text):
            if not link.startswith("http"):
                assert (path.parent / link).resolve().exists(), f"{page}: {link}"
    # The link to a component leads to its own page.
    text = (docs / "how-to" / "come-from-another-simulator.md").read_text(encoding="utf-8")
    assert "components.md#laser" in text
    assert "../reference/components/laser.md" in site_pages.links_to_parts(
        "how-to/come-from-another-simulator", text, docs
    )


def test_a_picture_with_a_dark_one_beside_it_has_both(tmp_path: Path) -> None:
    for name in ("a.png", "a-dark.png", "b.png"):
        (tmp_path / name).touch()
    found = site_pages.in_both_themes("page", "Text.\n\n![A](a.png)\n\n![B](b.png)\n", tmp_path)
    assert "```{image} a.png\n:alt: A\n:class: only-light\n```" in found
    assert "```{image} a-dark.png\n:alt: A\n:class: only-dark\n```" in found
    assert "![B](b.png)" in found


def test_a_number_sign_in_code_is_no_heading() -> None:
    text = "# Page\n\n## Group\n\n### `a_b`\n\n```sh\n### not this\n```\n\n### `a_b`\n\nThe other one.\n"
    parts = list(site_pages._parts(text))
    assert [(part.group, part.anchor, part.page) for part in parts] == [
        ("Group", "a_b", "a-b"),
        ("Group", "a_b-1", "a-b-1"),
    ]
    assert "### not this" in parts[0].text


def test_what_is_left_of_earlier_pages_goes(docs: Path) -> None:
    old = docs / "reference" / "components" / "gone.md"
    old.write_text("# gone\n")
    site_pages.make_parts(docs)
    assert not old.exists()


def test_each_handout_plays_the_run_that_the_site_makes_of_its_lab() -> None:
    for lab in find_labs():
        page = f"labs/{lab.folder.name}/handout"
        text = (ROOT / "docs" / page).with_suffix(".md").read_text(encoding="utf-8")
        assert site_pages.as_contents(page, text).count(f'href="../../runs/lab-{lab.number:02d}.html#lecture"') == 1
