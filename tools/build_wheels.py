"""Builds what a release publishes: amorsim's wheel and source distribution, and the wheel of its compiled kernels.

    python tools/build_wheels.py dist
    python tools/build_wheels.py dist kernels.zip

The kernels are compiled for x86-64-v3, which most machines have, in some four minutes on two cores, or for the
processor here where that is of another family; or they are those of an archive of `amorsim compile --archive`. Their
wheel asks for the very versions of amorsim and numba that made it.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import tomllib
from importlib import metadata
from pathlib import Path

from amorsim.kernels.archive import LEVEL, is_of_level

ROOT = Path(__file__).parents[1]
PROJECT = """\
[build-system]
requires = ["hatchling"]
build-backend = "hatchling.build"

[project]
name = "amorsim-kernels"
version = "{amorsim}"
description = "Compiled kernels for amorsim {amorsim}."
readme = "README.md"
requires-python = "=={python}.*"
license = "MIT"
dependencies = ["amorsim=={amorsim}", "numba=={numba}"]

[tool.hatch.build.hooks.custom]
tag = "{tag}"

[tool.hatch.build.targets.wheel]
packages = ["amorsim_kernels"]
artifacts = ["*.zip"]
"""


def main(target: Path, kernels: Path | None = None) -> None:
    """Build all three into a folder, with the kernels of an archive if there is one."""
    target = target.absolute()
    _build(ROOT, target)
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "source"
        shutil.copytree(ROOT / "tools" / "kernels_wheel", source)
        packed = source / "amorsim_kernels" / "kernels.zip"
        if kernels is None:
            _compile(packed, Path(folder) / "cache")
        else:
            shutil.copy(kernels, packed)
        version = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
        python = f"{sys.version_info.major}.{sys.version_info.minor}"
        project = PROJECT.format(amorsim=version, numba=metadata.version("numba"), python=python, tag=_tag())
        (source / "pyproject.toml").write_text(project, encoding="utf-8")
        _build(source, target, "--wheel")
    for file in sorted(target.iterdir()):
        sys.stdout.write(f"{file.name}: {file.stat().st_size / 1e6:.1f} MB\n")


def _tag() -> str:
    """The tag of the wheel of kernels: they fit where numba's own wheel does, for they are loaded by it."""
    wheel = metadata.distribution("numba").read_text("WHEEL") or ""
    platforms = [line.rpartition("-")[2] for line in wheel.splitlines() if line.startswith("Tag:")]
    if not platforms:
        raise SystemExit("numba was not installed from a wheel, so it is not known where its kernels fit")
    return f"cp{sys.version_info.major}{sys.version_info.minor}-none-{platforms[-1]}"


def _build(source: Path, target: Path, *options: str) -> None:
    subprocess.run([sys.executable, "-m", "build", "--outdir", target, *options, source], check=True, stdout=2)


def _compile(file: Path, cache: Path) -> None:
    """Compile all kernels into an archive."""
    processor = {"NUMBA_CPU_NAME": LEVEL, "NUMBA_CPU_FEATURES": ""} if is_of_level() else {}
    environment = os.environ | processor | {"NUMBA_CACHE_DIR": str(cache)}
    command = [sys.executable, "-m", "amorsim", "compile", "--quiet", "--archive", str(file)]
    subprocess.run(command, check=True, env=environment)


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:] or ["dist"]))
