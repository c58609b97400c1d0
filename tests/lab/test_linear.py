"""Plants of scenes, made linear, are those of the books; what cannot be one is said in one line."""

import numpy as np
import pytest

import mjsim
from mjsim.algorithms.balance import plant as balancing_plant
from mjsim.algorithms.balance import turning_plant
from mjsim.algorithms.signal import Signal
from mjsim.errors import UsageError, WorldError
from mjsim.interface import BalancingInfo
from mjsim.lab import ScenePlant, experiment

WORLD = """
mjsim: 1
robots:
  - {name: joe, preset: balancer, at: [1, 2], heading_deg: 30}
  - {name: scout, preset: pioneer3dx, at: [3, 0], heading_deg: -70}
  - {name: puma, base: fixed, at: [6, 0], arms: [{preset: puma560}]}
plants:
  - {name: plant, KEYS}
run: {step_ms: STEP}
"""


def plant(keys: str, step: int = 4) -> ScenePlant:
    world = mjsim.parse_world(WORLD.replace("KEYS", keys).replace("STEP", str(step)))
    return ScenePlant(world, world.plants[0])


def joe() -> BalancingInfo:
    """Return the masses of the preset, from its numbers alone."""
    m, r, width = 1.0, 0.105, 0.02625
    across = m * (r**2 / 4 + width**2 / 3)
    box = np.array([0.16, 0.32, 0.55])
    pitch, yaw = 12 / 12 * (box[0] ** 2 + box[2] ** 2), 12 / 12 * (box[0] ** 2 + box[1] ** 2)
    return BalancingInfo(
        wheel_mass=m,
        wheel_inertia=m * r**2 / 2,
        wheel_across=across,
        body_mass=12.0,
        center=0.30,
        pitch_inertia=pitch,
        yaw_inertia=yaw,
        max_torque=4.0,
    )


