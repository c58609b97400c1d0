"""Models and pictures that a world names are read in the guarded reader first, once per content."""

import os
import struct
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest

from mjsim.compile import compile_world
from mjsim.errors import UsageError, WorldError
from mjsim.exchange import write_sdf
from mjsim.models import content_notes, proven
from mjsim.sim.module_info import catalogue_of
from mjsim.world import Source, parse_world

PLATE = '<mujoco><worldbody><geom type="box" size="{} 1 1"/></worldbody></mujoco>'


@pytest.fixture(autouse=True)
def notes(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache/mjsim/read"


def png(color: int) -> bytes:
    return cv2.imencode(".png", np.full((8, 8, 3), color, np.uint8))[1].tobytes()


def world_with(folder, data: bytes, name: str = "a.png"):
    (folder / name).write_bytes(data)
    line = f"beacons: [{{name: a, image: {name}, at: [1, 2], width: 1}}]"
    if name.endswith(".xml"):
        line = f"obstacles: [{{model: {name}, at: [1, 2]}}]"
    return parse_world(f"mjsim: 1\n{line}\n", source=Source(folder=folder))


def test_a_picture_is_read_once_per_content(tmp_path, notes):
    world_with(tmp_path, png(10))
    assert len(list(notes.iterdir())) == 1
    world_with(tmp_path, png(10), "b.png")
    assert len(list(notes.iterdir())) == 1
    world_with(tmp_path, png(20))
    assert len(list(notes.iterdir())) == 2


def test_a_picture_is_read_again_by_other_code(tmp_path, notes, monkeypatch):
    world_with(tmp_path, png(10))
    monkeypatch.setattr(proven, "__file__", str(tmp_path / "another.py"))
    (tmp_path / "another.py").write_text("pass\n")
    proven._readers.cache_clear()
    try:
        world_with(tmp_path, png(10))
    finally:
        proven._readers.cache_clear()
    assert len(list(notes.iterdir())) == 2


def test_the_notes_of_the_user_are_not_those_of_the_tests(monkeypatch):
    monkeypatch.undo()
    assert not content_notes.folder().is_relative_to(Path.home())


def test_a_model_is_read_once_per_content(tmp_path, notes):
    for size, count in ((1, 1), (1, 1), (2, 2)):
        world_with(tmp_path, PLATE.format(size).encode(), "a.xml")
        assert len(list(notes.iterdir())) == count


def test_shipped_files_need_no_child(notes):
    parse_world("mjsim: 1\nbeacons: [{name: a, image: posters/lion.jpg, at: [1, 2], width: 1}]\n")
    parse_world("mjsim: 1\nobstacles: [{model: furniture/chair.xml, at: [1, 2]}]\n")
    assert not notes.exists()


def chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png_of(pixels: bytes) -> bytes:
    head = struct.pack(">IIBBBBB", 64, 64, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", pixels) + chunk(b"IEND", b"")


BROKEN = {
    "text": b"a letter",
    "empty": b"",
    "truncated": png(10)[:-20],
    "no pixels": png_of(b""),
    "few pixels": png_of(zlib.compress(bytes(100))),
    "noise": png_of(b"abcdefgh"),
}
NAMING = ("beacons: [{name: a, image: a.png, at: [1, 2]}]", "floor: {texture: a.png}")


@pytest.mark.parametrize("line", NAMING)
@pytest.mark.parametrize("data", BROKEN.values(), ids=BROKEN)
def test_a_picture_that_cannot_be_decoded_is_one_line_with_its_place(tmp_path, notes, line, data):
    (tmp_path / "a.png").write_bytes(data)
    for source in (Source(file="w.yaml", folder=tmp_path), Source(file="w.yaml", attached={"a.png": data})):
        with pytest.raises(WorldError) as caught:
            parse_world(f"mjsim: 1\n{line}\n", source=source)
        assert str(caught.value).startswith(f"w.yaml:2:{line.index('a.png') + 1}: 'a.png' is ")
        assert "\n" not in str(caught.value)
    assert not notes.exists()


@pytest.mark.parametrize("data", BROKEN.values(), ids=BROKEN)
def test_a_picture_that_breaks_after_its_world_was_loaded_is_named(tmp_path, data):
    world = world_with(tmp_path, png(40))
    (tmp_path / "a.png").write_bytes(data)
    for use in (compile_world, catalogue_of, lambda world: write_sdf(world, tmp_path / "a.sdf")):
        with pytest.raises(UsageError, match=r"^'a\.png' is "):
            use(world)


def test_what_ends_its_reader_is_one_line(monkeypatch):
    monkeypatch.setattr(proven, "TRIALS", "tests.guarded.decoders")
    with pytest.raises(ValueError, match=r"^cannot be read: its reader crashed \(SIGSEGV\); the file may be damaged$"):
        proven.require_readable("crash", content=[b"a"], about="a.png")


def test_a_cache_that_cannot_be_written_is_none(tmp_path):
    (tmp_path / "cache").write_text("a file")
    world_with(tmp_path, png(30))


def test_notes_are_bounded(tmp_path, notes, monkeypatch):
    monkeypatch.setattr(content_notes, "MAX_NOTES", 3)
    for color in range(5):
        world_with(tmp_path, png(color))
    assert len(list(notes.iterdir())) <= 3


def test_a_pipe_is_no_picture(tmp_path):
    os.mkfifo(tmp_path / "a.png")
    with pytest.raises(WorldError, match="no file"):
        parse_world(
            "mjsim: 1\nbeacons: [{name: a, image: a.png, at: [1, 2], width: 1}]\n", source=Source(folder=tmp_path)
        )
