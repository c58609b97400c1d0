"""The frames of a robot in ROS 2 (REP 105): `map`, `odom`, `base_link`, `base_footprint`, and one for each sensor.

With several robots, those of robot R have the prefix `R/`; `map` is the world frame, shared by all.
The origin of `base_link` is on the floor, so `base_footprint`, which Nav2 and slam_toolbox ask for, is the same place.
A camera's frame is optical, `CAMERA_optical_frame`; those of the 16 proximity rays are `proximity_0` and so on.
"""

from collections.abc import Mapping

import numpy as np

from mjsim.errors import UsageError
from mjsim.geometry import Array, Pose, Pose3
from mjsim.interface import JointState, RobotInfo, SensorInfo
from mjsim.ros.ros_names import plain_names
from mjsim.world import PROXIMITY_HEIGHT, AnySensor, Robot, RobotArm, name_of, rims

Poses = dict[tuple[str, str], Pose3]
"""outer_from_inner by (outer, inner)."""
MAP_FRAME = "map"
RAYS = 16


class RobotFrames:
    """The frames of one robot."""

    def __init__(self, robot: Robot, info: RobotInfo, *, prefix: str) -> None:
        """Assign the names of the frames.

        Args:
            robot: The robot, as in the world.
            info: The robot as known to its modules.
            prefix: '' or 'NAME/'.

        Raises:
            UsageError: Two frames would have the same name.
        """
        self._info = info
        self.odom, self.base, self.footprint = (f"{prefix}{word}" for word in ("odom", "base_link", "base_footprint"))
        self.plain = plain_names(info.sensors, of=f"sensors of robot '{robot.name}'")
        """Sensor -> its name in ROS."""
        self.sensors = {
            name: f"{prefix}{word}{'_optical_frame' if info.sensors[name].kind == 'camera' else ''}"
            for name, word in self.plain.items()
        }
        """Sensor -> its frame."""
        self.rays = [f"{prefix}proximity_{number}" for number in range(RAYS)]
        """Frames of the proximity rays, the first one forward, then counter-clockwise."""
        taken = {MAP_FRAME, self.odom, self.base, self.footprint, *self.rays} & set(self.sensors.values())
        if taken:
            raise UsageError(f"robot '{robot.name}' has a sensor whose frame in ROS is '{min(taken)}'; rename it")
        angles = np.asarray(np.arange(RAYS) * (2.0 * np.pi / RAYS), dtype=float)
        self._rims = rims(robot.body, angles).tolist()
        self._height = PROXIMITY_HEIGHT * robot.body.height
        self._robot = robot
        self._sensors = {name_of(sensor): sensor for sensor in robot.sensors}
        self._carried = [name for name, sensor in self._sensors.items() if getattr(sensor, "on", None) is not None]

    def fixed(self) -> Poses:
        """Return the poses of the frames fixed to the body."""
        poses = {
            (self.base, self.sensors[name]): Pose3.from_matrix(sensor.robot_from_sensor)
            for name, sensor in self._info.sensors.items()
            if name not in self._carried
        }
        poses[self.base, self.footprint] = Pose3.from_planar(Pose(0.0, 0.0, 0.0))
        for number, (frame, rim) in enumerate(zip(self.rays, self._rims, strict=True)):
            angle = number * 2.0 * np.pi / RAYS
            ray = Pose3.from_planar(Pose(rim * np.cos(angle), rim * np.sin(angle), angle))
            poses[self.base, frame] = Pose3(ray.x, ray.y, self._height, ray.qx, ray.qy, ray.qz, ray.qw)
        return poses

    def moving(self, odometry: Pose, estimate: Pose | None, joints: Mapping[str, JointState]) -> Poses:
        """Return the moving frames: the robot in `odom`, `odom` in the map, and sensors on arms.

        Args:
            odometry: Dead reckoning.
            estimate: Pose of the robot in the map; None without an estimator.
            joints: Joint states of its arms.
        """
        poses = {(self.odom, self.base): Pose3.from_planar(odometry)}
        if estimate is not None:
            poses[MAP_FRAME, self.odom] = Pose3.from_planar(estimate @ odometry.inverse())
        for name in self._carried:
            if str(getattr(self._sensors[name], "on", "")).partition("/")[0] in joints:
                mounted = robot_from_sensor(self._robot, self._info.sensors[name], self._sensors[name], joints)
                poses[self.base, self.sensors[name]] = Pose3.from_matrix(mounted)
        return poses


def robot_from_sensor(robot: Robot, sheet: SensorInfo, sensor: AnySensor, joints: Mapping[str, JointState]) -> Array:
    """Return the current robot_from_sensor, shape (4, 4) [m]; the sensor may be on an arm.

    Args:
        robot: The robot, as in the world.
        sheet: Data sheet of the sensor.
        sensor: The sensor, as in the world.
        joints: Joint states of the robot's arms; joints without a state are at their start.
    """
    on = getattr(sensor, "on", None)
    arm, _, part = (on or "").partition("/")
    if arm not in joints:
        return sheet.robot_from_sensor
    item = next(each for each in robot.arms if each.name == arm)
    return _moved(item, part, joints[arm].positions) @ sheet.robot_from_sensor


def _moved(item: RobotArm, part: str, q: Array) -> Array:
    """Return the motion of a part of an arm since the start, in the robot's frame, shape (4, 4) [m]."""
    arm = item.arm
    start, now = arm.posture(item.start()), arm.posture(q)
    if part == "tool":
        return np.asarray(now.tool @ np.linalg.inv(start.tool))
    link = int(part.removeprefix("link")) - 1
    return np.asarray(now.links[link] @ np.linalg.inv(start.links[link]))
