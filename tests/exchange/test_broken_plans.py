"""Fifty broken drawings and maps: each is refused in one line that names the file and says what is wrong."""

import struct
import zlib
from pathlib import Path

import ezdxf
import numpy as np
import pytest
from PIL import Image

from mjsim.errors import UsageError
from mjsim.exchange import Reading, bring_file
from mjsim.exchange.import_world import bring_drawing, bring_map
from mjsim.exchange.maps.grid_files import read_grid
from mjsim.exchange.maps.maps import world_from_grid
from mjsim.exchange.start_place import with_robot
from mjsim.geometry import Pose
from mjsim.world import Grid

PLANS = Path(__file__).parents[1] / "data" / "plans"
SVG = '<svg xmlns="http://www.w3.org/2000/svg">{}</svg>'
DXF = "0\nSECTION\n2\nENTITIES\n{}0\nENDSEC\n0\nEOF\n"
LINE = "0\nLINE\n8\nWALLS\n10\n{}\n20\n0.0\n11\n{}\n21\n0.0\n"
PGM = b"P5\n4 4\n255\n" + bytes(16)
MAP = "image: map.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n"

DRAWINGS = {
    "empty.svg": b"",
    "text.svg": b"this is no drawing",
    "cut.svg": (PLANS / "inkscape.svg").read_bytes()[:1500],
    "html.svg": b"<html><body/></html>",
    "zip.svg": b"PK\x03\x04" + bytes(200),
    "nothing.svg": SVG.format("").encode(),
    "words.svg": SVG.format("<text>wall</text>").encode(),
    "path.svg": SVG.format('<path d="M0 0 L nowhere"/>').encode(),
    "nan.svg": SVG.format('<line x1="nan" y1="0" x2="1" y2="0" stroke="red"/>').encode(),
    "point.svg": SVG.format('<path d="M1 1 L1 1" stroke="red"/>').encode(),
    "entity.svg": b'<!DOCTYPE svg [<!ENTITY a "b">]>' + SVG.format("&a;").encode(),
    "utf.svg": b'<?xml version="1.0" encoding="UTF-99"?>' + SVG.format("").encode(),
    "empty.dxf": b"",
    "text.dxf": b"this is no drawing",
    "zero.dxf": bytes(500),
    "dwg.dxf": b"AC1032" + bytes(500),
    "cut.dxf": (PLANS / "office.dxf").read_bytes()[:400],
    "odd.dxf": (PLANS / "office.dxf").read_bytes().replace(b"\nSECTION\n", b"\nSEKTION\n"),
    "nothing.dxf": DXF.format("").encode(),
    "text-only.dxf": DXF.format("0\nTEXT\n8\n0\n10\n0\n20\n0\n40\n1\n1\nwall\n").encode(),
    "huge.dxf": DXF.format(LINE.format("0.0", "1e12")).encode(),
    "infinite.dxf": DXF.format(LINE.format("0.0", "1e308")).encode(),
    "arc.svg": SVG.format('<path stroke="red" d="M0 0 A3 3 0 0 1 0 0"/><polygon points="1,2,3"/>').encode(),
    "skew.svg": SVG.format('<g transform="skewX(1e308)"><path stroke="red" d="M0 0H5V5"/></g>').encode(),
    "binary.dxf": b"AutoCAD Binary DXF\r\n\x1a\x00" + bytes(500),
    "control.dxf": b"\x1c\x85\x0b\x17\n" * 50,
    "dot.dxf": DXF.format(LINE.format("0.0", "0.0")).encode(),
}
MAPS = {
    "no-picture": (MAP.replace("map.pgm", "gone.pgm"), PGM),
    "no-resolution": ("image: map.pgm\n", PGM),
    "no-yaml": ("image: [", PGM),
    "cut-picture": (MAP, PGM[:-5]),
    "text-picture": (MAP, b"nothing"),
    "origin": (MAP.replace("[0, 0, 0]", "[0, .inf, 0]"), PGM),
    "mode": (MAP + "mode: fancy\n", PGM),
    "outside": (MAP.replace("map.pgm", "../map.pgm"), PGM),
    "negative": (MAP.replace("0.05", "-0.05"), PGM),
    "empty": ("", PGM),
    "list": ("- image: map.pgm\n", PGM),
    "huge-picture": (MAP, b"P5\n99999999 99999999\n255\n"),
    "blank": (MAP, b"P5\n4 4\n255\n" + bytes([254] * 16)),
    "thresholds": (MAP + "occupied_thresh: 0.1\nfree_thresh: 0.9\n", PGM),
}


@pytest.mark.parametrize("name", DRAWINGS)
def test_a_broken_drawing_is_refused_in_one_line(name, tmp_path, capfd):
    path = tmp_path / name
    path.write_bytes(DRAWINGS[name])
    with pytest.raises(UsageError) as caught:
        bring_file(path, robot=None, reading=Reading(scale=1.0))
    assert "\n" not in str(caught.value)
    assert name in str(caught.value)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("name", MAPS)
