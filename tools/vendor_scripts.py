"""Fetch what the window's scripts use of others', each with its licence, into ``amorsim/ui/web/vendor``.

``python tools/vendor_scripts.py`` asks the registry of npm, and refuses what is not bit by bit what is named here. To
take another version, change it with its ``integrity`` (``npm view NAME@VERSION dist.integrity``), and look at the
difference. What is fetched is kept in the repository: neither a user nor CI needs the registry.
"""

from __future__ import annotations

import base64
import hashlib
import io
import json
import shutil
import subprocess
import sys
import tarfile
import tempfile
import urllib.request
from pathlib import Path
from typing import NamedTuple

FOLDER = Path(__file__).parent.parent / "amorsim" / "ui" / "web" / "vendor"
ADDRESS = "https://registry.npmjs.org/{name}/-/{file}-{version}.tgz"


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
)
CODE_PACKAGES = (
    (
        "@codemirror/autocomplete",
        "6.20.4",
        "sha512-yF8RhOf2SXlg00+qtupzLhrglcas61boqaONiNcbPIebHCpJocpqTBA6dyrtUrQO47hqyTdeob/3XnYilT7TaQ==",
    ),
    (
        "@codemirror/commands",
        "6.11.1",
        "sha512-O/4hG3SC1YwcmQ0d2UVNDs+AsaNWd1iHVxbTeEBuqH+6bExAiPK3iS/BvpY6rZGURALv4ZD3sIgcCmRvw3ehBg==",
    ),
    (
        "@codemirror/lang-python",
        "6.2.1",
        "sha512-IRjC8RUBhn9mGR9ywecNhB51yePWCGgvHfY1lWN/Mrp3cKuHr0isDKia+9HnvhiWNnMpbGhWrkhuWOc09exRyw==",
    ),
    (
        "@codemirror/language",
        "6.13.1",
        "sha512-zfvU2r3TyylQLMj/te+5CnQ0rSqZi8B1oTCBbQkagcLW4Xc6imab6qN+pEJhsuNOLaJqiRyBXp9UhWA1DhVvDw==",
    ),
    (
        "@codemirror/legacy-modes",
        "6.5.5",
        "sha512-9ltT214oMb3Y1w5eAZMSigzrjzZnMI2Wa3Feq73rU/i4C56MkwrpfswfQYOr28C5pXr6dWwspNTMyeHXlzWMxg==",
    ),
    (
        "@codemirror/state",
        "6.7.6",
        "sha512-kAz+AncRtKuIknedxT1bq4XwXv4UowhbkHU1myPrtVb/jZtImWuV5BXzv5vK6i3kYACsdiZiQKFQQ5Mq7elW8w==",
    ),
    (
        "@codemirror/streamparser",
        "6.0.0",
        "sha512-JTFPF6xrfjt0mnfGPgzcLiMwYmvIyNaoizp8BYzv8FE8KrT6GBGDZ190rtt+O7Wke3gG/MFHyiY9YGNeimof4w==",
    ),
    (
        "@codemirror/view",
        "6.43.15",
        "sha512-HHsfpqFeHyXLs983pSRe38Xajs0vFWZQ2BuX0m7Ki8w3jZ5iD8cuR3lBz2/5/X53Dhf32SBHKh6rtSTB6tKeGw==",
    ),
    (
        "@lezer/common",
        "1.5.5",
        "sha512-Pw7PVCndruF1pb3ebCxpSVpkMHSDjwRCLcTRw+RizUKco5QbWylwq2g4lnG/RYN7yTTQDXE9F77MwtkAyphrjg==",
    ),
    (
        "@lezer/highlight",
        "1.2.5",
        "sha512-O1GMVKgtf5YspFaRzpmqkVgMtIk2HG9uMAbH6wdAIdNh3TVzCsch/+cRi+6l2//UGDKe6NB9BW3cvuR5ezMQ0w==",
    ),
    (
        "@lezer/lr",
        "1.4.12",
        "sha512-On9HU4oMMiHPMkQDgoTnGahjgG5n/MkN38CgG77sMraKLL+3JBbeQNi1FcCXV9QRqwF9/BUXP3caHyJC1fBOTQ==",
    ),
    (
        "@lezer/python",
        "1.1.19",
        "sha512-MhQIURHRytsNzP/YXnqpYKW6la6voAH3kyplTOOiCdjyFY6cWWGFVmYVdHIPrElqSDf4iCDktQCockB9FxuhzQ==",
    ),
    (
        "@marijn/find-cluster-break",
        "1.0.4",
        "sha512-Wy0V7+SGUjnF9/TkiM1hKVDPj7jKXduPNboMVtHTA8dySMURWqfg/JZ9E2Sq8JgSJmkl7k7Qe9FLeMSrSraWmQ==",
    ),
    (
        "crelt",
        "1.0.7",
        "sha512-aK6BbWfhf4U/wCcLHKPJl/xa6VkVstRaPywWtMKGwuOLc/wZTyQYuoxgvZnNsBvv7Kg3YTBQYYBCggcviQczuA==",
    ),
    (
        "style-mod",
        "4.1.5",
        "sha512-WQ2llCZa9sZSkJA+aOwpg5DkfbAXFKGh//t3MRTBeruFiSBC+GXUmbBzrw3bXyboCWAbtCW9InDfBsXrRD/rAg==",
    ),
    (
        "w3c-keyname",
        "2.2.8",
        "sha512-dpojBhNsCNN7T82Tm7k26A6G9ML3NkhDsnw9n/eoxSRlVBB4CEtIQ/KTCLI2Fwf3ataSXRhYFkQi3SlnFwPvPQ==",
    ),
)
"""The packages of CodeMirror, each with version and integrity; all are MIT and of one author."""
CODE_MODULES = {
    "@codemirror/legacy-modes/mode/toml": "@codemirror/legacy-modes/mode/toml.js",
    "@marijn/find-cluster-break": "@marijn/find-cluster-break/src/index.js",
    "crelt": "crelt/index.js",
    "style-mod": "style-mod/src/style-mod.js",
    "w3c-keyname": "w3c-keyname/index.js",
}
"""The file of each module that is not a package's ``dist/index.js``."""
CODE_EXPORTS = """
export { acceptCompletion, autocompletion } from "@codemirror/autocomplete";
export { defaultKeymap, history, historyKeymap, indentWithTab } from "@codemirror/commands";
export { python } from "@codemirror/lang-python";
export { bracketMatching, HighlightStyle, indentUnit, StreamLanguage, syntaxHighlighting } from "@codemirror/language";
export { toml } from "@codemirror/legacy-modes/mode/toml";
export { EditorState, StateEffect, StateField } from "@codemirror/state";
export { Decoration, EditorView, keymap, lineNumbers, WidgetType } from "@codemirror/view";
export { tags } from "@lezer/highlight";
"""
README = """# Scripts of others

Fetched by `tools/vendor_scripts.py`: uPlot unchanged, CodeMirror's packages bundled into one file. Each folder has the
licence.

| package | version | licence | for |
|---|---|---|---|
"""


