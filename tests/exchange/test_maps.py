"""Maps of robots come in as walls, and worlds go out as maps."""

import math
import struct
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest
import shapely
from PIL import Image

from mjsim.errors import UsageError
from mjsim.exchange import with_robot, world_from_map, write_map
from mjsim.exchange.maps import fidelity
from mjsim.exchange.maps.grid_files import read_grid, write_grid
from mjsim.exchange.maps.maps import world_from_grid
from mjsim.exchange.maps.trace import rectangles_for
from mjsim.exchange.start_place import with_newcomer, without_route
from mjsim.exchange.world_import import Newcomer
from mjsim.geometry import Pose
from mjsim.world import (
    BoxObstacle,
    Grid,
    Wall,
    World,
    cells_of,
    check_world,
    format_world,
    grid_of,
    load_world,
    parse_world,
    solid,
)

WORLDS = Path(__file__).parents[2] / "worlds"
ROOM = "mjsim: 1\nwalls: [{points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true}]\n"
HUGE_PNG = b"\x89PNG\r\n\x1a\n" + b"".join(
    struct.pack(">I4s", len(data), kind) + data + struct.pack(">I", zlib.crc32(kind + data))
    for kind, data in ((b"IHDR", struct.pack(">IIBBBBB", 100_000, 100_000, 8, 0, 0, 0, 0)), (b"IEND", b""))
)
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


@pytest.mark.slow
@pytest.mark.parametrize("name", ["empty", "maze", "museum", "dark", "cloister"])
def test_a_world_that_goes_out_as_a_map_comes_back_within_half_a_cell(name, tmp_path):
    world = load_world(WORLDS / f"{name}.yaml")
    path = write_map(world, tmp_path, resolution=0.05)
    back = world_from_map(path)
    assert apart(world, back) <= 0.025
    found = fidelity(back, read_grid(path))
    assert (found.touched, found.covered) == (found.occupied, 0)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["arena", "clutter", "corridor", "gallery", "office", "ramps", "sensors", "warehouse"])
def test_the_walls_of_a_shipped_world_come_back_within_half_a_cell(name, tmp_path):
    world = load_world(WORLDS / f"{name}.yaml").model_copy(update={"obstacles": (), "beacons": ()})
    assert apart(world, world_from_map(write_map(world, tmp_path, resolution=0.05))) <= 0.025


@pytest.mark.slow
def test_the_outside_of_a_hall_with_gates_is_unknown():
    grid = grid_of(load_world("warehouse"), resolution=0.1)
    x, y = np.meshgrid(*(np.arange(0.0, size) + 0.5 for size in grid.occupied.shape[::-1]))
    places = grid.corners(np.stack([x, y], axis=-1))
    hall = (places > [0.0, 0.0]) & (places < [60.0, 30.0])
    outside = ((places < [-0.3, -0.3]) | (places > [60.3, 30.3])).any(axis=-1)
    assert not grid.free[outside].any()
    assert (grid.free | grid.occupied)[hall.all(axis=-1)].all()
    # A gate is open: its middle is free.
    column, row = np.floor(grid.cells(np.array([0.0, 30.0 - 4.0 - 1.6]))).astype(int)
    assert grid.free[row, column]


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
        ("mode: Scale\noccupied_thresh: 0.65\nfree_thresh: 0.25\n", [0, 60, 100], [205, 254, 255]),
        ("negate: no\n", [0, 60], [254, 255]),
        ("negate: 'true'\n", [205, 254, 255], [0]),
        ("mode: raw\n", [100], [0]),  # 101 to 255 are unknown, 60 lies between the thresholds
    ],
)
def test_gray_becomes_occupied_and_free_as_map_server_reads_it(text, occupied, free, tmp_path):
    grid = read_grid(written(tmp_path, PIXELS, text))
    picture = PIXELS[::-1]  # the first row of a picture is the highest in y
    assert set(picture[grid.occupied].tolist()) == set(occupied)
    assert set(picture[grid.free].tolist()) == set(free)


