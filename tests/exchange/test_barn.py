"""Worlds of the BARN benchmark."""

from importlib import resources

import numpy as np
import pytest

import mjsim
from mjsim.cli import main
from mjsim.errors import UsageError
from mjsim.exchange import barn_path_length, barn_score, barn_world
from mjsim.run import drivers_of
from mjsim.world import check_world, load_checked, parse_world, world_path


def test_new_writes_a_world_with_the_jackal_at_its_start_and_a_goal(tmp_path, capsys):
    with pytest.raises(SystemExit) as caught:
        main(["new", "--barn", "1", "-o", str(tmp_path / "one.yaml")])
    assert not caught.value.code
    world = load_checked(tmp_path / "one.yaml")
    assert (world.name, len(world.obstacles)) == ("one", 237)
    assert world.obstacles == barn_world(1).obstacles
    (robot,) = world.robots
    assert (robot.at, robot.heading_deg, robot.drive.type, robot.drive.max_speed) == ((-2.25, 3), 90, "skid_steer", 2.0)
    (lidar,) = robot.sensors
    assert (lidar.fov_deg, lidar.beams, lidar.range) == (270, 1081, (0.06, 10))
    assert world.run.drivers["scout"].navigator.arguments() == {"goals": [[-2.25, 13.0]]}
    assert check_world(world) == []


@pytest.mark.parametrize("number", [0, 6, 294, 300, -1])
def test_worlds_kept_for_the_challenge_and_other_numbers_are_refused_in_a_line(number):
    with pytest.raises(
        UsageError, match=f"^no BARN world {number}; give a number from 1 to 299 that is not a multiple of 6"
    ):
        barn_world(number)


def test_all_250_worlds_are_there_and_none_begins_in_a_cylinder():
    with resources.files("mjsim.assets").joinpath("barn/barn.npz").open("rb") as file, np.load(file) as worlds:
        places = {int(name.partition("_")[2]): worlds[name] for name in worlds.files if name.startswith("cylinders")}
    assert sorted(places) == [number for number in range(300) if number % 6]
    assert min(np.hypot(*(each - (-2.25, 3.0)).T).min() for each in places.values()) > 0.5
    assert all(10.0 <= barn_path_length(number) < 16.0 for number in (1, 150 + 1, 299))


def test_a_score_is_half_from_the_optimal_speed_of_1_m_s_and_falls_to_an_eighth():
    # OT = L / 2; OT / clip(AT, 2 OT, 8 OT)
    assert [barn_score(time, 10.0) for time in (4.0, 10.0, 20.0, 90.0, None)] == [0.5, 0.5, 0.25, 0.125, 0.0]


def test_the_shipped_world_is_what_new_writes():
    assert parse_world(world_path("barn").read_text("utf-8")).obstacles == barn_world(181).obstacles


@pytest.mark.slow
def test_the_navigator_arrives_at_more_than_1_m_s_and_touches_nothing():
    world, way = barn_world(265), barn_path_length(265)
    with mjsim.Simulation(world, seed=265) as sim:
        for tick in mjsim.ticks(sim, drivers_of(world)):
            assert not tick.orders["scout"].events
            pose = tick.truth["scout"]
            if np.hypot(pose.x + 2.25, pose.y - 13.0) < 1.0:
                break
            assert tick.time < way
