"""Fetch what the window's scripts use of others', each with its licence, into ``amorsim/ui/web/vendor``.

``python tools/vendor_scripts.py`` asks the registry of npm, and refuses what is not bit by bit what is named here. To
take another version, change it with its ``integrity`` (``npm view NAME@VERSION dist.integrity``), and look at the
difference. What is fetched is kept in the repository: neither a user nor CI needs the registry.
"""

from __future__ import annotations

import base64
import hashlib
import io
import sys
import tarfile
import urllib.request
from pathlib import Path
from typing import NamedTuple

FOLDER = Path(__file__).parent.parent / "amorsim" / "ui" / "web" / "vendor"
ADDRESS = "https://registry.npmjs.org/{name}/-/{name}-{version}.tgz"


class Package(NamedTuple):
    """A package, and which of its files are kept."""

    name: str
    version: str
    integrity: str
    licence: str
    use: str
    files: tuple[str, ...]


PACKAGES = (
    Package(
        name="uplot",
        version="1.6.32",
        integrity="sha512-KIMVnG68zvu5XXUbC4LQEPnhwOxBuLyW1AHtpm6IKTXImkbLgkMy+jabjLgSLMasNuGGzQm/ep3tOkyTxpiQIw==",
        licence="MIT",
        use="plots",
        files=("LICENSE", "dist/uPlot.esm.js", "dist/uPlot.min.css"),
    ),
    Package(
        name="codemirror",
        version="5.65.18",
        integrity="sha512-Gaz4gHnkbHMGgahNt3CA5HBk5lLQBqmD/pBgeB4kQU6OedZmqMBjlRF0LSrp2tJ4wlLNPm2FfaUd1pDy0mdlpA==",
        licence="MIT",
        use="programs and TOML in the Editor; version 5 needs no build step",
        files=(
            "LICENSE",
            "lib/codemirror.js",
            "lib/codemirror.css",
            "mode/python/python.js",
            "mode/toml/toml.js",
            "addon/edit/matchbrackets.js",
        ),
    ),
)
README = """# Scripts of others

Fetched by `tools/vendor_scripts.py`, unchanged; each folder has its package's licence.

| package | version | licence | for |
|---|---|---|---|
"""


def fetch(package: Package) -> None:
    """Fetch a package and keep its files.

    Raises
    ------
    SystemExit
        If it is not what is named here.
    """
    with urllib.request.urlopen(ADDRESS.format(name=package.name, version=package.version)) as answer:
        data = answer.read()
    kind, _, wanted = package.integrity.partition("-")
    if base64.b64encode(hashlib.new(kind, data).digest()).decode() != wanted:
        sys.exit(f"{package.name} {package.version}: the registry gave something else than what is named here")
    folder = FOLDER / package.name
    folder.mkdir(parents=True, exist_ok=True)
    with tarfile.open(fileobj=io.BytesIO(data)) as archive:
        for name in package.files:
            file = archive.extractfile(f"package/{name}")
            assert file is not None
            (folder / Path(name).name).write_bytes(file.read())
    print(folder)


def main() -> None:
    """Fetch all, and list them."""
    for package in PACKAGES:
        fetch(package)
    lines = [f"| [{one.name}]({one.name}/LICENSE) | {one.version} | {one.licence} | {one.use} |\n" for one in PACKAGES]
    (FOLDER / "README.md").write_text(README + "".join(lines), encoding="utf-8")


if __name__ == "__main__":
    main()
