"""The worlds that come with mjsim: sound as written, wide enough for their tours, and what their names promise."""

import math
import re
import runpy
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
import shapely

import mjsim
from mjsim.geometry import Array
from mjsim.modules import check_modules, load_runnable
from mjsim.plan import leaf_path
from mjsim.run import drivers_of
from mjsim.world import Camera, Leaf, footprint, leaves, solid, wall_polygons, with_settings

FOLDER = Path(__file__).parents[2] / "worlds"
NAMES = sorted(path.stem for path in FOLDER.glob("*.yaml"))
DRIVEN_ON = {"ramps": {"way-up", "platform", "way-down"}}
"""What the tour leads over, by world."""


@cache
def shipped(name: str) -> mjsim.World:
    return load_runnable(FOLDER / f"{name}.yaml")


@pytest.mark.parametrize("name", NAMES)
def test_its_modules_are_there_and_fit(name):
    assert check_modules(shipped(name)) == []


def tours(world: mjsim.World) -> dict[str, shapely.LineString]:
    """Return the lines that robots with waypoints are to follow."""
    lines = {}
    for robot in world.robots:
        modules = world.run.drivers.get(robot.name)
        if modules is not None and modules.navigator is not None and modules.navigator.use.endswith(":Waypoints"):
            lines[robot.name] = shapely.LineString([robot.at, *modules.navigator.arguments()["points"]])
    return lines


def facing(beacon) -> Array:
    return np.array([math.cos(math.radians(beacon.heading_deg)), math.sin(math.radians(beacon.heading_deg))])


@pytest.mark.parametrize("name", NAMES)
def test_nothing_is_wrong_with_it_and_it_is_called_as_its_file(name):
    assert shipped(name).name == name


@pytest.mark.parametrize("name", NAMES)
def test_its_tours_pass_everything_with_10_cm_to_spare(name):
    world = shipped(name)
    over = DRIVEN_ON.get(name, set())
    kept = tuple(thing for thing in world.obstacles if thing.name not in over)
    everything = solid(world.model_copy(update={"obstacles": kept}))
    for robot, line in tours(world).items():
        body = next(item.body for item in world.robots if item.name == robot)
        half = np.abs(body.outline()[:, 1]).max()  # of the width: it drives along its lines
        assert everything.distance(line) - half > 0.1, robot


@pytest.mark.parametrize("name", NAMES)
def test_its_pictures_hang_before_something_solid(name):
    world = shipped(name)
    behind = shapely.union_all([shapely.Polygon(outline) for outline in wall_polygons(world, height=1.2)])
    for beacon in world.beacons:
        if beacon.image is not None and beacon.on is None:
            assert behind.distance(shapely.Point(beacon.at)) < 0.03, beacon.name
            assert behind.contains(shapely.Point(beacon.at - 0.04 * facing(beacon))), beacon.name


def test_the_empty_room_holds_nothing_but_pictures():
    world = shipped("empty")
    assert world.obstacles == ()
    assert len(world.beacons) == 8


def test_the_corridor_is_ten_times_as_long_as_it_is_wide_with_its_doors_closed():
    world = shipped("corridor")
    (x0, y0, x1, y1) = solid(world).bounds
    assert x1 - x0 > 10 * (y1 - y0)
    assert all(opening.door.angle_deg == 0 for wall in world.walls for opening in wall.openings if opening.sill == 0)


def test_there_are_twelve_worlds_and_each_names_the_schema():
    assert len(NAMES) >= 12
    for name in NAMES:
        first = (FOLDER / f"{name}.yaml").read_text().partition("\n")[0]
        assert first == "# yaml-language-server: $schema=mjsim.schema.json"


def shut_by(leaf: Leaf, angle_deg: float) -> shapely.LineString:
    """Return where a door's leaf stands at an angle."""
    return shapely.LineString([leaf.hinge, leaf_path(leaf, angle_deg)[-1]])


def test_the_page_of_worlds_shows_every_one_of_them_as_it_is_now():
    made = runpy.run_path(str(FOLDER.parent / "scripts" / "make" / "world_pictures.py"))
    page = FOLDER.parent / "docs" / "worlds.md"
    assert set(made["ORDER"]) == set(NAMES)
    text = made["page"]({name: shipped(name) for name in made["ORDER"]})
    assert page.read_text(encoding="utf-8") == text
    pictures = [page.parent / name for name in re.findall(r"\]\((images/.*?)\)", text)]
    alone = [path.stem for folder in made["FOLDERS"] for path in (FOLDER / folder).glob("*.yaml")]
    assert len(pictures) == 3 * len(NAMES) + len(alone)
    assert sum(picture.stat().st_size for picture in pictures) < 2.8e6


