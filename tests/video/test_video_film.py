"""The film of a recording: H.264 that plays, one frame for each 1/25 s, and never half a file."""

import av
import numpy as np
import pytest

import mjsim
from mjsim.errors import UsageError
from mjsim.record import read_recording
from mjsim.video import frame_rows, make_video
from mjsim.video.film import write_film
from mjsim.video.ink import TRUTH
from mjsim.video.plan_view import PlanView
from mjsim.video.views import scene_pictures
from tests.record_ticks import hand_made_ticks, record

ROOM = """
mjsim: 1
name: room
walls: [{points: [[0, 0], [4, 0], [4, 3], [0, 3]], closed: true}]
beacons: [{name: lion, image: posters/lion.jpg, at: [3.94, 1.5], heading_deg: 180}]
robots:
  - name: scout
    at: [1, 1.5]
    sensors: [{camera: front, width: 66, height: 50}]
run: {seconds: 0.4}
"""


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    """A robot that stands before a picture for 0.4 s, ten ticks."""
    with mjsim.Simulation(mjsim.parse_world(ROOM)) as sim:
        return mjsim.run(sim, record=tmp_path_factory.mktemp("run") / "run.mcap")


def decoded(path):
    """Return stream and RGB pictures of a film."""
    with av.open(str(path)) as film:
        stream = film.streams.video[0]
        facts = stream.codec_context.name, stream.codec_context.pix_fmt, float(stream.average_rate)
        return facts, [frame.to_ndarray(format="rgb24") for frame in film.decode(video=0)]


@pytest.mark.slow
def test_the_film_is_h264_of_25_frames_a_second_and_plays_to_its_end(recording, tmp_path):
    done = []
    make_video(recording, tmp_path / "new" / "run.mp4", progress=done.append)
    facts, frames = decoded(tmp_path / "new" / "run.mp4")
    assert facts == ("h264", "yuv420p", 25.0)
    assert [frame.shape for frame in frames] == [(720, 1280, 3)] * 10
    assert done == list(range(1, 11))
    # The index stands before the pictures, so that a browser begins at once.
    data = (tmp_path / "new" / "run.mp4").read_bytes()
    assert data.index(b"moov") < data.index(b"mdat")


@pytest.mark.slow
def test_the_plan_alone_shows_the_robot_where_it_is(recording, tmp_path):
    make_video(recording, tmp_path / "plan.mp4", view="plan", ellipses=False, trails=False)
    _, frames = decoded(tmp_path / "plan.mp4")
    rows, columns = np.nonzero(np.abs(frames[-1].astype(int) - TRUTH).max(axis=-1) < 30)
    view = PlanView.fit([[-0.05, -0.05], [4.05, 3.05]], 1280, 720, margin=16)
    middle = view.world((columns.mean(), rows.mean()))
    np.testing.assert_allclose(middle, recording.robots["scout"].truth[-1, :2], atol=0.05)


@pytest.mark.slow
def test_views_of_the_scene_are_drawn_from_the_recorded_states(recording, tmp_path):
    make_video(recording, tmp_path / "front.mp4", view="scout/front")
    _, frames = decoded(tmp_path / "front.mp4")
    _, onboard = next(iter(recording.images("scout", "front")))
    assert len(frames) == 10
    # Two codings that lose a little lie between the two pictures, and the quality of the view.
    assert np.abs(frames[0].astype(int) - onboard).mean() < 12


@pytest.mark.slow
@pytest.mark.parametrize("view", ["chase", "overview"])
def test_views_from_outside_fill_a_film(recording, tmp_path, view):
    make_video(recording, tmp_path / "view.mp4", view=view)
    _, frames = decoded(tmp_path / "view.mp4")
    assert [frame.shape for frame in frames] == [(720, 1280, 3)] * 10
    # The robot is red and nothing else in the room is.
    red = (frames[0][..., 0] > 120) & (frames[0][..., 1] < 80)
    assert red.sum() > 200


@pytest.mark.slow
def test_a_world_may_ask_for_films_of_high_quality(tmp_path):
    first = []
    for quality in ("normal", "high"):
        text = ROOM.replace("run: {seconds: 0.4}", f"run: {{seconds: 0.04, view: {{quality: {quality}}}}}")
        with mjsim.Simulation(mjsim.parse_world(text)) as sim:
            recorded = mjsim.run(sim, record=tmp_path / f"{quality}.mcap")
        first.append(next(scene_pictures(recorded, [0], "overview")).astype(int))
    # A shadow falls on the floor, and only some of the picture changes.
    darker = (first[0] - first[1]).max(axis=-1) > 10
    assert 0.01 < darker.mean() < 0.5


@pytest.mark.slow
def test_a_recording_of_several_robots_without_3d_state_can_be_filmed(tmp_path):
    made = read_recording(record(tmp_path / "run.mcap", hand_made_ticks(12)))
    make_video(made, tmp_path / "run.mp4")
    assert len(decoded(tmp_path / "run.mp4")[1]) == 12


@pytest.mark.parametrize(("rate", "rows"), [(25, [0, 1, 2, 3]), (50, [0, 2, 4, 6]), (12.5, [0, 0, 1, 1])])
def test_each_frame_shows_the_newest_tick_at_its_time(rate, rows):
    assert frame_rows(3.0 + np.arange(1 + round(0.16 * rate)) / rate)[:4] == rows


def test_an_unknown_view_is_refused_with_those_there_are(recording, tmp_path):
    with pytest.raises(UsageError, match="no view 'chaise' of this recording; did you mean 'chase'"):
        make_video(recording, tmp_path / "run.mp4", view="chaise")
    with pytest.raises(UsageError, match="there are chase, overview, plan, scout/front"):
        make_video(recording, tmp_path / "run.mp4", view="12")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("name", "follow", "fault"),
    [("run.avi", None, "name it .mp4"), ("run.mp4", "me", "must be truth, estimate or nothing")],
)
def test_what_cannot_be_meant_is_refused(recording, tmp_path, name, follow, fault):
    with pytest.raises(UsageError, match=fault):
        make_video(recording, tmp_path / name, follow=follow)


def test_a_place_that_cannot_be_written_is_named(recording, tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(UsageError, match="exists and is not a folder"):
        make_video(recording, tmp_path / "file" / "run.mp4", view="plan")


def test_an_interrupted_film_leaves_the_old_one_and_no_half_file(recording, tmp_path):
    path = tmp_path / "run.mp4"
    path.write_bytes(b"the film of before")

    def interrupt(done):
        if done == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        make_video(recording, path, view="plan", progress=interrupt, overwrite=True)
    assert [(file.name, file.read_bytes()) for file in tmp_path.iterdir()] == [("run.mp4", b"the film of before")]


def test_a_fault_while_drawing_ends_the_film_with_that_fault(tmp_path):
    def pictures():
        yield np.zeros((64, 64, 3), np.uint8)
        raise ValueError("no more")

    with pytest.raises(ValueError, match="no more"):
        write_film(pictures(), tmp_path / "run.mp4")


def test_odd_sizes_lose_their_last_row_and_column_and_colours_stay(tmp_path):
    picture = np.full((75, 101, 3), TRUTH, np.uint8)
    write_film([picture] * 3, tmp_path / "odd.mp4")
    _, frames = decoded(tmp_path / "odd.mp4")
    assert frames[0].shape == (74, 100, 3)
    assert np.abs(frames[0].astype(int) - TRUTH).max() <= 4
