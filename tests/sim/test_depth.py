"""What a camera gives besides a straight, sharp picture: depth, instances, two eyes, and pictures that take time."""

import math

import numpy as np
import pytest

from mjsim.geometry import Array
from mjsim.interface import CameraFrame, Command
from mjsim.sim import Simulation
from mjsim.world import parse_world

ROOM = """
mjsim: 1
walls: [{points: [[-2, -3], [4, -3], [4, 3], [-2, 3]], closed: true, thickness: 0.2, height: 2}]
obstacles:
  - {name: crate, box: [0.4, 0.4, 1.0], at: [2.2, 0.5], color: "#20c040"}
  - {name: post, cylinder: [0.1, 1.5], at: [3, -0.8], color: "#c02020"}
beacons: [{name: lion, image: posters/lion.jpg, at: [3.89, 0], heading_deg: 180, width: 0.6, center: 0.8}]
"""
CAMERA = "camera: c, at: [0, 0, 0.5], width: 160, height: 120, rate_hz: 25"
FOCAL = 80 / math.tan(math.radians(30))


def simulation(*cameras: str, more: str = "  - {name: other, at: [2, -1.4], heading_deg: 90}\n") -> Simulation:
    sensors = ", ".join(f"{{{camera}}}" for camera in cameras)
    return Simulation(parse_world(f"{ROOM}robots:\n  - {{name: r, at: [0, 0], sensors: [{sensors}]}}\n{more}"))


def frame(keys: str) -> CameraFrame:
    with simulation(f"{CAMERA}, {keys}" if "noise: " in keys.split("{")[0] else f"{CAMERA}, noise: 0, {keys}") as sim:
        return sim.sense("r").cameras["c"]


def spin(sim: Simulation, turn: float, *, speed: float = 0.0) -> None:
    """Let a robot turn and go at once, without stepping."""
    start = sim.model.joint("r/free").dofadr[0]
    sim.data.qvel[start : start + 6] = [speed, 0, 0, 0, 0, turn]


@pytest.mark.slow
def test_depth_is_along_the_optical_axis_in_metres_and_instances_have_names():
    seen = frame("depth: true, segmentation: true")
    assert seen.depth is not None
    assert seen.segmentation is not None
    row = 60
    for column, name, far in ((80, "beacon/lion", 3.89), (45, "obstacle/crate", 2.0), (116, "obstacle/post", 2.9)):
        assert seen.instances[seen.segmentation[row, column]] == name, column
        # The lens is 0.5 m up, on a robot that stands a tenth of a millimetre off; the post is round.
        assert seen.depth[row, column] == pytest.approx(far, abs=0.012), column
    told = {seen.instances[index] for index in np.unique(seen.segmentation) if index >= 0}
    assert told == {"wall", "floor", "beacon/lion", "obstacle/crate", "obstacle/post", "other"}
    sky = seen.segmentation == -1
    assert np.isposinf(seen.depth[sky]).all()
    # The floor: what is drawn v below the middle is 0.5 m down.
    floor = seen.segmentation == seen.instances.index("floor")
    v = np.nonzero(floor)[0] - 59.5
    np.testing.assert_allclose(seen.depth[floor], 0.5 * FOCAL / v, rtol=0.01)


@pytest.mark.slow
def test_a_camera_gives_neither_depth_nor_instances_unless_asked():
    seen = frame("blur: 0.5")
    assert (seen.depth, seen.segmentation, seen.instances) == (None, None, ())


