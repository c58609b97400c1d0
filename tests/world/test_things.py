"""Things that can be pushed: what checks, maps and figures make of them."""

import re
from pathlib import Path

import mujoco
import numpy as np
import pytest

import mjsim
from mjsim.compile import compile_world
from mjsim.errors import WorldError
from mjsim.record import Landmarks, Track
from mjsim.report.coverage import coverage
from mjsim.report.statistics import landmark_figures
from mjsim.world import check_world, parse_world, segments, solid

ROOM = "mjsim: 1\nwalls: [{points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true}]\n"


def room(obstacle, rest=""):
    return parse_world(f"{ROOM}obstacles: [{{{obstacle}}}]\n{rest}")


def test_what_can_be_pushed_is_no_part_of_the_map_nor_of_what_cannot_be_reached():
    bare = parse_world(ROOM)
    pushed = room("box: [2, 2, 1], at: [4, 2], movable: true")
    driven = room("box: [2, 2, 1], at: [4, 2], path: {points: [[4, 3]]}")
    fixed = room("box: [2, 2, 1], at: [4, 2]")
    way = np.array([[1.0, 1.0], [1.0, 3.0]])
    for world in (pushed, driven):
        np.testing.assert_array_equal(segments(world), segments(bare))
        assert coverage(world, way, radius=0.2) == coverage(bare, way, radius=0.2)
    assert solid(fixed).area == pytest.approx(solid(bare).area + 4.0)
    assert coverage(fixed, way, radius=0.2) > coverage(bare, way, radius=0.2)


@pytest.mark.parametrize("obstacle", ["box: [1, 1, 1]", "sphere: 0.5", "model: furniture/chair.xml"])
def test_a_robot_does_not_start_inside_what_can_be_pushed(obstacle):
    world = room(f"{obstacle}, at: [2, 2], movable: true, name: thing", "robots: [{name: r, at: [2.2, 2.2]}]")
    (problem,) = check_world(world)
    assert "robot 'r' at [2.2, 2.2] starts inside obstacle 'thing'" in str(problem)


def test_a_robot_may_start_under_what_hangs_high():
    assert not check_world(room("box: [1, 1, 1], at: [2, 2], elevation: 0.6", "robots: [{name: r, at: [2, 2]}]"))


@pytest.mark.parametrize(
    ("obstacle", "message"),
    [
        ("box: [1, 1, 1e-4]", "a size is 0.0001 m; a movable object is at least 0.001 m large"),
        ("cylinder: [1e-5, 1]", "a size is 1e-05 m; a movable object is at least 0.001 m large"),
        ("box: [1, 1, 1], mass: 1e-9", "mass is 1e-09 kg; it must be at least 0.001"),
    ],
)
def test_dust_cannot_be_pushed(obstacle, message):
    with pytest.raises(WorldError) as caught:
        room(f"{obstacle}, at: [1, 1], movable: true")
    assert message in str(caught.value)


def test_the_smallest_things_that_can_be_pushed_lie_still():
    world = room("box: [0.001, 0.001, 0.001], at: [1, 1], movable: true, mass: 0.001, name: dust")
    model = compile_world(world).compile()
    data = mujoco.MjData(model)
    for _ in range(100):
        mujoco.mj_step(model, data)
    np.testing.assert_allclose(data.body("obstacle/dust").xpos, [1, 1, 0], atol=1e-3)


def test_beacons_that_move_are_neither_right_nor_false_on_a_map():
    world = room(
        "box: [0.4, 0.4, 0.4], at: [2, 2], movable: true, name: cart",
        "beacons:\n  - {name: still, at: [3, 3]}\n  - {name: moving, on: cart, at: [0.2, 0]}\n",
    )
    names = ("still", "moving", "nothing")
    mean = np.array([[[3.0, 3.1], [9.0, 9.0], [1.0, 1.0]]])
    marks = Landmarks(names=names, mean=mean, covariance=np.zeros((1, 3, 2, 2)))
    empty, rows = np.zeros((1, 3)), ((),)
    track = Track(
        time=np.zeros(1),
        truth=empty,
        truth_pose=np.zeros((1, 7)),
        odometry=empty,
        odometry_covariance=np.zeros((1, 3, 3)),
        estimate=empty,
        covariance=np.zeros((1, 3, 3)),
        command=empty,
        landmarks=marks,
        sightings=rows,
        innovations=rows,
        events=(),
    )
    figures = landmark_figures(world, track)
    assert (figures["count"], figures["false"]) == (2, 1)
    assert figures["rms"] == pytest.approx(0.1)


def test_a_beacon_on_a_model_hangs_at_its_height_above_the_lowest_point(tmp_path):
    text = '<mujoco><worldbody><geom type="box" size="0.2 0.2 0.5" mass="3"/></worldbody></mujoco>'
    (tmp_path / "post.xml").write_text(text)
    (tmp_path / "world.yaml").write_text(
        "mjsim: 1\nobstacles: [{name: post, model: post.xml, at: [1, 2], elevation: 0.1, movable: true}]\n"
        "beacons: [{name: tag, marker: {id: 4}, on: post, at: [0.2, 0], center: 0.8, width: 0.2}]\n"
    )
    with mjsim.Simulation(mjsim.load_world(tmp_path / "world.yaml")) as simulation:
        np.testing.assert_allclose(simulation.data.geom("beacon/tag").xpos, [1.2, 2, 0.9], atol=1e-3)


def test_a_beacon_inside_the_robot_that_carries_it_is_reported():
    text = "beacons: [{name: b, on: r, at: [0, 0], center: HIGH}]\nrobots: [{name: r, at: [2, 2]}]"
    assert not check_world(parse_world(ROOM + text.replace("HIGH", "0.5")))
    (problem,) = check_world(parse_world(ROOM + text.replace("HIGH", "0.1")))
    assert "hangs inside this robot, whose body is 0.25 m high; move it out or above" in str(problem)


def test_a_model_that_an_event_takes_away_is_neither_seen_nor_touched():
    text = """
    mjsim: 1
    obstacles:
      - {name: chair, model: furniture/office_chair.xml, at: [1, 0], movable: true}
      - {name: shelf, model: furniture/shelf.urdf, at: [2, 0]}
    robots: [{name: scout, at: [0, 0], proximity_range: 3}]
    run: {events: [{time: 0.2, remove: chair}, {time: 0.4, remove: shelf}]}
    """
    nearest = []
    with mjsim.Simulation(parse_world(text)) as simulation:
        for _ in range(12):
            nearest.append(float(simulation.sense("scout").proximity.min()))
            simulation.step()
    assert nearest[0] < 0.8
    assert 1.2 < nearest[7] < 1.8
    assert nearest[-1] > 3.0


@pytest.mark.slow
def test_the_example_of_the_page_is_a_world_that_runs_and_whose_things_lie_still():
    page = (Path(__file__).parents[2] / "docs" / "things.md").read_text(encoding="utf-8")
    (example,) = re.findall(r"```yaml\n(.*?)```", page, flags=re.DOTALL)
    world = parse_world(example)
    assert not check_world(world)
    with mjsim.Simulation(world) as simulation:
        before = {thing: simulation.data.body(f"obstacle/{thing}").xpos.copy() for thing in ("crate", "lunch", "seat")}
        for _ in range(50):
            simulation.step()
        for thing, place in before.items():
            np.testing.assert_allclose(simulation.data.body(f"obstacle/{thing}").xpos, place, atol=2e-3)
