import mujoco
import pytest

from mjsim.geometry import wrap_angle
from mjsim.interface import Command
from mjsim.safety import react_to_bump
from mjsim.sim import Simulation
from mjsim.world import parse_world

ANGLES = (0, 20, -45, 70)
FACE = 1.5
"""Where the near face of the wall is [m]."""


def towards_a_wall(*, speed: float, thickness: float = 0.05, acceleration: float = 5.0) -> Simulation:
    """Return robots that head for one long wall at several angles, 8 m from each other."""
    keys = f"drive: {{max_speed: {speed}, max_acceleration: {acceleration}, noise: {{speed: 0.02, turn: 0.02}}}}"
    robots = "".join(
        f"  - {{name: r{k}, at: [0, {8 * k}], heading_deg: {angle}, {keys}}}\n" for k, angle in enumerate(ANGLES)
    )
    x = FACE + thickness / 2
    wall = f"{{points: [[{x}, -20], [{x}, 60]], thickness: {thickness}}}"
    return Simulation(parse_world(f"mjsim: 1\nwalls: [{wall}]\nrobots:\n{robots}"))


def step(sim: Simulation, command: Command, seconds: float) -> None:
    for _ in range(round(seconds / sim.dt)):
        for name in sim.robots:
            sim.apply(name, command)
        sim.step()


@pytest.mark.slow
@pytest.mark.parametrize("speed", [0.7, 2.1])
def test_a_robot_that_drives_into_a_wall_stays_before_it_feels_it_and_can_turn_and_back_off(speed):
    sim = towards_a_wall(speed=speed)
    for _ in range(150):
        step(sim, Command(speed), sim.dt)
        for name, robot in sim.robots.items():
            # A bumper is soft: it gives way by some millimetres at the moment of the crash.
            assert sim.truth(name).x + robot.radius < FACE + 0.01, name
    for name, robot in sim.robots.items():
        assert sim.truth(name).x + robot.radius == pytest.approx(FACE, abs=0.002), name
        bump = sim.sense(name).bump
        assert bump, name
        # The rim is nearest to the wall at the bearing of its normal.
        assert all(abs(wrap_angle(bearing + sim.truth(name).heading)) < 0.02 for bearing in bump), name
        # Rays are 22.5 degrees apart, so one meets the wall at 11.25 degrees from its normal at most, 4 mm off.
        assert sim.sense(name).proximity.min() < 0.01, name
    headings = {name: sim.truth(name).heading for name in sim.robots}
    step(sim, Command(), 1.0)
    step(sim, Command(turn=1.0), 1.5)
    for name in sim.robots:
        assert wrap_angle(sim.truth(name).heading - headings[name]) > 1.0, name
    before = sim.truths()
    away = {name: -0.4 if abs(pose.heading) < 1.5 else 0.4 for name, pose in before.items()}
    for _ in range(50):
        for name in sim.robots:
            sim.apply(name, Command(away[name]))
        sim.step()
    for name in sim.robots:
        moved = before[name].inverse() @ sim.truth(name)
        assert abs(moved.x) > 0.4, name


def test_even_a_robot_at_six_metres_a_second_does_not_pass_a_thin_wall():
    sim = towards_a_wall(speed=6.0, thickness=0.01, acceleration=15.0)
    for _ in range(60):
        step(sim, Command(6.0), sim.dt)
        for name, robot in sim.robots.items():
            # Far from the 0.22 m after which the wall would push it to the other side.
            assert sim.truth(name).x + robot.radius < FACE + 0.06, name


@pytest.mark.slow
def test_with_the_bump_reaction_a_robot_stays_at_the_place_where_it_bumped():
    sim = towards_a_wall(speed=0.7)
    places = []
    for tick in range(500):
        for name in sim.robots:
            sim.apply(name, react_to_bump(Command(0.7), sim.sense(name).bump))
        sim.step()
        if tick >= 250:
            places.append(sim.truth("r0"))
    # Its driving noise makes it wriggle by some centimetres in ten seconds, 0.02 sqrt(10) = 0.06 m at one deviation.
    assert max(abs(place.x - places[0].x) for place in places) < 0.1
    assert max(abs(place.y - places[0].y) for place in places) < 0.2
    assert len({place.x for place in places}) > 100


