"""The modules of one robot at work: observation in, order out, and a fault named when one fails."""

import time
import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from mjsim.errors import ModuleFault
from mjsim.geometry import Array, Pose
from mjsim.interface import (
    Avoidance,
    BeaconInfo,
    Command,
    Estimate,
    Estimator,
    Navigator,
    Observation,
    Observer,
    RobotInfo,
    Sighting,
    TakesMap,
    WheelCommand,
    WorldMap,
)
from mjsim.record.tick import Event, Order
from mjsim.run.checks import checked_command, checked_estimate, checked_sightings
from mjsim.safety import RingAvoidance, react_to_bump

T = TypeVar("T")
Steer = Callable[[str, float], Command | None]
"""Robot and simulated time [s] -> the command that takes the place of its navigator's; None to let that one decide."""

BUMP_ENDS_AFTER = 0.5
"""A bump begins at contact and ends after this long without [s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Driver:
    """The modules that drive one robot.

    Without an estimator the belief is dead reckoning, without a navigator the robot stands still.
    """

    observer: Observer | None = None
    estimator: Estimator | None = None
    navigator: Navigator | None = None
    avoidance: bool | Avoidance = False
    """True for the built-in one."""
    push: bool = False
    """Whether it may press on against what it touches, to push a door open or a thing away; else a bump stops it."""


@dataclass(frozen=True, slots=True, eq=False)
class Noticed:
    """What a robot's modules make of an observation before they decide."""

    seen: Observation
    """With what the observer saw."""
    belief: Estimate
    events: tuple[Event, ...]
    """The bump that begins now, if one does."""


class DeadReckoning:
    """Odometry summed from the prior, with its covariance."""

    def __init__(self, robot: RobotInfo) -> None:
        self.pose = robot.prior
        self.covariance: Array = np.array(robot.prior_covariance, dtype=float)

    def add(self, seen: Observation) -> None:
        """Go on by one tick's odometry.

        References:
            Thrun, Burgard, Fox, Probabilistic Robotics (2005), section 7.4: the motion part of an EKF.
        """
        odometry, heading = seen.odometry, self.pose.heading
        c, s = np.cos(heading), np.sin(heading)
        F = np.eye(3)
        F[0, 2] = -s * odometry.forward - c * odometry.left
        F[1, 2] = c * odometry.forward - s * odometry.left
        G = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        self.pose = self.pose @ Pose(odometry.forward, odometry.left, odometry.turn)
        self.covariance = F @ self.covariance @ F.T + G @ odometry.covariance @ G.T


