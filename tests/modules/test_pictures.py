"""The pictures of beacons are judged before a run: each alone, each against the others, and for the cameras."""

from collections.abc import Mapping
from pathlib import Path

import pytest

import mjsim
from mjsim.algorithms.beacon_vision import picture_quality
from mjsim.bench.odd_pictures import drawing, odd_pictures, png
from mjsim.cli import main
from mjsim.modules import check_pictures, judge_images, judge_pictures, picture_checks
from mjsim.web.worlds.parsed import parsed
from mjsim.world import Source, World, load_world, parse_world

WORLDS = Path(__file__).parents[2] / "worlds"
ODD = odd_pictures()
PLAIN = "is of one colour or nearly so; use one with clear shapes all over it"
ONE_WAY = "changes in one direction only, like stripes; use one with shapes all over it"
REPEATED = "repeats itself, so that its parts cannot be told apart; use one that is different everywhere"
POOR = "has too few details or too little contrast; use one with many clear shapes"


def text_with(*beacons: str, sensors: str = "{camera: front}") -> str:
    hung = "".join(f"  - {{at: [3, {k}], heading_deg: 180, {beacon}}}\n" for k, beacon in enumerate(beacons))
    return f"mjsim: 1\nbeacons:\n{hung}robots: [{{name: scout, at: [0, 0], sensors: [{sensors}]}}]\n"


def room(*beacons: str, files: Mapping[str, bytes], sensors: str = "{camera: front}") -> World:
    return parse_world(text_with(*beacons, sensors=sensors), source=Source(file="w", attached=files))


GOOD = {f"good{k}.png": png(drawing(30 + k)) for k in range(3)}


@pytest.mark.parametrize(
    ("name", "fault"),
    [
        ("white.png", PLAIN),
        ("faint.png", PLAIN),
        ("1x1.png", PLAIN),
        ("transparent.png", PLAIN),
        ("gradient.png", ONE_WAY),
        ("stripes-across.png", ONE_WAY),
        ("barcode.png", ONE_WAY),
        ("gradient-slanted.png", ONE_WAY),
        ("checkerboard.png", REPEATED),
        ("bricks.png", REPEATED),
        ("tiles-of-one-motif.png", REPEATED),
        ("disc.png", POOR),
        ("8x6.png", POOR),
        ("1x1000.png", "is 1000 times as long as it is wide; use one that is at most 16 times as long"),
    ],
)
def test_what_no_camera_can_recognise_is_named_with_its_fix(name: str, fault: str):
    world = room(f"name: mine, image: {name}", files=ODD)
    assert [str(each) for each in check_pictures(world)] == [f"w:3:55: picture '{name}' of beacon 'mine' {fault}"]


@pytest.mark.parametrize(
    "name", ["gray.png", "sixteen-bit-alpha.png", "one-bit.png", "cmyk.jpg", "turned.jpg", "palette.png"]
)
def test_a_good_picture_of_any_form_is_not_mentioned(name: str):
    assert check_pictures(room(f"name: mine, image: {name}", files=ODD)) == []


def test_equal_and_similar_pictures_are_named_with_those_that_they_are_like():
    files = {**GOOD, "copy.png": GOOD["good0.png"], "saved-again.jpg": ODD["gray.jpg"], "first.png": ODD["gray.png"]}
    names = ["good0.png", "copy.png", "good0.png", "first.png", "saved-again.jpg", "good1.png", "good2.png"]
    world = room(*(f"name: b{k}, image: {name}" for k, name in enumerate(names)), files=files)
    assert [str(each).partition(": ")[2] for each in check_pictures(world)] == [
        "picture 'copy.png' of beacon 'b1' is the same as that of beacon 'b0', so neither is recognised;"
        " give each its own picture",
        "picture 'good0.png' of beacon 'b2' is the same as that of beacon 'b0', so neither is recognised;"
        " give each its own picture",
        "picture 'saved-again.jpg' of beacon 'b4' looks like that of beacon 'b3' (99% alike), so both may be missed;"
        " use a different picture",
    ]