def test_middle_gray_of_the_mode_scale_is_unknown(tmp_path):
    grays = np.array([[0, 126, 127], [128, 129, 255]], dtype=np.uint8)
    grid = read_grid(written(tmp_path, grays, "mode: scale\noccupied_thresh: 0.65\nfree_thresh: 0.25\n"))
    assert (grid.occupied[::-1] == [[True, True, False], [False, True, False]]).all()
    assert (grid.free[::-1] == [[False, False, False], [False, False, True]]).all()


@pytest.mark.parametrize("name", ["/home/me/map.pgm", "C:\\maps\\map.pgm", "~/maps/map.pgm", "./map.pgm"])
def test_a_picture_named_by_its_path_on_another_machine_is_looked_for_beside_the_yaml_file(name, tmp_path):
    path = written(tmp_path, PIXELS)
    expected = read_grid(path).occupied
    path.write_text(path.read_text().replace("image: map.pgm", f"image: {name}"))
    assert name in path.read_text()
    assert (read_grid(path).occupied == expected).all()


def test_a_picture_alone_is_a_map_when_the_side_of_a_pixel_is_given(tmp_path):
    grid = read_grid(write_map(parse_world(ROOM), tmp_path))
    alone = read_grid(tmp_path / "map.pgm", resolution=0.1)
    assert (alone.occupied == grid.occupied).all()
    assert alone.resolution == 0.1
    with pytest.raises(UsageError, match=r"is a map image; name '.*map.yaml' beside it"):
        read_grid(tmp_path / "map.pgm")
    with pytest.raises(UsageError, match=r"the YAML file of a map states its resolution; leave out --scale"):
        read_grid(tmp_path / "map.yaml", resolution=0.1)
    (tmp_path / "map.yaml").unlink()
    with pytest.raises(UsageError, match=r"name the YAML file beside it, or give --scale METRES to a pixel"):
        read_grid(tmp_path / "map.pgm")


def test_a_robot_starts_in_the_building_not_on_the_paper_around_it(tmp_path):
    picture = np.full((200, 300), 255, dtype=np.uint8)
    cv2.rectangle(picture, (180, 20), (280, 100), 0, 3)
    cv2.imwrite(str(tmp_path / "plan.png"), picture)
    grid = read_grid(tmp_path / "plan.png", resolution=0.05)
    world = with_robot(world_from_grid(grid), grid=grid)
    column, row = grid.cells(np.array(world.robots[0].at))
    assert 180 < column < 280
    assert 100 < row < 180


def test_two_faces_of_fine_cells_with_the_unknown_between_them_are_walls():
    occupied = np.zeros((160, 240), dtype=bool)
    for inset in (4, 10):
        cv2.rectangle(view := occupied.astype(np.uint8), (inset, inset), (239 - inset, 159 - inset), 1, 1)
        occupied |= view > 0
    free = np.zeros_like(occupied)
    free[11:149, 11:229] = True
    grid = Grid(occupied, free, 0.025, Pose(0.0, 0.0, 0.0))
    assert np.count_nonzero(occupied) > 1000
    (wall,) = world_from_grid(grid).walls
    assert wall.closed
    assert wall.thickness == pytest.approx(7 * 0.025, abs=0.01)


@pytest.mark.parametrize("turn", [0.0, 0.05])
def test_a_shelf_that_leans_on_a_wall_is_one_thing_in_coarse_cells(turn):
    shelf = World(obstacles=(BoxObstacle(name="shelf", box=(2.0, 0.5, 1.0), at=(5.0, 5.6), heading_deg=0.0),))
    room = Wall(name="room", points=((0, 0), (9, 0), (9, 6), (0, 6)), closed=True, thickness=0.2)
    c, s = math.cos(turn), math.sin(turn)
    shape = shapely.transform(solid(World(walls=(room,), obstacles=shelf.obstacles)), lambda p: p @ [[c, s], [-s, c]])
    frame = Grid(np.zeros((80, 110), dtype=bool), np.zeros((80, 110), dtype=bool), 0.1, Pose(-1.0, -1.0, 0.0))
    occupied = cells_of(shape.buffer(0.02), frame)
    world = world_from_grid(Grid(occupied, ~occupied, 0.1, frame.world_from_grid))
    assert len(world.walls) == 1
    (thing,) = world.obstacles
    assert thing.box[:2] == pytest.approx((2.0, 0.5), abs=0.2)