class Pilot:
    """One robot's driver during a run: it holds what changes from tick to tick."""

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
        self._seconds: dict[str, float] = {}
        self._avoidance = RingAvoidance() if driver.avoidance is True else driver.avoidance or None

        def stream(purpose: str) -> np.random.Generator:
            return np.random.default_rng([seed, *f"{robot.name}/{purpose}/module".encode()])

        for part, module, extra in (
            ("observer", driver.observer, (catalogue,)),
            ("estimator", driver.estimator, (catalogue,)),
            ("navigator", driver.navigator, (map,)),
            ("avoidance", self._avoidance, ()),
        ):
            if isinstance(module, TakesMap):
                self._call(part, module, 0.0, module.take_map, map)
            if module is not None:
                self._call(part, module, 0.0, module.start, robot, *extra, stream(part))

    def decide(self, seen: Observation) -> Order:
        """Let the modules look, believe, decide; then let safety have the last word.

        Raises:
            ModuleFault: A module raised, or returned what it must not; names it, the robot and the time.
        """
        return self.order(self.notice(seen))

    def notice(self, seen: Observation) -> Noticed:
        """Let the modules look and believe, once a tick; `order` comes next."""
        self._seconds = {}
        self._dead_reckoning.add(seen)
        seen = self._look(seen)
        return Noticed(seen, self._believe(seen), self._bump(seen))

    def order(self, noticed: Noticed) -> Order:
        """Let the navigator decide on what was noticed; then let safety have the last word."""
        seen, belief = noticed.seen, noticed.belief
        # The navigator is asked all the same, so that it knows where it is when it drives again.
        navigated = self._navigate(seen, belief)
        wanted = self._steered(seen.time) or navigated
        command = wanted
        if self._avoidance is not None and isinstance(wanted, Command):
            command = self._ask("avoidance", self._avoidance, seen.time, self._avoidance.adjust, wanted, seen)
            command = self._check("avoidance", self._avoidance, seen.time, checked_command, command, self._robot)
            if isinstance(command, Command):
                command = replace(command, messages=wanted.messages)  # Who avoids a wall need not think of the radio.
        safe = command if self._driver.push else react_to_bump(command, seen.bump, self._robot)
        return Order(
            command=safe,
            wanted=wanted,
            estimate=belief,
            dead_reckoning=self._dead_reckoning.pose,
            dead_reckoning_covariance=self._dead_reckoning.covariance,
            sightings=seen.sightings,
            events=(*noticed.events, *self._block(seen, blocked=safe is not command)),
            timing=self._seconds,
        )

    def _look(self, seen: Observation) -> Observation:
        observer = self._driver.observer
        if observer is None:
            return seen
        found: Sequence[Sighting] = self._ask("observer", observer, seen.time, observer.observe, seen)
        sightings = self._check("observer", observer, seen.time, checked_sightings, found)
        return replace(seen, sightings=(*seen.sightings, *sightings)) if sightings else seen

    def _believe(self, seen: Observation) -> Estimate:
        estimator = self._driver.estimator
        if estimator is None:
            return Estimate(self._dead_reckoning.pose, self._dead_reckoning.covariance)
        belief: Estimate = self._ask("estimator", estimator, seen.time, estimator.update, seen)
        return self._check("estimator", estimator, seen.time, checked_estimate, belief)

    def _navigate(self, seen: Observation, belief: Estimate) -> Command | WheelCommand:
        navigator = self._driver.navigator
        if navigator is None:
            return Command()
        command = self._ask("navigator", navigator, seen.time, navigator.command, seen, belief)
        return self._check("navigator", navigator, seen.time, checked_command, command, self._robot)

    def _steered(self, now: float) -> Command | None:
        """Return what somebody who took over wants, None when nobody has."""
        return self._steer(self._robot.name, now) if self._steer is not None else None

    def _bump(self, seen: Observation) -> tuple[Event, ...]:
        """Return the bump that begins now, if one does."""
        if not seen.bump:
            return ()
        begins = seen.time - self._touched > BUMP_ENDS_AFTER
        self._touched = seen.time
        return (Event(seen.time, "bump", f"{self._robot.name} bumped", seen.bump[0]),) if begins else ()

    def _block(self, seen: Observation, *, blocked: bool) -> tuple[Event, ...]:
        """Return that the robot is held up, if that begins now."""
        begins = blocked and not self._blocked
        # Contact flickers while a robot presses against a wall; one episode is one event.
        self._blocked = blocked or (self._blocked and seen.time - self._touched <= BUMP_ENDS_AFTER)
        text = f"{self._robot.name} cannot go on; what it touches is in the way"
        return (Event(seen.time, "blocked", text),) if begins else ()

    def _ask(self, part: str, module: object, now: float, function: Callable[..., T], *arguments: Any) -> T:
        """Call a module and note how long it took."""
        began = time.perf_counter()
        answer = self._call(part, module, now, function, *arguments)
        self._seconds[part] = time.perf_counter() - began
        return answer

    def _call(self, part: str, module: object, now: float, function: Callable[..., T], *arguments: Any) -> T:
        try:
            return function(*arguments)
        # Whatever the user's code raises ends the run with one line; this is the boundary to that code.
        except Exception as error:
            frame = traceback.extract_tb(error.__traceback__)[-1]
            where = f"{frame.filename.rpartition('/')[2]}:{frame.lineno}"
            raise self._fault(part, module, now, f"raised {type(error).__name__}: {error} ({where})") from error

    def _check(self, part: str, module: object, now: float, check: Callable[..., T], *arguments: Any) -> T:
        try:
            return check(*arguments)
        except ValueError as error:
            raise self._fault(part, module, now, str(error)) from error

    def _fault(self, part: str, module: object, now: float, what: str) -> ModuleFault:
        name = self._robot.name
        return ModuleFault(f"{part} {type(module).__name__} of robot '{name}' at {now:.2f} s {what}", robot=name)
