"""Controllers run between ticks: at their rate, on encoders and IMU, with torques that reach the motors."""

import numpy as np
import pytest

import mjsim
from mjsim.algorithms.constant import ConstantCommand
from mjsim.errors import UsageError, WorldError
from mjsim.run import drivers_of

WORLD = """
mjsim: 1
robots:
  - name: joe
    preset: balancer
    at: [0, 0]
    odometry: {{ticks: {ticks}}}
    sensors: [{{imu: imu, at: [0, 0, 0.105], rate_hz: {imu}, noise: {{acceleration: 0.1, turn: 0.01}}}}]
run: {{step_ms: {step}, drivers: {{joe: {{{driver}}}}}}}
"""


def world(driver: str = "", *, step: int = 4, imu: float = 250, ticks: str = "null") -> mjsim.World:
    return mjsim.parse_world(WORLD.format(driver=driver, step=step, imu=imu, ticks=ticks))


class Notes:
    """Gives torques by the time, and keeps what it was given."""

    def __init__(self, torques=lambda time: (0.0, 0.0)):
        self.given, self.sensed, self.wanted = torques, [], []

    def start(self, robot, part, rng):
        self.part, self.rng = part, rng

    def torques(self, sensed, wanted):
        self.sensed.append(sensed)
        self.wanted.append(wanted)
        return self.given(sensed.time)


def noted(controller: Notes, seconds: float, *, rate_hz: float = 250.0, latency: int = 0, **keys) -> Notes:
    """Return a controller after a run, and what the motors did at each step."""
    with mjsim.Simulation(world(**keys), seed=3) as sim:
        sim.control("joe", {"drive": mjsim.ControlLoop(controller=controller, rate_hz=rate_hz, latency=latency)})
        controller.imu = []
        for _ in range(round(seconds / sim.dt)):
            sim.step()
            controller.imu += sim.sense("joe").imu
    return controller


@pytest.mark.parametrize(("step", "rate"), [(4, 250.0), (4, 50.0), (2, 250.0), (1, 1000.0), (1, 1000 / 7)])
def test_it_is_asked_once_a_period_in_whole_steps(step, rate):
    notes = noted(Notes(), 0.28, step=step, rate_hz=rate)
    assert notes.part == "drive"
    times = np.array([each.time for each in notes.sensed])
    np.testing.assert_allclose(times, np.arange(len(times)) / rate, atol=1e-12)
    assert len(times) == np.ceil(0.28 * rate - 1e-9)
    assert {round(each.dt * rate, 9) for each in notes.sensed} == {1.0}


@pytest.mark.parametrize(("latency", "rate"), [(0, 250.0), (1, 250.0), (3, 125.0), (12, 62.5)])
def test_torques_act_as_many_steps_late_as_said(latency, rate):
    """Encoders tell the torques of the step before, so a controller sees its own one step and its latency later."""
    told = noted(Notes(lambda time: (time, -time)), 0.2, rate_hz=rate, latency=latency).sensed
    for each in told[:1]:
        np.testing.assert_allclose(each.wheels.torques, 0.0)
    for each in told[1:]:
        asked = np.array([other.time for other in told if other.time + 0.004 * (latency + 1) <= each.time + 1e-9])
        last = asked.max(initial=0.0)
        np.testing.assert_allclose(each.wheels.torques, [last, -last], atol=1e-12)


def test_a_motor_gives_no_more_than_its_limit():
    told = noted(Notes(lambda time: (100.0, -100.0)), 0.04).sensed
    np.testing.assert_allclose(told[-1].wheels.torques, [4.0, -4.0])


def test_encoders_tell_what_the_wheels_have_turned_relative_to_the_body():
    exact = noted(Notes(lambda time: (0.3, 0.2)), 0.4).sensed
    counted = noted(Notes(lambda time: (0.3, 0.2)), 0.4, ticks="1000").sensed
    size = 2 * np.pi / 1000
    for one, other in zip(exact, counted, strict=True):
        np.testing.assert_allclose(other.wheels.positions, np.floor(one.wheels.positions / size) * size, atol=1e-12)
    speeds = np.array([each.wheels.velocities for each in exact])
    np.testing.assert_allclose(
        np.cumsum(speeds[1:], axis=0) * 0.004, [e.wheels.positions for e in exact[1:]], atol=1e-9
    )
    differences = np.diff([each.wheels.positions for each in counted], axis=0) / 0.004
    np.testing.assert_allclose(differences, [each.wheels.velocities for each in counted[1:]], atol=1e-9)


@pytest.mark.parametrize("imu", [250, 125, 31.25])
def test_it_gets_the_readings_that_modules_get_at_the_next_tick_and_one_of_the_robot_held_at_the_start(imu):
    notes = noted(Notes(), 0.4, imu=imu)
    first, *fast = (reading for each in notes.sensed for reading in each.imu)
    assert first.stamp == 0.0
    np.testing.assert_allclose(first.acceleration, [0.0, 0.0, 9.81], atol=0.4)
    told = [reading for reading in notes.imu if reading.stamp <= notes.sensed[-1].time + 1e-9]
    assert len(told) == len(fast) == int(0.396 * imu + 1e-9)
    for one, other in zip(fast, told, strict=True):
        assert one is other


def test_set_points_keep_the_limits_of_the_drive():
    notes = Notes()
    with mjsim.Simulation(world()) as sim:
        sim.control("joe", {"drive": notes})
        sim.apply("joe", mjsim.Command(9.0, turn=0.1))
        for _ in range(60):
            sim.step()
    ahead = np.array([each.forward for each in notes.wanted])
    np.testing.assert_allclose(ahead, np.minimum(0.5 * 0.004 * np.arange(600), 0.8), atol=1e-9)


