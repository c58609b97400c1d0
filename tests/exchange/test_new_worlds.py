"""Mazes and templates are worlds that run at once."""

import math
import re
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
import shapely
from shapely import Point

import mjsim
from mjsim.cli import main
from mjsim.errors import UsageError
from mjsim.exchange import TEMPLATES, maze_world, template_text
from mjsim.world import World, check_world, load_world, parse_world, solid, world_notes

needs_labmaze = pytest.mark.skipif(find_spec("labmaze") is None, reason="labmaze is there for Python 3.11 and 3.12")
WORLDS = Path(__file__).parents[2] / "worlds"


def typed(*line: str) -> int:
    """Return the exit code of a command."""
    with pytest.raises(SystemExit) as caught:
        main(line)
    return int(caught.value.code or 0)


def reached(world: World, cell: float, size: tuple[int, int]) -> int:
    """Count the cells of a maze that can be driven to, by shapely: those whose middles no wall parts."""
    walls = solid(world)
    shapely.prepare(walls)
    waiting, seen = [(0, 0)], {(0, 0)}
    while waiting:
        x, y = waiting.pop()
        for ahead in ((x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)):
            between = shapely.LineString([((i + 0.5) * cell, (j + 0.5) * cell) for i, j in ((x, y), ahead)])
            if ahead not in seen and not walls.intersects(between):
                seen.add(ahead)
                waiting.append(ahead)
    assert all(0 <= x < size[0] and 0 <= y < size[1] for x, y in seen)
    return len(seen)


@needs_labmaze
def test_every_cell_of_a_maze_can_be_reached_and_nothing_outside():
    for seed in range(2):
        world = maze_world((7, 5), seed=seed, cell=1.2)
        assert not check_world(world)
        assert reached(world, 1.2, (7, 5)) == 35


@needs_labmaze
def test_the_same_seed_gives_the_same_maze_and_another_another():
    assert maze_world((9, 9), seed=3) == maze_world((9, 9), seed=3)
    assert maze_world((9, 9), seed=3).walls != maze_world((9, 9), seed=4).walls


@needs_labmaze
def test_markers_of_a_maze_hang_before_walls_and_face_the_way():
    world = maze_world((9, 9), seed=3, beacons=6)
    assert [beacon.marker.id for beacon in world.beacons] == list(range(6))
    walls = solid(world)
    for beacon in world.beacons:
        assert walls.distance(Point(beacon.at)) == pytest.approx(0.01, abs=1e-3)
        ahead = math.radians(beacon.heading_deg)
        nose = np.add(beacon.at, 0.6 * np.array([math.cos(ahead), math.sin(ahead)]))
        assert walls.distance(Point(nose)) > 0.5


def test_an_invalid_maze_is_refused():
    for size, cell, message in [
        ((2, 9), 1.5, "3 to 50"),
        ((9, 60), 1.5, "3 to 50"),
        ((9, 9), 0.5, "must be 0.9 to 10"),
    ]:
        with pytest.raises(UsageError, match=message):
            maze_world(size, seed=1, cell=cell)


