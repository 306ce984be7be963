"""The fence around a submission: bubblewrap, with Python and the submission's files inside, and nothing else.

It has namespaces of its own: it sees no process, network or user of the system, and no file but those bound here, which
it cannot change. What it writes is in memory, and gone when it ends.
"""

from __future__ import annotations

import importlib.metadata
import importlib.util
import shutil
import subprocess
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

import attrs

from amorsim.core.errors import StudyError
from amorsim.grading.handed_in import is_within
from amorsim.kernels.cache_folder import cache_folder
from amorsim.plugins.hooks import GROUP

__all__ = ["HOME", "TEMPORARY", "Fence", "find_fence"]

HOME = "/submission"
"""Where a submission starts, and its files are."""
TEMPORARY = "/tmp"

_ROOM = 256 * 2**20  # [bytes] of each folder in memory
_USER = "1000"  # within the fence
_SYSTEM = ("/usr", "/nix/store", "/gnu/store")
_LINKED = ("/bin", "/sbin", "/lib", "/lib32", "/lib64")  # into /usr, or folders of their own
_LOADER = ("/etc/ld.so.cache", "/etc/alternatives")
_PACKAGES = ("site-packages", "dist-packages")


@attrs.frozen
class Fence:
    """A fence that this system allows: bubblewrap's program and version, and the folders that can be read inside."""

    program: str
    version: str
    visible: tuple[Path, ...]

    def command(self, inner: Sequence[str], *options: str) -> list[str]:
        """The command that runs another one within the fence."""
        system: list[str] = []
        for link in map(Path, _LINKED):
            if link.is_symlink():
                system += ["--symlink", str(link.readlink()), str(link)]
            elif link.is_dir():
                system += ["--ro-bind", str(link), str(link)]
        for each in (*_LOADER, *map(str, self.visible)):
            system += ["--ro-bind-try", each, each]
        room: list[str] = []
        for folder in (TEMPORARY, HOME, "/dev/shm"):
            room += ["--size", str(_ROOM), "--tmpfs", folder]
        return [
            *(self.program, "--unshare-all", "--unshare-user", "--disable-userns", "--uid", _USER, "--gid", _USER),
            *("--die-with-parent", "--new-session", "--clearenv", "--cap-drop", "ALL"),
            *("--proc", "/proc", "--dev", "/dev"),
            *room,
            *system,  # last, for an environment of Python may lie among temporary files
            # Root would own the settings in /proc, and all could fill memory through the others.
            *("--remount-ro", "/proc", "--remount-ro", "/dev", "--remount-ro", "/"),
            *("--chdir", HOME),
            *options,
            "--",
            *inner,
        ]

    def path(self) -> list[str]:
        """Where Python finds modules within the fence."""
        return [each for each in sys.path if each and any(self._leads_to(Path(each), seen) for seen in self.visible)]

    @staticmethod
    def _leads_to(path: Path, seen: Path) -> bool:
        """Whether a folder of modules can be seen, or its packages `seen` can."""
        return is_within(path, seen) or seen.parent == path


def find_fence(private: Iterable[Path]) -> Fence:
    """A fence in which no private file can be read.

    Raises
    ------
    StudyError
        If bubblewrap is not installed, or the system does not allow it, or private files lie among Python's.
    """
    program = shutil.which("bwrap")
    if sys.platform != "linux":
        raise _no_fence("bubblewrap, which fences submissions in, is for Linux alone")
    if program is None:
        raise _no_fence("there is no bubblewrap to fence submissions in; install it (Debian: apt install bubblewrap)")
    visible = _visible()
    for each in private:
        for seen in visible:
            if is_within(each.resolve(), seen):
                raise StudyError(f"{each}: lies in {seen}, which submissions can read; move it elsewhere")
    fence = Fence(program, _said([program, "--version"]), visible)
    _said(fence.command([sys.executable, "-c", ""]))
    return fence


def is_fence_there() -> bool:
    """Whether submissions can be fenced in here."""
    try:
        find_fence([])
    except StudyError:
        return False
    return True


def _no_fence(problem: str) -> StudyError:
    return StudyError(f"{problem}. With --no-fence, a submission can read and change what you can")


def _said(command: Sequence[str]) -> str:
    """The output of a command."""
    ended = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, env={}, check=False)
    if ended.returncode:
        problem = (ended.stderr.strip().splitlines() or ["no message"])[-1]
        raise _no_fence(f"bubblewrap cannot fence submissions in here ({problem}); it must be 0.8 or later")
    return ended.stdout.strip()


def _visible() -> tuple[Path, ...]:
    """The folders of the system, of Python, of installed packages, and of compiled kernels, none within another."""
    found = [*_SYSTEM, sys.prefix, sys.base_prefix, sys.exec_prefix, sys.base_exec_prefix]
    found += [each for each in sys.path if Path(each).name in _PACKAGES]
    paths = [Path(each) for each in found]
    points = importlib.metadata.entry_points(group=GROUP)
    for name in sorted({GROUP, *(point.module.partition(".")[0] for point in points)}):  # installed as editable
        spec = importlib.util.find_spec(name)
        if spec is not None and spec.origin is not None:
            origin = Path(spec.origin)
            paths.append(origin.parent if spec.submodule_search_locations else origin)
    if (kernels := cache_folder()) is not None:
        paths.append(kernels)
    there = list(dict.fromkeys(each for path in paths for each in (path.absolute(), path.resolve()) if path.exists()))
    return tuple(each for each in there if not any(each != other and is_within(each, other) for other in there))
