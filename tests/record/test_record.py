from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from mcap.reader import make_reader

from mjsim.errors import UsageError
from mjsim.interface import Command
from mjsim.record import Recorder, Recording, RobotEvent, Tick, numeric_topics, read_recording, same_run
from mjsim.record.schemas import ROBOT_TOPICS
from mjsim.world import Robot, Wall, World, load_world
from tests.record_ticks import DT, ROBOTS, TEXT, hand_made_ticks, hand_made_world, infos, record

TICKS = 60


@pytest.fixture(scope="module")
def ticks() -> list[Tick]:
    return list(hand_made_ticks(TICKS))


@pytest.fixture(scope="module")
def recording(ticks: list[Tick], tmp_path_factory: pytest.TempPathFactory) -> Recording:
    return read_recording(record(tmp_path_factory.mktemp("record") / "run.mcap", ticks, command="mjsim run"))


def test_poses_states_and_covariances_read_back_bit_for_bit(recording: Recording, ticks: list[Tick]):
    assert recording.whole
    assert recording.time.tolist() == [tick.time for tick in ticks]
    assert recording.qpos.tobytes() == np.array([tick.qpos for tick in ticks]).tobytes()
    assert recording.qvel.tobytes() == np.array([tick.qvel for tick in ticks]).tobytes()
    for name in ROBOTS:
        track, orders = recording.robots[name], [tick.orders[name] for tick in ticks]
        written = {
            "truth": [tick.truth[name].as_array() for tick in ticks],
            "odometry": [order.dead_reckoning.as_array() for order in orders],
            "odometry_covariance": [order.dead_reckoning_covariance for order in orders],
            "estimate": [order.estimate.pose.as_array() for order in orders],
            "covariance": [order.estimate.covariance for order in orders],
        }
        for key, rows in written.items():
            assert getattr(track, key).tobytes() == np.array(rows).tobytes(), key


def test_a_command_reads_back_and_wheel_speeds_are_rows_of_nan(recording: Recording, ticks: list[Tick]):
    for k, row in enumerate(recording.robots["scout"].command):
        command = ticks[k].orders["scout"].command
        if isinstance(command, Command):
            assert row.tolist() == [command.forward, command.left, command.turn]
        else:
            assert np.isnan(row).all()


def test_the_map_reads_back_with_its_names_and_rests_between_changes(recording: Recording, ticks: list[Tick]):
    landmarks = recording.robots["scout"].landmarks
    assert landmarks.names == ("lion", 7, "7", "Infinity", 100, 101, 102)
    for k, tick in enumerate(ticks):
        written = tick.orders["scout"].estimate.landmarks
        for j, name in enumerate(landmarks.names):
            if name in written:
                assert landmarks.mean[k, j].tobytes() == written[name][0].tobytes()
                assert landmarks.covariance[k, j].tobytes() == written[name][1].tobytes()
            else:
                assert np.isnan(landmarks.mean[k, j]).all()
    assert sum(1 for _ in recording.messages("/scout/landmarks")) == TICKS // 2
    assert recording.robots[ROBOTS[1]].landmarks.names == ()


def test_sightings_innovations_and_events_read_back(recording: Recording, ticks: list[Tick]):
    track = recording.robots["scout"]
    for k, tick in enumerate(ticks):
        order = tick.orders["scout"]
        assert len(track.sightings[k]) == len(order.sightings)
        for read, sighting in zip(track.sightings[k], order.sightings, strict=True):
            same_sighting(read, sighting)
        assert len(track.innovations[k]) == len(order.estimate.innovations)
        for read, innovation in zip(track.innovations[k], order.estimate.innovations, strict=True):
            assert read[0] == innovation[0]
            np.testing.assert_array_equal(read[1], innovation[1])
            np.testing.assert_array_equal(read[2], innovation[2])
    assert track.events == (RobotEvent(4 * DT, "bump", "touched the wall", 0.1),)


