"""A compass: headings known from geometry, statistics of its errors, and every form that its readings take."""

import csv
import json
import math
import re
from dataclasses import replace
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import mjsim
from mjsim.env import GymEnvironment, Task
from mjsim.interface import Numbers, doubles_of, json_line, observation_tree, retimed
from mjsim.record import export_csv, export_npz
from mjsim.ros.messages import bytes_of, message_of
from mjsim.ros.ros_robot import RosRobot, RosTick
from mjsim.sim.sensors.compass import SmoothField
from mjsim.world import parse_world


def room(keys: str = "", *, heading_deg: float = 0.0, at: str = "[0, 0]", rate_hz: float = 25.0) -> mjsim.World:
    return parse_world(
        f"mjsim: 1\nrobots: [{{name: r, at: {at}, heading_deg: {heading_deg},"
        f" sensors: [{{compass: needle{keys}}}]}}]\nrun: {{rate_hz: {rate_hz}, seconds: 0.4}}\n"
    )


def headings(world: mjsim.World, count: int) -> np.ndarray:
    """Return the headings of a robot that stands still, shape (count,) [rad]."""
    found: list[float] = []
    with mjsim.Simulation(world, seed=1) as sim:
        while len(found) < count:
            found += [reading.heading for reading in sim.sense("r").compasses.values()]
            sim.step()
    return np.array(found)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Return a recording of a robot with a noisy compass, and the readings that its modules got."""
    world = room(
        ", rate_hz: 12.5, noise: {heading_deg: 2}, bias: {amplitude_deg: 5}, declination_deg: 3", heading_deg=40
    )
    given = []

    class Rests:
        def start(self, robot, map, rng):
            pass

        def command(self, seen, belief):
            given.append(seen)
            return mjsim.Command(turn=0.5)

    path = tmp_path_factory.mktemp("compass") / "run.mcap"
    recording = mjsim.run(world, drivers={"r": mjsim.Driver(navigator=Rests())}, seed=3, record=path)
    return recording, given


def told_of(seen) -> list:
    return [(reading.stamp, reading.heading, reading.variance) for each in seen for reading in each.compasses.values()]


@pytest.mark.parametrize(
    ("keys", "heading_deg", "expected_deg"),
    [("", 30, 30), (", declination_deg: 10", 30, 40), (", declination_deg: 10", 175, -175)],
)
def test_a_perfect_compass_reads_the_heading_from_magnetic_east(keys, heading_deg, expected_deg):
    (heading,) = headings(room(keys, heading_deg=heading_deg), 1)
    assert heading == pytest.approx(math.radians(expected_deg), abs=1e-4)  # the robot settles on its wheels


def test_its_noise_has_the_deviation_of_the_world_file_and_the_data_sheet():
    world = room(", rate_hz: 250, noise: {heading_deg: 2}", rate_hz=250)
    measured = np.degrees(headings(world, 400))
    assert np.std(measured) == pytest.approx(2.0, rel=4 / math.sqrt(2 * 400))
    assert abs(measured.mean()) < 4 * 2.0 / math.sqrt(400)
    with mjsim.Simulation(world, seed=1) as sim:
        assert sim.sense("r").compasses["needle"].variance == pytest.approx(math.radians(2) ** 2)
        assert sim.robots["r"].sensors["needle"].noise["heading"] == pytest.approx(math.radians(2))


def test_the_field_of_its_bias_has_unit_variance_and_the_declared_correlation():
    apart, places = np.array([0.0, 0.7, 1.5, 6.0]), np.random.default_rng(0).uniform(-500, 500, (50, 1, 2))
    fields = [SmoothField(seed, 1.5) for seed in range(200)]
    values = np.concatenate([each.at(places + np.stack([apart, 0 * apart], axis=-1)) for each in fields])
    correlation = (values[:, :1] * values).mean(axis=0)
    expected = np.exp(-(apart**2) / (2 * 1.5**2))
    np.testing.assert_allclose(correlation, expected, atol=4 * math.sqrt(2 / len(values)))


def test_its_bias_depends_on_the_place_and_on_the_seed_of_the_field_alone():
    bias = ", bias: {amplitude_deg: 5, length: 2, seed: %d}"
    at = {
        (seed, place): headings(room(bias % seed, at=place), 1)[0] for seed in (0, 1) for place in ("[0, 0]", "[4, 1]")
    }
    expected = math.radians(5) * SmoothField(1, 2.0).at(np.array([4.0, 1.0]))
    assert at[1, "[4, 1]"] == pytest.approx(expected, abs=2e-4)
    assert len({round(float(each), 4) for each in at.values()}) == 4


def test_latency_delays_a_reading_and_keeps_its_stamp():
    with mjsim.Simulation(room(", rate_hz: 25, latency: 2")) as sim:
        stamps = []
        for _ in range(4):
            stamps += [(sim.time, each.stamp) for each in sim.sense("r").compasses.values()]
            sim.step()
    np.testing.assert_allclose(stamps, [(0.08, 0.0), (0.12, 0.04)])


def test_recordings_and_replay_give_every_reading_exactly(run, tmp_path):
    recording, given = run
    assert len(told_of(given)) == 5
    assert told_of(recording.observations("r")) == told_of(given)
    replayed: list = []

    class Listens:
        def start(self, robot, catalogue, rng):
            pass

        def update(self, seen):
            replayed.append(seen)
            return mjsim.Estimate(mjsim.Pose(0, 0, 0), np.eye(3))

    mjsim.replay(recording.path, robot="r", estimator=Listens(), record=tmp_path / "again.mcap")
    assert told_of(replayed) == told_of(given)


def test_programs_and_octave_get_its_readings(run):
    _, given = run
    tree = observation_tree(given[0], Numbers(), pictures=False)
    reading = given[0].compasses["needle"]
    line = json.loads(json_line(tree))["compasses"]["needle"]
    assert line == {"stamp": reading.stamp, "heading": reading.heading, "variance": reading.variance}
    doubles = doubles_of(tree)
    assert "'compasses',struct('needle',struct('stamp',d(" in doubles.code
    assert {reading.heading, reading.variance} <= set(doubles.fixed)


def test_a_program_gets_its_readings_as_the_schema_of_programs_says(run):
    _, given = run
    schema = json.loads((Path(mjsim.__file__).parents[1] / "docs" / "programs.schema.json").read_text())
    line = json.loads(json_line(observation_tree(given[0], Numbers(), pictures=False)))
    assert line["compasses"]
    jsonschema.validate(line, {"$ref": "#/$defs/obs", "$defs": schema["$defs"]})


def test_ros_gets_an_inertial_message_with_the_heading_alone(run):
    _, given = run
    world = room(", rate_hz: 12.5")
    with mjsim.Simulation(world) as sim:
        robot = RosRobot(world.robots[0], sim.robots["r"], namespace="/r", prefix="")
    sent = {
        each.topic.name: each
        for each in robot.messages(RosTick(time=0.0, truth=None, seen=given[0], odometry=mjsim.Pose(0, 0, 0)))
    }
    outgoing, reading = sent["/r/heading"], given[0].compasses["needle"]
    message = message_of(bytes_of(outgoing.message), "sensor_msgs/msg/Imu")
    turned = message.orientation
    rotation = Rotation.from_quat([turned.x, turned.y, turned.z, turned.w])
    np.testing.assert_allclose(rotation.as_euler("xyz"), [0.0, 0.0, reading.heading], atol=1e-12)
    assert message.orientation_covariance[8] == reading.variance
    assert message.orientation_covariance[0] > 3.0  # roll and pitch may be anything
    assert (message.angular_velocity_covariance[0], message.linear_acceleration_covariance[0]) == (-1.0, -1.0)


def test_a_log_of_own_observations_keeps_its_stamps(run, tmp_path):
    _, given = run
    late = [retimed(replace(seen, time=seen.time + 1e6), lambda time: time + 1e6) for seen in given]
    logged = mjsim.write_log(tmp_path / "log.mcap", late)
    np.testing.assert_allclose(told_of(logged.observations("robot")), told_of(given), atol=1e-9)


def test_environments_have_its_heading_within_bounds():
    env = GymEnvironment(Task(world=room(heading_deg=40), seconds=0.4))
    seen, _ = env.reset(seed=1)
    space = env.observation_space["needle"]
    assert (space.shape, float(space.low[0]), float(space.high[0])) == ((1,), *map(pytest.approx, (-math.pi, math.pi)))
    assert seen["needle"][0] == pytest.approx(math.radians(40), abs=1e-4)
    env.close()


def test_tables_and_arrays_have_its_columns(run, tmp_path):
    recording, given = run
    export_csv(recording, tmp_path)
    with (tmp_path / "r_compass_needle.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["time", "stamp", "heading", "variance"]
    assert [(float(row["stamp"]), float(row["heading"]), float(row["variance"])) for row in rows] == told_of(given)
    export_npz(recording, tmp_path / "run.npz")
    with np.load(tmp_path / "run.npz") as arrays:
        assert arrays["r/compass_needle/heading"].tolist() == [heading for _, heading, _ in told_of(given)]


def test_the_estimator_of_the_page_keeps_the_heading_that_dead_reckoning_loses():
    page = (Path(mjsim.__file__).parents[1] / "docs" / "sensors.md").read_text(encoding="utf-8")
    names: dict = {}
    exec(re.findall(r"```python\n(.*?)```", page.partition("## Compass")[2], re.DOTALL)[0], names)
    errors = {}
    for compass in ("", "{compass: c, noise: {heading_deg: 2}, declination_deg: 5}"):
        world = parse_world(
            f"mjsim: 1\nrobots: [{{name: r, at: [0, 0], odometry: {{noise: {{turn: 0.1}}}}, sensors: [{compass}]}}]"
        )
        with mjsim.Simulation(world, seed=4) as sim:
            estimator = names["CompassHeading"](declination_deg=5)
            estimator.start(sim.robots["r"], {}, np.random.default_rng(0))
            differences = []
            for _ in range(250):
                belief = estimator.update(sim.sense("r"))
                differences.append(math.remainder(belief.pose.heading - sim.truth("r").heading, math.tau))
                sim.apply("r", mjsim.Command(forward=0.4, turn=0.6))
                sim.step()
        errors[bool(compass)] = math.degrees(np.sqrt(np.mean(np.square(differences))))
    assert errors[True] < 2.0
    assert errors[True] < 0.5 * errors[False]


OCTAVE = """function [est, state] = facing(obs, robot, state)
  est.pose = [0; 0; obs.compasses.needle.heading];
  est.covariance = eye(3);
