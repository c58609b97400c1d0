"""Maps of others become worlds that explain them, of few walls, in which a robot knows where it is."""

import math
import time
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import shapely

from mjsim.bench.robot_maps import Noise, mapped
from mjsim.cli import main
from mjsim.errors import UsageError
from mjsim.exchange import read_grid, world_from_map
from mjsim.exchange.import_world import bring_map
from mjsim.exchange.maps import fidelity
from mjsim.exchange.maps.grid_files import write_grid
from mjsim.exchange.maps.maps import WALL_HEIGHT, specks, world_from_grid
from mjsim.geometry import Pose
from mjsim.record import read_recording
from mjsim.world import Grid, World, load_world, solid

MAPS = Path(__file__).parents[1] / "data" / "maps"
FIGURES = {
    "cave": (0.97, 50),
    "depot": (0.97, 100),
    "drawn": (0.97, 40),
    "house": (0.97, 190),
    "tb3_sandbox": (0.97, 5),
}
"""Least share of occupied cells explained, most walls. Of `intel`, whose walls are bent, see below."""


@cache
def brought(name: str) -> tuple[Grid, World]:
    path = MAPS / f"{name}.yaml"
    return read_grid(path), world_from_map(path)


LARGE = {"cave", "depot", "house"}


@pytest.mark.slow
@pytest.mark.parametrize("name", [pytest.param(n, marks=[pytest.mark.slow] if n in LARGE else []) for n in FIGURES])
def test_a_world_explains_the_map_of_others_in_few_walls(name):
    grid, world = brought(name)
    found = fidelity(world, grid)
    least, most = FIGURES[name]
    assert found.share >= least
    assert len(world.walls) <= most
    # Crates of the depot are seen from some sides only.
    assert found.false_walls <= (0.03 if name == "depot" else 0.005)
    assert found.covered <= 0.06 * found.solid


@pytest.mark.slow
def test_raw_lidar_cells_along_drifting_odometry_are_mostly_explained():
    grid, world = brought("intel")
    found = fidelity(world, grid)
    assert found.share >= 0.97
    assert found.false_walls <= 0.03  # rows of cells with gaps below 0.3 m are walls
    assert len(world.walls) <= 135


def test_explained_cells_are_those_within_one_cell_of_something_solid():
    grid, world = brought("tb3_sandbox")
    rows, columns = np.nonzero(grid.occupied)
    middles = shapely.points(grid.corners(np.column_stack([columns, rows]) + 0.5))
    shape = solid(world)
    near = shapely.distance(shape, middles) <= grid.resolution
    assert fidelity(world, grid).explained == np.count_nonzero(near)
    half = World(walls=world.walls[:1])
    near = shapely.distance(solid(half), middles) <= grid.resolution
    # Middles on the very edge of the round corners of a buffer.
    assert fidelity(half, grid).explained == pytest.approx(np.count_nonzero(near), abs=3)


def test_a_wall_that_no_cell_speaks_for_is_counted_as_false():
    grid, world = brought("tb3_sandbox")
    length = sum(math.dist(*segment) for wall in world.walls for segment in wall.segments())
    lie = world.walls[0].model_copy(update={"points": ((-2.0, 0.6), (-0.5, 0.6)), "closed": False, "name": "lie"})
    false = fidelity(world.model_copy(update={"walls": (*world.walls, lie)}), grid).false_walls
    assert false == pytest.approx(1.5 / (length + 1.5), abs=0.01)


def test_columns_that_a_lidar_sees_as_rings_are_cylinders():
    _, world = brought("tb3_sandbox")
    # TurtleBot3's world has nine columns of 0.15 m radius, 1.1 m apart, about its middle.
    columns = np.array(sorted(item.at for item in world.obstacles))
    assert len(columns) == 9
    expected = np.array(sorted((x, y) for x in (-1.1, 0.0, 1.1) for y in (-1.1, 0.0, 1.1)))
    offset = columns.mean(axis=0)
    apart = columns - offset
    assert max(np.hypot(*(apart - place).T).min() for place in expected) < 0.1
    assert all(0.12 < item.cylinder[0] < 0.22 for item in world.obstacles)


@pytest.mark.slow
def test_fragments_of_a_noisy_map_of_fine_cells_are_joined():
    noise = Noise(fray=0.3, missed=0.10, specks=2e-3)
    grid = mapped(load_world("museum"), turn=0.1, seed=2, resolution=0.02, noise=noise)
    world = world_from_grid(grid)
    assert len(world.walls) <= 12
    assert len(world.obstacles) <= 50
    assert fidelity(world, grid).share >= 0.96  # a tenth of all specks are nowhere near a wall


