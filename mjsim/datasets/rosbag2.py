"""Exports a recording as a ROS 2 bag, with the topics and frames of `mjsim bridge`, and the map of the world."""

import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal

import numpy as np

from mjsim.datasets.dataset_folder import new_folders
from mjsim.datasets.recorded_robots import RecordedRobots, RecordedTick, planar_pose
from mjsim.errors import UsageError
from mjsim.interface import JointState
from mjsim.record import Recording
from mjsim.ros import MAP, Outgoing, Qos, RosTick, RosTopic, RosWorld, bytes_of, grid_map, nanoseconds, typestore
from mjsim.world import grid_of, read_value

Storage = Literal["mcap", "sqlite3"]
METADATA = "metadata.yaml"
"""Name of the metadata file, which lists the other files of a bag."""
VERSION: Literal[8] = 8
"""Version of the metadata, readable by ROS 2 Humble and later."""


def export_rosbag2(
    recording: Recording,
    folder: str | Path,
    *,
    storage: Storage = "mcap",
    redraw: bool = False,
    overwrite: bool = False,
) -> Path:
    """Write a ROS 2 bag: odometry, estimate, readings with a standard message, frames, clock, map and ground truth.

    The bag time of a message is when modules received it; the stamp in its header is when it was measured.

    Args:
        recording: A run.
        folder: The bag.
        storage: 'mcap' or 'sqlite3'.
        redraw: Whether to render pictures and depth again from the recorded states and store them raw; otherwise both
            are as recorded, pictures compressed.
        overwrite: Whether an existing bag may be replaced.

    Returns:
        The folder.

    Raises:
        UsageError: The bag exists or cannot be written; it would replace the recording itself; two names become equal
            in ROS; or rosbags is not installed.
    """
    if storage not in ("mcap", "sqlite3"):
        raise UsageError(f"storage is '{storage}'; it must be mcap or sqlite3")
    typestore()  # before the world is compiled, so that a missing package is reported immediately
    with (
        new_folders([Path(folder)], files=_files_of(Path(folder), recording), overwrite=overwrite) as (part,),
        RecordedRobots(recording, redraw=redraw) as recorded,
    ):
        _write(recorded, part, storage, redraw=redraw)
    return Path(folder)


def _files_of(folder: Path, recording: Recording) -> str:
    """Return a regular expression for the files that a bag in a folder replaces.

    These are the files of the new bag, and those listed in the metadata of an older one: the folder may contain other
    recordings.

    Raises:
        UsageError: The recording itself is one of them.
    """
    name = Path(os.path.abspath(folder)).name
    names = [METADATA, f"{name}.mcap", f"{name}.db3", *_listed(folder / METADATA)]
    if any((folder / each).exists() and (folder / each).samefile(recording.path) for each in names):
        raise UsageError(f"'{folder}' would replace the recording itself; name another folder")
    return "|".join(map(re.escape, names))


def _listed(metadata: Path) -> list[str]:
    """Return the files listed in the metadata of a bag; none if it is invalid."""
    try:
        content = read_value(metadata.read_text(encoding="utf-8"))
        return [str(each) for each in content["rosbag2_bagfile_information"]["relative_file_paths"]]
    except (OSError, ValueError, KeyError, TypeError):
        return []


def _write(recorded: RecordedRobots, folder: Path, storage: Storage, *, redraw: bool) -> None:
    from rosbags.rosbag2 import StoragePlugin, Writer

    world, is_log = recorded.recording.world, "log" in recorded.recording.metadata
    ros = RosWorld(world, recorded.infos)
    with Writer(folder, version=VERSION, storage_plugin=StoragePlugin[storage.upper()]) as writer:
        for key, value in {**recorded.recording.metadata, "seed": str(recorded.recording.seed)}.items():
            writer.set_custom_data(f"mjsim {key}", value)
        bag = _Bag(writer)
        bag.put(ros.fixed(), 0.0)
        if (known := _map(recorded)) is not None:
            bag.put(known, 0.0)
        for row, (time, ticks, pictures) in enumerate(_ticks(recorded)):
            for each in ros.messages(time, ticks, _joints(recorded.recording, row, time)):
                # A log has no proximity sensors: messages of free space would clear a costmap.
                if not (is_log and each.topic.name.endswith("/proximity") and each.message.range == np.inf):
                    bag.put(each, time)
            for robot, camera, stamp in pictures:
                named = ros.robots[robot]
                if redraw:
                    found = named.pictures(camera, recorded.frame(robot, camera, stamp))
                else:
                    data, suffix = recorded.picture(robot, camera, stamp)
                    form = "jpeg" if suffix == "jpg" else suffix
                    found = named.compressed(camera, stamp, data, form, depth=recorded.depth(robot, camera, stamp))
                for each in found:
                    bag.put(each, time)


