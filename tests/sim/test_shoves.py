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
