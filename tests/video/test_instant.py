"""Any instant of a film is a picture, an SVG or a PDF."""

from dataclasses import replace
from xml.etree import ElementTree

import cv2
import numpy as np
import pytest

from mjsim.errors import UsageError
from mjsim.plan import INKS
from mjsim.record import read_recording
from mjsim.video import write_instant
from mjsim.video.ink import TRUTH
from tests.record_ticks import hand_made_ticks, record

SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    return read_recording(record(tmp_path_factory.mktemp("run") / "run.mcap", hand_made_ticks(12)))


def lines(path, color):
    """Return the points of the lines of a colour, shape (n, 2) each [m]."""
    found = [line for line in ElementTree.parse(path).iter(f"{SVG}polyline") if line.get("stroke") == color]
    return [np.array([pair.split(",") for pair in line.get("points").split()], float) / 100 * [1, -1] for line in found]


def test_an_svg_has_the_paths_up_to_its_time_and_the_robot_where_it_is(recording, tmp_path):
    robot, row = next(iter(recording.robots)), 8
    write_instant(recording, tmp_path / "now.svg", float(recording.time[row]), sightings=False, ellipses=False)
    track = recording.robots[robot]
    known = track.odometry[: row + 1, :2]
    (path,) = [line for line in lines(tmp_path / "now.svg", INKS["odometry"].light) if len(line) > 2]
    np.testing.assert_allclose(path, known[np.isfinite(known).all(axis=1)], atol=1e-4)
    body = [each for each in ElementTree.parse(tmp_path / "now.svg").iter(f"{SVG}polygon")]
    (true,) = [each for each in body if each.get("fill") == INKS["truth"].light]
    corners = np.array([pair.split(",") for pair in true.get("points").split()], float) / 100 * [1, -1]
    np.testing.assert_allclose(corners.mean(axis=0), track.truth[row, :2], atol=0.02)


def test_a_close_up_fits_a_column_and_shows_the_robot_larger(recording, tmp_path):
    sizes, notes = {}, {}
    for view in (None, "close-up"):
        write_instant(recording, tmp_path / f"{view}.svg", 0.4, view=view, sightings=False)
        root = ElementTree.parse(tmp_path / f"{view}.svg").getroot()
        width, height = (float(root.get(key).removesuffix("mm")) for key in ("width", "height"))
        sizes[view] = width, max(map(float, root.get("viewBox").split()[2:]))
        assert max(width, height) < (96.0 if view else 261.0)
        notes[view] = [each.text for each in root.iter(f"{SVG}text") if "ellipses" in each.text]
    # Beliefs of metres need no magnification.
    assert notes == {None: [], "close-up": ["95 % ellipses"]}
    # It shows less of the world, so on a column of one width more of the robot.
    assert sizes["close-up"][1] < sizes[None][1]


def test_ellipses_that_a_column_would_not_show_are_magnified_and_the_drawing_says_so(recording, tmp_path):
    robot, row = next(iter(recording.robots)), 8
    track = recording.robots[robot]
    sure = replace(track, covariance=np.tile(np.diag([9e-6, 1e-6, 1e-6]), (len(track.time), 1, 1)))
    small = replace(recording, robots={**recording.robots, robot: sure})
    write_instant(small, tmp_path / "now.svg", float(recording.time[row]), view="close-up")
    root = ElementTree.parse(tmp_path / "now.svg").getroot()
    (robot_item,) = (each for each in recording.world.robots if each.name == robot)
    factor = max(k for k in (1, 2, 5, 10, 20, 50, 100) if k * 0.003 * 2.4477 <= robot_item.body.radius)
    assert f"95 % ellipses, magnified {factor} times" in [each.text for each in root.iter(f"{SVG}text")]
    drawn = [each for each in root.iter(f"{SVG}polygon") if each.get("stroke") == INKS["estimate"].light]
    points = [np.array([p.split(",") for p in each.get("points").split()], float) / 100 for each in drawn]
    widths = [np.ptp(each[:, 0]) for each in points]
    assert any(width == pytest.approx(2 * factor * 0.003 * 2.4477, rel=0.01) for width in widths)


def test_dark_paper_has_the_lighter_colours(recording, tmp_path):
    write_instant(recording, tmp_path / "now.svg", float(recording.time[8]), theme="dark")
    text = (tmp_path / "now.svg").read_text()
    assert INKS["truth"].dark in text
    assert INKS["truth"].light not in text


@pytest.mark.slow
def test_a_pdf_is_one_and_a_picture_is_the_frame_of_the_film(recording, tmp_path):
    time = float(recording.time[8])
    write_instant(recording, tmp_path / "now.pdf", time)
    assert (tmp_path / "now.pdf").read_bytes().startswith(b"%PDF")
    write_instant(recording, tmp_path / "now.png", time, view="plan")
    page = cv2.imread(str(tmp_path / "now.png"))[..., ::-1]
    assert page.shape == (720, 1280, 3)
    assert (page == TRUTH).all(axis=-1).sum() > 50


@pytest.mark.parametrize(
    ("name", "time", "view", "fault"),
    [
        ("now.gif", 0.0, None, "name it .svg, .pdf, .png, .jpg or .jpeg"),
        ("now.svg", 99.0, None, "time is 99 s; the recording has"),
        ("now.svg", 0.0, "chase", "an instant is shown as plan"),
    ],
)
def test_what_cannot_be_shown_is_refused(recording, tmp_path, name, time, view, fault):
    with pytest.raises(UsageError, match=fault):
        write_instant(recording, tmp_path / name, time, view=view)