def _joints(recording: Recording, row: int, time: float) -> dict[str, tuple[tuple[str, ...], JointState]]:
    """Return names and states of the joints of each arm and mechanism at a tick; none where they were not recorded."""
    return {
        name: (track.names, JointState(time, track.positions[row], track.velocities[row], track.torques[row]))
        for name, track in recording.joints.items()
        if np.isfinite(track.positions[row]).all()
    }


def _map(recorded: RecordedRobots) -> Outgoing | None:
    """Return the map of the world; None if nothing is solid."""
    try:
        grid = grid_of(recorded.recording.world)
    except UsageError:
        return None
    message = grid_map(grid.occupied, grid.free, resolution=grid.resolution, map_from_grid=grid.world_from_grid)
    return Outgoing(MAP, message)


def _ticks(recorded: RecordedRobots) -> Iterator[tuple[float, dict[str, RosTick], list[tuple[str, str, float]]]]:
    """Yield for each tick its time [s], the robots, and (robot, camera, stamp) of each picture."""
    ticks_of = {robot: recorded.ticks(robot) for robot in recorded.recording.robots}
    estimated = {robot for robot in ticks_of if recorded.recording.has_estimator(robot)}
    for time in recorded.recording.time.tolist():
        now = {robot: next(each) for robot, each in ticks_of.items()}
        ticks = {robot: _robot_tick(recorded, robot, tick, robot in estimated) for robot, tick in now.items()}
        pictures = [(robot, camera, stamp) for robot, tick in now.items() for camera, stamp in tick.stamps.items()]
        yield time, ticks, pictures


def _robot_tick(recorded: RecordedRobots, robot: str, tick: RecordedTick, estimated: bool) -> RosTick:
    track, row = recorded.recording.robots[robot], tick.row
    return RosTick(
        time=tick.moment,
        truth=tick.truth,
        seen=tick.seen,
        odometry=planar_pose(track.odometry[row]),
        odometry_covariance=track.odometry_covariance[row],
        estimate=planar_pose(track.estimate[row]) if estimated else None,
        estimate_covariance=track.covariance[row],
    )


class _Bag:
    """A bag being written; a topic is added with its first message."""

    def __init__(self, writer: Any) -> None:
        self._writer, self._connections = writer, dict[RosTopic, Any]()

    def put(self, each: Outgoing, time: float) -> None:
        """Add a message received at a time [s]."""
        topic, message = each
        if topic not in self._connections:
            self._connections[topic] = self._writer.add_connection(
                topic.name, topic.type, typestore=typestore(), offered_qos_profiles=[_profile(topic.qos)]
            )
        self._writer.write(self._connections[topic], nanoseconds(time), bytes_of(message))


def _profile(qos: Qos) -> Any:
    """Return a quality of service in the format of bags."""
    from rosbags import interfaces

    without_end = interfaces.QosTime(0, 0)
    return interfaces.Qos(
        history=interfaces.QosHistory.KEEP_LAST,
        depth=qos.depth,
        reliability=interfaces.QosReliability.RELIABLE if qos.reliable else interfaces.QosReliability.BEST_EFFORT,
        durability=interfaces.QosDurability.TRANSIENT_LOCAL
        if qos.transient_local
        else interfaces.QosDurability.VOLATILE,
        deadline=without_end,
        lifespan=without_end,
        liveliness=interfaces.QosLiveliness.AUTOMATIC,
        liveliness_lease_duration=without_end,
        avoid_ros_namespace_conventions=False,
    )