def same_sighting(read, sighting):
    assert (read.stamp, read.name, read.range, read.bearing) == (
        sighting.stamp,
        sighting.name,
        sighting.range,
        sighting.bearing,
    )
    np.testing.assert_array_equal(read.covariance, sighting.covariance)
    if sighting.corners is None:
        assert read.corners is None
    else:
        np.testing.assert_array_equal(read.corners, sighting.corners)


def test_an_observation_holds_every_number_that_the_modules_were_given(recording: Recording, ticks: list[Tick]):
    read = list(recording.observations("scout"))
    assert len(read) == TICKS
    for tick, observation in zip(ticks, read, strict=True):
        seen = tick.seen["scout"]
        assert (observation.time, observation.dt, observation.bump) == (seen.time, seen.dt, seen.bump)
        assert np.isinf(seen.proximity).any()
        np.testing.assert_array_equal(observation.proximity, seen.proximity)
        assert (observation.odometry.forward, observation.odometry.turn) == (seen.odometry.forward, seen.odometry.turn)
        np.testing.assert_array_equal(observation.odometry.covariance, seen.odometry.covariance)
        for a, b in zip(observation.sightings, seen.sightings, strict=True):
            same_sighting(a, b)


def test_the_joint_covariance_reads_back(recording: Recording, ticks: list[Tick]):
    read = list(recording.joint_covariances("scout"))
    assert len(read) == TICKS
    for tick, (now, names, P) in zip(ticks, read, strict=True):
        estimate = tick.orders["scout"].estimate
        assert (now, names) == (tick.time, tuple(estimate.landmarks))
        # Only the lower triangle is kept; the numbers here are symmetric to the last bit or nearly so.
        np.testing.assert_array_equal(np.tril(P), np.tril(estimate.joint_covariance))
        np.testing.assert_array_equal(P, P.T)


def test_pictures_come_back_with_their_stamps_and_nearly_their_pixels(recording: Recording, ticks: list[Tick]):
    frames = [tick.seen["scout"].cameras["front"] for tick in ticks if tick.seen["scout"].cameras]
    images = list(recording.images("scout", "front"))
    assert [stamp for stamp, _ in images] == [frame.stamp for frame in frames]
    for (_, image), frame in zip(images, frames, strict=True):
        assert image.shape == frame.image.shape
        # JPEG at quality 90; swapped colours would differ by more than 20 on average.
        assert np.abs(image.astype(int) - frame.image).mean() < 5


def test_a_recording_needs_no_file_but_itself(recording: Recording):
    assert recording.world == hand_made_world()
    assert recording.world.source.text == TEXT
    assert recording.seed == 5
    assert recording.metadata["command"] == "mjsim run"
    assert recording.metadata["mjsim version"]


def test_the_pictures_that_a_world_names_come_with_it(tmp_path: Path):
    picture = cv2.imencode(".png", np.zeros((4, 4, 3), np.uint8))[1].tobytes()
    (tmp_path / "tile.png").write_bytes(picture)
    world_file = tmp_path / "room.yaml"
    world_file.write_text(TEXT + "floor: {texture: tile.png}\n")
    world = load_world(world_file)
    path = tmp_path / "run.mcap"
    with Recorder(path, world=world, seed=1, robots=infos(), metadata={}) as recorder:
        recorder.write(next(hand_made_ticks(1)))
    (tmp_path / "tile.png").unlink()
    assert read_recording(path).world.read_asset("tile.png") == picture


def test_a_world_that_was_changed_after_reading_is_recorded_as_it_is(tmp_path: Path, ticks: list[Tick]):
    world = hand_made_world()
    changed = world.model_copy(update={"name": "changed"})
    with Recorder(tmp_path / "run.mcap", world=changed, seed=1, robots=infos(), metadata={}) as recorder:
        recorder.write(ticks[0])
    assert read_recording(tmp_path / "run.mcap").world == changed


