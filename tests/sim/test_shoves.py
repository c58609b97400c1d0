"""A shove gives a robot or a thing the momentum that it says, and nothing after."""

import numpy as np
import pytest

import mjsim
from mjsim.errors import UsageError, WorldError

WORLD = """
mjsim: 1
obstacles: [{name: ball, sphere: 0.2, at: [0, 0], movable: true, mass: 2}]
robots: [{name: scout, at: [0, 3]}]
run: {events: [EVENTS]}
"""


def pushed(events: str, ticks: int = 15) -> mjsim.Simulation:
    sim = mjsim.Simulation(mjsim.parse_world(WORLD.replace("EVENTS", events)))
    for _ in range(ticks):
        sim.step()
    return sim


@pytest.mark.parametrize("seconds", [0.1, 0.2, 0.002])
def test_a_ball_in_the_air_has_the_momentum_of_its_shove_less_that_of_its_fall(seconds):
    with pushed(f"{{time: 0.2, shove: ball, impulse: [1.4, 0.7, 6.0], seconds: {seconds}}}") as sim:
        speed = np.array(sim.data.joint("obstacle/ball").qvel[:3])
        np.testing.assert_allclose(speed[:2], [0.7, 0.35], rtol=0.01)
        assert speed[2] == pytest.approx(6.0 / 2 - 9.81 * 0.4, abs=0.02)
        np.testing.assert_array_equal(sim.data.xfrc_applied, 0.0)
        (event,) = sim.happened()
        assert event.shove == "ball"


def test_shoves_at_one_time_add_up():
    event = "{time: 0.2, shove: ball, impulse: [0.7, 0, 0], seconds: 0.1}"
    with pushed(f"{event}, {event}") as twice, pushed(event.replace("0.7", "1.4")) as once:
        np.testing.assert_array_equal(twice.state()[1], once.state()[1])


def test_python_shoves_too_and_a_robot_moves_off():
    with mjsim.Simulation(mjsim.parse_world(WORLD.replace("EVENTS", ""))) as sim:
        sim.shove("scout", (30.0, 0.0, 0.0), seconds=0.2)
        for _ in range(10):
            sim.step()
        assert sim.truth("scout").x > 0.02
        with pytest.raises(UsageError, match="no robot or movable obstacle 'bal' in this world; did you mean 'ball'"):
            sim.shove("bal", (1.0, 0.0, 0.0))
        with pytest.raises(UsageError, match="impulse"):
            sim.shove("ball", (1.0, 0.0, float("nan")))


@pytest.mark.parametrize(
    ("event", "says"),
    [
        ("{time: 1, shove: bal, impulse: [1, 0, 0]}", "no robot or movable obstacle 'bal' in this world"),
        ("{time: 1, shove: ball}", "impulse"),
        ("{time: 1, shove: ball, impulse: [1, 0]}", "impulse"),
        ("{time: 1, shove: ball, impulse: [1, 0, 0], seconds: 0}", "seconds is 0"),
    ],
)
def test_what_is_wrong_is_one_line(event, says):
    with pytest.raises(WorldError) as caught:
        mjsim.parse_world(WORLD.replace("EVENTS", event))
    (line,) = str(caught.value).splitlines()
    assert line.startswith("world.yaml:5:")
    assert says in line


def test_a_force_that_changes_gives_the_momentum_of_its_integral():
    force = "{sine: {amplitude: 6, frequency_hz: 1.25, offset: 2}}"
    push = f"{{time: 0.2, push: ball, signal: {force}, along: [0, 0.5, 0], seconds: 0.4}}"
    with mjsim.Simulation(mjsim.parse_world(WORLD.replace("EVENTS", push))) as sim:
        sim.model.opt.gravity[:] = 0.0
        for _ in range(20):
            sim.step()
        # Half a period of the sine, and its mean.
        momentum = 0.5 * (2 * 6 / (2 * np.pi * 1.25) + 0.4 * 2)
        assert float(sim.data.joint("obstacle/ball").qvel[1]) == pytest.approx(momentum / 2, rel=0.005)
        np.testing.assert_array_equal(sim.data.xfrc_applied, 0.0)


def test_a_random_push_is_the_same_for_the_same_seed_and_another_for_another():
    push = "{time: 0, push: ball, signal: {random: {deviation: 5, hold: 0.05}}}"
    world = mjsim.parse_world(WORLD.replace("EVENTS", f"{push}, {push}"))
    states = []
    for seed in (1, 1, 2):
        with mjsim.Simulation(world, seed=seed) as sim:
            for _ in range(10):
                sim.step()
            states.append(sim.state()[1])
    np.testing.assert_array_equal(states[0], states[1])
    assert not np.array_equal(states[0], states[2])
