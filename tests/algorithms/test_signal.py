"""The signal navigator commands what its signals say."""

import numpy as np
import pytest

import mjsim
from mjsim.algorithms.signal import Signal
from mjsim.errors import ModuleFault

WORLD = """
mjsim: 1
robots: [{name: scout, preset: pioneer3dx, at: [0, 0]}]
run:
  drivers:
    scout:
      navigator:
        use: "mjsim.algorithms.signal:Signal"
        forward: {step: {to: 0.4, at: 0.2}}
        turn: KEYS
"""
ARM = """
mjsim: 1
robots: [{name: puma, base: fixed, at: [0, 0], arms: [{preset: puma560}]}]
run:
  drivers:
    puma:
      navigator:
        use: "mjsim.algorithms.signal:Signal"
        joints: {arm: [JOINTS]}
"""
STILL = "{constant: {value_deg: 0}}"
WAVE = "{sine: {amplitude_deg: 20, frequency_hz: 0.5}}"


def wanted(text: str, seed: int = 1, seconds: float = 1.0) -> list:
    """Return what the navigator asked for, tick by tick."""
    orders = []
    with mjsim.Simulation(mjsim.parse_world(text), seed=seed) as sim:
        robot = sim.world.robots[0].name
        mjsim.run(sim, seconds=seconds, watch=lambda tick: orders.append(tick.orders[robot].wanted))
    return orders


def test_commands_are_the_values_of_the_signals():
    orders = wanted(WORLD.replace("KEYS", "{ramp: {from_deg: 10, slope_deg: 90}}"))
    times = np.arange(25) * 0.04
    np.testing.assert_array_equal([order.forward for order in orders], np.where(times >= 0.2 - 1e-9, 0.4, 0.0))
    np.testing.assert_allclose([order.turn for order in orders], np.radians(10 + 90 * times))


@pytest.mark.slow
def test_chance_is_the_seed_s():
    text = WORLD.replace("KEYS", "{random: {deviation_deg: 10, hold: 0.08}}")
    one, again, other = ([order.turn for order in wanted(text, seed)] for seed in (1, 1, 2))
    assert one == again != other
    assert one[0::2][:12] == one[1::2]


def test_joints_get_goals_with_their_rates_and_accelerations():
    orders = wanted(ARM.replace("JOINTS", ", ".join([WAVE] + [STILL] * 5)), seconds=0.4)
    goal, time = orders[5].joints["arm"], 0.2
    a, w = np.radians(20), np.pi
    assert goal.positions[0] == pytest.approx(a * np.sin(w * time))
    assert goal.velocities[0] == pytest.approx(a * w * np.cos(w * time))
    assert goal.accelerations[0] == pytest.approx(-a * w**2 * np.sin(w * time))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (WORLD.replace("KEYS", "{ramp: {slope: 1}}"), "turn: this is an angle, in degrees; write slope_deg for slope"),
        (WORLD.replace("KEYS", "{rump: {slope: 1}}"), "turn: rump: unknown key 'rump'; did you mean 'ramp'?"),
        (WORLD.replace("KEYS", "{table: {file: a.csv}}"), "turn: file 'a.csv' cannot be read here; give the table's"),
        (ARM.replace("JOINTS", STILL), "joints.arm holds 1 signals; the arm has 6 joints"),
        (ARM.replace("{arm:", "{hand:").replace("JOINTS", STILL), "robot 'puma' has no arm 'hand'; its arms are arm"),
        (WORLD.replace("forward: {step: {to: 0.4, at: 0.2}}", "").replace("turn: KEYS", ""), "no signal is given"),
    ],
)
def test_a_mistake_ends_in_one_line(text, message):
    with pytest.raises(ModuleFault) as caught:
        wanted(text)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_signals_are_checked_when_the_module_is_made():
    with pytest.raises(ValueError, match="forward: ramp: slope is missing"):
        Signal(forward={"ramp": {}})
