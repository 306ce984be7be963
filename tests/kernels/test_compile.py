"""The cache of compiled kernels goes stale with what a kernel reaches, and with nothing else."""

import importlib
import pkgutil
from pathlib import Path

import amorsim.kernels
from amorsim.kernels.folder import sources_of

HERE = Path(amorsim.kernels.__file__).parent
COMPILING = {"answers", "compile", "cache", "claims", "folder", "parts"}  # how a kernel is compiled and kept


def names(path):
    return {source.stem for source in sources_of(path)}


def test_a_kernel_hangs_on_itself_and_its_callees():
    assert names(HERE / "philox.py") == {"philox", "normals"} | COMPILING
    assert {"cones", "rays", "grid", "compile"} <= names(HERE / "cones.py")


def test_a_kernel_does_not_hang_on_its_callers():
    assert "cones" not in names(HERE / "rays.py")


def test_every_dispatcher_that_a_module_can_reach_is_among_its_sources():
    """What a compiled function may call are the dispatchers in its module's globals: their files must be known."""
    for found in pkgutil.iter_modules([str(HERE)]):
        module = importlib.import_module(f"amorsim.kernels.{found.name}")
        known = names(Path(module.__file__))
        for value in vars(module).values():
            if hasattr(value, "py_func"):
                assert value.py_func.__module__.rpartition(".")[2] in known


def test_a_kernel_of_a_plugin_hangs_on_its_own_file(tmp_path):
    own = tmp_path / "gust.py"
    own.write_text("from amorsim.kernels.philox import uniform\n")
    assert names(own) == {"gust", "philox", "normals"} | COMPILING


def test_an_import_of_the_whole_package_counts_as_all(tmp_path):
    own = tmp_path / "gust.py"
    own.write_text("from amorsim.kernels import philox\n")
    assert names(own) == {"gust"} | {path.stem for path in HERE.glob("*.py")}