def test_a_broken_map_is_refused_in_one_line(name, tmp_path):
    text, picture = MAPS[name]
    (tmp_path / "map.yaml").write_text(text)
    (tmp_path / "map.pgm").write_bytes(picture)
    with pytest.raises(UsageError) as caught:
        bring_map(tmp_path / "map.yaml", robot=None)
    assert "\n" not in str(caught.value)


def png(raw: bytes, *, packed: bytes | None = None, more: bytes = b"", size: int = 40) -> bytes:
    """Return a gray PNG of a size, from its rows, each with a byte for its filter before it."""
    data = zlib.compress(raw) if packed is None else packed
    chunks = (
        (b"IHDR", struct.pack(">IIBBBBB", size, size, 8, 0, 0, 0, 0)),
        (b"zTXt", more),
        (b"IDAT", data),
        (b"IEND", b""),
    )
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body)) for kind, body in chunks
    )


ROWS = bytes(41 * 40)
PNGS = {
    "few rows": png(ROWS[:-41]),
    "cut data": png(ROWS, packed=zlib.compress(ROWS)[:-8]),
    "no data": png(ROWS, packed=b""),
    "noise": png(ROWS, packed=bytes(range(200))),
    "sum": png(ROWS)[:-20] + b"wrong" + png(ROWS)[-15:],
    "cut file": png(ROWS)[:-10],
}


@pytest.mark.parametrize("name", PNGS)
def test_a_damaged_png_is_refused_in_one_line_and_the_decoder_is_silent(name, tmp_path, capfd):
    (tmp_path / "map.png").write_bytes(PNGS[name])
    with pytest.raises(UsageError, match=r"is a (damaged|truncated) PNG picture; save it again$"):
        read_grid(tmp_path / "map.png", resolution=0.05)
    assert capfd.readouterr() == ("", "")


def test_a_png_is_read_whatever_lies_beside_its_picture(tmp_path, capfd):
    (tmp_path / "map.png").write_bytes(png(ROWS, more=b"a\0\0" + zlib.compress(bytes(1_000_000))))
    assert read_grid(tmp_path / "map.png", resolution=0.05).occupied.all()
    picture = np.random.default_rng(1).integers(0, 2, (37, 53), dtype=np.uint8)
    for number, mode in enumerate(("L", "1", "P", "LA", "RGBA", "I;16")):
        image = Image.fromarray(picture * 255)
        image = Image.fromarray(picture.astype(np.uint16) * 65535) if mode == "I;16" else image.convert(mode)
        image.save(tmp_path / f"{number}.png")
        grid = read_grid(tmp_path / f"{number}.png", resolution=0.05)
        assert (grid.occupied[::-1] == (picture == 0)).all()
    assert capfd.readouterr() == ("", "")


def test_an_all_black_picture_is_refused_as_a_map():
    occupied = np.ones((2500, 2500), dtype=bool)
    with pytest.raises(UsageError, match=r"the map has 6250000 occupied cells; .* has at most 6000000"):
        world_from_grid(Grid(occupied, ~occupied, 0.05, Pose(0.0, 0.0, 0.0)))


def test_shapes_that_cannot_be_read_are_left_out_and_counted(tmp_path):
    room = '<path d="M0 0H6V4H0z" fill="none" stroke="#000"/>'
    odd = '<path stroke="red" d="M0 0 A3 3 0 0 1 0 0"/>'
    (tmp_path / "room.svg").write_text(SVG.format(room + odd))
    brought = bring_drawing(tmp_path / "room.svg", robot=None, reading=Reading(scale=1.0))
    assert any("left out: 1 shape that cannot be read" in line for line in brought.report)
    document = ezdxf.new(units=6)
    space = document.modelspace()
    space.add_lwpolyline([(0, 0), (6, 0), (6, 4), (0, 4)], close=True)
    space.add_lwpolyline([(0, 0, 1e300), (5, 0, -1e300), (5, 5, 0)], format="xyb")
    document.saveas(tmp_path / "room.dxf", fmt="bin")
    brought = bring_drawing(tmp_path / "room.dxf", robot=None, reading=Reading())
    assert any("left out: 1 LWPOLYLINE that cannot be read" in line for line in brought.report)


def test_repaired_faults_of_a_drawing_are_counted_not_printed(tmp_path, capfd):
    path = tmp_path / "house.dxf"
    path.write_bytes((PLANS / "house.dxf").read_bytes().replace(b"\n0.0\n", b"\n0.(\n", 1))
    brought = bring_drawing(path, robot=None, reading=Reading())
    assert any(line.startswith("mended: ") and "faults of the file" in line for line in brought.report)
    assert capfd.readouterr() == ("", "")


@pytest.mark.slow
def test_specks_of_a_map_do_not_stand_in_the_way_of_its_robot():
    occupied = np.zeros((400, 500), dtype=bool)
    occupied[::399], occupied[:, ::499] = True, True
    free = ~occupied
    free[np.random.default_rng(1).random(free.shape) < 0.002] = False
    grid = Grid(occupied, free, 0.02, Pose(0.0, 0.0, 0.0))
    world = with_robot(world_from_grid(grid), preset="turtlebot3_burger", grid=grid)
    way = np.array(world.run.drivers["scout"].navigator.model_dump()["points"])
    assert np.hypot(*np.diff(way, axis=0).T).sum() > 10.0
