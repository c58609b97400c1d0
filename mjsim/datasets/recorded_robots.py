"""Reads a recording tick by tick: observations and estimates of each robot, and pictures, recorded or rendered."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from mjsim.closing import Closes
from mjsim.errors import UsageError
from mjsim.geometry import Array, Pose, Pose3
from mjsim.interface import CameraFrame, Observation, RobotInfo
from mjsim.record import LoggedPictures, Recording, Track, depth_values, logged_cameras, with_logged_cameras
from mjsim.ros import nanoseconds, robot_from_sensor
from mjsim.sim import Retake, Simulation
from mjsim.world import Camera, name_of

SAME_TIME = 1e-6
"""Times that differ by less are equal [s]."""


Depth = tuple[float, NDArray[Any]]
"""Stamp [s] and pixels of depth."""


class PictureFile(NamedTuple):
    """A picture as stored in a file."""

    data: bytes
    suffix: str
    """'jpg' or 'png'."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RecordedTick:
    """One robot at one tick."""

    row: int
    """Row of the recording."""
    moment: float
    """Time of the robot's pose: in a log, that of the scan or picture that came with the tick [s]."""
    truth: Pose3 | None
    """world_from_base; None if unknown."""
    seen: Observation | None
    """Without pictures; None for a robot without a driver."""
    stamps: Mapping[str, float]
    """Camera -> stamp of its picture at this tick [s]."""