def download(name: str, version: str, integrity: str) -> tarfile.TarFile:
    """A package's files.

    Raises
    ------
    SystemExit
        If it is not what is named here.
    """
    address = ADDRESS.format(name=name, file=name.rpartition("/")[2], version=version)
    with urllib.request.urlopen(address) as answer:
        data = answer.read()
    kind, _, wanted = integrity.partition("-")
    if base64.b64encode(hashlib.new(kind, data).digest()).decode() != wanted:
        sys.exit(f"{name} {version}: the registry gave something else than what is named here")
    return tarfile.open(fileobj=io.BytesIO(data))


def fetch(package: Package) -> None:
    """Fetch a package and keep its files."""
    folder = FOLDER / package.name
    folder.mkdir(parents=True, exist_ok=True)
    with download(package.name, package.version, package.integrity) as archive:
        for name in package.files:
            file = archive.extractfile(f"package/{name}")
            assert file is not None
            (folder / Path(name).name).write_bytes(file.read())
    print(folder)


def bundle_code() -> None:
    """Bundle CodeMirror's packages into one module, with `deno bundle`, which fetches its bundler."""
    folder = FOLDER / "codemirror"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    with tempfile.TemporaryDirectory() as at:
        work = Path(at)
        imports = {}
        for name, version, integrity in CODE_PACKAGES:
            with download(name, version, integrity) as archive:
                archive.extractall(work / name, filter="data")
            imports[name] = f"./{name}/package/dist/index.js"
        for name, file in CODE_MODULES.items():
            package = next(one for one, _, _ in CODE_PACKAGES if file.startswith(f"{one}/"))
            imports[name] = f"./{package}/package{file.removeprefix(package)}"
        (work / "deno.json").write_text(json.dumps({"imports": imports}))
        (work / "code.js").write_text(CODE_EXPORTS)
        made = work / "codemirror.js"
        command = ["deno", "bundle", "--platform", "browser", "--minify", "--output", str(made), "code.js"]
        subprocess.run(command, cwd=work, check=True)
        (folder / "codemirror.js").write_text(
            f"// CodeMirror 6, bundled by tools/vendor_scripts.py\n{made.read_text()}"
        )
        licences = dict.fromkeys((work / name / "package/LICENSE").read_text().strip() for name, _, _ in CODE_PACKAGES)
        (folder / "LICENSE").write_text("\n\n---\n\n".join(licences) + "\n")
    print(folder)


def main() -> None:
    """Fetch all, and list them."""
    for package in PACKAGES:
        fetch(package)
    bundle_code()
    lines = [f"| [{one.name}]({one.name}/LICENSE) | {one.version} | {one.licence} | {one.use} |\n" for one in PACKAGES]
    version = next(version for name, version, _ in CODE_PACKAGES if name == "@codemirror/view")
    lines.append(f"| [codemirror](codemirror/LICENSE) | view {version} | MIT | programs and TOML in the Editor |\n")
    (FOLDER / "README.md").write_text(README + "".join(lines), encoding="utf-8")


if __name__ == "__main__":
    main()