@pytest.mark.parametrize(
    ("at", "bearing"), [("[1, 0]", 0.0), ("[0, 1]", 1.5708), ("[-1, 0]", 3.1416), ("[0, -1]", -1.5708)]
)
def test_a_bump_is_at_the_bearing_of_what_is_touched(at, bearing):
    # The faces of a box of 1.56 m around a point 1 m away are 0.22 m from the robot's middle.
    text = f"""
mjsim: 1
obstacles: [{{box: [1.56, 1.56, 0.2], at: {at}}}]
robots: [{{name: r, at: [0, 0]}}]
"""
    (felt,) = {round(abs(wrap_angle(b - bearing)), 3) for b in Simulation(parse_world(text)).sense("r").bump}
    assert felt == 0.0


def test_two_robots_that_meet_feel_each_other_and_one_that_is_free_feels_nothing():
    text = """
mjsim: 1
robots:
  - {name: a, at: [0, 0]}
  - {name: b, at: [0.4405, 0]}
  - {name: c, at: [5, 0]}
"""
    sim = Simulation(parse_world(text))
    assert sim.sense("a").bump == pytest.approx([0.0], abs=1e-3)
    assert [abs(bearing) for bearing in sim.sense("b").bump] == pytest.approx([3.14159], abs=1e-3)
    assert sim.sense("c").bump == ()


def test_what_its_wheels_roll_over_is_no_bump():
    sim = Simulation(
        parse_world("mjsim: 1\nobstacles: [{box: [3, 3, 0.02], at: [0, 0]}]\nrobots: [{name: r, at: [0, 0]}]\n")
    )
    sim.data.qpos[2] += 0.0199
    mujoco.mj_forward(sim.model, sim.data)
    touching = {sim.model.body(sim.model.geom_bodyid[geom]).name for pair in sim.data.contact.geom for geom in pair}
    assert {"r/wheel_left", "r/wheel_right"} <= touching
    assert sim.sense("r").bump == ()


def felt_from(rate_hz: int) -> list[tuple[float, ...]]:
    """Return what a robot at rest feels while a post grazes it at 5 m/s, in each tick in which it feels anything."""
    text = f"""
mjsim: 1
run: {{rate_hz: {rate_hz}}}
obstacles: [{{cylinder: [0.2, 0.5], at: [-1, 0.41], path: {{points: [[1, 0.41]], speed: 5, wait: 0}}}}]
robots: [{{name: r, at: [0, 0]}}]
"""
    sim, felt = Simulation(parse_world(text)), []
    for _ in range(round(0.4 / sim.dt)):
        sim.step()
        felt.append(sim.sense("r").bump)
    return [bump for bump in felt if bump]


def test_a_contact_between_two_ticks_is_felt_once_at_the_next_with_its_last_bearing():
    # Ticks of one physics step, the second and last of which with contact ends 12 ms before one of 40 ms.
    steps = felt_from(250)
    assert len(steps) == 2
    assert felt_from(25) == steps[-1:]


def test_a_robot_that_lies_on_a_patch_of_floor_has_not_bumped():
    sim = Simulation(
        parse_world("mjsim: 1\nfloor: {patches: [{at: [0, 0], size: [2, 2]}]}\nrobots: [{name: r, at: [0, 0]}]\n")
    )
    sim.data.qpos[2] -= 0.06
    mujoco.mj_forward(sim.model, sim.data)
    touching = [{sim.model.body(sim.model.geom_bodyid[g]).name for g in pair} for pair in sim.data.contact.geom]
    assert {"r/base", "world"} in touching
    assert sim.sense("r").bump == ()