def test_its_time_counts_in_the_timing(tmp_path):
    import time

    def slow(now):
        time.sleep(0.0002)
        return 0.0, 0.0

    with mjsim.Simulation(world()) as sim:
        driver = mjsim.Driver(controllers={"drive": Notes(slow)})
        recording = mjsim.run(sim, drivers={"joe": driver}, seconds=0.4, record=tmp_path / "run.mcap")
        # Ten calls a tick; the first tick comes before the first call.
        assert (recording.module_seconds["joe/controller/drive"][1:] > 0.002).all()


@pytest.mark.slow
def test_the_world_file_names_it_with_rate_latency_and_arguments(tmp_path):
    driver = (
        'controllers: {drive: {use: "mjsim.algorithms.balance:Lqr", rate_hz: 125, latency: 2, effort: 0.3}},'
        ' navigator: {use: "mjsim.algorithms.constant:ConstantCommand", forward: 0.3}'
    )
    with mjsim.Simulation(world(driver)) as sim:
        drivers = drivers_of(sim.world)
        recording = mjsim.run(sim, drivers=drivers, seconds=4.0, record=tmp_path / "run.mcap")
    loop = drivers["joe"].controllers["drive"]
    assert isinstance(loop, mjsim.ControlLoop)
    assert (loop.rate_hz, loop.latency) == (125, 2)
    assert recording.robots["joe"].truth[-1, 0] == pytest.approx(0.3 * 3.7, abs=0.2)
    assert "Lqr" in recording.metadata["modules"]


def test_the_recording_has_the_wheels_of_the_base_with_their_torques(tmp_path):
    notes = Notes(lambda time: (0.1, 0.05))
    with mjsim.Simulation(world()) as sim:
        driver = mjsim.Driver(navigator=ConstantCommand(forward=0.4), controllers={"drive": notes})
        recording = mjsim.run(sim, drivers={"joe": driver}, seconds=0.4, record=tmp_path / "run.mcap")
    wheels = recording.joints["joe/drive"]
    assert wheels.names == ("wheel_left", "wheel_right")
    np.testing.assert_allclose(wheels.torques[1:], [[0.1, 0.05]] * 9, atol=1e-12)
    at_ticks = [each.wheels for each in notes.sensed[::10]]
    np.testing.assert_allclose(wheels.positions[: len(at_ticks)], [each.positions for each in at_ticks], atol=1e-12)
    # The set-points gather speed by 0.5 m/s^2, a step of the physics at a time.
    np.testing.assert_allclose(wheels.goal[:, 0] * 0.105, 0.5 * recording.time**2 / 2, atol=0.5 * 0.36 * 0.004)


@pytest.mark.slow
def test_the_same_seed_gives_the_same_bytes_and_so_does_a_reset():
    def states(sim: mjsim.Simulation) -> bytes:
        sim.apply("joe", mjsim.Command(0.5, turn=0.4))
        for _ in range(30):
            sim.step()
        return b"".join(part.tobytes() for part in sim.state())

    with mjsim.Simulation(world(), seed=5) as sim, mjsim.Simulation(world(), seed=5) as other:
        first = states(sim)
        assert first == states(other)
        sim.reset()
        assert first == states(sim)
        sim.reset(6)
        assert first != states(sim)


WRONG = [
    ("controllers: {drive: {use: 'a.b:C', rate_hz: 40}}", "rate_hz is 40 Hz; a period must be a whole number of 4 ms"),
    ("controllers: {drive: {use: 'a.b:C', latency: -1}}", "latency is -1; it must be at least 0"),
    ("controllers: {drive: {rate_hz: 250}}", "use"),
    ("controllers: {drvie: {use: 'a.b:C'}}", "no part 'drvie' of robot 'joe' for a controller; did you mean 'drive'?"),
]


@pytest.mark.parametrize(("driver", "says"), WRONG)
def test_what_a_world_says_wrong_is_one_line_with_its_place(driver, says):
    with pytest.raises(WorldError) as caught:
        world(driver)
    (line,) = str(caught.value).splitlines()
    assert line.startswith("world.yaml:9:")
    assert says in line


def test_robots_on_servos_have_no_part_for_a_controller():
    text = "mjsim: 1\nrobots: [{name: a, at: [0, 0]}]\nrun: {drivers: {a: {controllers: {drive: {use: 'a.b:C'}}}}}\n"
    with pytest.raises(WorldError, match="3:35: robot 'a' has no part that a controller drives"):
        mjsim.parse_world(text)
    with (
        mjsim.Simulation(mjsim.parse_world("mjsim: 1\nrobots: [{name: a, at: [0, 0]}]\n")) as sim,
        pytest.raises(UsageError, match="no part 'drive' of robot 'a' for a controller"),
    ):
        sim.control("a", {"drive": Notes()})


@pytest.mark.parametrize(
    ("keys", "says"),
    [
        ({"rate_hz": 40.0}, "rate_hz is 40 Hz; a period of the controller of 'drive' must be a whole number of 4 ms"),
        ({"rate_hz": float("nan")}, "rate_hz of the controller of 'drive' is nan; it must be above 0"),
        ({"latency": -1}, "latency of the controller of 'drive' is -1; it is a number of steps from 0"),
        ({"latency": 0.5}, "latency of the controller of 'drive' is 0.5; it is a number of steps from 0"),
    ],
)
def test_what_python_says_wrong_is_one_line(keys, says):
    with mjsim.Simulation(world()) as sim, pytest.raises(UsageError, match=says):
        sim.control("joe", {"drive": mjsim.ControlLoop(controller=Notes(), **keys)})
