"""Maps as robots make them, noisy, turned and edited by hand, become worlds in which a robot drives."""

import math
from pathlib import Path

import cv2
import numpy as np
import pytest
import shapely

import mjsim
from mjsim.algorithms.waypoints import Waypoints
from mjsim.bench.robot_maps import mapped, mapped_with_pose
from mjsim.exchange import with_robot, world_from_map, write_map
from mjsim.exchange.maps import fidelity
from mjsim.exchange.maps.grid_files import read_grid, write_grid
from mjsim.world import World, check_world, load_world, solid

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
