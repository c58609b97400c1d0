"""Pictures of recorded states: from outside and onboard, things are where projection by hand says."""

import math

import numpy as np
import pytest

from mjsim.errors import UsageError
from mjsim.sim import Onlooker, Orbit, Playback
from mjsim.world import Looks, parse_world
from mjsim.world.items.timeline.events import LightEvent

WORLD = parse_world(
    """
mjsim: 1
floor: {color: "#808080"}
obstacles: [{name: blue, box: [0.4, 0.4, 0.8], at: [2, 1], color: "#0000ff"}]
robots: [{name: scout, at: [0, 0], sensors: [{camera: front, width: 64, height: 48, noise: 2, depth: true}]}]
"""
)
EMPTY = parse_world("mjsim: 1\n")
START = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
WIDTH, HEIGHT = 96, 72


def blue_of(picture):
    """Columns and rows of what is blue."""
    shade = picture.astype(int)
    rows, columns = np.nonzero((shade[..., 2] > 1.8 * shade[..., 1] + 10) & (shade[..., 2] > 1.8 * shade[..., 0] + 10))
    return columns, rows


@pytest.fixture(scope="module")
def qpos():
    with Playback(WORLD, width=8, height=6) as playback:
        return playback._scene.data.qpos.copy()


@pytest.fixture(scope="module")
def onlooker(qpos):
    with Onlooker(WORLD) as onlooker:
        onlooker.show(qpos, None)
        yield onlooker


@pytest.mark.parametrize("azimuth", [0.0, 90.0, 200.0])
@pytest.mark.parametrize("off", [(0.0, 0.0), (0.4, -0.3)])
def test_an_orbit_sees_things_where_a_pinhole_does(onlooker, azimuth, off):
    turn, rise, distance = math.radians(azimuth), math.radians(-30.0), 5.0
    at = np.array([2.0 + off[0], 1.0 + off[1], 0.4])
    picture = onlooker.outside(Orbit(turn, rise, distance, tuple(at[:2].tolist())), width=WIDTH, height=HEIGHT)
    ahead = np.array([math.cos(turn) * math.cos(rise), math.sin(turn) * math.cos(rise), math.sin(rise)])
    right = np.array([math.sin(turn), -math.cos(turn), 0.0])
    offset = np.array([2.0, 1.0, 0.4]) - (at - distance * ahead)
    focal = HEIGHT / 2 / math.tan(math.radians(float(onlooker._shown().model.vis.global_.fovy)) / 2)
    column = WIDTH / 2 + focal * (offset @ right) / (offset @ ahead)
    row = HEIGHT / 2 - focal * (offset @ np.cross(right, ahead)) / (offset @ ahead)
    columns, rows = blue_of(picture)
    assert (columns.min() + columns.max()) / 2 == pytest.approx(column, abs=2.5)
    assert (rows.min() + rows.max()) / 2 == pytest.approx(row, abs=3.0)


def test_a_portrait_is_filled_by_what_stands_on_the_floor(qpos):
    world = parse_world('mjsim: 1\nobstacles: [{box: [0.4, 0.4, 0.8], at: [7, -3], color: "#0000ff"}]\n')
    for size in ((96, 72), (60, 96)):
        with Onlooker(world) as onlooker:
            onlooker.show(np.zeros(0), None)
            columns, rows = blue_of(onlooker.portrait(width=size[0], height=size[1], quality="normal"))
        margins = columns.min(), size[0] - 1 - columns.max(), rows.min(), size[1] - 1 - rows.max()
        assert 0 < min(margins) < 0.25 * min(size)
        assert abs(margins[0] - margins[1]) < 0.15 * size[0]
        assert abs(margins[2] - margins[3]) < 0.2 * size[1]
    with Onlooker(EMPTY) as onlooker:
        with pytest.raises(UsageError, match="no state is shown"):
            onlooker.portrait(width=8, height=6)
        onlooker.show(np.zeros(0), None)
        with pytest.raises(UsageError, match="this world is empty"):
            onlooker.portrait(width=8, height=6)


def test_an_onboard_frame_has_no_noise_its_stamp_and_what_is_asked_for(onlooker):
    plain = onlooker.onboard("scout", "front", stamp=2.5)
    assert (plain.stamp, plain.depth, plain.segmentation) == (2.5, None, None)
    assert plain.image.shape == (48, 64, 3)
    np.testing.assert_array_equal(plain.image, onlooker.onboard("scout", "front").image)
    deep = onlooker.onboard("scout", "front", depth=True)
    seen = onlooker.onboard("scout", "front", segmentation=True)
    assert deep.segmentation is None
    assert seen.depth is None
    blue = seen.segmentation == next(k for k, name in enumerate(seen.instances) if name.endswith("blue"))
    rows, columns = np.nonzero(blue)
    assert np.mean(columns) < 32  # at [2, 1], to the left
    assert float(np.min(deep.depth[rows, columns])) == pytest.approx(1.8, abs=0.35)
    for robot, camera in (("scout", "frnt"), ("scot", "front")):
        with pytest.raises(UsageError, match="did you mean 'scout/front'"):
            onlooker.onboard(robot, camera)


def test_a_recorded_state_is_drawn_with_the_events_before_it(qpos):
    dark = LightEvent(time=1.0, light=0.0)
    moved = qpos.copy()
    moved[0] += 0.5
    with Playback(WORLD, width=64, height=48, events=[dark]) as playback:
        picture = playback.picture(qpos, "overview").copy()
        before = playback.picture(qpos, "overview", time=0.99).copy()
        after = playback.picture(qpos, "overview", time=1.0).copy()
        out = np.zeros((48, 64, 3), np.uint8)
        assert playback.picture(moved, "overview", out) is out
        assert (out != picture).any()
        np.testing.assert_array_equal(picture, before)
        assert after.mean() < 0.8 * before.mean()
        chased = playback.picture(qpos, "scout/chase")
        assert chased.shape == (48, 64, 3)
        high = playback._scene.model.camera("overview").pos.copy()
        playback.widen(np.array([[-9.0, -9.0, 0.0], [9.0, 9.0, 1.0]]))
        assert playback._scene.model.camera("overview").pos[2] > high[2]
        columns, _ = blue_of(playback.picture(qpos, "overview"))
        assert len(columns) < len(blue_of(picture)[0])
        with pytest.raises(UsageError, match="did you mean"):
            playback.picture(qpos, "overvew")


def test_removed_things_are_not_seen(qpos):
    gone = Looks(light=1.0, lamps={}, removed=frozenset({"blue"}))
    with Onlooker(WORLD) as onlooker:
        view = Orbit(0.0, -0.5, 5.0, (2.0, 1.0))
        onlooker.show(qpos, gone)
        assert not len(blue_of(onlooker.outside(view, width=WIDTH, height=HEIGHT))[0])
        onlooker.show(qpos, None)
        assert len(blue_of(onlooker.outside(view, width=WIDTH, height=HEIGHT))[0])


def test_a_chasing_camera_comes_nearer_than_a_wall_behind_the_robot(qpos):
    walled = parse_world(
        "mjsim: 1\nwalls: [{points: [[-0.8, -2], [-0.8, 2]], thickness: 0.1, height: 3}]\n"
        "robots: [{name: scout, at: [0, 0]}]\n".replace("\\\n", "\n")
    )
    with Onlooker(walled) as onlooker:
        onlooker.show(qpos, None)
        onlooker.outside("scout/chase", width=16, height=12)
        data, model = onlooker._shown().data, onlooker._shown().model
        x = data.cam_xpos[model.camera("scout/chase").id][0]
        assert -0.75 < x < -0.3