@pytest.mark.slow
@pytest.mark.parametrize("step", [1, 4])
def test_a_balancing_base_in_contact_is_that_of_pathak(step):
    found = plant("of: joe, input: torque, outputs: [way, lean]", step).linear
    A, B = balancing_plant(joe(), wheel_radius=0.105)
    assert found.states == ("way", "lean", "way.rate", "lean.rate")
    np.testing.assert_allclose(found.A, A, rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(found.B, B, rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(found.C, np.eye(2, 4), atol=1e-12)
    assert found.units == ("N m", "m", "rad")


@pytest.mark.slow
def test_a_balancing_base_turns_as_its_inertia_says():
    found = plant("of: joe, input: twist, outputs: heading").linear
    A, B = turning_plant(joe(), wheel_radius=0.105, track=0.43)
    np.testing.assert_allclose(found.A, A, atol=1e-8)
    np.testing.assert_allclose(found.B, B, rtol=1e-8)


@pytest.mark.slow
def test_the_pioneer_follows_its_motors_with_the_pole_of_its_mass():
    lab = plant("of: scout, input: forward, outputs: way.rate")
    model, radius = lab.model, 0.0975
    wheel, servo = model.body("scout/wheel_left"), model.actuator("scout/wheel_left")
    turning = wheel.inertia[1] + model.dof_armature[model.joint("scout/wheel_left").dofadr[0]]
    mass = model.body("scout/base").mass[0] + 2 * wheel.mass[0] + 2 * turning / radius**2
    pole = -2 * servo.gainprm[0] / radius**2 / mass
    found = lab.linear
    assert found.states == ("way.rate",)
    np.testing.assert_allclose([found.A[0, 0], found.B[0, 0], found.C[0, 0]], [pole, -pole, 1.0], rtol=1e-9)
    # What MuJoCo does, contacts that yield and all, is not far from that.
    steps = np.arange(300)
    speed = lab.simulated(np.full(300, 0.2))[0]
    np.testing.assert_allclose(speed, 0.2 * (1 - np.exp(pole * steps * 0.004)), atol=0.008)


def test_a_joint_of_an_arm_is_held_against_gravity_and_moves_as_its_inertia_says():
    lab = plant("of: puma/arm, input: joint3, outputs: [joint3, joint3.rate], around: {joint3_deg: 20}")
    arm = mjsim.arm("puma560")
    q = np.zeros(6)
    q[2] = np.radians(20)
    assert lab.setting.value == pytest.approx(arm.gravload(q)[2], rel=1e-9)
    inertia = arm.inertia(q)[2, 2]
    h = 1e-5
    ahead, behind = (arm.gravload(q + d * np.eye(6)[2])[2] for d in (h, -h))
    link = arm.links[2]
    A = [[0, 1], [-(ahead - behind) / (2 * h) / inertia, -link.viscous * link.gear**2 / inertia]]
    np.testing.assert_allclose(lab.linear.A, A, rtol=1e-6)
    np.testing.assert_allclose(lab.linear.B, [[0], [1 / inertia]], rtol=1e-9)


@pytest.mark.slow
def test_dry_friction_is_left_out_of_the_comparison_and_shown_beside_it():
    keys = "of: puma/arm, input: joint3, outputs: joint3, around: {joint3_deg: 20}, amplitude: 0.02"
    world = mjsim.parse_world(WORLD.replace("KEYS", keys).replace("STEP", "4"))
    found = experiment(world, world.plants[0])
    link = mjsim.arm("puma560").links[2]
    assert found.dry_friction == pytest.approx(abs(link.gear) * (link.coulomb[0] - link.coulomb[1]) / 2)
    assert found.nonlinear_fit is not None
    assert found.nonlinear_fit[0] > 99.0
    assert found.nonlinear is not None
    assert found.rough is not None
    assert found.rough[1][0, -1] < 0.5 * found.nonlinear[1][0, -1]


@pytest.mark.slow
def test_a_drive_is_identified_from_a_run_whatever_its_profile_makes_of_commands(tmp_path):
    text = WORLD.replace("KEYS", "of: scout, input: forward, outputs: way.rate").replace("STEP", "4")
    world = mjsim.parse_world(text)
    driver = mjsim.Driver(navigator=Signal(forward={"square": {"amplitude": 0.2, "frequency_hz": 0.5}}))
    with mjsim.Simulation(world) as sim:
        recording = mjsim.run(sim, drivers={"scout": driver}, seconds=5, record=tmp_path / "run.mcap")
    found = experiment(world, world.plants[0], recording=recording).identified
    assert found is not None
    # The servos' pole; contacts yield, so that it is not exactly there.
    np.testing.assert_allclose(found.poles, [-10.0], rtol=0.05)
    assert found.model_fit[0] > 97.0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ("of: joe, input: torqe, outputs: way", "no input 'torqe' of joe; did you mean 'torque'?"),
        ("of: joe, input: torque, outputs: [wy]", "no output 'wy' of joe; did you mean 'way'?"),
        (
            "of: puma/amr, input: joint1, outputs: joint1",
            "no robot, arm or mechanism 'puma/amr'; did you mean 'puma/arm'",
        ),
        ("of: scout, input: forward, outputs: heading", "forward affects none of heading; name another input"),
        (
            "of: puma/arm, input: joint1, outputs: joint1, around: {joint3_deg: 20}",
            "has no equilibrium at its operating",
        ),
        ("of: puma/arm, input: joint3, outputs: joint3, around: {joint3: 1}", "joint joint3 turns; write joint3_deg"),
        (
            "of: puma/arm, input: joint3, outputs: joint3, around: {elbow_deg: 1}",
            "puma/arm has no joint 'elbow'; there",
        ),
    ],
)
def test_what_is_no_plant_is_said_in_one_line(keys, message):
    with pytest.raises(UsageError) as caught:
        plant(keys)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ("of: jo, input: torque, outputs: way", "no robot or mechanism 'jo' in this world; did you mean 'joe'?"),
        ("of: joe, outputs: way", "key 'input' is missing; a part of the scene has an input and outputs"),
        ("input: torque", "a plant has one of 'of', 'tf', 'zpk' and 'ss'; this one has none"),
        (
            "of: joe, tf: {num: [1], den: [1, 1]}",
            "'zpk' and 'ss'; this one has of and tf",
        ),
        ("tf: {num: [1, 2, 3], den: [1, 1]}", "num has degree 2, den 1; that of num must not be higher"),
        ("tf: {num: [1], den: [0, 1]}", "the first coefficient of den is 0; leave leading zeros out"),
        ("tf: {num: [0], den: [1]}", "all numbers of num are 0; give another"),
        ("tf: {num: [1], den: [1, x]}", "den[1] is 'x'; it must be a number"),
        ("tf: {num: [1], dem: [1]}", "unknown key 'dem'; did you mean 'den'?"),
        ("tf: {num: [1], den: [1, 1]}, input: torque", "input is for a part of the scene; leave it out beside tf"),
        ("ss: {a: [[0, 1]], b: [[1]], c: [[1]]}", "a must have 1 rows of 1 each, as a has 1 rows"),
        ("ss: {a: [[0]], b: [[1, 2]], c: [[1]]}", "input is missing; the state space has u1, u2; name one"),
        ("ss: {a: [[0]], b: [[1, 2]], c: [[1]]}, input: u3", "input has 'u3'; the state space has u1, u2"),
        ("ss: {a: [[0]], b: [[1]], c: [[1]]}, outputs: [y2]", "outputs has 'y2'; the state space has y"),
        ("ss: {a: [[0]], b: [[1], [2]], c: [[1]]}", "b must have 1 rows of 1 each, as a has 1 rows"),
        ("ss: {a: [[0]], b: [[1]], c: [[1]], d: [[1, 2]]}", "d must have 1 rows of 1 each, as a has 1 rows"),
        ("ss: {a: [[0]], b: [[1]], c: [[1]]}, around: {q: 1}", "around is for a part of the scene; leave it out"),
        ("tf: {num: [1], den: [1, 1], delay: -1}", "delay is -1"),
        ("tf: {num: [1], den: [1, .nan]}", "den[1] is nan; it must be a finite number"),
        ("tf: [1, 2]", "tf is [1, 2]; it must be keys with values"),
        ("ss: {a: [[0]], b: [[1]]}", "key 'c' is missing; add it"),
        ("tf: {num: [1], den: [1, 1]}, amplitude: 0", "amplitude is 0; it must be above 0"),
    ],
)
def test_a_malformed_plant_is_one_line_with_its_place(keys, message):
    with pytest.raises(WorldError) as caught:
        plant(keys)
    (line,) = str(caught.value).splitlines()
    assert line.startswith("world.yaml:8:")
    assert message in line
