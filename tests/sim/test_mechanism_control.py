"""Controllers of mechanisms, and springs between points, move them as closed forms say."""

import math

import numpy as np
import pytest

import mjsim
from mjsim.errors import ModuleFault, UsageError, WorldError

LAW = "mjsim.algorithms.linear_control:MechanismLoop"
SLIDE = """mjsim: 1
mechanisms:
  - name: m
    elevation: 2
    bodies: [{name: box, box: [0.2, 0.2, 0.2], mass: 2}]
    joints: [{prismatic: s, of: [ground, box], axis: [1, 0, 0], start: 0.3}]
    %s
run: {step_ms: 1, rate_hz: 25}
"""
MODULE = """
class Spring:
    def __init__(self, stiffness):
        self.stiffness = stiffness

    def start(self, robot, part, rng):
        self.part = part
        assert (robot.name, part, robot.drive) == ("m", "s", "fixed")

    def torques(self, sensed, wanted):
        return [self.stiffness * (wanted.joints[self.part].positions[0] - sensed.joints[self.part].positions[0])]
"""


def moved(world, ticks):
    """Return times and the first value of the mechanism 'm' at each tick."""
    with mjsim.Simulation(world) as sim:
        rows = []
        for _ in range(ticks):
            rows.append((sim.time, sim.motions()["m"].positions[0]))
            sim.step()
    return np.array(rows).T


def test_a_module_beside_the_world_drives_a_joint_as_the_spring_that_it_is(tmp_path):
    (tmp_path / "own.py").write_text(MODULE)
    use = "controller: {use: 'own.py:Spring', stiffness: 50, rate_hz: 1000}, goal: {constant: {value: 0.1}}"
    (tmp_path / "w.yaml").write_text(SLIDE % f"actuators: [{{force: s, {use}}}]")
    times, positions = moved(mjsim.load_world(tmp_path / "w.yaml"), 10)
    np.testing.assert_allclose(positions, 0.1 + 0.2 * np.cos(5 * times), atol=4e-3)


def test_a_transfer_function_and_state_feedback_of_one_law_move_a_joint_alike():
    found = []
    for law in ("num: [4, 50], den: [0.0001, 1]", "gain: {s: [50, 4]}"):
        text = SLIDE % f"actuators: [{{force: s, controller: {{use: '{LAW}', {law}}}}}]"
        found.append(moved(mjsim.parse_world(text.replace("start: 0.3", "start: 0.3, speed: 1")), 8)[1])
    # The goal is where the joint starts, so that the derivative begins without a kick; one feels the rate.
    np.testing.assert_allclose(found[0], found[1], atol=5e-3)
    assert found[1].max() > 0.4


def test_a_box_on_a_spring_with_a_damper_swings_as_the_equation_says():
    text = "constraints: [{spring: [{ground: [-1, 0, 0]}, box], stiffness: 50, rest: 1.1, damping: 1}]"
    times, positions = moved(mjsim.parse_world(SLIDE % text), 25)
    decay, pulse = 0.25, math.sqrt(25 - 0.25**2)
    expected = np.exp(-decay * times) * (np.cos(pulse * times) + decay / pulse * np.sin(pulse * times))
    np.testing.assert_allclose(positions, 0.1 + 0.2 * expected, atol=2e-4)


def test_what_is_trimmed_on_a_spring_hangs_where_it_balances_the_weight():
    text = (SLIDE % "constraints: [{spring: [{ground: [0, 0, 3]}, box], stiffness: 100, rest: 1}]").replace(
        "[1, 0, 0], start: 0.3", "[0, 0, 1]"
    )
    world = mjsim.parse_world(text.replace("name: m\n", "name: m\n    mode: trim\n"))
    assert world.mechanisms[0].assembly.start[0] == pytest.approx(2.0 - 2 * 9.81 / 100, abs=1e-9)


@pytest.mark.parametrize(
    ("actuator", "line"),
    [
        ("force: s, signal: {constant: {value: 1}}, controller: {use: 'a.py:A'}", "leave out signal and find"),
        ("force: s, signal: {constant: {value: 1}}, goal: {constant: {value: 1}}", "add controller: {use: ...}"),
        ("force: box, axis: [1, 0, 0], controller: {use: 'a.py:A'}", "is for a force on a joint; give a signal"),
        ("force: s, controller: {use: 'a.py:A'}, goal: {constant: {value_deg: 1}}", "value_deg"),
        ("position: s, controller: {use: 'a.py:A'}", "unknown key 'controller'"),
    ],
)
def test_a_controller_that_does_not_fit_is_one_line(actuator, line):
    with pytest.raises(WorldError, match=r"^w.yaml:7:\d+: [^\n]*$") as caught:
        mjsim.parse_world(SLIDE % f"actuators: [{{{actuator}}}]", file="w.yaml")
    assert line in str(caught.value)


def test_a_module_that_is_not_there_or_fails_is_one_line(tmp_path):
    (tmp_path / "w.yaml").write_text(SLIDE % "actuators: [{force: s, controller: {use: 'gone.py:A'}}]")
    with mjsim.Simulation(mjsim.load_world(tmp_path / "w.yaml")) as sim, pytest.raises(UsageError, match=r"gone\.py"):
        sim.step()
    text = SLIDE % f"actuators: [{{force: s, controller: {{use: '{LAW}', gain: {{t: [1, 1]}}}}}}]"
    with mjsim.Simulation(mjsim.parse_world(text)) as sim, pytest.raises(ModuleFault, match="no joint 't'"):
        sim.step()


CHAIN = """mjsim: 1
mechanisms:
  - name: m
    elevation: 3
    bodies: [{name: u, rod: [1, 0.02]}, {name: l, rod: [1, 0.02]}]
    joints:
      - {revolute: a, of: [ground, u], axis: [0, 1, 0], start_deg: 10}
      - {revolute: b, of: [u.end, l], start_deg: 60}
run: {step_ms: 4}
"""


def test_a_double_pendulum_keeps_its_energy():
    with mjsim.Simulation(mjsim.parse_world(CHAIN)) as sim:
        energies = []
        for _ in range(25):
            now = sim.readings()["m"]
            energies.append(
                now.values[now.names.index("energy.kinetic")] + now.values[now.names.index("energy.potential")]
            )
            sim.step()
    assert np.ptp(energies) < 5e-3  # of 40 J; with forces of inertia half a step late it is 100 times as much
