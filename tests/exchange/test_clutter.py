"""Cluttered rooms: what is drawn by chance leaves a robot a way to everywhere."""

import numpy as np
import pytest
import shapely

from mjsim.cli import main
from mjsim.exchange import bring_clutter, clutter_world
from mjsim.world import check_world, obstacle_polygons, parse_world, solid

SIZE = (12.0, 10.0)


@pytest.mark.parametrize("seed", range(1, 3))
def test_a_robot_comes_to_every_free_place_of_a_cluttered_room(seed):
    world = clutter_world(SIZE, seed=seed)
    assert check_world(world) == []
    free = shapely.box(0.0, 0.0, *SIZE).difference(solid(world))
    # A disc of 0.8 m: 18 cm to spare on both sides of this robot; corners in which it would not fit have no area.
    parts = [part for part in shapely.get_parts(free.buffer(-0.4)) if part.area > 0.06]
    assert len(parts) == 1
    assert parts[0].contains(shapely.Point(world.robots[0].at))
    assert 0.7 * 120.0 < free.area < 0.95 * 120.0


def test_some_things_are_convex_and_some_have_a_hollow():
    world = clutter_world(SIZE, seed=3)
    things = shapely.get_parts(shapely.union_all([shapely.Polygon(outline) for outline in obstacle_polygons(world)]))
    hollow = np.array([thing.convex_hull.area - thing.area > 0.02 for thing in things])
    assert hollow.sum() >= 5
    assert (~hollow).sum() >= 5


@pytest.mark.slow
def test_the_same_seed_gives_the_same_text_and_another_another():
    one, again, other = (bring_clutter("12x10", preset=None, seed=seed, name=None).text for seed in (3, 3, 4))
    assert one == again
    assert one != other


def test_new_prints_a_cluttered_room_in_which_a_robot_is_told_only_to_go_ahead(capsys):
    with pytest.raises(SystemExit) as caught:
        main(["new", "--clutter", "6x5.5", "--seed", "3"])
    assert not caught.value.code
    world = parse_world(capsys.readouterr().out)
    assert world == clutter_world((6.0, 5.5), seed=3)
    modules = world.run.drivers["scout"]
    assert modules.avoidance is True
    assert modules.navigator.arguments() == {"forward": 0.7}
