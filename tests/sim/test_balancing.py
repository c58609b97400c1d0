"""A balancing base moves as the linear model of its masses does, which another program computed."""

import math
from pathlib import Path

import mujoco
import numpy as np
import pytest
from scipy.linalg import expm

import mjsim
from mjsim.algorithms.balance import Lqr, TickLean, plant, turning_plant
from mjsim.compile import compile_world

GOLDEN = np.load(Path(__file__).parents[1] / "data" / "joints" / "balancer.npz")
STEP, RADIUS, CENTER = 0.004, 0.105, 0.3
JOE = """
mjsim: 1
robots:
  - name: joe
    at: [0, 0]
    {keys}
    drive: {{type: balancing, wheel_radius: 0.105, track: 0.43, wheel_mass: 1.0, max_torque: 4}}
    odometry: {{noise: {{distance: 0, turn: 0}}}}
    body: {{box: [0.16, 0.32, 0.55], mass: 12, center: 0.30}}
    sensors: [{{imu: imu, at: [0, 0, {height}], rate_hz: 250}}]
run: {{rate_hz: {rate}, {run}}}
"""


def joe(keys: str = "", *, rate: float = 250.0, run: str = "", height: float = 0.105) -> mjsim.World:
    """Return a world of the robot of the golden arrays, one tick for each physics step unless said."""
    return mjsim.parse_world(JOE.format(keys=keys, rate=rate, run=run, height=height))


def state(sim: mjsim.Simulation) -> list[float]:
    """Return way of the axle, pitch, and their rates, of a robot that heads along x."""
    pose, rates = sim.poses()["joe"], sim.data.joint("joe/free").qvel
    pitch, turn = pose.pitch(), float(rates[4])
    return [
        pose.x + RADIUS * math.sin(pitch),
        pitch,
        float(rates[0]) + RADIUS * math.cos(pitch) * turn,
        turn,
    ]


def driven(world: mjsim.World, seconds: float, speed: float = 0.0) -> np.ndarray:
    """Return the states at each step of a robot that is told to drive from the start, shape (n, 4)."""
    with mjsim.Simulation(world) as sim:
        sim.apply("joe", mjsim.Command(speed))
        states = []
        for _ in range(round(seconds / STEP)):
            states.append(state(sim))
            sim.step()
    return np.array(states)


def linear(seconds: float, *, lean: float = 0.0, speed: float = 0.0, push: float = 0.0) -> np.ndarray:
    """Return what the linear model does under the golden feedback; a push lasts 0.1 s from 1 s on [N]."""
    A, B, K = GOLDEN["A"], GOLDEN["B"], GOLDEN["K_4ms"]
    # A force along x at the centre of mass turns the body too.
    M = np.array([[12 + 2 + 1, 12 * CENTER], [12 * CENTER, 12 * (0.16**2 + 0.55**2) / 12 + 12 * CENTER**2]])
    F = np.array([[0.0], [0.0], *np.linalg.solve(M, [[1.0], [CENTER]])])
    held = expm(np.block([[A, B, F], [np.zeros((2, 6))]]) * STEP)
    x, way, states = np.array([0.0, lean, 0.0, 0.0]), 0.0, []
    for step in range(round(seconds / STEP)):
        wanted = min(0.5 * step * STEP, speed)
        states.append(x)
        torque = -K @ (x - [way, 0.0, wanted, 0.0])
        way += wanted * STEP
        x = held[:4] @ [*x, torque[0], push if 250 <= step < 275 else 0.0]
    return np.array(states)


def assert_alike(states: np.ndarray, model: np.ndarray) -> None:
    """Compare over the whole course, in shares of each peak: pitch within 1 %, the rest within 2 %."""
    peaks = np.abs(model).max(axis=0)
    off = np.abs(states - model).max(axis=0) / peaks
    assert (off < [0.02, 0.01, 0.02, 0.02]).all(), off
    np.testing.assert_allclose(np.abs(states).max(axis=0), peaks, rtol=0.02)


