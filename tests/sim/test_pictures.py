"""Camera truth: what the pictures show is what the world file and the calibration say."""

import math
from pathlib import Path

import cv2
import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from mjsim.bench.rooms import GALLERY, beacon_corners, cast, forwarded, look_from, place, png
from mjsim.compile import compile_world
from mjsim.interface import Intrinsics
from mjsim.sim import Renderer
from mjsim.sim.imaging.lens import intrinsics_of
from mjsim.sim.sensors import robot_from_camera
from mjsim.world import Source, World, load_world, parse_world

SHIPPED = Path(__file__).parents[2] / "worlds" / "gallery.yaml"
WORLDS = [pytest.param(None, id="small")] + [pytest.param(SHIPPED, id="gallery")] * SHIPPED.exists()


@pytest.mark.slow
@pytest.mark.parametrize("path", WORLDS)
def test_the_mask_of_a_beacon_is_its_projected_outline_to_a_pixel_of_its_edge(path: Path | None):
    world = parse_world(GALLERY) if path is None else load_world(path)
    model = compile_world(world).compile()
    data, robot = mujoco.MjData(model), world.robots[0]
    sensor = robot.sensors[0]
    intrinsics, rng, compared = intrinsics_of(sensor), np.random.default_rng(0), 0
    corners = {beacon.name: beacon_corners(world, beacon) for beacon in world.beacons if beacon.image}
    with Renderer(model, width=sensor.width, height=sensor.height) as renderer:
        for pose in _poses(world, rng, 30):
            place(model, data, robot.name, pose)
            seen = renderer.segment(data, f"{robot.name}/{sensor.camera}")
            world_from_camera = _world_from_robot(pose) @ robot_from_camera(sensor)
            for name, outline in corners.items():
                pixels = _unoccluded(model, data, intrinsics, world_from_camera, outline)
                if pixels is not None:
                    compared += 1
                    mask = seen == model.geom(f"beacon/{name}").id
                    inside = _signed_distances(pixels, intrinsics)
                    wrong = mask != (inside > 0)
                    assert np.abs(inside[wrong]).max(initial=0.0) <= 1.0, (name, pose)
    assert compared >= 18


def _poses(world: World, rng: np.random.Generator, count: int) -> NDArray[np.float64]:
    """Return random poses within the walls, not always in free space: a camera may look out of anything."""
    corners = np.array([point for wall in world.walls for point in wall.points])
    low, high = corners.min(axis=0) + 0.5, corners.max(axis=0) - 0.5
    return np.column_stack([rng.uniform(low, high, (count, 2)), rng.uniform(-np.pi, np.pi, count)])


def _world_from_robot(pose: NDArray[np.float64]) -> NDArray[np.float64]:
    x, y, heading = pose
    c, s = math.cos(heading), math.sin(heading)
    return np.array([[c, -s, 0, x], [s, c, 0, y], [0, 0, 1, 0], [0, 0, 0, 1.0]])


def _unoccluded(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    intrinsics: Intrinsics,
    world_from_camera: NDArray[np.float64],
    outline: NDArray[np.float64],
) -> NDArray[np.float64] | None:
    """Return the outline as the calibration has it, shape (4, 2) [px]; None when it is behind or hidden in part."""
    eye = world_from_camera[:3, 3]
    normal = np.cross(outline[3] - outline[0], outline[1] - outline[0])
    p_camera = (outline - eye) @ world_from_camera[:3, :3]
    if (eye - outline[0]) @ normal <= 0 or p_camera[:, 2].min() < 0.05:
        return None
    projected = p_camera @ intrinsics.matrix().T
    pixels = projected[:, :2] / projected[:, 2:]
    if (pixels.max(axis=0) < 0).any() or (pixels.min(axis=0) > [intrinsics.width - 1, intrinsics.height - 1]).any():
        return None
    # Rays to a grid that reaches a little beyond the outline, denser than anything that could hide a part of it.
    u, v = (grid.ravel()[:, None] for grid in np.meshgrid(np.linspace(-0.04, 1.04, 28), np.linspace(-0.04, 1.04, 28)))
    points = outline[0] + u * (outline[1] - outline[0]) + v * (outline[3] - outline[0])
    free = cast(model, data, eye, points - eye) > 0.999
    return pixels if free.all() else None