@pytest.mark.slow
def test_depth_errs_with_the_square_of_the_distance_and_ends_where_its_range_does():
    exact = frame("depth: true").depth
    noisy = frame("depth: {noise: 0.004}").depth
    assert exact is not None
    assert noisy is not None
    for low, high in ((1.0, 2.1), (3.7, 4.0)):
        there = (exact > low) & (exact < high)
        scaled = (noisy[there] - exact[there]) / exact[there] ** 2
        # Thousands of pixels: known to 2 %.
        assert scaled.std() == pytest.approx(0.004, rel=0.08)
    ended = frame("depth: {range: [1.5, 3]}").depth
    assert ended is not None
    assert np.isposinf(ended[exact > 3]).all()
    assert np.isneginf(ended[exact < 1.5]).all()
    between = (exact > 1.5) & (exact < 3)
    np.testing.assert_array_equal(ended[between], exact[between])


@pytest.mark.slow
def test_two_cameras_side_by_side_see_one_instant_and_the_disparity_of_a_base():
    base = 0.12
    eyes = [
        f"camera: {name}, at: [0, {y}, 0.5], width: 160, height: 120, rate_hz: 25, depth: true, segmentation: true"
        for name, y in (("left", base / 2), ("right", -base / 2))
    ]
    with simulation(*eyes) as sim:
        cameras = sim.sense("r").cameras
    left, right = cameras["left"], cameras["right"]
    assert left.stamp == right.stamp
    for name, far in (("obstacle/crate", 2.0), ("beacon/lion", 3.89)):
        middles = [float(np.nonzero(e.segmentation[60] == e.instances.index(name))[0].mean()) for e in (left, right)]
        assert middles[0] - middles[1] == pytest.approx(FOCAL * base / far, abs=0.75), name


@pytest.mark.slow
@pytest.mark.parametrize("latency", [0, 2])
def test_in_a_moving_scene_picture_depth_and_instances_of_a_frame_are_of_its_stamp(latency):
    robot = "  - {name: other, at: [2, -0.6], heading_deg: 90, body: {height: 0.6, color: '#ff00ff'}}\n"
    columns, seen = {}, []
    with simulation(f"{CAMERA}, noise: 0, depth: true, segmentation: true, latency: {latency}", more=robot) as sim:
        for tick in range(30):
            # Between the two lines of sight that touch its round body at this instant.
            other = sim.truth("other")
            bearing, half = math.atan2(other.y, other.x), math.asin(0.22 / math.hypot(other.x, other.y))
            tangents = math.tan(bearing - half) + math.tan(bearing + half)
            columns[round(tick * sim.dt, 6)] = 79.5 - FOCAL * tangents / 2
            frames = sim.sense("r").cameras
            assert [frame.stamp for frame in frames.values()] == [(tick - latency) * sim.dt] * (tick >= latency)
            seen += frames.values()
            sim.apply("other", Command(0.7))
            sim.step()
    assert abs(columns[0.0] - columns[1.16]) > 30
    for frame in seen:
        there = frame.segmentation[66] == frame.instances.index("other")
        red, green, blue = frame.image[66].astype(int).T
        pink = (red - green > 60) & (blue - green > 60)
        near = frame.depth[66] < 1.99
        for mask in (there, pink, near):
            assert np.flatnonzero(mask).mean() == pytest.approx(columns[round(frame.stamp, 6)], abs=1.0), frame.stamp
        np.testing.assert_array_equal(there, pink)


@pytest.mark.slow
def test_exposure_multiplies_and_clips_and_automatic_exposure_ends_at_a_middle_grey():
    plain, dark, bright = (frame(f"exposure: {gain}").image.astype(float) for gain in (1.0, 0.5, 2.0))
    np.testing.assert_allclose(dark, plain / 2, atol=0.51)
    np.testing.assert_allclose(bright, np.minimum(2 * plain, 255), atol=0.51)
    assert frame("exposure: auto").image.mean() == pytest.approx(118, abs=3)


@pytest.mark.slow
def test_a_blurred_edge_spreads_as_a_gaussian():
    sharp, smeared = (frame(f"blur: {sigma}").image[60, :, 1].astype(float) for sigma in (0, 2.0))
    offsets = np.arange(-8, 9)
    kernel = np.exp(-(offsets**2) / 8) / np.exp(-(offsets**2) / 8).sum()
    # Rows above and below are alike beside the poster, so that one row tells it all.
    inner = np.r_[20:60, 98:140]
    np.testing.assert_allclose(smeared[inner], np.convolve(sharp, kernel, mode="same")[inner], atol=3)