end
"""
PROGRAM = """#!/usr/bin/env python3
import json, sys
for line in sys.stdin:
    asked = json.loads(line)
    heading = asked["obs"]["compasses"]["needle"]["heading"] if "obs" in asked else 0.0
    print(json.dumps({"pose": [0, 0, heading], "covariance": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}), flush=True)
"""


@pytest.mark.slow
@pytest.mark.parametrize(("file", "text", "use"), [("facing.m", OCTAVE, "facing.m"), ("f.py", PROGRAM, "exec:./f.py")])
def test_an_estimator_in_another_language_reads_the_heading(file, text, use, tmp_path):
    (tmp_path / file).write_text(text)
    (tmp_path / file).chmod(0o755)
    world = tmp_path / "world.yaml"
    world.write_text(
        "mjsim: 1\nrobots: [{name: r, at: [0, 0], heading_deg: 40, sensors: [{compass: needle, rate_hz: 25}]}]\n"
        f'run: {{seconds: 0.2, drivers: {{r: {{estimator: {{use: "{use}"}}}}}}}}\n'
    )
    recording = mjsim.run(mjsim.load_world(world), record=tmp_path / "run.mcap")
    estimated = recording.robots["r"].estimate[:, 2]
    np.testing.assert_allclose(estimated, [heading for _, heading, _ in told_of(recording.observations("r"))])
    assert estimated[0] == pytest.approx(math.radians(40), abs=1e-4)