def test_all_twenty_rooms_of_the_office_are_entered_through_their_open_doors_and_are_rooms_when_these_are_shut():
    world = shipped("office")
    (robot,) = world.robots
    floor, masonry = shapely.box(*solid(world).bounds), solid(world)
    opened = shapely.union_all([masonry, *(shut_by(leaf, leaf.door.angle_deg) for leaf in leaves(world))])
    reached = next(
        part
        for part in shapely.get_parts(floor.difference(opened.buffer(robot.body.radius)))
        if part.contains(shapely.Point(robot.at))
    )
    assert all(reached.contains(shapely.Point(3.6 * k + 1.8, y)) for k in range(10) for y in (2.6, 9.8))
    shut = shapely.union_all([masonry, *(shut_by(leaf, 0.0) for leaf in leaves(world))])
    rooms = shapely.get_parts(floor.difference(shut.buffer(0.1)))
    assert len([room for room in rooms if room.area > 5]) == 20 + 1


def test_the_warehouse_is_60_m_long_and_its_racks_reach_over_the_head_of_the_robot():
    world = shipped("warehouse")
    (x0, _, x1, _) = solid(world).bounds
    assert x1 - x0 >= 60
    high = [thing for thing in world.obstacles if thing.elevation > 1]
    assert len(high) > 50


def test_the_maze_has_one_way_and_its_end_is_far_from_its_start():
    masonry = solid(shipped("maze"))
    outside = shapely.get_parts(masonry)
    assert len(outside) == 1  # nothing stands alone, so there is no ring to go round
    free = shapely.Polygon(outside[0].interiors[0])
    (line,) = tours(shipped("maze")).values()
    assert len(outside[0].interiors) == 1
    assert free.contains(line)
    assert line.length > 2 * shapely.Point(line.coords[0]).distance(shapely.Point(line.coords[-1]))


def test_the_dark_room_has_next_to_no_light_but_its_lamps():
    world = shipped("dark")
    assert world.light < 0.05
    assert sum(lamp.brightness > 0 for lamp in world.lamps) >= 2


def test_the_cluttered_room_has_things_of_all_weights_that_can_be_pushed():
    masses = [thing.mass for thing in shipped("clutter").obstacles if thing.movable]
    assert len(masses) >= 6
    assert min(masses) < 1 < 50 < max(masses)


def test_the_museum_shows_forty_pictures_and_each_is_seen_from_2_m():
    world = shipped("museum")
    assert len({beacon.image for beacon in world.beacons}) == 40
    blind = solid(world, height=1.3)
    for beacon in world.beacons:
        sight = shapely.LineString([beacon.at + 0.01 * facing(beacon), beacon.at + 2.0 * facing(beacon)])
        assert not blind.intersects(sight), beacon.name


def test_the_cloister_is_a_walk_all_around_a_court():
    masonry = solid(shipped("cloister")).buffer(0.3)
    (walk,) = shapely.get_parts(shapely.box(0, 0, 16, 16).difference(masonry)).tolist()[:1]
    (line,) = tours(shipped("cloister")).values()
    assert walk.contains(line)
    assert shapely.Polygon(walk.interiors[0]).contains(shapely.box(3, 3, 13, 13))


def test_the_ramps_rise_by_5_degrees_and_meet_the_platform_at_its_height():
    things = {thing.name: thing for thing in shipped("ramps").obstacles}
    platform = shapely.Polygon(footprint(things["platform"]))
    for name in ("way-up", "way-down"):
        length, _, rise = things[name].ramp
        assert math.degrees(math.atan2(rise, length)) == pytest.approx(5.0, abs=0.05)
        assert rise == things["platform"].box[2]
        assert platform.distance(shapely.Polygon(footprint(things[name]))) < 1e-9


def test_the_two_robots_of_the_arena_go_round_the_same_way():
    lines = tours(shipped("arena"))
    assert len(lines) == 2
    assert len({shapely.LinearRing(line.coords).is_ccw for line in lines.values()}) == 1