def test_masses_and_feedback_are_those_of_the_golden_arrays():
    with mjsim.Simulation(joe()) as sim:
        masses = sim.robots["joe"].balancing
    assert masses is not None
    A, B = plant(masses, wheel_radius=RADIUS)
    np.testing.assert_allclose(A, GOLDEN["A"], rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(B, GOLDEN["B"], rtol=1e-12, atol=1e-12)
    lqr = Lqr()
    with mjsim.Simulation(joe()) as sim:
        sim.control("joe", {"drive": lqr})
        sim.step()
    np.testing.assert_allclose(lqr.feedback, GOLDEN["K_4ms"][0], rtol=1e-9)


def test_the_settled_plant_falls_with_the_pole_of_the_linear_model():
    model = compile_world(joe()).compile()
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 200)  # it stands on its edge, and the tyres settle
    A = np.zeros((2 * model.nv, 2 * model.nv))
    mujoco.mjd_transitionFD(model, data, 1e-6, True, A, None, None, None)
    pole = math.log(np.linalg.eigvals(A).real.max()) / model.opt.timestep
    assert pole == pytest.approx(np.linalg.eigvals(GOLDEN["A"]).real.max(), rel=1e-3)
    assert float(data.body("joe/wheel_left").xpos[2]) == pytest.approx(RADIUS - 5.15e-4 / 2, abs=1e-6)


@pytest.mark.slow
def test_released_at_a_lean_it_comes_back_as_the_linear_model():
    assert_alike(driven(joe(f"lean_deg: {math.degrees(0.1)!r}"), 2.5), linear(2.5, lean=0.1))


@pytest.mark.slow
def test_shoved_it_sways_as_the_linear_model():
    shoved = joe(run="events: [{time: 1, shove: joe, impulse: [6, 0, 0], seconds: 0.1}]")
    assert_alike(driven(shoved, 4.0), linear(4.0, push=60.0))


@pytest.mark.slow
def test_told_to_drive_it_first_rolls_back_as_the_linear_model():
    states = driven(joe(), 4.0, speed=0.5)
    assert states[:, 2].min() < -0.03  # before it leans forward
    assert_alike(states, linear(4.0, speed=0.5))


@pytest.mark.slow
def test_its_tyres_roll_at_the_radius_that_odometry_goes_by():
    with mjsim.Simulation(joe(rate=25)) as sim:
        sim.apply("joe", mjsim.Command(0.3))
        for _ in range(150):
            sim.step()
        way, told = state(sim)[0], 0.0
        for _ in range(75):
            sim.step()
            told += sim.sense("joe").odometry.forward
        assert told == pytest.approx(state(sim)[0] - way, rel=5e-4)
        assert told / 3.0 == pytest.approx(0.3, rel=5e-3)


@pytest.mark.slow
def test_the_height_of_its_inertial_sensor_does_not_matter():
    states = driven(joe(f"lean_deg: {math.degrees(0.1)!r}", height=0.6), 2.0)
    np.testing.assert_allclose(states[:, 1], linear(2.0, lean=0.1)[:, 1], atol=1e-3)


@pytest.mark.slow
def test_it_stands_after_a_shove_of_12_newton_seconds():
    with mjsim.Simulation(joe(rate=25)) as sim:
        sim.shove("joe", (12.0, 3.0, 0.0))
        for _ in range(250):
            sim.step()
        pose = sim.poses()["joe"]
    assert abs(pose.pitch()) < 0.01
    assert abs(pose.x) < 0.05


