"""Malformed worlds: each is refused in one line a fault, with its place, quickly, and nothing is written."""

import contextlib
import io
import json
import re
import struct
import time
import zlib

import pytest

from mjsim.errors import WorldError
from mjsim.modules import load_runnable
from mjsim.world import World, parse_world
from mjsim.world.ground import pydantic_words
from tests.world.malformed import TEXTS

LIMIT = 2.0
"""No malformed file may take longer [s]."""


def png(width, height, *, end=True):
    """Return the bytes of a grey PNG whose pixels are not there, which only its head tells."""

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + head + (chunk(b"IEND", b"") if end else b"")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    top = tmp_path_factory.mktemp("malformed")
    (top / "outside").mkdir()
    (top / "outside" / "secret.png").write_bytes(png(1, 1))
    place = top / "worlds"
    place.mkdir()
    (place / "link").symlink_to(top / "outside")
    (place / "short.png").write_bytes(png(3, 3, end=False))
    (place / "huge.png").write_bytes(png(50_000, 50_000))
    return place


def refused(path):
    """Return the lines that a malformed file gives, within the time limit."""
    begun = time.process_time()
    with pytest.raises(WorldError) as caught:
        load_runnable(path)
    assert time.process_time() - begun < LIMIT
    assert caught.value.exit_code == 2
    lines = str(caught.value).splitlines()
    assert all(re.match(rf"{re.escape(str(path))}:\d+:\d+: \S", line) for line in lines)
    return [line.removeprefix(f"{path}:") for line in lines]


@pytest.mark.parametrize(("text", "first"), TEXTS.values(), ids=TEXTS.keys())
def test_a_malformed_text_is_refused_with_its_place(folder, text, first):
    path = folder / "world.yaml"
    path.write_text(text, encoding="utf-8")
    lines = refused(path)
    assert lines[0].startswith(first)


def test_the_corpus_is_large_enough():
    assert len(TEXTS) >= 40


def test_files_that_hold_no_text_are_refused(tmp_path):
    path = tmp_path / "world.yaml"
    path.write_bytes(b"name: a\nwalls: \xff\xfe\n")
    assert refused(path) == ["2:8: byte 0xff is not UTF-8 text; write the file as UTF-8 text"]
    path.write_bytes("name: room\n".encode("utf-16"))
    assert refused(path) == ["1:1: byte 0xff is not UTF-8 text; write the file as UTF-8 text"]
    path.write_bytes(b"\x7fELF\x02\x01\x01" + bytes(range(128)) * 50)
    assert refused(path) == ["1:1: character U+007F is not text; write the file as UTF-8 text"]
    path.write_bytes(png(4, 4))
    assert refused(path) == ["1:1: byte 0x89 is not UTF-8 text; write the file as UTF-8 text"]


def test_a_file_of_100_megabytes_is_refused_unread(tmp_path):
    path = tmp_path / "world.yaml"
    with path.open("wb") as file:
        file.truncate(100_000_000)
    assert refused(path) == ["1:1: the file has 100 MB; a world file has at most 5 MB"]


def test_folders_devices_and_closed_files_are_refused(tmp_path):
    import os

    assert refused(tmp_path) == ["1:1: this is a folder; name a world file"]
    os.mkfifo(tmp_path / "pipe")
    assert refused(tmp_path / "pipe") == ["1:1: this is not a file; name a world file"]
    closed = tmp_path / "closed.yaml"
    closed.write_text("name: a\n")
    closed.chmod(0)
    with contextlib.suppress(WorldError):  # root may read it all the same
        load_runnable(closed)


def test_all_errors_of_a_file_are_reported_together_in_order(tmp_path):
    path = tmp_path / "room.yaml"
    path.write_text(
        "mjsim: 1\nwals: []\nwalls:\n- points: [[0, 0], [1, 0]]\n  height: -2.0\n  color: red\n"
        "robots:\n- {name: a, at: [1]}\n- {name: a, at: [1, 1], sensors: [{camera: c, widht: 3}]}\nrun: {seed: -1}\n"
    )
    assert refused(path) == [
        "2:1: unknown key 'wals'; did you mean 'walls'?",
        "5:11: height is -2.0 m; it must be above 0",
        "6:10: color is 'red'; it must be a colour such as \"#e8e4da\", in quotes",
        "8:17: at is [1]; it must be [x, y]",
        "9:10: name 'a' is taken by robots[0]; give each item its own",
        "9:47: unknown key 'widht'; did you mean 'width'?",
        "10:13: seed is -1; it must be at least 0",
    ]


@pytest.mark.parametrize("kind", ["a misspelt key", "a robot in a wall", "a YAML bomb", "a picture that is not there"])
def test_the_command_line_says_so_and_writes_nothing(folder, tmp_path, kind):
    from mjsim.cli import main

    text, first = TEXTS[kind]
    path = folder / "world.yaml"
    path.write_text(text, encoding="utf-8")
    output = tmp_path / "out"
    for arguments in (["check"], ["run", "-o", f"{output}/run.mcap"], ["compile", "-o", f"{output}/scene"]):
        told = io.StringIO()
        with contextlib.redirect_stderr(told), pytest.raises(SystemExit) as ended:
            main([arguments[0], str(path), *arguments[1:]])
        assert ended.value.code == 2
        assert told.getvalue().startswith(f"{path}:{first}")
        assert "Traceback" not in told.getvalue()
    assert not output.exists()


def test_every_pattern_of_the_language_is_put_into_words():
    # One without words ended in a KeyError.
    patterns = re.findall(r'"pattern": ("(?:[^"\\]|\\.)*")', json.dumps(World.model_json_schema()))
    assert len(patterns) > 5
    assert {json.loads(pattern) for pattern in patterns} <= set(pydantic_words._PATTERNS)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (
            "robots: [{at: [0, 0], preset: ../robot.yaml}]",
            "path '../robot.yaml' is outside its folder; name a file beside",
        ),
        (
            "robots: [{at: [0, 0], preset: mein Röbi.yaml}]",
            "no file 'mein Röbi.yaml' beside the world file or in assets",
        ),
        ("robots: [{at: [0, 0], preset: my robot}]", "no preset 'my robot'; did you mean"),
        (
            "beacons: [{at: [0, 0], marker: {dictionary: 4X4_50, id: 1}}]",
            "no dictionary '4X4_50'; did you mean '4x4_50'?",
        ),
        ("plants: [{name: p, of: a b}]", "of is 'a b'; it must be NAME, or NAME/PART"),
    ],
)
def test_names_of_files_and_parts_that_cannot_be_are_told(text, says):
    with pytest.raises(WorldError, match=re.escape(says)):
        parse_world(f"mjsim: 1\n{text}\n")
