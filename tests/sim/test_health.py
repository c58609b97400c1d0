"""What is told of a state that has failed."""

import mujoco
import numpy as np
import pytest

from mjsim.sim import Simulation
from mjsim.sim.health import MAX_SPEED, Health, collected_warnings
from mjsim.world import parse_world

ROBOTS = "mjsim: 1\nrobots: [{name: a, at: [0, 0]}, {name: b, at: [3, 0]}, {name: c, at: [6, 0], base: fixed}]"


@pytest.fixture(scope="module")
def sim():
    with Simulation(parse_world(ROBOTS)) as sim:
        yield sim


@pytest.fixture
def data(sim):
    """The state, which is as before afterwards."""
    qpos, qvel = sim.data.qpos.copy(), sim.data.qvel.copy()
    yield sim.data
    sim.data.qpos[:], sim.data.qvel[:] = qpos, qvel
    sim.data.warning.number[:] = 0


@pytest.fixture
def health(sim):
    return Health(sim.model, sim.world)


@pytest.mark.parametrize("robot", ["a", "b"])
@pytest.mark.parametrize("axis", range(3))
def test_a_speed_of_a_base_along_any_axis_is_noticed(health, data, robot, axis):
    start = data.joint(f"{robot}/free").qvel
    start[axis] = -0.99 * MAX_SPEED
    assert health.fault(data, [], loop=None) is None
    start[axis] = -1.5 * MAX_SPEED
    assert health.fault(data, [], loop=None).startswith("a robot moves at 150 m/s")


def test_a_base_may_turn_fast_and_wheels_too(health, data):
    data.joint("a/free").qvel[3:] = 10 * MAX_SPEED
    data.joint("a/wheel_left").qvel[:] = 10 * MAX_SPEED
    assert health.fault(data, [], loop=None) is None


def test_a_place_that_is_no_number_is_noticed(health, data):
    data.qpos[-1] = np.nan
    assert health.fault(data, [], loop=None) is not None


def test_the_warning_of_the_physics_comes_first_and_that_of_a_mechanism_before_it(health, data):
    data.warning.number[3] = 1
    assert health.fault(data, ["Nan in QACC at DOF 0. Time = 1.0"], loop=None).startswith("Nan in QACC at DOF 0.")
    assert health.fault(data, [], loop="loop of 'm' is open").startswith("loop of 'm' is open")
    data.warning.number[3] = 0
    assert health.fault(data, [], loop="loop of 'm' is open").startswith("loop of 'm' is open")


def test_warnings_go_to_a_list_within_the_block_alone():
    mine = [].append
    mujoco.set_mju_user_warning(mine)
    try:
        with collected_warnings() as collected:
            mujoco.get_mju_user_warning()("a warning")
        assert mujoco.get_mju_user_warning() == mine
    finally:
        mujoco.set_mju_user_warning(None)
    assert collected == ["a warning"]