class RecordedRobots(Closes):
    """The robots of a recording; pictures must be requested in the order of the ticks."""

    def __init__(self, recording: Recording, *, redraw: bool) -> None:
        """Open the recording.

        Args:
            recording: The recording.
            redraw: Whether to render pictures again from the recorded states, without loss; otherwise as recorded.
                Those of a log are always as recorded.
        """
        self.recording, self._redraw = recording, redraw
        with Simulation(recording.world, seed=recording.seed) as sim:
            self._logged = logged_cameras(recording)
            self.infos: Mapping[str, RobotInfo] = with_logged_cameras(sim.robots, self._logged)
        self._takes: dict[str, Callable[[str, float], CameraFrame]] = {}
        self._retakes: dict[str, Retake] = {}
        self._recorded: dict[tuple[str, str], Iterator[tuple[float, bytes, str]]] = {}
        self._coming: dict[tuple[str, str], tuple[Iterator[Depth], Depth | None]] = {}
        self._depths = {
            (robot.name, sensor.camera)
            for robot in recording.world.robots
            for sensor in robot.sensors
            if isinstance(sensor, Camera) and sensor.depth
        }
        self._undo = ExitStack()

    def close(self) -> None:
        """Release the renderer; a second call does nothing."""
        self._undo.close()

    def on_arms(self, robot: str) -> set[str]:
        """Return the sensors mounted on a robot's arms."""
        owner = next(each for each in self.recording.world.robots if each.name == robot)
        return {name_of(sensor) for sensor in owner.sensors if getattr(sensor, "on", None) is not None}

    def has_depth(self, robot: str, camera: str) -> bool:
        """Return whether a camera has depth."""
        if (robot, camera) in self._logged:
            return next(self.recording.messages(f"/{robot}/{camera}/depth"), None) is not None
        return (robot, camera) in self._depths

    def world_from_sensor(self, robot: str, sensor: str, tick: RecordedTick) -> Pose3 | None:
        """Return world_from_sensor, for a camera that of its optical frame; None if unknown."""
        if tick.truth is None:
            return None
        joints = {} if tick.seen is None else tick.seen.joints
        owner = next(each for each in self.recording.world.robots if each.name == robot)
        model = next(each for each in owner.sensors if name_of(each) == sensor)
        mounted = robot_from_sensor(owner, self.infos[robot].sensors[sensor], model, joints)
        return Pose3.from_matrix(tick.truth.matrix() @ mounted)

    def ticks(self, robot: str) -> Iterator[RecordedTick]:
        """Yield the ticks of a robot."""
        track = self.recording.robots[robot]
        observed = self.recording.observed(robot)
        upcoming = next(observed, None)
        logged = LoggedPictures(self.recording, robot)
        for row, (time, moment) in enumerate(zip(track.time.tolist(), track.moments.tolist(), strict=True)):
            seen, stamps = None, dict[str, float]()
            self._takes[robot] = logged.at(nanoseconds(time))
            while upcoming is not None and upcoming[0].time < time + SAME_TIME:
                seen, stamps = upcoming
                upcoming = next(observed, None)
            truth = true_pose(track, row)
            yield RecordedTick(row=row, moment=moment, truth=truth, seen=seen, stamps=stamps)

    def truths(self, robot: str, stamps: Sequence[float]) -> dict[float, Pose3]:
        """Return the known true poses of a robot by time [s], ascending: at each tick, and interpolated at more times.

        Args:
            robot: Its name.
            stamps: The other times, such as those of pictures between ticks [s].
        """
        track = self.recording.robots[robot]
        more = [each for each in stamps if np.abs(track.moments - each).min() > SAME_TIME]
        times = np.unique([*track.moments.tolist(), *more])
        poses = zip(times.tolist(), map(pose_in_space, track.truth_at(times)), strict=True)
        return {time: pose for time, pose in poses if pose is not None}

    def picture(self, robot: str, camera: str, stamp: float) -> PictureFile:
        """Return a picture as recorded, or rendered again as PNG.

        Raises:
            UsageError: It was not recorded.
        """
        if self._redraw and (robot, camera) not in self._logged:
            return PictureFile(png_of(self.frame(robot, camera, stamp).image[..., ::-1]), "png")
        recorded = self._recorded.setdefault((robot, camera), self.recording.pictures(robot, camera))
        for taken, data, form in recorded:
            if taken > stamp - SAME_TIME:
                return PictureFile(data, "jpg" if form == "jpeg" else form)
        raise UsageError(
            f"'{self.recording.path}' holds no picture of '{robot}/{camera}' at {stamp:g} s; render them again:"
            " --redraw (in Python: redraw=True)"
        )

    def depth(self, robot: str, camera: str, stamp: float) -> Depth | None:
        """Return the recorded depth of a picture, as in `Recording.depths`; None without depth."""
        if (robot, camera) in self._logged:
            frame = self.frame(robot, camera, stamp)
            return None if frame.depth is None else (depth_time(frame), depth_values(frame))
        if (robot, camera) not in self._coming:
            depths = self.recording.depths(robot, camera)
            self._coming[robot, camera] = depths, next(depths, None)
        depths, found = self._coming[robot, camera]
        while found is not None and found[0] < stamp - SAME_TIME:
            found = next(depths, None)
        self._coming[robot, camera] = depths, found
        return None if found is None or found[0] > stamp + SAME_TIME else found

    def frame(self, robot: str, camera: str, stamp: float) -> CameraFrame:
        """Return the frame of a camera at the current tick: rendered again from the recorded states, or from a log."""
        if (robot, camera) in self._logged:
            return self._takes[robot](camera, stamp)
        if robot not in self._retakes:
            run = self.recording
            again = Retake(
                run.world, robot, seed=run.seed, times=run.time, qpos=run.qpos, qvel=run.qvel, looks=run.looks
            )
            self._retakes[robot] = self._undo.enter_context(again)
        return self._retakes[robot].frame(camera, stamp)


def depth_time(frame: CameraFrame) -> float:
    """Return when the depth of a picture was taken [s]."""
    return frame.stamp if frame.depth_stamp is None else frame.depth_stamp


def true_pose(track: Track, row: int) -> Pose3 | None:
    """Return world_from_base of a robot at a row of its track; None if unknown."""
    return pose_in_space(track.truth_pose[row])


def pose_in_space(row: Array) -> Pose3 | None:
    """Return a pose of (x, y, z, qx, qy, qz, qw), shape (7,); None for NaN."""
    return Pose3(*row.tolist()) if np.isfinite(row).all() else None


def planar_pose(row: Array) -> Pose | None:
    """Return a pose of (x, y, heading), shape (3,); None for NaN."""
    return Pose(*row.tolist()) if np.isfinite(row).all() else None


def png_of(picture: "np.ndarray[tuple[int, ...], np.dtype[np.generic]]") -> bytes:
    """Return a picture as PNG: BGR uint8, shape (height, width, 3), or one channel of uint8 or uint16."""
    return cv2.imencode(".png", np.ascontiguousarray(picture))[1].tobytes()