class Informed:
    """An estimator that is told the truth: what a tour is worth, whatever the estimate."""

    def __init__(self, sim: mjsim.Simulation, robot: str) -> None:
        self._sim, self._robot = sim, robot

    def start(self, robot, catalogue, rng) -> None:
        """Nothing to prepare."""

    def update(self, seen) -> mjsim.Estimate:
        return mjsim.Estimate(self._sim.truth(self._robot), np.eye(3) * 1e-6)


def goals(world: mjsim.World) -> dict[str, tuple[float, float]]:
    """Return where each robot is to be in the end."""
    ends = {}
    for robot, modules in world.run.drivers.items():
        asked = modules.navigator.arguments() if modules.navigator is not None else {}
        points = asked.get("points") or asked.get("goals")
        if points:
            ends[robot] = points[-1]
    return ends


SHORTER = {
    "office": ["run.drivers.post.navigator.goals=[[8.5, 3.2]]"],
    "clutter": ["run.drivers.helper.navigator.goals=[[7.2, 1.2], [7.2, 4.6]]"],
    "warehouse": ["run.drivers.picker.navigator.points=[[4.5, 6.6], [16.0, 6.6]]"],
    "arena": [
        "run.drivers.red.navigator.points=[[8.5, 2.5], [9.5, 3.5], [9.5, 8.5]]",
        "run.drivers.blue.navigator.points=[[3.5, 9.5], [2.5, 8.5], [2.5, 3.5]]",
    ],
}
"""Settings with which a robot is there sooner: that the rest of its way is free is tested above, by its geometry."""
STILL = 50
"""Ticks for which robots are told to stand where they go to before a tour is over; elsewhere they may wait."""


def is_at_rest(tick: mjsim.Tick, robot: str) -> bool:
    """Return whether a robot is told to stand."""
    command = tick.orders[robot].command
    return command.forward == command.left == command.turn == 0.0


def stays(ticks: Sequence[mjsim.Tick], robot: str, end: tuple[float, float]) -> bool:
    """Return whether a robot is told to stand near a place for long enough."""
    there = ticks[-1].truth[robot]
    near = math.dist((there.x, there.y), end) < 0.3
    return near and len(ticks) == STILL and all(is_at_rest(tick, robot) for tick in ticks)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["arena", "clutter", "office", "ramps", "warehouse"])  # where geometry does not tell
def test_who_knows_where_it_is_reaches_its_goal_in_time_without_a_bump(name):
    world = with_settings(shipped(name), ["shading=plain", "style=plain", *SHORTER.get(name, ())])
    robots = [
        robot.model_copy(update={"sensors": tuple(item for item in robot.sensors if not isinstance(item, Camera))})
        for robot in world.robots
    ]
    with mjsim.Simulation(world.model_copy(update={"robots": tuple(robots), "beacons": ()})) as sim:
        drivers = {
            robot: replace(driver, observer=None, estimator=Informed(sim, robot))
            for robot, driver in drivers_of(world).items()
        }
        ends, way = goals(world), []
        for tick in islice(mjsim.ticks(sim, drivers), round(world.run.seconds / sim.dt)):
            way.append(tick)
            if all(stays(way[-STILL:], robot, end) for robot, end in ends.items()):
                break
    for robot, end in ends.items():
        assert not [event for tick in way for event in tick.orders[robot].events if event.kind == "bump"], robot
        assert is_at_rest(way[-1], robot)
        # Noise of the drive shakes a robot that stands, so where it is now is not where it arrived.
        arrival = [tick for tick in way if not is_at_rest(tick, robot)][-1].truth[robot]
        np.testing.assert_allclose((arrival.x, arrival.y), end, atol=0.15, err_msg=robot)


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in NAMES if name not in {"balancing", "gallery", "manipulator"}])
def test_it_compiles_with_every_robot_and_beacon_and_its_first_seconds_run_as_it_is_written(name):
    """The others are run in files of their own."""
    world = with_settings(shipped(name), ["shading=plain"])  # baking is tested by itself
    with mjsim.Simulation(world) as sim:
        for robot in world.robots:
            assert sim.model.body(f"{robot.name}/base")
        for beacon in world.beacons:
            assert sim.model.geom(f"beacon/{beacon.name}")
        recording = mjsim.run(sim, seconds=0.48, pictures=False)
    for robot, track in recording.robots.items():
        assert np.isfinite(track.truth).all()
        assert not [event for event in track.events if event.kind == "bump"], robot
    ways = [np.hypot(*(track.truth[-1] - track.truth[0])[:2]) for track in recording.robots.values()]
    assert max(ways) > 0.01
