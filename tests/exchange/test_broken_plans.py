"""Thirty broken drawings and maps: each is refused in one line that names the file and says what is wrong."""

from pathlib import Path

import numpy as np
import pytest

from mjsim.errors import UsageError
from mjsim.exchange.bring import Reading, bring_drawing, bring_map
from mjsim.exchange.maps import world_from_grid
from mjsim.exchange.place import with_robot
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
    "thresholds": (MAP + "occupied_thresh: 0.1\nfree_thresh: 0.9\n", PGM),
}


@pytest.mark.parametrize("name", DRAWINGS)
def test_a_broken_drawing_is_refused_in_one_line(name, tmp_path, capfd):
    path = tmp_path / name
    path.write_bytes(DRAWINGS[name])
    with pytest.raises(UsageError) as caught:
        bring_drawing(path, robot=None, reading=Reading(scale=1.0))
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


def test_faults_of_a_drawing_that_were_mended_are_counted_not_printed(tmp_path, capfd):
    path = tmp_path / "house.dxf"
    path.write_bytes((PLANS / "house.dxf").read_bytes().replace(b"\n0.0\n", b"\n0.(\n", 1))
    brought = bring_drawing(path, robot=None, reading=Reading())
    assert any("faults of the file were mended" in line for line in brought.report)
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