def _signed_distances(polygon: NDArray[np.float64], intrinsics: Intrinsics) -> NDArray[np.float64]:
    """Return how far each pixel's centre lies within a convex clockwise outline, negative outside [px]."""
    y, x = np.mgrid[: intrinsics.height, : intrinsics.width]
    best = np.full(y.shape, np.inf)
    for (ax, ay), (bx, by) in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        best = np.minimum(best, ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / math.hypot(bx - ax, by - ay))
    return best


CORNERED = np.full((60, 90, 3), (120, 130, 140), dtype=np.uint8)
"""Wider than high, with another colour in each corner."""
COLORS = {
    "top left": (200, 40, 30),
    "top right": (40, 170, 60),
    "bottom right": (30, 60, 200),
    "bottom left": (210, 190, 40),
}
CORNERED[:20, :20], CORNERED[:20, -20:] = COLORS["top left"], COLORS["top right"]
CORNERED[-20:, -20:], CORNERED[-20:, :20] = COLORS["bottom right"], COLORS["bottom left"]
ROOM = """
mjsim: 1
walls: [{points: [[0, -3], [0, 3]], thickness: 0.2}]
beacons: [{name: flag, image: flag.png, at: [0.11, 0], heading_deg: 0, width: 0.9}]
robots: [{name: scout, at: [4, 2], sensors: [{camera: front, noise: 0}]}]
"""

TILED = """
mjsim: 1
floor: {texture: tile.png, tile: 1.5}
robots: [{name: scout, at: [9, 9], sensors: [{camera: front, noise: 0}]}]
"""