def test_a_world_built_in_python_comes_with_its_recording(tmp_path: Path, ticks: list[Tick]):
    robots = tuple(Robot(name=name, at=(1.0, 1.0)) for name in ROBOTS)
    world = World(walls=(Wall(points=((0.0, 0.0), (3.0, 0.0)), thickness=0.2),), robots=robots)
    with Recorder(tmp_path / "run.mcap", world=world, seed=1, robots=infos(), metadata={}) as recorder:
        recorder.write(ticks[0])
    assert read_recording(tmp_path / "run.mcap").world == world


@pytest.mark.slow
def test_two_equal_runs_have_the_same_bytes_in_every_numeric_topic(tmp_path: Path, recording: Recording):
    again = record(tmp_path / "again.mcap", hand_made_ticks(TICKS), command="another one")
    topics = numeric_topics(again)
    assert topics == numeric_topics(recording.path)
    assert same_run(again, recording.path)
    assert "/timing" not in topics
    assert {f"/{robot}/observation" for robot in ROBOTS} | {"/state", "/tf", "/map"} <= set(topics)
    other = record(tmp_path / "other.mcap", hand_made_ticks(TICKS, seed=1))
    assert not same_run(other, recording.path)


def test_log_time_is_simulated_time_and_foxglove_knows_the_schemas(recording: Recording):
    with recording.path.open("rb") as stream:
        reader = make_reader(stream)
        found = {}
        for schema, channel, message in reader.iter_messages():
            assert message.log_time == message.publish_time
            assert 0 <= message.log_time <= round((TICKS - 1) * DT * 1e9)
            found[channel.topic] = (channel.message_encoding, schema.encoding, schema.name)
    proto, text = ("protobuf", "protobuf"), ("json", "jsonschema")
    assert found["/tf"] == (*proto, "foxglove.FrameTransforms")
    assert found["/map"] == (*proto, "foxglove.SceneUpdate")
    assert found["/scout/front/image"] == (*proto, "foxglove.CompressedImage")
    assert found["/scout/front/calibration"] == (*proto, "foxglove.CameraCalibration")
    for robot in ROBOTS:
        for kind in ("truth", "odometry", "estimate"):
            assert found[f"/{robot}/{kind}"] == (*text, "foxglove.PoseInFrame")
    assert found["/scout/landmarks"] == (*text, "foxglove.PosesInFrame")
    assert found["/scout/events"] == (*text, "foxglove.Log")
    told = set(ROBOT_TOPICS) - {"path"}  # Only estimators that have a final path tell one.
    assert {f"/scout/{kind}" for kind in told} | {"/state", "/timing"} <= set(found)


def test_a_robot_without_a_driver_has_its_truth_alone(tmp_path: Path, ticks: list[Tick]):
    lonely = [replace(tick, seen={}, orders={"scout": tick.orders["scout"]}) for tick in ticks[:5]]
    track = read_recording(record(tmp_path / "run.mcap", lonely)).robots[ROBOTS[1]]
    assert np.isfinite(track.truth).all()
    assert np.isnan(track.estimate).all()
    assert track.sightings == ((),) * 5


def test_what_a_module_changes_afterwards_does_not_change_the_recording(tmp_path: Path):
    tick = next(hand_made_ticks(1))
    covariance = tick.orders["scout"].estimate.covariance
    written = covariance.copy()
    with Recorder(tmp_path / "run.mcap", world=hand_made_world(), seed=1, robots=infos(), metadata={}) as recorder:
        recorder.write(tick)
        covariance[:] = 0.0
    np.testing.assert_array_equal(read_recording(tmp_path / "run.mcap").robots["scout"].covariance[0], written)


def test_an_unknown_camera_is_refused_with_those_there_are(recording: Recording):
    with pytest.raises(UsageError, match=r"no camera 'scout/frnt' .*did you mean 'scout/front'"):
        next(recording.images("scout", "frnt"))


def test_observations_of_an_unknown_robot_are_refused_with_those_there_are(recording: Recording):
    with pytest.raises(UsageError, match=r"no robot 'scot' in .*did you mean 'scout'"):
        next(recording.observations("scot"))