def edge_columns(seen: CameraFrame, name: str) -> Array:
    """Return the first column of an instance in each row in which it is, NaN elsewhere, shape (rows,)."""
    assert seen.segmentation is not None
    mask = seen.segmentation == seen.instances.index(name)
    return np.where(mask.any(axis=1), mask.argmax(axis=1), np.nan)


@pytest.mark.slow
@pytest.mark.parametrize("turn", [1.5, -1.0])
def test_a_rolling_shutter_leans_what_is_upright_by_the_turn_from_row_to_row(turn):
    readout = 0.1
    with simulation(f"{CAMERA}, noise: 0, segmentation: true, depth: true, rolling_shutter: {readout}") as sim:
        still = sim.sense("r").cameras["c"]
        sim.step()
        spin(sim, turn)
        seen = sim.sense("r").cameras["c"]
    upright, leaning = edge_columns(still, "obstacle/post"), edge_columns(seen, "obstacle/post")
    rows = np.flatnonzero(np.isfinite(upright) & np.isfinite(leaning))[1:-1]
    # The post is at a bearing where a turn moves it by f (1 + tan^2) a radian, to the right for a turn to the left.
    bearing = math.atan2(-0.8, 3)
    times = readout * ((rows + 0.5) / 120 - 0.5)
    expected = FOCAL * (np.tan(turn * times - bearing) - math.tan(-bearing))
    np.testing.assert_allclose((leaning - upright)[rows], expected, atol=1.6)
    assert abs(expected[-1] - expected[0]) > 8
    # The picture, the depth and the instances are of the same instants.
    red = (seen.image[..., 0].astype(int) - seen.image[..., 1] > 60)[rows, 95:]
    np.testing.assert_allclose(95 + red.argmax(axis=1), leaning[rows], atol=1)
    assert seen.depth is not None
    np.testing.assert_allclose(seen.depth[rows, leaning[rows].astype(int) + 2], 2.9, atol=0.25)


@pytest.mark.slow
def test_an_open_shutter_blurs_what_moves_through_the_picture_and_not_a_camera_at_rest():
    with simulation(f"{CAMERA}, noise: 0, shutter: 0.05, segmentation: true") as sim:
        still = sim.sense("r").cameras["c"].image
        np.testing.assert_array_equal(still, frame("noise: 0").image)
        sim.step()
        spin(sim, 1.5)
        moving = sim.sense("r").cameras["c"].image
    steepest = [np.abs(np.diff(image[60].astype(float), axis=0)).max() for image in (still, moving)]
    # An edge is spread over 80 / tan(30) * 1.5 * 0.05 = 10 pixels.
    assert steepest[1] < 0.35 * steepest[0]
    assert moving.mean() == pytest.approx(still.mean(), abs=6)


@pytest.mark.slow
def test_nothing_is_rendered_that_is_not_due(monkeypatch: pytest.MonkeyPatch):
    from mjsim.sim import Renderer

    drawn: list[float] = []
    with simulation("camera: c, width: 32, height: 24, rate_hz: 5, depth: true, segmentation: true") as sim:
        for kind in ("render", "depth", "segment"):
            draw = getattr(Renderer, kind)
            monkeypatch.setattr(
                Renderer, kind, lambda *args, draw=draw, **keys: drawn.append(round(sim.time, 6)) or draw(*args, **keys)
            )
        for _ in range(11):
            sim.sense("r")
            sim.sense("r")
            sim.step()
        for _ in range(10):
            sim.step()
    # The depth is that of the image.
    assert drawn == [0.0] * 2 + [0.2] * 2 + [0.4] * 2
