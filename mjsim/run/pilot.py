"""Runs the modules of one robot: turns an observation into an order, and reports faults."""

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, TypeVar

import numpy as np

from mjsim.closing import Closes
from mjsim.errors import UsageError
from mjsim.geometry import Array, Pose
from mjsim.interface import (
    Avoidance,
    BeaconInfo,
    Command,
    Controller,
    ControlLoop,
    Estimate,
    Estimator,
    Navigator,
    Observation,
    Observer,
    Odometry,
    RobotInfo,
    WheelCommand,
    WorldMap,
)
from mjsim.modules import (
    Boundary,
    Hosted,
    checked_command,
    checked_estimate,
    checked_lost,
    checked_path,
    checked_reason,
    checked_show,
    checked_sightings,
    name_of,
    sealed_catalogue,
    sealed_map,
    sealed_observation,
    sealed_robot,
)
from mjsim.record import Order, RobotEvent
from mjsim.safety import RingAvoidance, react_to_bump
from mjsim.sentences import Sentence
from mjsim.world import GoalEvent

T = TypeVar("T")
Steer = Callable[[str, float], Command | None]
"""Robot and simulated time [s] -> command that replaces the navigator's, or None."""

BUMP_ENDS_AFTER = 0.5
"""A bump begins at contact and ends after this long without [s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Driver:
    """The modules that drive one robot.

    Without an estimator the belief is dead reckoning, without a navigator the robot stands still.
    """

    observer: Observer | None = None
    """Turns pictures and scans into sightings; without one only sensors give sightings."""
    estimator: Estimator | None = None
    """Estimates the pose; dead reckoning without one."""
    navigator: Navigator | None = None
    """Decides where to go; the robot stands still without one."""
    avoidance: bool | Avoidance = False
    """True for the built-in one."""
    controllers: Mapping[str, Controller | ControlLoop] = field(default_factory=dict)
    """Controllers that drive motors between ticks, by part: 'drive' of a balancing base, or the name of an arm; at 250
    Hz and without latency unless a ControlLoop says otherwise. By default those of mjsim."""
    push: bool = False
    """Whether it may keep pushing against doors and movable objects; otherwise a bump stops it."""


@dataclass(frozen=True, slots=True, eq=False)
class Noticed:
    """The estimate of a robot's modules before the navigator decides."""

    seen: Observation
    """The observation, including the sightings of the observer."""
    belief: Estimate
    events: tuple[RobotEvent, ...]
    """The bump that starts now, if any."""


def controller_of(control: Controller | ControlLoop) -> Controller:
    """Return a controller, alone or in its loop."""
    return control.controller if isinstance(control, ControlLoop) else control


def final_path(robot: str, driver: Driver, now: float) -> Array | None:
    """Return the final trajectory of an estimator, or None.

    Args:
        robot: Its name.
        driver: Driver with the estimator, after its last tick.
        now: Simulated time [s].

    Returns:
        Rows of time [s], x, y [m] and heading [rad], shape (M, 4).

    Raises:
        ModuleFault: It raised, or returned an invalid value.
    """
    estimator, boundary = driver.estimator, Boundary(robot)
    if estimator is None or isinstance(estimator, Hosted) or not boundary.offers("estimator", estimator, "path"):
        return None
    answer = boundary.call("estimator", estimator, now, "path")
    return boundary.check("estimator", estimator, now, "path", checked_path, answer)


def require_takes_goals(drivers: Mapping[str, Driver], robot: str) -> None:
    """Check that a robot has a navigator that takes goals.

    Raises:
        UsageError: It has none.
    """
    navigator = drivers[robot].navigator if robot in drivers else None
    if navigator is None:
        raise UsageError(
            Sentence("robot '{robot}' has no navigator to take a goal; give it one, such as GoToGoal", robot)
        )
    if isinstance(navigator, Hosted) or not Boundary(robot).offers("navigator", navigator, "take_goal"):
        raise UsageError(
            Sentence(
                "{navigator}, the navigator of robot '{robot}', takes no goals; choose one with take_goal(),"
                " such as GoToGoal",
                name_of(navigator),
                robot,
            )
        )


def _avoidance_of(driver: Driver) -> Avoidance | None:
    if driver.avoidance is True:
        return RingAvoidance()
    return None if driver.avoidance is False else driver.avoidance


def _offers(part: str, module: object | None, boundary: Boundary, method: str) -> bool:
    """Return whether a module has an optional method."""
    return module is not None and boundary.offers(part, module, method)


