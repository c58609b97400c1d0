"""Publishes a running world to ROS 2 tick by tick, and drives its robots by received commands."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from mjsim.bridge.bus import Bus, domain_id
from mjsim.bridge.services import offer
from mjsim.bridge.simulation_interfaces import SimulationInterfaces
from mjsim.closing import Closes
from mjsim.errors import UsageError
from mjsim.interface import Command, JointState, RobotInfo
from mjsim.output import NewFile
from mjsim.progress import say
from mjsim.record import Order, Tick
from mjsim.ros import CLOCK, COMMANDS, MAP, MAP_FRAME, RELIABLE, Outgoing, RosTick, RosTopic, RosWorld, grid_map
from mjsim.session import Session
from mjsim.sim import Simulation
from mjsim.world import Modules, World, grid_of

ENDLESS_RUN_SECONDS = 1e8
"""Duration of a run without a time limit [s]."""
WATCHDOG = 0.5
"""Time for which a command holds, simulated [s]."""
DISCOVERY_SECONDS = 1.0
"""Time in which other participants of a domain are found [s]."""
SERVICE_TIMEOUT = 30.0
"""Maximum time that a service waits for its action [s]."""
SUBSCRIBED_TOPICS = ("/cmd_vel", "/goal_pose")
"""Suffixes of the topics that the bridge subscribes to."""
TWIST_TYPES = ("geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped")
"""Types accepted as commands; Nav2 sends the second since Kilted."""


class Bridge(Closes):
    """Runs a world in a separate thread; other programs see its robots as ROS 2 robots.

    It publishes the messages of `mjsim.ros` for each tick, subscribes to `/R/cmd_vel` (Twist or TwistStamped) and, with
    modules, `/R/goal_pose` (PoseStamped), and offers the services `/mjsim/pause` (std_srvs/SetBool), `/mjsim/step` and
    `/mjsim/reset` (std_srvs/Trigger), and those of `simulation_interfaces` below `/mjsim`.
    """

    def __init__(
        self,
        world: World,
        *,
        seed: int | None = None,
        seconds: float | None = None,
        speed: float | None = 1.0,
        modules: bool = False,
        watchdog: float = WATCHDOG,
        record: str | Path | NewFile | None = None,
        overwrite: bool = False,
        domain: int | None = None,
        interface: str | None = None,
        namespaces: bool = True,
        publish_map: bool = True,
    ) -> None:
        """Join the bus; `start` starts the run.

        Args:
            world: The world to simulate.
            seed: Seed of all random numbers; by default that of the world.
            seconds: Simulated duration [s]; by default unlimited.
            speed: Simulated seconds per second; None for as fast as possible.
            modules: Whether to run the modules of the world, which drive while no commands are received; otherwise
                robots wait for commands, and there are no estimates.
            watchdog: Time for which a command holds, simulated [s].
            record: The MCAP file to write, or its name from `reserve`; by default none.
            overwrite: Whether `record` may replace a file.
            domain: DDS domain; by default that of `ROS_DOMAIN_ID`.
            interface: Name or address of the network interface; by default loopback.
            namespaces: Whether topics of a robot begin with its name; without, there is one robot.
            publish_map: Whether to publish the true map on `/map`, where mapping nodes publish theirs.

        Raises:
            UsageError: An argument is invalid; cyclonedds or rosbags is not installed.
        """
        if not 0.0 < watchdog < ENDLESS_RUN_SECONDS:
            raise UsageError(f"watchdog is {watchdog:g} s; it must be above 0")
        self.domain = domain_id() if domain is None else domain
        """DDS domain."""
        world = world if modules else _without_modules(world)
        with Simulation(world, seed=seed) as sim:
            infos: Mapping[str, RobotInfo] = dict(sim.robots)
        self._ros = RosWorld(world, infos, namespaces=namespaces)
        self._map = _map(world) if publish_map else None
        self._estimates = {name for name, driver in world.run.drivers.items() if driver.estimator is not None}
        self.session = Session(
            world,
            seed=seed,
            seconds=ENDLESS_RUN_SECONDS if seconds is None else seconds,
            speed=speed,
            record=record,
            overwrite=overwrite,
            on_tick=self._publish_tick,
        )
        """The run."""
        self._bus = Bus(domain=self.domain, interface=interface)
        for name, robot in self._ros.robots.items():
            self._obey(name, robot.namespace, watchdog)
            if modules:
                self._go(name, robot.namespace)
        offer(self._bus, "/mjsim/pause", "std_srvs/srv/SetBool", self._pause)
        offer(self._bus, "/mjsim/step", "std_srvs/srv/Trigger", self._step)
        offer(self._bus, "/mjsim/reset", "std_srvs/srv/Trigger", self._reset)
        self._interfaces = SimulationInterfaces(self._bus, self.session, patience=SERVICE_TIMEOUT)

    @property
    def robots(self) -> list[str]:
        """Namespaces of the robots: '/scout' and so on, '/' without."""
        return [robot.namespace or "/" for robot in self._ros.robots.values()]

    def start(self, *, paused: bool = False) -> None:
        """Start; if paused, stop after the first tick.

        Raises:
            UsageError: Another simulation publishes its clock on the domain.
        """
        self._require_alone()
        self.session.start(paused=paused)
        self._bus.start()  # services need a session that runs

    def close(self) -> None:
        """End the run and leave the bus; a second call does nothing."""
        self.session.close()
        self._bus.close()

    def _require_alone(self) -> None:
        """Check that no other program publishes the clock; report one that publishes other topics of ours."""
        own = tuple(f"{robot}/" for robot in self.robots if robot != "/")
        others = self._bus.publishers(
            lambda topic: topic == CLOCK.name or (topic.startswith(own) and not topic.endswith(SUBSCRIBED_TOPICS)),
            wait=DISCOVERY_SECONDS,
        )
        if not others:
            return
        topic = CLOCK.name if CLOCK.name in others else min(others)
        by = f"another program{f', {others[topic]},' if others[topic] else ''}"
        more = f" and {len(others) - 1} more topics of this world" if len(others) > 1 else ""
        line = f"{by} publishes {topic}{more} on domain {self.domain}"
        if topic == CLOCK.name:
            raise UsageError(f"{line}; stop it, or set ROS_DOMAIN_ID to another number")
        say(f"{line}; subscribers receive both")

    def _obey(self, robot: str, namespace: str, watchdog: float) -> None:
        """Drive a robot by a message on its `cmd_vel`; the stamp is ignored, since a command holds from now."""

        def take(message: Any) -> None:
            twist = getattr(message, "twist", message)
            command = Command(twist.linear.x, twist.linear.y, twist.angular.z)
            self.session.drive(robot, command, hold=watchdog)

        for kind in TWIST_TYPES:
            self._bus.receive(RosTopic(f"{namespace}/cmd_vel", kind, COMMANDS), take)

    def _go(self, robot: str, namespace: str) -> None:
        """Give the navigator of a robot the goals on its `goal_pose`."""

        def take(message: Any) -> None:
            if (frame := message.header.frame_id) not in (MAP_FRAME, ""):
                raise UsageError(f"the goal for '{robot}' is in the frame '{frame}'; give it in '{MAP_FRAME}'")
            place, turned = message.pose.position, message.pose.orientation
            heading = 2.0 * math.atan2(turned.z, turned.w)
            self.session.set_goal(robot, (place.x, place.y), math.remainder(heading, 2.0 * math.pi))

        self._bus.receive(RosTopic(f"{namespace}/goal_pose", "geometry_msgs/msg/PoseStamped", RELIABLE), take)

    def _publish_tick(self, tick: Tick) -> None:
        """Publish a tick, in the session's thread."""
        self._interfaces.see(tick)
        if tick.time == 0.0:
            for each in (self._ros.fixed(), self._map):
                if each is not None:
                    self._bus.send(each)
        ticks = {
            name: _robot_tick(tick, name, tick.orders.get(name), estimated=name in self._estimates)
            for name in self._ros.robots
        }
        joints = {
            name: (motion.names, JointState(tick.time, motion.positions, motion.velocities, motion.torques))
            for name, motion in tick.joints.items()
        }
        for each in self._ros.messages(tick.time, ticks, joints):
            self._bus.send(each)

    # Services run in the bus's thread.

    def _pause(self, request: Any) -> tuple[bool, str]:
        if request.data:
            self.session.pause()
        else:
            self.session.go()
        return self._now("paused" if request.data else "running")

    def _step(self, request: Any) -> tuple[bool, str]:
        self.session.tick()
        return self._now("paused")

    def _reset(self, request: Any) -> tuple[bool, str]:
        self.session.restart()
        return self._now("paused", "running")

    def _now(self, *states: Any) -> tuple[bool, str]:
        """Wait for one of these states; return whether it was reached, and a description of state and time."""
        found = self.session.wait(*states, "ended", "failed", timeout=SERVICE_TIMEOUT)
        newest = self.session.newest
        return found in states, f"{found} at {0.0 if newest is None else newest.time:g} s"


def _without_modules(world: World) -> World:
    """Return a world whose robots wait for commands: it has no modules except controllers."""
    drivers = {
        name: Modules(avoidance=False, controllers=driver.controllers, push=driver.push)
        for name, driver in world.run.drivers.items()
    }
    return world.model_copy(update={"run": world.run.model_copy(update={"drivers": drivers})})


def _map(world: World) -> Outgoing | None:
    """Return the map of a world; None if nothing is solid."""
    try:
        grid = grid_of(world)
    except UsageError:
        return None
    message = grid_map(grid.occupied, grid.free, resolution=grid.resolution, map_from_grid=grid.world_from_grid)
    return Outgoing(MAP, message)


def _robot_tick(tick: Tick, robot: str, order: Order | None, *, estimated: bool) -> RosTick:
    truth = tick.poses.get(robot)
    if order is None:
        return RosTick(time=tick.time, truth=truth)
    return RosTick(
        time=tick.time,
        truth=truth,
        seen=tick.seen[robot],
        odometry=order.dead_reckoning,
        odometry_covariance=order.dead_reckoning_covariance,
        estimate=order.estimate.pose if estimated else None,
        estimate_covariance=order.estimate.covariance,
    )
