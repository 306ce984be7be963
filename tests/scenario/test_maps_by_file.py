"""Maps from files: which loader reads one, its options, and what is said when none can."""

import os
import pickle
import sys
from typing import ClassVar

import attrs
import pytest

from amorsim.contracts import MapLoader, parameter
from amorsim.core.errors import MapError
from amorsim.core.maps.map import Map
from amorsim.maps.bmp import Bitmap
from amorsim.maps.wld import Wld
from amorsim.plugins.manager import make_registry
from amorsim.scenario.files.maps import MapFile, find_loader, load_map


@attrs.frozen(kw_only=True)
class Boxes(MapLoader):
    """Maps of one empty box; files begin with BOX."""

    extensions: ClassVar[tuple[str, ...]] = (".box", ".wld")
    side: float = parameter(unit="m", gt=0, help="of the box")

    @classmethod
    def sniff(cls, head):
        return head.startswith(b"BOX")

    def load(self, path):
        text = path.read_text()
        if "crash" in text:
            raise ZeroDivisionError("oh")
        return (
            "no map"
            if "nothing" in text
            else Map.from_segments([], extent=(0, 0, self.side, self.side), resolution=0.1)
        )


@pytest.fixture
def boxes():
    registry = make_registry(entry_points=(), disabled="")
    registry.map_loader("boxes", Boxes)
    return registry


def test_the_extension_tells_whatever_its_case(registry, folder, tmp_path):
    path = tmp_path / "ROOM.WLD"
    path.write_bytes((folder / "room.wld").read_bytes())
    assert load_map(path, registry=registry, resolution=0.05).size == (4.0, 3.0)
    assert load_map(str(path), registry=registry).grid.resolution == 0.001


def test_where_the_extension_does_not_tell_the_first_bytes_do(registry, folder, tmp_path):
    path = tmp_path / "room"
    path.write_bytes((folder / "room.wld").read_bytes())
    assert find_loader(path, None, registry) == ("wld", Wld)


def test_where_two_claim_an_extension_the_first_bytes_decide(boxes, folder, tmp_path):
    path = tmp_path / "one.wld"
    path.write_text("BOX")
    assert find_loader(path, None, boxes) == ("boxes", Boxes)
    assert find_loader(folder / "room.wld", None, boxes) == ("wld", Wld)
    assert find_loader(path, "bmp", boxes) == ("bmp", Bitmap)


@pytest.mark.parametrize(
    ("name", "options", "words"),
    [
        ("none.wld", {}, "none.wld: there is no such file; check its name and its folder$"),
        ("office.wld", {}, r"The scenario 'demo' has one of this name: amorsim convert demo office\.wld$"),
        ("maze", {}, r"The scenario '\S*maze' has one of this name: amorsim convert \S*maze maze\.wld$"),
        (".", {}, "a folder; a map is a file"),
        ("what.dwg", {}, r"a DWG drawing is not a map that amorsim reads; save it as \.dxf$"),
        ("what.map.scen", {}, r"problems on a map of MovingAI .*; give the \.map$"),
        ("what.SVGZ", {}, r"a compressed drawing is not a map that amorsim reads; unpack it to a plain \.svg$"),
        ("what.xyz", {}, r"no map of a known format; known extensions: \.bmp, \.box, .*\.png, .*\.wld"),
        ("room.wld", {"resolutoin": 1.0}, r"'wld' has no option 'resolutoin'; .*[Dd]id you mean 'resolution'\?"),
        ("room.wld", {"resolution": "fine"}, r"option resolution: expected a number \[m\] > 0, got 'fine'"),
        ("room.wld", {"use": "wdl"}, r"no map loader 'wdl'.*Did you mean 'wld'\?"),
        ("a.box", {}, "side"),
        ("crash.box", {"side": 1.0}, "crash.box: Boxes failed with ZeroDivisionError: oh"),
        ("nothing.box", {"side": 1.0}, "Boxes gave 'no map', which is not a map"),
    ],
)
def test_what_is_wrong_is_said(boxes, folder, name, options, words):
    for other in ("xyz", "dwg", "map.scen", "SVGZ"):
        (folder / f"what.{other}").write_bytes(b"\x01\x02\x03")
    for box in ("a", "crash", "nothing"):
        (folder / f"{box}.box").write_text(f"BOX {box}")
    with pytest.raises(MapError, match=words):
        load_map(folder / name, registry=boxes, **options)


@pytest.mark.skipif(sys.platform == "win32" or not hasattr(os, "geteuid"), reason="POSIX permissions")
def test_a_file_that_may_not_be_read(registry, folder, monkeypatch):
    path = folder / "secret.wld"
    path.write_text("width 1000\nheight 1000\n")
    if os.geteuid() == 0:  # root reads everything, so the refusal is played
        real = type(path).open

        def refused(self, *args, **options):
            if self == path:
                raise PermissionError(13, "Permission denied")
            return real(self, *args, **options)

        monkeypatch.setattr(type(path), "open", refused)
    else:
        path.chmod(0)
    with pytest.raises(MapError, match=r"secret\.wld: no permission to read this file"):
        load_map(path, registry=registry)


def test_a_map_knows_its_file_and_options(registry, folder):
    found = load_map(folder / "room.wld", registry=registry, resolution=0.25)
    assert found.source == MapFile(path=folder / "room.wld", loader=Wld(resolution=0.25))
    assert Map.from_segments([], extent=(0, 0, 1, 1), resolution=0.1).source is None
    assert pickle.loads(pickle.dumps(found)).source == found.source


def test_equal_maps_from_two_files_each_keep_their_own(registry, folder, tmp_path):
    path = tmp_path / "same.wld"
    path.write_bytes((folder / "room.wld").read_bytes())
    first = load_map(folder / "room.wld", registry=registry, resolution=0.25)
    second = load_map(path, registry=registry, resolution=0.25)
    assert first.source.path == folder / "room.wld"
    assert second.source.path == path