def test_a_picture_too_small_for_the_cameras_is_named_with_the_width_that_suffices():
    camera = "{camera: front, width: 160, height: 120}, {camera: back, width: 320, height: 240, fov_deg: 70}"
    world = room("name: mine, image: good0.png, width: 0.1", files=GOOD, sensors=camera)
    (problem,) = check_pictures(world)
    judged = judge_pictures(world)["mine"]
    # A third more high than wide; the second camera has the longer focal length.
    assert judged.distance == pytest.approx(world.robots[0].sensors[1].focal * 0.1 * (4 / 3) ** 0.5 / judged.least_side)
    words = problem.message.split()
    width = float(words[words.index("make") + 2])
    assert f"only up to {judged.distance:.2f} m" in problem.message
    for share, count in ((1.0, 0), (0.9, 1)):
        wider = room(f"name: mine, image: good0.png, width: {share * width}", files=GOOD, sensors=camera)
        assert len(check_pictures(wider)) == count


def test_without_a_camera_or_a_picture_nothing_is_judged():
    assert judge_pictures(room("name: mine, image: white.png", files=ODD, sensors="{lidar: scan}")) == {}
    assert judge_pictures(room("name: mine", "name: tag, marker: {dictionary: 4x4_50, id: 1}", files={})) == {}


def test_the_studio_and_check_report_what_a_picture_lacks_and_a_run_goes_on(tmp_path, capsys):
    path = tmp_path / "room.yaml"
    (tmp_path / "stripes.png").write_bytes(ODD["stripes.png"])
    path.write_text(text_with("name: mine, image: stripes.png"))
    line = f"picture 'stripes.png' of beacon 'mine' {ONE_WAY}"
    with pytest.raises(SystemExit):
        main(["check", str(path)])
    assert line in capsys.readouterr().err
    (problem,) = parsed(path.read_text(), Source(folder=tmp_path)).content["problems"]
    assert (problem["message"], problem["kind"], problem["path"][:2]) == (line, "warning", ["beacons", 0])
    with mjsim.Simulation(mjsim.modules.load_runnable(path)) as sim:
        assert sim.catalogue["mine"].picture is not None


@pytest.mark.slow
def test_the_posters_that_are_shipped_are_recognised_from_four_metres():
    world = load_world(WORLDS / "museum.yaml")
    judged = judge_pictures(world)
    assert len(judged) == 40
    assert check_pictures(world) == []
    assert min(each.distance for each in judged.values()) > 4.0


def test_a_fainter_picture_must_be_nearer():
    files = {f"{share}.png": png(128 + (drawing(20) - 128.0) * share) for share in (1.0, 0.2, 0.02)}
    full, weak, faint = (judge_pictures(room(f"name: b, image: {name}", files=files))["b"].distance for name in files)
    assert full > 1.2 * weak > faint == 0.0


def test_pictures_that_were_judged_before_are_not_judged_again(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    picture_checks._cached.cache_clear()
    world = room("name: a, image: good0.png, width: 0.6", files=GOOD)
    judged = judge_pictures(world)
    (note,) = (each for each in tmp_path.rglob("read/*") if each.stat().st_size)
    picture_checks._cached.cache_clear()
    with monkeypatch.context() as patch:
        patch.setattr(picture_quality, "picture_qualities", None)
        assert judge_pictures(world) == judged
    for damaged in (b"", b"[]", b'{"a": 1}', b'{"a": [1, null, null]}'):
        note.write_bytes(damaged)
        picture_checks._cached.cache_clear()
        assert judge_pictures(world) == judged


def test_pictures_that_may_be_added_are_judged_among_those_that_hang_already():
    files = {
        "king.png": GOOD["good0.png"],
        "again.png": GOOD["good0.png"],
        "other.png": GOOD["good1.png"],
        "plain.png": png(drawing(1) * 0 + 90),
    }
    world = room("name: king, image: king.png", files=files)
    judged = judge_images(world, ["again.png", "other.png", "plain.png"], width=0.6)
    assert "the same as that of beacon 'king'" in str(judged["again.png"].fault)
    assert judged["other.png"].fault is None
    assert judged["plain.png"].fault == PLAIN
    wide = judge_images(world, ["other.png"], width=1.2)["other.png"]
    assert wide.distance == pytest.approx(2 * judged["other.png"].distance)
