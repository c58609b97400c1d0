"""Maps of robots come in as walls, and worlds go out as maps."""

import math
from pathlib import Path

import numpy as np
import pytest

from mjsim.errors import UsageError
from mjsim.exchange import explained, with_robot, world_from_map, write_map
from mjsim.exchange.grid import read_grid
from mjsim.world import World, load_world, parse_world
from mjsim.world.check import check_world
from mjsim.world.plan import solid

WORLDS = Path(__file__).parent.parent / "worlds"
ROOM = "mjsim: 1\nwalls: [{points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true}]\n"
PIXELS = np.array([[0, 100, 205], [254, 255, 60]], dtype=np.uint8)


def written(folder: Path, picture: np.ndarray, text: str = "", *, resolution: float = 0.05) -> Path:
    """Write a map as map_saver does, and return its YAML file."""
    rows, columns = picture.shape
    (folder / "map.pgm").write_bytes(b"P5\n# CREATOR: map_saver\n%d %d\n255\n" % (columns, rows) + picture.tobytes())
    (folder / "map.yaml").write_text(f"image: map.pgm\nresolution: {resolution}\n{text}")
    return folder / "map.yaml"


def apart(one: World, other: World) -> float:
    """Return the Hausdorff distance between the outlines of what is solid in two worlds [m]."""
    return float(solid(one).boundary.hausdorff_distance(solid(other).boundary))


@pytest.mark.parametrize("name", ["empty", "maze", "museum", "dark", "cloister"])
def test_a_world_that_goes_out_as_a_map_comes_back_within_half_a_cell(name, tmp_path):
    world = load_world(WORLDS / f"{name}.yaml")
    path = write_map(world, tmp_path, resolution=0.05)
    back = world_from_map(path)
    assert apart(world, back) <= 0.025
    found, there, invented = explained(back, read_grid(path))
    assert (found, invented) == (there, 0)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["arena", "clutter", "corridor", "gallery", "office", "ramps", "sensors", "warehouse"])
def test_the_walls_of_a_shipped_world_come_back_within_half_a_cell(name, tmp_path):
    world = load_world(WORLDS / f"{name}.yaml").model_copy(update={"obstacles": (), "beacons": ()})
    assert apart(world, world_from_map(write_map(world, tmp_path, resolution=0.05))) <= 0.025


def test_a_map_that_lies_turned_comes_back_turned(tmp_path):
    path = write_map(parse_world(ROOM), tmp_path)
    path.write_text(path.read_text().replace("origin: [-1.05, -1.05, 0]", "origin: [10, 20, 0.5]"))
    assert "0.5]" in path.read_text()
    c, s = math.cos(0.5), math.sin(0.5)
    corners = np.array(world_from_map(path).walls[0].points)
    expected = np.array([[0, 0], [6, 0], [6, 4], [0, 4]]) + 1.05
    expected = expected @ [[c, s], [-s, c]] + [10, 20]
    for corner in expected:
        assert np.hypot(*(corners - corner).T).min() <= 0.025


@pytest.mark.parametrize(
    ("text", "occupied", "free"),
    [
        ("", [0, 60], [254, 255]),  # 100 is a share of 0.61: between the thresholds, unknown
        ("mode: trinary\nnegate: 1\noccupied_thresh: 0.9\nfree_thresh: 0.3\n", [254, 255], [0, 60]),
        ("mode: scale\noccupied_thresh: 0.8\nfree_thresh: 0.2\n", [0, 60, 100], [205, 254, 255]),
        ("mode: raw\n", [100], [0]),  # 101 to 255 are unknown, 60 lies between the thresholds
    ],
)
def test_gray_becomes_occupied_and_free_as_map_server_reads_it(text, occupied, free, tmp_path):
    grid = read_grid(written(tmp_path, PIXELS, text))
    picture = PIXELS[::-1]  # the first row of a picture is the highest in y
    assert set(picture[grid.occupied].tolist()) == set(occupied)
    assert set(picture[grid.free].tolist()) == set(free)


def test_a_robot_stands_in_the_widest_place_of_a_map(tmp_path):
    world = with_robot(world_from_map(write_map(parse_world(ROOM), tmp_path)))
    assert not check_world(world)
    x, y = world.robots[0].at
    assert min(x, 6 - x, y, 4 - y) == pytest.approx(2.0, abs=0.05)


@pytest.mark.slow
def test_a_picture_of_noise_is_no_map(tmp_path):
    noise = np.random.default_rng(0).integers(0, 256, (250, 250)).astype(np.uint8)
    with pytest.raises(UsageError, match="straight lines, and that of a building at most 4000; clean it"):
        world_from_map(written(tmp_path, noise))


def test_what_is_not_a_map_is_refused_in_one_line(tmp_path):
    path = written(tmp_path, PIXELS)
    large = b"P5\n10000 5000\n255\n"
    for text, picture, message in [
        ("walls: []\n", None, "this is not a map; it names an image, a resolution and an origin"),
        ("image: map.pgm\n", None, "resolution is None; it must be a number"),
        ("image: map.pgm\nresolution: 0\n", None, "resolution is 0 m; a map has cells of 0.001 to 10 m"),
        ("image: ../map.pgm\nresolution: 0.05\n", None, "leaves its folder; put it beside the YAML file"),
        ("image: gone.pgm\nresolution: 0.05\n", None, "gone.pgm'; name the picture of a map"),
        ("image: map.pgm\nresolution: 0.05\norigin: [0, a, 0]\n", None, "write [x, y, yaw] in metres"),
        ("image: map.pgm\nresolution: 0.05\nmode: gray\n", None, "mode is 'gray'; it must be trinary, scale or raw"),
        ("image: map.pgm\nresolution: 0.05\n", large, "is a picture of 50 megapixels; it must have at most 40"),
        ("image: map.pgm\nresolution: 0.05\n", b"P5\n3 2\n255\n", "is cut short; 3 x 2 pixels are as many bytes"),
        ("image: map.pgm\nresolution: 0.05\n", b"GIF89a", "is not a PNG or JPEG picture; convert it"),
    ]:
        path.write_text(text)
        if picture is not None:
            (tmp_path / "map.pgm").write_bytes(picture)
        with pytest.raises(UsageError) as caught:
            world_from_map(path)
        assert message in str(caught.value)
        assert "\n" not in str(caught.value)
