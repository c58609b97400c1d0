"""One robot in ROS 2: its topics, and the messages of each tick.

Topics of robot R are `/R/odom`, `/R/truth`, `/R/estimate`, `/R/proximity`, `/R/joint_states`, and those of its sensors:
`/R/scan`, `/R/points`, `/R/imu`, `/R/CAMERA/image_raw`, `/R/CAMERA/camera_info`, `/R/CAMERA/depth/image_raw`. The first
lidar has `/R/scan`, others `/R/LIDAR/scan`, and likewise for 3-D lidars and inertial sensors. Without a namespace they
are `/odom`, `/scan` and so on.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array, Pose, Pose3
from mjsim.interface import CameraFrame, Observation, RobotInfo, named
from mjsim.ros import messages
from mjsim.ros.frames import MAP_FRAME, Poses, RobotFrames
from mjsim.ros.qos import RELIABLE, SENSOR_DATA
from mjsim.ros.topics import Outgoing, RosTopic
from mjsim.world import Robot


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RosTick:
    """The data of a robot at one tick."""

    time: float
    """When the robot was at these poses [s]."""
    truth: Pose3 | None
    """world_from_base; None if unknown."""
    seen: Observation | None = None
    """Observation; None for a robot without a driver."""
    odometry: Pose | None = None
    """Dead reckoning from the prior; None if `seen` is."""
    odometry_covariance: Array = field(default_factory=lambda: np.zeros((3, 3)))
    """Shape (3, 3) [m, m, rad]."""
    estimate: Pose | None = None
    """Estimate, world frame; None without an estimator."""
    estimate_covariance: Array = field(default_factory=lambda: np.zeros((3, 3)))
    """Shape (3, 3) [m, m, rad]."""


class RosRobot:
    """The topics of one robot."""

    def __init__(self, robot: Robot, info: RobotInfo, *, namespace: str, prefix: str) -> None:
        """Assign the names of topics and frames.

        Args:
            robot: The robot, as in the world.
            info: The robot as known to its modules.
            namespace: Namespace of its topics: '/NAME' or ''.
            prefix: Prefix of its frames: '' or 'NAME/'.

        Raises:
            UsageError: Two of its frames would have the same name.
        """
        self.namespace = namespace
        """Namespace of its topics: '/NAME' or ''."""
        self._info, self._farthest = info, robot.proximity_range
        self._frames = RobotFrames(robot, info, prefix=prefix)
        kinds: dict[str, str] = {}
        for sensor, about in info.sensors.items():
            kinds.setdefault(about.kind, sensor)
        self._firsts = set(kinds.values())

    def fixed(self) -> Poses:
        """Return the frames that are fixed to its body."""
        return self._frames.fixed()

    def moving(self, tick: RosTick) -> Poses:
        """Return the moving frames at a tick."""
        if tick.seen is None or tick.odometry is None:
            return {}
        return self._frames.moving(tick.odometry, tick.estimate, tick.seen.joints)

    def messages(self, tick: RosTick) -> Iterator[Outgoing]:
        """Yield all messages of a tick except frames and clock, with raw pictures."""
        if tick.truth is not None:
            topic = self._topic("truth", "geometry_msgs/msg/PoseStamped")
            yield Outgoing(topic, messages.stamped_pose(tick.time, MAP_FRAME, tick.truth))
        if tick.seen is None or tick.odometry is None:
            return
        yield self._odometry(tick, tick.seen, tick.odometry)
        if tick.estimate is not None:
            topic = self._topic("estimate", "geometry_msgs/msg/PoseWithCovarianceStamped")
            pose = messages.uncertain_pose(tick.time, MAP_FRAME, tick.estimate, tick.estimate_covariance)
            yield Outgoing(topic, pose)
        yield from self._readings(tick.seen)
        for camera, frame in tick.seen.cameras.items():
            yield from self.pictures(camera, frame)

    def pictures(self, camera: str, frame: CameraFrame) -> Iterator[Outgoing]:
        """Yield a raw picture, its depth if there is any, and the calibration."""
        frame_id = self._frames.sensors[camera]
        image = messages.picture(frame.stamp, frame_id, frame.image)
        yield Outgoing(self._camera_topic(camera, "image_raw", "sensor_msgs/msg/Image"), image)
        if frame.depth is not None:
            taken = frame.stamp if frame.depth_stamp is None else frame.depth_stamp
            yield self._depth(camera, taken, frame.depth)
        yield from self._calibration(camera, frame.stamp)

    def compressed(
        self, camera: str, stamp: float, data: bytes, form: str, *, depth: tuple[float, NDArray[Any]] | None
    ) -> Iterator[Outgoing]:
        """Yield a picture as recorded, its depth if there is any, and the calibration.

        Args:
            camera: Name of the camera in the world.
            stamp: Time of the picture [s].
            data: Contents of the picture's file.
            form: 'jpeg' or 'png'.
            depth: When it was taken [s], and its pixels, shape (height, width): whole millimetres as uint16, 0 for
                none, or metres as floats.
        """
        picture = messages.compressed_picture(stamp, self._frames.sensors[camera], data, form)
        yield Outgoing(self._camera_topic(camera, "image_raw/compressed", "sensor_msgs/msg/CompressedImage"), picture)
        if depth is not None:
            yield self._depth(camera, *depth)
        yield from self._calibration(camera, stamp)

    def _depth(self, camera: str, stamp: float, depth: NDArray[Any]) -> Outgoing:
        message = messages.depth_picture(stamp, self._frames.sensors[camera], depth)
        return Outgoing(self._camera_topic(camera, "depth/image_raw", "sensor_msgs/msg/Image"), message)

    def _calibration(self, camera: str, stamp: float) -> Iterator[Outgoing]:
        intrinsics = self._info.sensors[camera].intrinsics
        if intrinsics is not None:
            about = messages.camera_info(stamp, self._frames.sensors[camera], intrinsics)
            yield Outgoing(self._camera_topic(camera, "camera_info", "sensor_msgs/msg/CameraInfo"), about)

    def _odometry(self, tick: RosTick, seen: Observation, pose: Pose) -> Outgoing:
        moved, dt = seen.odometry, seen.dt
        message = messages.odometry(
            tick.time,
            (self._frames.odom, self._frames.base),
            pose,
            tick.odometry_covariance,
            np.array([moved.forward, moved.left, moved.turn]) / dt,
            np.asarray(moved.covariance) / dt**2,
        )
        return Outgoing(self._topic("odom", "nav_msgs/msg/Odometry"), message)

    def _readings(self, seen: Observation) -> Iterator[Outgoing]:
        """Yield the readings of sensors other than cameras."""
        for readings, of in messages.SENSOR_TOPICS.items():
            for name, reading in named(getattr(seen, readings)):
                message = of.message(reading, self._frames.sensors[name], self._info.sensors[name])
                yield Outgoing(self._sensor_topic(name, of.word, of.kind), message)
        ring = self._topic("proximity", "sensor_msgs/msg/Range", sensor=True)
        for frame, distance in zip(self._frames.rays, seen.proximity.tolist(), strict=True):
            yield Outgoing(ring, messages.distance(seen.time, frame, distance, farthest=self._farthest))
        for arm, state in seen.joints.items():
            names = [f"{arm}/{joint}" for joint in self._info.arms[arm].joints]
            joints = self._topic("joint_states", "sensor_msgs/msg/JointState")
            yield Outgoing(joints, messages.joint_state(names, state))

    def _topic(self, word: str, kind: str, *, sensor: bool = False) -> RosTopic:
        return RosTopic(f"{self.namespace}/{word}", kind, SENSOR_DATA if sensor else RELIABLE)

    def _sensor_topic(self, sensor: str, word: str, kind: str) -> RosTopic:
        """Return '/R/scan' for the first sensor of its kind, '/R/SENSOR/scan' for others."""
        return self._topic(
            word if sensor in self._firsts else f"{self._frames.plain[sensor]}/{word}", kind, sensor=True
        )

    def _camera_topic(self, camera: str, word: str, kind: str) -> RosTopic:
        return self._topic(f"{self._frames.plain[camera]}/{word}", kind, sensor=True)