def _warped(image: NDArray[np.uint8], pixels: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Return a picture in the picture, seen squarely at the size of CORNERED."""
    height, width = CORNERED.shape[:2]
    # Its outline is half a pixel outside the centres of its outermost pixels.
    frame = np.array([[0, 0], [width, 0], [width, height], [0, height]]) - 0.5
    transform = cv2.getPerspectiveTransform(pixels.astype(np.float32), frame.astype(np.float32))
    return cv2.warpPerspective(image, transform, (width, height), flags=cv2.INTER_LINEAR)


@pytest.mark.slow
@pytest.mark.parametrize("quality", ["normal", pytest.param("high", marks=pytest.mark.slow)])
def test_a_picture_hangs_upright_and_unmirrored_in_its_own_colours_at_any_angle(quality: str):
    world = parse_world(ROOM, source=Source(attached={"flag.png": png(CORNERED)}))
    model = compile_world(world).compile()
    data, outline = forwarded(model), beacon_corners(world, world.beacons[0])
    camera = world.robots[0].sensors[0]
    with Renderer(model, width=camera.width, height=camera.height, quality=quality) as renderer:
        for angle in np.radians([-65, -40, 0, 20, 65]):
            eye = np.array([0.11 + 1.6 * math.cos(angle), 1.6 * math.sin(angle), 1.2])
            look_from(model, data, "scout/front", eye, outline.mean(axis=0) - eye)
            index = model.camera("scout/front").id
            p_camera = (outline - eye) @ (data.cam_xmat[index].reshape(3, 3) * [1, -1, -1])
            projected = p_camera @ intrinsics_of(camera).matrix().T
            seen = _warped(renderer.render(data, "scout/front"), projected[:, :2] / projected[:, 2:])
            inner = np.abs(seen.astype(int) - CORNERED)
            for rows in (slice(4, 16), slice(-16, -4), slice(25, 35)):
                for columns in (slice(4, 16), slice(-16, -4), slice(35, 55)):
                    # Of 255; a lamp of high quality may add a tenth.
                    assert inner[rows, columns].max() <= (3 if quality == "normal" else 26), (angle, rows, columns)


def test_a_beacon_is_plain_from_behind():
    text = ROOM.replace("walls: [{points: [[0, -3], [0, 3]], thickness: 0.2}]", "")
    world = parse_world(text, source=Source(attached={"flag.png": png(CORNERED)}))
    model = compile_world(world).compile()
    data = forwarded(model)
    with Renderer(model, width=64, height=48) as renderer:
        look_from(model, data, "scout/front", [-0.3, 0.0, 1.2], [1.0, 0.0, 0.0])
        assert len(np.unique(renderer.render(data, "scout/front").reshape(-1, 3), axis=0)) == 1
        assert model.geom("beacon/flag").id not in renderer.segment(data, "scout/front")


def test_a_picture_in_the_face_of_its_wall_is_seen_whole():
    text = ROOM.replace("at: [0.11, 0]", "at: [0.1, 0]")
    world = parse_world(text, source=Source(attached={"flag.png": png(CORNERED)}))
    model = compile_world(world).compile()
    data = forwarded(model)
    with Renderer(model, width=320, height=240) as renderer:
        look_from(model, data, "scout/front", [4.0, 2.0, 0.5], [-3.9, -2.0, 0.7])
        mask = renderer.segment(data, "scout/front") == model.geom("beacon/flag").id
    contours, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_CCOMP, cv2.CHAIN_APPROX_SIMPLE)
    assert mask.sum() > 500
    assert len(contours) == 1


@pytest.mark.slow
def test_a_tile_of_the_floor_has_its_size_in_metres_and_lies_at_the_origin():
    tile = np.zeros((64, 64, 3), dtype=np.uint8)
    tile[:32, :32], tile[:32, 32:], tile[32:, :32], tile[32:, 32:] = (
        [200, 0, 0],
        [0, 200, 0],
        [0, 0, 200],
        [150, 150, 0],
    )
    model = compile_world(parse_world(TILED, source=Source(attached={"tile.png": png(tile)}))).compile()
    data = forwarded(model)
    with Renderer(model, width=640, height=480) as renderer:
        eye = np.array([0.4, 0.7, 2.0])
        look_from(model, data, "scout/front", eye, [0.0, 0.0, -1.0])
        image = renderer.render(data, "scout/front").astype(int)
    focal = 320 / math.tan(math.radians(30))
    rows, columns = np.mgrid[:480, :640]
    x, y = eye[0] + (columns - 319.5) / focal * 2.0, eye[1] - (rows - 239.5) / focal * 2.0
    # The tile's left half lies west, its upper half north.
    along, down = x / 1.5 % 1.0, -y / 1.5 % 1.0
    expected = tile[(down * 64).astype(int), (along * 64).astype(int)]
    far_from_edges = (np.abs(along * 2 - np.rint(along * 2)) > 0.05) & (np.abs(down * 2 - np.rint(down * 2)) > 0.05)
    shade = image.sum(axis=2, keepdims=True) / expected.sum(axis=2, keepdims=True)
    assert 0.85 < shade[far_from_edges].min() <= shade[far_from_edges].max() <= 1.01
    assert np.abs(image - expected * shade)[far_from_edges].max() <= 6


def test_a_texture_on_a_wall_is_upright_unmirrored_and_metric():
    text = ROOM.replace("thickness: 0.2", "thickness: 0.2, texture: flag.png, tile: 1.0").replace(
        "heading_deg: 0", "heading_deg: 90"
    )
    model = compile_world(parse_world(text, source=Source(attached={"flag.png": png(CORNERED)}))).compile()
    data = forwarded(model)
    with Renderer(model, width=320, height=240) as renderer:
        # One tile, from the floor up: y from 1 to 2, z from 0 to 1, seen from the east.
        look_from(model, data, "scout/front", [1.1, 1.5, 0.5], [-1.0, 0.0, 0.0])
        image = renderer.render(data, "scout/front").astype(float)
    focal = 120 / math.tan(math.radians(model.cam_fovy[model.camera("scout/front").id]) / 2)
    for name, sign in {
        "top left": (-1, -1),
        "top right": (1, -1),
        "bottom right": (1, 1),
        "bottom left": (-1, 1),
    }.items():
        u, v = 159.5 + sign[0] * 0.42 * focal, 119.5 + sign[1] * 0.42 * focal
        if 0 <= v < 240:
            shade = image[round(v), round(u)] / COLORS[name]
            assert np.ptp(shade) < 0.06, name
