"""Maps as robots make them, noisy, turned and edited by hand, become worlds in which a robot drives."""

import math
from pathlib import Path

import cv2
import numpy as np
import pytest
import shapely

import mjsim
from mjsim import UsageError
from mjsim.algorithms.waypoints import Waypoints
from mjsim.bench.robot_maps import mapped, mapped_with_pose
from mjsim.exchange import with_robot, world_from_map, write_map
from mjsim.exchange.maps import fidelity
from mjsim.exchange.maps.grid_files import read_grid, write_grid
from mjsim.exchange.start_place import with_newcomer
from mjsim.exchange.world_import import Newcomer
from mjsim.world import World, check_world, load_world, parse_world, solid

WORLDS = Path(__file__).parents[2] / "worlds"


def edited(folder: Path) -> Path:
    """Draw a map by hand, as people mend them in paint programs: gray walls, a desk, an L, scribbles, holes."""
    picture = np.full((160, 220), 205, dtype=np.uint8)
    cv2.rectangle(picture, (20, 20), (200, 140), 254, -1)
    cv2.rectangle(picture, (20, 20), (200, 140), 0, 2)
    cv2.line(picture, (110, 20), (112, 85), 20, 3)
    cv2.line(picture, (150, 100), (200, 101), 10, 2)
    cv2.rectangle(picture, (40, 95), (70, 112), 0, -1)
    cv2.circle(picture, (165, 60), 6, 30, -1)
    picture[60:68, 18:23] = 254
    cv2.imwrite(str(folder / "hall.png"), 255 - picture)
    (folder / "hall.yaml").write_text(
        "image: hall.png\nresolution: 0.05\norigin: [-3, 2, 0.4]\nnegate: 1\nmode: scale\n"
    )
    return folder / "hall.yaml"


def driven(world: World, seconds: float) -> np.ndarray:
    """Return where the world's own waypoints lead its robot, x, y and the height of its base, shape (n, 3) [m]."""
    points = world.run.drivers["scout"].navigator.model_dump()["points"]
    places = []
    with mjsim.Simulation(world, seed=1) as sim:
        for tick in mjsim.ticks(sim, {"scout": mjsim.Driver(navigator=Waypoints(points=points), avoidance=True)}):
            if tick.time >= seconds:
                return np.array(places)
            places.append((tick.truth["scout"].x, tick.truth["scout"].y, sim.data.body("scout/base").xpos[2]))
    raise AssertionError("ticks never end")


@pytest.mark.slow
@pytest.mark.parametrize(("name", "turn"), [("museum", 0.3), ("maze", 0.2)])
def test_a_noisy_turned_map_comes_back_as_straight_square_walls(name, turn, tmp_path):
    world = load_world(WORLDS / f"{name}.yaml")
    grid, map_from_world = mapped_with_pose(world, turn=turn, seed=3)
    path = write_grid(grid, tmp_path)
    back = world_from_map(path)
    found = fidelity(back, read_grid(path))
    assert found.touched >= 0.985 * found.occupied
    assert found.covered == 0
    turned: shapely.Geometry = shapely.transform(solid(world), map_from_world.transform)
    assert turned.boundary.hausdorff_distance(solid(back).boundary) < 0.1  # two cells
    for wall in back.walls:
        for (x0, y0), (x1, y1) in wall.segments():
            if math.hypot(x1 - x0, y1 - y0) > 1.0:
                off = math.degrees(math.atan2(y1 - y0, x1 - x0) - turn)
                assert abs((off + 45.0) % 90.0 - 45.0) < 0.25
    assert sum(len(wall.segments()) for wall in back.walls) <= 1.3 * sum(len(w.segments()) for w in world.walls) + 10


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["exported", "noisy", "edited"])
def test_a_robot_drives_in_what_a_map_became(kind, tmp_path):
    if kind == "exported":
        path = write_map(load_world(WORLDS / "gallery.yaml"), tmp_path, resolution=0.05)
    elif kind == "noisy":
        path = write_grid(mapped(load_world(WORLDS / "museum.yaml"), turn=-0.4, seed=5), tmp_path)
    else:
        path = edited(tmp_path)
    grid = read_grid(path)
    world = with_robot(world_from_map(path), grid=grid)
    assert not check_world(world)
    found = fidelity(world, grid)
    assert found.touched >= 0.98 * found.occupied
    places = driven(world, 15.0)
    way = np.hypot(*np.diff(places[:, :2], axis=0).T).sum()
    assert way > 2.0
    assert np.ptp(places[:, 2]) < 0.02  # it neither falls through the floor nor climbs a wall
    walls = solid(world)
    assert min(walls.distance(shapely.Point(place)) for place in places[::5, :2]) > 0.15
    cells = np.floor(grid.cells(places[:, :2])).astype(int)
    assert grid.free[cells[:, 1], cells[:, 0]].mean() > 0.97


def bars(rows: str, *, thickness: float, height: float) -> World:
    """Return a world of single walls."""
    walls = "".join(f"  - {{points: {row}, thickness: {thickness}, height: {height}}}\n" for row in rows.split("; "))
    return parse_world(f"mjsim: 1\nwalls:\n{walls}")


def test_a_pen_of_barriers_with_gaps_has_its_space_between_them():
    sides = "; ".join(f"[[{x}, {y}], [{x + 3}, {y}]]" for x in (0, 5) for y in (0, 8))
    ends = "; ".join(f"[[{x}, {y}], [{x}, {y + 2}]]" for x in (-0.5, 8.5) for y in (0.5, 5.5))
    world = with_robot(bars(f"{sides}; {ends}", thickness=0.3, height=1.0))
    assert not check_world(world)
    x, y = world.robots[0].at
    assert solid(world).distance(shapely.Point(x, y)) > 2


def test_a_world_too_narrow_for_the_usual_robot_has_none_and_one_that_was_named_is_refused():
    cell = "[[0, 0], [0.5, 0]]; [[0.5, 0], [0.5, 0.5]]; [[0.5, 0.5], [0, 0.5]]; [[0, 0.5], [0, 0]]"
    world = bars(cell, thickness=0.02, height=0.3)
    same, told = with_newcomer(world, Newcomer(is_usual=True))
    assert same is world
    assert told[0].startswith("no robot: the widest free space of this world is 0.3")
    with pytest.raises(UsageError, match="the pioneer3dx needs"):
        with_newcomer(world, Newcomer())


def test_walls_thinner_than_a_cell_and_lower_than_a_lidar_are_no_free_space():
    thin = "; ".join(f"[[{x}, 0], [{x}, 3]]; [[0, {x}], [3, {x}]]" for x in np.arange(0, 3.1, 0.6).round(2).tolist())
    world = bars(thin, thickness=0.012, height=0.05)
    inhabited = with_robot(world)
    assert not check_world(inhabited)
    assert solid(world, height=0.02).distance(shapely.Point(inhabited.robots[0].at)) > 0.37
