"""A world in ROS 2: the messages at its start, and those of each tick."""

from collections.abc import Iterator, Mapping, Sequence

from mjsim.errors import UsageError
from mjsim.geometry import Pose3
from mjsim.interface import JointState, RobotInfo
from mjsim.ros import messages
from mjsim.ros.ros_names import plain_names
from mjsim.ros.ros_robot import RosRobot, RosTick
from mjsim.ros.topics import CLOCK, TF, TF_STATIC, Outgoing, RosTopic
from mjsim.world import World


class RosWorld:
    """All robots and mechanisms of a world, and their common topics."""

    def __init__(self, world: World, infos: Mapping[str, RobotInfo], *, namespaces: bool = True) -> None:
        """Determine all names in ROS.

        Args:
            world: World with the robots.
            infos: Data sheet of each robot.
            namespaces: Whether topics of a robot begin with its name; without, there is one robot.

        Raises:
            UsageError: Several robots are without namespaces, two robots or mechanisms, or two sensors of a robot,
                would have the same name in ROS, or rosbags is missing.
        """
        messages.typestore()
        owners = [robot.name for robot in world.robots], [each.name for each in world.mechanisms]
        plain = plain_names([*owners[0], *owners[1]], of="robots and mechanisms" if owners[1] else "robots")
        several = len(world.robots) > 1
        if several and not namespaces:
            raise UsageError(f"the world has {len(world.robots)} robots; without namespaces it must have one")
        self.robots = {
            robot.name: RosRobot(
                robot,
                infos[robot.name],
                namespace=f"/{plain[robot.name]}" if namespaces else "",
                prefix=f"{plain[robot.name]}/" if several else "",
            )
            for robot in world.robots
        }
        """By their names in the world."""
        self._joint_topics = {
            name: RosTopic(f"/{plain[name]}/joint_states", "sensor_msgs/msg/JointState") for name in owners[1]
        }
        """Topics of mechanisms, by their names in the world."""

    def fixed(self) -> Outgoing:
        """Return the frames that never move."""
        poses = {frames: pose for robot in self.robots.values() for frames, pose in robot.fixed().items()}
        return Outgoing(TF_STATIC, messages.transforms(0.0, poses))

    def messages(
        self, time: float, ticks: Mapping[str, RosTick], joints: Mapping[str, tuple[Sequence[str], JointState]]
    ) -> Iterator[Outgoing]:
        """Yield all messages of a tick; the clock comes first.

        Args:
            time: Time of the tick [s].
            ticks: Ticks by the names of robots in the world.
            joints: Names and true states of joints, by the name of the mechanism; others are ignored.
        """
        yield Outgoing(CLOCK, messages.clock(time))
        moving: dict[float, dict[tuple[str, str], Pose3]] = {}
        for name, tick in ticks.items():
            moving.setdefault(tick.time, {}).update(self.robots[name].moving(tick))
        for moment, poses in moving.items():
            if poses:
                yield Outgoing(TF, messages.transforms(moment, poses))
        for name, tick in ticks.items():
            yield from self.robots[name].messages(tick)
        for name, topic in self._joint_topics.items():
            if name in joints:
                yield Outgoing(topic, messages.joint_state(*joints[name]))