class DeadReckoning:
    """Dead reckoning from the prior, with its covariance."""

    def __init__(self, robot: RobotInfo) -> None:
        self.pose = robot.prior
        self.covariance: Array = np.array(robot.prior_covariance, dtype=float)
        self._F, self._G = np.eye(3), np.eye(3)

    def add(self, odometry: Odometry) -> None:
        """Add the odometry of one tick.

        References:
            Thrun, Burgard, Fox, Probabilistic Robotics (2005), section 7.4: the motion part of an EKF.
        """
        c, s = np.cos(self.pose.heading), np.sin(self.pose.heading)
        F, G = self._F, self._G
        F[0, 2] = -s * odometry.forward - c * odometry.left
        F[1, 2] = c * odometry.forward - s * odometry.left
        G[0, 0], G[0, 1], G[1, 0], G[1, 1] = c, -s, s, c
        self.pose = self.pose @ Pose(odometry.forward, odometry.left, odometry.turn)
        self.covariance = F @ self.covariance @ F.T + G @ odometry.covariance @ G.T


class Pilot(Closes):
    """The driver of one robot during a run, with its state."""

    def __init__(
        self,
        driver: Driver,
        robot: RobotInfo,
        catalogue: dict[str, BeaconInfo],
        map: WorldMap | None,
        *,
        seed: int,
        steer: Steer | None = None,
    ) -> None:
        self._driver = driver
        self._steer = steer
        self._robot = robot
        self._dead_reckoning = DeadReckoning(robot)
        self._touched = -np.inf
        self._blocked = False
        self._reason: str | None = None
        self._lost = False
        self._seconds: dict[str, float] = {}
        self._boundary = Boundary(robot.name)
        self._avoidance = _avoidance_of(driver)
        self._checked_command = partial(checked_command, robot=robot)
        self._ticks_a_second, self._unchecked = max(round(1.0 / robot.dt), 1), 0
        controllers = [controller_of(each) for each in driver.controllers.values()]
        modules = (driver.observer, driver.estimator, driver.navigator, self._avoidance, *controllers)
        self._modules = [module for module in modules if module is not None]
        try:
            self._start(sealed_catalogue(catalogue), sealed_map(map), seed)
            self._shows = _offers("navigator", driver.navigator, self._boundary, "show")
            self._explains = _offers("navigator", driver.navigator, self._boundary, "blocked")
            self._locates = _offers("estimator", driver.estimator, self._boundary, "lost")
        except BaseException:
            self.close()
            raise

    def _start(self, catalogue: Mapping[str, BeaconInfo], map: WorldMap | None, seed: int) -> None:
        """Start the modules, each with its own random stream."""
        robot, driver, boundary = sealed_robot(self._robot), self._driver, self._boundary
        parts: tuple[tuple[str, object | None, tuple[object, ...]], ...] = (
            ("observer", driver.observer, (catalogue,)),
            ("estimator", driver.estimator, (catalogue,)),
            ("navigator", driver.navigator, (map,)),
            ("avoidance", self._avoidance, ()),
        )
        for part, module, extra in parts:
            if module is None:
                continue
            boundary.require(part, module)
            if isinstance(module, Hosted):
                boundary.call(part, module, 0.0, "take_world", catalogue, map)
            if boundary.offers(part, module, "take_map"):
                boundary.call(part, module, 0.0, "take_map", map)
            rng = np.random.default_rng([seed, *f"{robot.name}/{part}/module".encode()])
            boundary.call(part, module, 0.0, "start", robot, *extra, rng)

    def close(self) -> None:
        """Close the modules that hold more than memory."""
        for module in self._modules:
            if isinstance(module, Hosted):
                module.close()

    def decide(self, seen: Observation) -> Order:
        """Run observer, estimator and navigator, then the safety functions.

        Raises:
            ModuleFault: A module raised an exception or returned an invalid value; the message names it, the robot and
            the time.
        """
        return self.order(self.notice(seen))

    def take_goal(self, event: GoalEvent) -> None:
        """Give the navigator, which takes goals, a new one."""
        (x, y), degrees = event.to, event.heading_deg
        heading = None if degrees is None else math.radians(degrees)
        self._boundary.call("navigator", self._driver.navigator, event.time, "take_goal", x, y, heading)

    def notice(self, seen: Observation) -> Noticed:
        """Run observer and estimator, once per tick; `order` follows."""
        self._seconds = {}
        self._dead_reckoning.add(seen.odometry)
        seen = self._observe(sealed_observation(seen) if self._modules else seen)
        return Noticed(seen, self._believe(seen), self._bump(seen))

    def order(self, noticed: Noticed) -> Order:
        """Run the navigator, then the safety functions."""
        seen, belief = noticed.seen, noticed.belief
        # The navigator is called anyway, so that its state is current when it drives again.
        navigated = self._navigate(seen, belief)
        wanted = self._steered(seen.time) or navigated
        command = wanted
        if self._avoidance is not None and isinstance(wanted, Command):
            command = self._call("avoidance", self._avoidance, seen.time, "adjust", self._checked_command, wanted, seen)
            if isinstance(command, Command):
                # An avoidance module need not know about messages or arms.
                command = replace(command, messages=wanted.messages, joints=wanted.joints)
        safe = command if self._driver.push else react_to_bump(command, seen.bump, self._robot)
        return Order(
            command=safe,
            wanted=wanted,
            estimate=self._with_plan(belief, seen.time),
            dead_reckoning=self._dead_reckoning.pose,
            dead_reckoning_covariance=self._dead_reckoning.covariance,
            sightings=seen.sightings,
            events=(
                *noticed.events,
                *self._block(seen, blocked=safe is not command),
                *self._explain(seen.time),
                *self._locate(seen.time),
            ),
            timing=self._seconds,
        )

    def _observe(self, seen: Observation) -> Observation:
        observer = self._driver.observer
        if observer is None:
            return seen
        sightings = self._call("observer", observer, seen.time, "observe", checked_sightings, seen)
        return replace(seen, sightings=(*seen.sightings, *sightings)) if sightings else seen

    def _believe(self, seen: Observation) -> Estimate:
        estimator = self._driver.estimator
        if estimator is None:
            return Estimate(self._dead_reckoning.pose, self._dead_reckoning.covariance)
        return self._call("estimator", estimator, seen.time, "update", self._checked_estimate, seen)

    def _navigate(self, seen: Observation, belief: Estimate) -> Command | WheelCommand:
        navigator = self._driver.navigator
        if navigator is None:
            return Command()
        return self._call("navigator", navigator, seen.time, "command", self._checked_command, seen, belief)

    def _with_plan(self, belief: Estimate, now: float) -> Estimate:
        """Return a belief with what the navigator shows beside the estimator, such as its planned path."""
        navigator, boundary = self._driver.navigator, self._boundary
        if navigator is None or not self._shows:
            return belief
        shown = boundary.check(
            "navigator", navigator, now, "show", checked_show, boundary.call("navigator", navigator, now, "show")
        )
        return replace(belief, show=(*belief.show, *shown)) if shown else belief

    def _steered(self, now: float) -> Command | None:
        """Return the command of manual control, or None."""
        return self._steer(self._robot.name, now) if self._steer is not None else None

    def _bump(self, seen: Observation) -> tuple[RobotEvent, ...]:
        """Return the bump that starts now, if any."""
        if not seen.bump:
            return ()
        begins = seen.time - self._touched > BUMP_ENDS_AFTER
        self._touched = seen.time
        return (
            (RobotEvent(seen.time, "bump", Sentence("{name} bumped", self._robot.name), seen.bump[0]),)
            if begins
            else ()
        )

    def _block(self, seen: Observation, *, blocked: bool) -> tuple[RobotEvent, ...]:
        """Return the event that the robot is blocked, if that starts now."""
        begins = blocked and not self._blocked
        # Contact flickers while a robot presses against a wall; one episode is one event.
        self._blocked = blocked or (self._blocked and seen.time - self._touched <= BUMP_ENDS_AFTER)
        if not begins:
            return ()
        return (
            RobotEvent(
                seen.time,
                "blocked",
                Sentence("{name} cannot continue; an object that it touches blocks it", self._robot.name),
            ),
        )

    def _explain(self, now: float) -> tuple[RobotEvent, ...]:
        """Return the event that the navigator first reports its robot as blocked, if it does."""
        navigator, boundary = self._driver.navigator, self._boundary
        if navigator is None or not self._explains:
            return ()
        answer = boundary.call("navigator", navigator, now, "blocked")
        before, self._reason = (
            self._reason,
            boundary.check("navigator", navigator, now, "blocked", checked_reason, answer),
        )
        if self._reason is None or before is not None:
            return ()
        return (RobotEvent(now, "blocked", Sentence("{name} is blocked: {reason}", self._robot.name, self._reason)),)

    def _locate(self, now: float) -> tuple[RobotEvent, ...]:
        """Return the event that the estimator first reports its robot as lost, or no longer, if it does."""
        estimator, boundary, before = self._driver.estimator, self._boundary, self._lost
        if estimator is None or not self._locates:
            return ()
        answer = boundary.call("estimator", estimator, now, "lost")
        self._lost = boundary.check("estimator", estimator, now, "lost", checked_lost, answer)
        if self._lost == before:
            return ()
        if self._lost:
            return (
                RobotEvent(
                    now, "lost", Sentence("{name} is lost: what it senses does not fit its estimate", self._robot.name)
                ),
            )
        return (RobotEvent(now, "found", Sentence("{name} knows where it is again", self._robot.name)),)

    def _call(
        self, part: str, module: object, now: float, method: str, check: Callable[[object], T], *arguments: Any
    ) -> T:
        """Return the checked result of a module, and record its computing time."""
        began = time.perf_counter()
        answer = self._boundary.call(part, module, now, method, *arguments)
        self._seconds[part] = time.perf_counter() - began
        return self._boundary.check(part, module, now, method, check, answer)

    def _checked_estimate(self, belief: object) -> Estimate:
        """Return a checked estimate; the joint covariance, which is expensive, is checked in full once per second."""
        self._unchecked -= 1
        if self._unchecked > 0:
            return checked_estimate(belief, whole=False)
        self._unchecked = self._ticks_a_second
        return checked_estimate(belief)
