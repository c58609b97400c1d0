"""The period of the physics, and what acts between ticks."""

import math

import numpy as np
import pytest

import mjsim
from mjsim import Command

ROOM = """
mjsim: 1
robots: [{{name: scout, preset: {preset}, at: [0, 0]}}]
run: {{step_ms: {step}, rate_hz: {rate}}}
"""


def room(preset="pioneer3dx", step=4, rate=25):
    return mjsim.parse_world(ROOM.format(preset=preset, step=step, rate=rate))


class Watching:
    """An actuation that only notes when it is asked."""

    def __init__(self, every):
        self.every, self.steps = every, []

    def act(self, step):
        self.steps.append(step)


@pytest.mark.parametrize("step", [1, 2, 4])
def test_the_physics_goes_on_by_the_step_that_the_world_asks_for(step):
    with mjsim.Simulation(room(step=step)) as sim:
        sim.step()
        assert sim.model.opt.timestep == step / 1000
        assert sim.data.time == pytest.approx(0.04, abs=1e-12)
        assert sim.dt == 0.04


@pytest.mark.parametrize("step", [pytest.param(1, marks=pytest.mark.slow), pytest.param(2, marks=pytest.mark.slow), 4])
@pytest.mark.parametrize("preset", ["pioneer3dx", "husky", "f1tenth", "forklift", "robotino", "youbot"])
def test_speed_times_time_holds_at_every_step(preset, step):
    with mjsim.Simulation(room(preset, step)) as sim:
        speed = 0.5 * sim.robots["scout"].max_speed
        sim.apply("scout", Command(speed))
        for _ in range(75):
            sim.step()
        before = sim.truth("scout").x
        for _ in range(50):
            sim.step()
        assert sim.truth("scout").x - before == pytest.approx(speed * 50 * sim.dt, rel=0.02)


def test_an_imu_reads_at_1000_hz_where_the_step_is_1_ms():
    text = ROOM.format(preset="pioneer3dx", step=1, rate=25).replace(
        "at: [0, 0]", "at: [0, 0], sensors: [{imu: felt, rate_hz: 1000}]"
    )
    with mjsim.Simulation(mjsim.parse_world(text)) as sim:
        sim.step()
        readings = sim.sense("scout").imu
    assert np.allclose([reading.stamp for reading in readings], np.arange(1, 41) / 1000, atol=1e-12)


@pytest.mark.parametrize(
    ("run", "sensors", "said"),
    [
        ("{step_ms: 3}", "", "step_ms is 3; it must be 1, 2 or 4"),
        (
            "{step_ms: 2, rate_hz: 160}",
            "",
            "rate_hz is 160 Hz; a tick must be a whole number of 2 ms steps, the nearest rate is 166.667 Hz",
        ),
        (
            "{step_ms: 4}",
            "{imu: felt, rate_hz: 500}",
            "rate_hz is 500 Hz; a period must be a whole number of 4 ms steps, the nearest rate is 250 Hz",
        ),
    ],
)
def test_what_is_no_whole_number_of_steps_is_refused(run, sensors, said):
    text = f"mjsim: 1\nrobots: [{{name: r, preset: pioneer3dx, at: [0, 0], sensors: [{sensors}]}}]\nrun: {run}\n"
    with pytest.raises(mjsim.WorldError, match=said):
        mjsim.parse_world(text)


@pytest.mark.parametrize("every", [10, 5, 2, 1])
def test_an_actuation_acts_at_its_own_rate_and_changes_nothing_of_the_others(every):
    def state(*more):
        with mjsim.Simulation(room(), seed=1) as sim:
            sim._robots["scout"].actuations.extend(more)
            sim.apply("scout", Command(0.4, turn=0.5))
            for _ in range(3):
                sim.step()
            return sim.state()[0]

    watching = Watching(every)
    np.testing.assert_array_equal(state(watching), state())
    assert watching.steps == list(range(0, 30, every))


def test_a_torque_written_between_ticks_moves_the_wheels():
    class Push(Watching):
        def act(self, step):
            super().act(step)
            sim.data.qfrc_applied[turned] = 0.05 * math.copysign(1.0, math.sin(2 * math.pi * 5 * step * 0.004))

    with mjsim.Simulation(room()) as sim:
        turned = sim.model.joint("scout/wheel_left").dofadr
        sim._robots["scout"].actuations.append(Push(1))
        speeds = []
        for _ in range(25):
            sim.step()
            speeds.append(float(sim.data.qvel[turned][0]))
    assert max(speeds) > 0.01
    assert min(speeds) < -0.01