@pytest.mark.slow
def test_without_a_controller_that_acts_it_falls_and_its_motors_stop():
    class Slack:
        def start(self, robot, part, rng):
            pass

        def torques(self, sensed, wanted):
            return 0.0, 0.0

    with mjsim.Simulation(joe("lean_deg: 1", rate=25)) as sim:
        sim.control("joe", {"drive": Slack()})
        for _ in range(100):
            sim.step()
        assert sim.poses()["joe"].pitch() > 1.0
        sim.control("joe", {"drive": Lqr()})
        for _ in range(100):
            sim.step()
        assert abs(sim.truth("joe").x) < 1.0


def test_it_turns_by_what_the_masses_say():
    """The torque that turns it, over the moment of inertia about the vertical that MuJoCo finds for the whole robot."""
    with mjsim.Simulation(joe()) as sim:
        masses, model, data = sim.robots["joe"].balancing, sim.model, sim.data
        assert masses is not None
        mass = np.zeros((model.nv, model.nv))
        mujoco.mj_forward(model, data)
        mujoco.mj_fullM(model, data, mass)
        wheels = [int(model.joint(f"joe/wheel_{side}").dofadr[0]) for side in ("left", "right")]
    # Wheels that roll turn with the base: J' M J of the motion of one radian.
    motion = np.zeros(model.nv)
    motion[5], motion[wheels] = 1.0, np.array([-1.0, 1.0]) * 0.43 / (2 * RADIUS)
    _, B = turning_plant(masses, wheel_radius=RADIUS, track=0.43)
    assert B[1, 0] == pytest.approx(0.43 / (2 * RADIUS) / (motion @ mass @ motion), rel=1e-9)


@pytest.mark.slow
def test_odometry_is_the_way_of_the_axle_whatever_the_body_does():
    with mjsim.Simulation(joe("lean_deg: 5", rate=25)) as sim:
        sim.apply("joe", mjsim.Command(0.4, turn=0.3))
        told, began = mjsim.Pose(0.0, 0.0, 0.0), sim.poses()["joe"]
        for _ in range(120):
            sim.step()
            seen = sim.sense("joe").odometry
            told = told @ mjsim.Pose(seen.forward, seen.left, seen.turn)
        end = sim.poses()["joe"]
    ways = [pose.planar() @ mjsim.Pose(RADIUS * math.sin(pose.pitch()), 0.0, 0.0) for pose in (began, end)]
    true = ways[0].inverse() @ ways[1]
    np.testing.assert_allclose(told.as_array(), true.as_array(), atol=0.012)


def test_the_whole_pose_leans_and_so_do_its_sensors():
    """A lidar that leans forward by 0.1 rad meets the floor where geometry says."""
    world = mjsim.parse_world(
        JOE.format(keys=f"lean_deg: {math.degrees(0.1)!r}", rate=25, run="", height=0.105).replace(
            "rate_hz: 250}]", "rate_hz: 250}, {lidar: scan, at: [0, 0, 0.605], beams: 3, fov_deg: 180, rate_hz: 25}]"
        )
    )
    with mjsim.Simulation(world) as sim:
        assert sim.poses()["joe"].pitch() == pytest.approx(0.1)
        height = RADIUS + 0.5 * math.cos(0.1)
        ahead = float(sim.sense("joe").scans["scan"].ranges[1])
        assert ahead == pytest.approx(height / math.sin(0.1), rel=1e-6)
        assert sim.truth("joe").x == pytest.approx(-RADIUS * math.sin(0.1))


@pytest.mark.slow
def test_modules_find_its_lean_from_the_readings_of_each_tick():
    world = joe(rate=25, run="events: [{time: 2, shove: joe, impulse: [5, 0, 0]}]")
    with mjsim.Simulation(world) as sim:
        lean = TickLean(sim.robots["joe"])
        sim.apply("joe", mjsim.Command(0.5))
        for _ in range(90):
            pitch = lean.update(sim.sense("joe"))
            # During the shove its speed does not grow evenly, as is taken within a tick.
            assert pitch == pytest.approx(sim.poses()["joe"].pitch(), abs=0.012), sim.time
            sim.step()
