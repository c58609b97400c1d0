"""A world in ROS 2: the messages at its start, and those of each tick."""

from collections.abc import Iterator, Mapping

from mjsim.geometry import Pose3
from mjsim.interface import RobotInfo
from mjsim.ros import messages
from mjsim.ros.names import plain_names
from mjsim.ros.robot import RosRobot, RosTick
from mjsim.ros.topics import CLOCK, TF, TF_STATIC, Outgoing
from mjsim.world import World


class RosWorld:
    """All robots of a world, and their common topics."""

    def __init__(self, world: World, infos: Mapping[str, RobotInfo]) -> None:
        """Name everything.

        Args:
            world: With its robots.
            infos: Data sheet of each robot.

        Raises:
            UsageError: Two robots, or two sensors of one, would have the same name in ROS; or rosbags is not installed.
        """
        messages.typestore()
        plain = plain_names((robot.name for robot in world.robots), of="robots")
        several = len(world.robots) > 1
        self.robots = {
            robot.name: RosRobot(
                robot,
                infos[robot.name],
                name=plain[robot.name],
                prefix=f"{plain[robot.name]}/" if several else "",
            )
            for robot in world.robots
        }
        """By their names in the world."""

    def fixed(self) -> Outgoing:
        """Return the frames that never move."""
        poses = {frames: pose for robot in self.robots.values() for frames, pose in robot.fixed().items()}
        return Outgoing(TF_STATIC, messages.transforms(0.0, poses))

    def messages(self, time: float, ticks: Mapping[str, RosTick]) -> Iterator[Outgoing]:
        """Yield all messages of a tick [s], of each robot by its name in the world; the clock comes first."""
        yield Outgoing(CLOCK, messages.clock(time))
        moving: dict[float, dict[tuple[str, str], Pose3]] = {}
        for name, tick in ticks.items():
            moving.setdefault(tick.time, {}).update(self.robots[name].moving(tick))
        for moment, poses in moving.items():
            if poses:
                yield Outgoing(TF, messages.transforms(moment, poses))
        for name, tick in ticks.items():
            yield from self.robots[name].messages(tick)
