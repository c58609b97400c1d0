"""Films and pictures of arms that stand: an oblique view fitted to them, joints and tools beside."""

import numpy as np
import pytest

from mjsim.record import read_recording
from mjsim.run import run
from mjsim.video.arm_frame import ArmFrame, CurveChart
from mjsim.video.chart import BOTTOM, LEFT, RIGHT, TOP
from mjsim.video.film import usual_view
from mjsim.video.ink import Letters
from mjsim.video.instant import write_instant
from mjsim.video.moment import moments
from mjsim.video.oblique import ObliqueView, standing_arms
from mjsim.video.views import arms_alone, composed_picture
from mjsim.world import parse_world

WORLD = """
mjsim: 1
obstacles: [{name: table, box: [0.4, 0.3, 0.5], at: [1.4, 2.5]}]
robots:
  - name: r
    base: fixed
    at: [1, 2]
    heading_deg: 30
    arms: [{name: arm, dh: {rows: [{d: 0.4, alpha_deg: 90}, {a: 0.5, mass: 1}, {a: 0.3, mass: 0.5}]},
            start_deg: [20, 40, -60]}]
run: {seconds: 0.4}
"""


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    path = tmp_path_factory.mktemp("arm") / "run.mcap"
    run(parse_world(WORLD), record=path)
    return read_recording(path)


def test_the_last_part_of_an_arm_ends_where_mujoco_has_its_tool(recording):
    (arm,) = standing_arms(recording)
    assert arms_alone(recording)
    for row in (0, len(arm.tool) - 1):
        bones = arm.bones(arm.positions[row])
        np.testing.assert_allclose(bones[-1, 1], arm.tool[row], atol=1e-6)
        np.testing.assert_allclose(bones[0, 0], [1.0, 2.0, 0.0], atol=1e-12)
        np.testing.assert_allclose(bones[1:, 0][:3], bones[:-1, 1][:3], atol=1e-9)


def test_the_view_is_fitted_to_the_arm_and_shows_the_path_of_its_tool(recording):
    view = ObliqueView(recording, standing_arms(recording))
    (moment,) = moments(recording, "r", [5])
    items = {item.role: item for item in view.items(moment, 5)}
    assert {"floor grid", "obstacle", "link", "tool path", "landmark"} <= items.keys()
    assert len(items["tool path"].parts[0]) == 6
    links = np.concatenate([part for item in view.items(moment, 5) if item.role == "link" for part in item.parts])
    low, high = view.bounds
    assert (links > low).all()
    assert (links < high).all()
    # The arm moves little, so it fills most of the height.
    assert np.ptp(links[:, 1]) > 0.6 * (high[1] - low[1])


def test_an_upright_line_stays_upright_and_keeps_its_proportion(recording):
    view = ObliqueView(recording, standing_arms(recording))
    foot, head = view._flat(np.array([[1.0, 2.0, 0.0], [1.0, 2.0, 1.0]]))
    assert head[0] == pytest.approx(foot[0])
    assert 0.8 < head[1] - foot[1] < 1.0


def test_a_frame_shows_joints_up_to_its_time(recording):
    frame, rows = ArmFrame(recording), range(len(recording.time))
    drawn = [frame.draw(moment, row).copy() for row, moment in zip(rows, moments(recording, "r", rows), strict=True)]
    assert drawn[0].shape == (720, 1280, 3)
    charts = [int((picture[:, 790:] != drawn[0][:, 790:]).any(axis=2).sum()) for picture in drawn]
    assert charts == sorted(charts)
    assert charts[-1] > 500
    display = recording.world.run.view
    np.testing.assert_array_equal(composed_picture(recording, len(rows) - 1, display), drawn[-1])


def test_an_instant_of_an_arm_is_a_drawing_to_scale(recording, tmp_path):
    write_instant(recording, tmp_path / "arm.svg", 0.2)
    text = (tmp_path / "arm.svg").read_text()
    assert 'id="floor"' in text
    assert 'id="paths"' in text
    write_instant(recording, tmp_path / "plan.svg", 0.2, view="plan")
    assert 'id="floor"' not in (tmp_path / "plan.svg").read_text()


def test_a_world_of_people_alone_is_filmed_from_above(tmp_path):
    world = "mjsim: 1\npeople: [{name: ann, sex: female, at: [1, 1]}]\nrun: {seconds: 0.1}\n"
    assert usual_view(run(parse_world(world), record=tmp_path / "run.mcap")) == "overview"


def test_curves_are_drawn_up_to_the_moment_and_no_further():
    time, width, height = np.linspace(2.0, 4.0, 21), 300, 160
    chart = CurveChart("q", time, [("a", (200, 30, 30), np.sin(time))], Letters(), width=width, height=height)
    empty, image = np.empty((height, width, 3), np.uint8), np.empty((height, width, 3), np.uint8)
    chart.draw(empty, -1)
    for row in (1, 10, 20):
        chart.draw(image, row)
        drawn = np.argwhere((image != empty).any(axis=2))
        until = LEFT + (width - LEFT - RIGHT - 1) * row / 20
        # A line is 2 px wide, with round ends; a row is 12 px from the next.
        assert drawn[:, 1].max() == pytest.approx(until, abs=4.0)
        assert drawn[:, 1].min() == pytest.approx(LEFT, abs=4.0)
        assert TOP - 2 <= drawn[:, 0].min() <= drawn[:, 0].max() <= height - BOTTOM + 2