def speckled(grid: Grid, share: float) -> Grid:
    """Return a grid of which a share of all cells is occupied at random."""
    specks = np.random.default_rng(7).random(grid.occupied.shape) < share
    return Grid(grid.occupied | specks, grid.free & ~specks, grid.resolution, grid.world_from_grid)


@pytest.mark.parametrize("share", [0.005, pytest.param(0.085, marks=pytest.mark.slow)])
def test_specks_are_told_from_walls_and_counted_however_dense_they_are(share):
    grid, _ = brought("tb3_sandbox")
    noisy = speckled(grid, share)
    world, noise = world_from_grid(noisy), specks(noisy)
    found = fidelity(world, noisy)
    assert found.explained >= 0.97 * (found.occupied - noise)
    assert found.false_walls < 0.01
    lone = np.count_nonzero(noisy.occupied & ~grid.occupied)
    assert noise == pytest.approx(lone, rel=0.15)  # others of them touch walls, or lie in a row by chance
    assert len(world.walls) <= 10


def test_a_map_of_noise_alone_is_refused(tmp_path):
    nothing = np.zeros((200, 200), dtype=bool)
    path = write_grid(speckled(Grid(nothing, ~nothing, 0.05, Pose(0.0, 0.0, 0.0)), 0.03), tmp_path)
    with pytest.raises(UsageError, match=r"all of its 11\d\d occupied cells are noise"):
        bring_map(path, robot=None)


def test_a_map_that_is_all_occupied_is_refused(tmp_path):
    everything = np.ones((80, 100), dtype=bool)
    path = write_grid(Grid(everything, ~everything, 0.05, Pose(0.0, 0.0, 0.0)), tmp_path)
    with pytest.raises(
        UsageError, match=r"map\.yaml: all of its cells are occupied; check the gray values of its floor"
    ):
        bring_map(path, robot=None)


def test_legs_of_a_chair_are_not_joined_to_walls():
    occupied = np.zeros((60, 80), dtype=bool)
    for row, column in ((20, 20), (20, 27), (27, 20), (27, 27)):
        occupied[row : row + 2, column : column + 2] = True
    world = world_from_grid(Grid(occupied, ~occupied, 0.05, Pose(0.0, 0.0, 0.0)))
    assert not world.walls
    assert len(world.obstacles) == 4


def test_a_thin_box_beside_a_wall_is_as_high_as_the_wall():
    occupied = np.zeros((120, 160), dtype=bool)
    occupied[20:23, 20:140] = True
    occupied[23:27, 60:66] = True  # leans on the wall
    occupied[60:70, 60:72] = True  # stands in the room
    grid = Grid(occupied, ~occupied, 0.05, Pose(0.0, 0.0, 0.0))
    world = world_from_grid(grid)
    assert sorted(item.box[2] for item in world.obstacles) == [1.0, WALL_HEIGHT]
    assert fidelity(world, grid).share == 1.0


@pytest.mark.slow
def test_a_robot_localises_in_the_depot_to_three_centimetres(tmp_path):
    world, run = tmp_path / "depot.yaml", tmp_path / "run.mcap"
    line = ["new", "--from", str(MAPS / "depot.yaml"), "--robot", "turtlebot3_burger", "--lidar", "lds-02"]
    assert _typed(*line, "--estimator", "monte_carlo", "-o", str(world)) == 0
    assert _typed("run", str(world), "--seconds", "8", "--seed", "1", "-o", str(run)) == 0
    robot = read_recording(run).robots["scout"]
    apart = np.hypot(*(robot.truth[:, :2] - robot.estimate[:, :2]).T)
    assert math.sqrt(float(np.mean(apart**2))) <= 0.03
    assert np.hypot(*np.diff(robot.truth[:, :2], axis=0).T).sum() > 0.8


@pytest.mark.slow
def test_a_thousand_cells_square_come_in_within_seconds():
    grid = mapped(load_world("office"), turn=0.3, seed=1, resolution=0.04, noise=Noise())
    assert min(grid.occupied.shape) > 1000
    began = time.process_time()
    world = world_from_grid(grid)
    assert time.process_time() - began < 5.0
    assert fidelity(world, grid).share > 0.97


def _typed(*line: str) -> int:
    with pytest.raises(SystemExit) as caught:
        main(line)
    return int(caught.value.code or 0)