@pytest.mark.parametrize("template", TEMPLATES)
def test_a_template_is_the_shipped_world_under_a_name_of_ones_own(template, tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text(template_text(template, name="mine"))
    shipped = load_world(WORLDS / f"{template}.yaml")
    assert load_world(path) == shipped.model_copy(update={"name": "mine"})


@needs_labmaze
def test_new_writes_a_world_and_keeps_what_is_there(tmp_path, capsys):
    path = tmp_path / "labyrinth.yaml"
    assert typed("new", "--maze", "5x4", "--seed", "3", "-o", str(path)) == 0
    assert load_world(path) == maze_world((5, 4), seed=3, name="labyrinth")
    capsys.readouterr()
    for line, message in [
        (["--maze", "5x4", "-o", str(path)], f"'{path}' exists; name another file, or add --overwrite"),
        (["--maze", "5 by 4"], "the size of the maze is '5 by 4'; write it like 9x9"),
        (["--maze", "5x4", "--template", "empty"], "a world has one source"),
        (["--template", "ofice"], "no template 'ofice'; templates are office, corridor, empty, gallery"),
        (["--template", "empty", "--no-robot"], "a template already has a robot; change it in the new file"),
        (["--clutter", "12 m"], "the size of the room is '12 m'; write it like 12x10"),
        (["--clutter", "2x10"], "the room is 2 x 10 m; each side must be 3 to 40 m"),
    ]:
        assert typed("new", *line) == 2
        assert message in capsys.readouterr().err


@pytest.mark.slow
@needs_labmaze
def test_a_world_goes_out_and_comes_in_by_commands(tmp_path, capsys):
    maze, plan = str(tmp_path / "maze.yaml"), str(tmp_path / "plan.svg")
    assert typed("new", "--maze", "4x4", "-o", maze) == 0
    assert typed("export-world", maze, "--map", str(tmp_path / "nav2"), "--svg", plan) == 0
    assert capsys.readouterr().out.splitlines() == [maze, str(tmp_path / "nav2" / "map.yaml"), plan]
    for source in (str(tmp_path / "nav2" / "map.yaml"), plan):
        assert typed("new", "--from", source, "-o", str(tmp_path / "back.yaml"), "--force") == 0
        assert not check_world(load_world(tmp_path / "back.yaml"))
    assert "the world explains" in capsys.readouterr().err
    assert typed("export-world", maze) == 2
    assert "name at least one of --map DIR, --sdf FILE, --usd FILE, --glb FILE, --svg FILE" in capsys.readouterr().err


@needs_labmaze
def test_new_prints_a_world_that_is_not_written_to_a_file(capsys):
    assert typed("new", "--maze", "4x4", "--no-robot") == 0
    assert parse_world(capsys.readouterr().out) == maze_world((4, 4), seed=1, preset=None)


@needs_labmaze
def test_the_program_on_the_page_about_bringing_in_runs(tmp_path, monkeypatch, capsys):
    page = (WORLDS.parent / "docs" / "bring-in.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    monkeypatch.chdir(tmp_path)
    exec(code, {})
    assert capsys.readouterr().out == f"{len(maze_world((6, 4), seed=3).walls)} walls\n"


@pytest.mark.slow
@needs_labmaze
def test_the_robot_of_a_maze_drives_to_its_far_end():
    world = maze_world((3, 3), seed=3)
    (goal,) = (driver.navigator.model_dump()["points"][-1] for driver in world.run.drivers.values())
    with mjsim.Simulation(world, seed=1) as sim:
        mjsim.run(sim, seconds=world.run.seconds)
        pose = sim.truth("theseus")
    assert math.dist((pose.x, pose.y), goal) < 0.4


@pytest.mark.slow
def test_a_robot_of_a_map_gets_a_lidar_and_an_estimator_or_one_line_says_why_not(tmp_path, capsys):
    depot = str(WORLDS.parent / "tests" / "data" / "maps" / "tb3_sandbox.yaml")
    world = tmp_path / "sandbox.yaml"
    start = ["new", "--from", depot, "-o", str(world), "--overwrite", "--robot", "turtlebot3_burger"]
    assert typed(*start, "--lidar", "lds-02", "--estimator", "monte_carlo{particles: 500}") == 0
    made = load_world(world)
    assert not check_world(made)
    assert not world_notes(made)
    assert made.run.map == "known"
    assert made.run.drivers["scout"].estimator.model_dump()["particles"] == 500
    assert [sensor.kind for sensor in made.robots[0].sensors] == ["lidar"]
    assert typed(*start, "--lidar", "lds-02", "--estimator", "lidar_slam") == 0
    assert load_world(world).run.map == "unknown"
    capsys.readouterr()
    for more, message in [
        (["--estimator", "monte_carlo"], "has no lidar to localise with; add --lidar, one of hokuyo-ust-10lx"),
        (["--lidar", "lds-03"], "no lidar preset 'lds-03'; did you mean 'lds-0"),
        (["--lidar", "lds-02", "--estimator", "kalman"], "no estimator 'kalman'; write monte_carlo, lidar_slam"),
        (["--lidar", "lds-02", "--no-robot"], "--lidar and --estimator need a robot; leave out --no-robot"),
    ]:
        assert typed(*start, *more) == 2
        (line,) = [line for line in capsys.readouterr().err.splitlines() if not line.startswith("mjsim: ")]
        assert message in line