def test_pictures_of_any_depth_and_channels_are_the_same_map(tmp_path):
    expected = read_grid(written(tmp_path, PIXELS)).occupied
    rows, columns = PIXELS.shape
    flat = Image.fromarray(PIXELS)
    # Channels that differ and have the gray value as their mean.
    tint = np.stack([np.clip(PIXELS.astype(int) + shift, 0, 255) for shift in (-1, 0, 1)], axis=-1).astype(np.uint8)
    clear = np.dstack([PIXELS, np.array([[255, 255, 255], [255, 255, 0]], dtype=np.uint8)])
    text = " ".join(map(str, PIXELS.ravel().tolist()))
    deep = (PIXELS.astype(">u2") * 257).tobytes()
    size = b"%d %d\n" % (columns, rows)
    files = {
        "p2.pgm": b"P2\n# a comment\n" + size + b"255\n" + text.encode(),
        "p5.pgm": b"P5\n" + size + b"65535\n" + deep,
        "p6.ppm": b"P6\n" + size + b"255\n" + tint.tobytes(),
        "percent.pgm": b"P5\n" + size + b"51\n" + (PIXELS // 5).tobytes(),
    }
    for name, data in files.items():
        (tmp_path / name).write_bytes(data)
    flat.save(tmp_path / "gray.png")
    flat.convert("RGB").save(tmp_path / "rgb.png")
    flat.save(tmp_path / "gray.bmp")
    flat.convert("P").save(tmp_path / "palette.png")
    Image.fromarray(clear, "LA").save(tmp_path / "clear.png")
    Image.fromarray(PIXELS.astype(np.uint16) * 257).save(tmp_path / "deep.png")
    for name in (*files, "gray.png", "gray.bmp", "rgb.png", "palette.png", "clear.png", "deep.png"):
        path = tmp_path / "map.yaml"
        path.write_text(f"image: {name}\nresolution: 0.05\n")
        grid = read_grid(path)
        if name == "clear.png":  # a pixel that nobody sees is unknown
            assert not grid.occupied[0, 2]
            grid.occupied[0, 2] = expected[0, 2]
        assert (grid.occupied == expected).all(), name


def test_a_robot_stands_in_the_widest_place_of_a_map(tmp_path):
    world = with_robot(world_from_map(write_map(parse_world(ROOM), tmp_path)))
    assert not check_world(world)
    x, y = world.robots[0].at
    assert min(x, 6 - x, y, 4 - y) == pytest.approx(2.0, abs=0.05)


def test_a_robot_starts_where_it_can_drive_or_it_is_said_that_it_stands_still(tmp_path):
    cell = "  - {name: cell, points: [[0, 0], [2, 0], [2, 2], [0, 2]], closed: true}\n"
    corridor = "  - {name: corridor, points: [[4, 0], [12, 0], [12, 1.4], [4, 1.4]], closed: true}\n"
    for text, begins, said in (
        (cell + corridor, 4.0, []),
        (
            cell.replace("2", "1.2"),
            0.0,
            ["no straight path of 1 m is wide enough for the pioneer3dx; it does not drive"],
        ),
    ):
        world = with_robot(world_from_map(write_map(parse_world(f"mjsim: 1\nwalls:\n{text}"), tmp_path / str(begins))))
        assert not check_world(world)
        assert world.robots[0].at[0] > begins
        assert without_route(world) == said


def ring_with_core(core: int) -> np.ndarray:
    """Return a map of a corridor 1.5 m wide around a block of 4 m whose inside has a gray value; cells of 5 cm."""
    picture = np.full((160, 160), 205, dtype=np.uint8)
    picture[10:150, 10:150] = 0
    picture[12:148, 12:148] = 254
    picture[42:118, 42:118] = 0
    picture[44:116, 44:116] = core
    return picture


def test_unknown_cells_of_map_savers_are_no_free_space_at_any_threshold(tmp_path):
    for negate, free in ((0, False), (1, True)):
        picture = ring_with_core(205) if not negate else 255 - ring_with_core(205)
        grid = read_grid(written(tmp_path, picture, f"free_thresh: 0.25\nnegate: {negate}\n"))
        assert grid.free[80, 80] == free  # only map savers write 205, and they never negate
        assert grid.free[80, 20]
    grid = read_grid(written(tmp_path, ring_with_core(205), "free_thresh: 0.25\n"))
    x, y = with_robot(world_from_grid(grid), grid=grid).robots[0].at
    assert not (2.0 < x < 6.0 and 2.0 < y < 6.0)


def test_a_robot_starts_in_the_largest_area_and_closed_rooms_are_told(tmp_path):
    grid = read_grid(written(tmp_path, ring_with_core(254)))  # the block is wider than the corridor
    world, told = with_newcomer(world_from_grid(grid), Newcomer("turtlebot3_burger"), grid=grid)
    x, y = world.robots[0].at
    assert not (2.0 < x < 6.0 and 2.0 < y < 6.0)
    assert told == ["1 free area has no path to the robot that is wide enough: around [4.0, 4.0] (10 m2)"]


@pytest.mark.parametrize("start", [(100.0, 10.0), (-100.0, 10.0), (10.0, 1e300)])
def test_a_start_outside_the_map_is_not_free(tmp_path, start):
    picture = np.full((20, 20), 254, dtype=np.uint8)
    picture[[0, 0, -1, -1], [0, -1, 0, -1]] = 0  # rims of the map are free between its corners
    grid = read_grid(written(tmp_path, picture, resolution=1.0))
    world, told = with_newcomer(world_from_grid(grid), Newcomer("turtlebot3_burger"), grid=grid, start=(*start, 0.0))
    assert any("is not free; the robot is elsewhere" in line for line in told)
    assert all(0.0 < place < 20.0 for place in world.robots[0].at)


def test_a_robot_that_balances_gets_the_inertial_sensor_that_levels_its_scans(tmp_path):
    bare = world_from_map(write_map(parse_world(ROOM), tmp_path))
    for preset, kinds in [("balancer", ["imu", "lidar"]), ("turtlebot3_burger", ["lidar"])]:
        world = with_robot(bare, preset=preset, lidar="lds-02")
        assert parse_world(format_world(world)) == world
        assert [sensor.kind for sensor in world.robots[0].sensors] == kinds


@pytest.mark.slow
def test_a_picture_of_noise_is_refused_as_a_map(tmp_path):
    noise = np.random.default_rng(0).integers(0, 256, (250, 250)).astype(np.uint8)
    with pytest.raises(UsageError, match="has gaps everywhere, like noise; clean it"):
        world_from_map(written(tmp_path, noise))


def test_what_is_not_a_map_is_refused_in_one_line(tmp_path):
    path = written(tmp_path, PIXELS)
    large = b"P5\n10000 5000\n255\n"
    for text, picture, message in [
        ("walls: []\n", None, "this is not a map; a map names an image, a resolution and an origin"),
        ("mjsim: 1\nname: a\n", None, "this is already a world of mjsim; run it, or copy it"),
        ("image: map.pgm\n", None, "key 'resolution' is missing; add it: side of a cell [m]"),
        ("image: map.pgm\nresolution: 0\n", None, "map.yaml:2:13: resolution is 0 m; cells must be 0.001 to 10 m"),
        ("image: ../map.pgm\nresolution: 0.05\n", None, "is outside its folder; put it beside the YAML file"),
        ("image: gone.pgm\nresolution: 0.05\n", None, "map.yaml:1:8: no file 'gone.pgm' beside it; name the picture"),
        ("image: map.pgm\nresolution: 0.05\norigin: [0, a, 0]\n", None, "write [x, y, yaw] in metres"),
        ("image: map.pgm\nresolution: 0.05\n", b"", "is empty; write a PGM or PNG picture"),
        (
            "image: map.pgm\nresolution: 0.05\norigin: [0, 0, 90]\n",
            None,
            "map.yaml:3:9: the yaw of origin is 90 rad; it must be between -6.3 and 6.3",
        ),
        ("image: map.pgm\nresolution: 0.05\nmode: gray\n", None, "mode is 'gray'; it must be trinary, scale or raw"),
        ("image: map.pgm\nresolution: 0.05\nnegate: maybe\n", None, "negate is 'maybe'; it must be 0 or 1"),
        ("image: map.pgm\nresolution: 0.05\n", large, "is a picture of 50 megapixels; it must have at most 40"),
        ("image: map.pgm\nresolution: 0.05\n", b"P5\n3 2\n255\n", "is truncated; 3 x 2 pixels need 6 numbers"),
        ("image: map.pgm\nresolution: 0.05\n", b"P6\n100000 100000\n255\n", "is a picture of 10000 megapixels;"),
        ("image: map.pgm\nresolution: 0.05\n", HUGE_PNG, "is a picture of 10000 megapixels; it must have at most 40"),
        ("image: map.pgm\nresolution: 0.05\n", b"P2\n2 1\n255\n0 black\n", "holds a value that is not a number"),
        (
            "image: map.pgm\nresolution: 0.05\n",
            b"P5\n2 1\n99999\n0 0",
            "of 2 x 1 pixels with values up to 99999; write 8 or 16",
        ),
        ("image: map.pgm\nresolution: .nan\n", None, "resolution is nan; it must be a number"),
        ("image: map.pgm\nresolution: 0.05\nfree_thresh: 0.9\n", None, "free_thresh below"),
        ("image: [1, 2]\nresolution: 0.05\n", None, "name the picture of a map"),
        ("a: [\n", None, "map.yaml:2"),
        ("image: map.pgm\nresolution: 0.05\n", b"BM" + bytes(16) + b"\0\0\1\0" * 2, "is a picture of 4295 megapixels;"),
        ("image: map.pgm\nresolution: 0.05\n", b"BM", "is a truncated picture; save it again"),
        ("image: map.pgm\nresolution: 0.05\n", b"GIF89a", "is not a PGM, PPM, PNG or JPEG picture; convert it"),
    ]:
        path.write_text(text)
        if picture is not None:
            (tmp_path / "map.pgm").write_bytes(picture)
        with pytest.raises(UsageError) as caught:
            world_from_map(path)
        assert message in str(caught.value)
        assert "\n" not in str(caught.value)


def test_what_is_left_over_is_cut_until_nothing_stands_where_there_are_no_cells():
    x = np.arange(0.5, 2000.0)
    legs = [np.column_stack([x, np.full(2000, y)]) for y in (0.5, 12.5)]
    hairpin = np.concatenate([*legs, np.column_stack([np.full(11, 1999.5), np.arange(1.5, 12.0)])])
    bars = rectangles_for(hairpin, 0)
    assert sum(bar.length * bar.width for bar in bars) < 1.2 * len(hairpin)


def test_the_last_row_of_the_picture_is_that_of_the_smallest_y(tmp_path):
    occupied = np.array([[True, False, False], [False, False, False]])
    free = np.array([[False, True, False], [False, False, True]])
    file = write_grid(Grid(occupied, free, 0.5, Pose(1.0, 2.0, 0.25)), tmp_path)
    # 0 is occupied, 254 free, 205 unknown, as map_saver writes them.
    assert (tmp_path / "map.pgm").read_bytes() == b"P5\n3 2\n255\n" + bytes([205, 205, 254, 0, 254, 205])
    assert "resolution: 0.5\norigin: [1, 2, 0.25]\nnegate: 0\n" in file.read_text()
    back = read_grid(file)
    np.testing.assert_array_equal(back.occupied, occupied)
    np.testing.assert_array_equal(back.free, free)
    assert (back.resolution, back.world_from_grid) == (0.5, Pose(1.0, 2.0, 0.25))
    with pytest.raises(UsageError, match="exists"):
        write_grid(back, tmp_path)


def test_tabs_between_words_and_at_ends_of_lines_of_a_map_file_are_spaces(tmp_path):
    Image.fromarray(np.pad(np.full((40, 60), 254, dtype=np.uint8), 3)).save(tmp_path / "m.png")
    text = "image: m.png\t\nresolution:\t0.05 \t# fine\norigin: [0,\t0, 0]\t\nnegate: 0\t\n"
    (tmp_path / "m.yaml").write_text(text + "occupied_thresh: 0.65\nfree_thresh: 0.196\n")
    assert read_grid(tmp_path / "m.yaml").occupied.sum() == 46 * 66 - 40 * 60
