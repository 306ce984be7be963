"""How Sphinx makes the website from these pages: `python -m sphinx -W -b html docs site`."""

import importlib.metadata
import os
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "tools"))  # which are no package

import site_pages  # noqa: E402
import site_runs  # noqa: E402

project = "amorsim"
author = "the authors of amorsim"
release = version = importlib.metadata.version("amorsim")

extensions = ["myst_parser"]
myst_heading_anchors = 4
exclude_patterns = ["_site_static"]

html_theme = "furo"
html_title = "amorsim"
html_static_path = ["_site_static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sphinx = False
# With the address of the repository every page has a link to edit it.
if repository := os.environ.get("AMORSIM_REPOSITORY"):
    html_theme_options = {
        "source_repository": repository,
        "source_branch": "main",
        "source_directory": "docs/",
    }


def change_page(_, page, source):
    """Turn links, lists and pictures into what they are on the site."""
    text = site_pages.links_to_parts(page, source[0], HERE)
    text = site_pages.in_both_themes(page, text, HERE)
    source[0] = site_pages.as_contents(page, text)


def add_runs(app, exception):
    """Make the runs that the page of scenarios plays."""
    if exception is None and app.builder.name == "html":
        site_runs.make_runs(Path(app.outdir) / "runs")


def setup(app):
    """Make the pages of components and public names, change all pages as they are read, and add runs to play."""
    site_pages.make_parts(HERE)
    app.connect("source-read", change_page)
    app.connect("build-finished", add_runs)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
