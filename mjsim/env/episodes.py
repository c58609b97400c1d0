"""Episodes of a task: the loop of a run with actions in place of the navigators, from fixed or random starts."""

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from numpy.random import Generator

from mjsim.env.actions import Actions
from mjsim.env.channels import channels_of
from mjsim.env.step import Step
from mjsim.env.task import Task, driven
from mjsim.errors import ModuleFault, UsageError, did_you_mean, one_line
from mjsim.geometry import Pose
from mjsim.interface import Command, Estimate, Observation, RobotInfo, WheelCommand, WorldMap
from mjsim.modules import error_text, kind_of
from mjsim.record import codec_of
from mjsim.run import Noticed, Pilot, drivers_of
from mjsim.sim import Simulation, stream
from mjsim.world import SLICE, AnySensor, Modules, Robot, Solids, World, disc, leaves, name_of, solid

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry


_MAX_CHARACTERS = 80
"""Maximum length of an invalid value in a message [characters]."""
Seen = dict[str, Any]
"""Arrays by name; for several robots, dicts of these by robot."""


class ByAction:
    """A navigator that returns the command of the action."""

    def __init__(self) -> None:
        self.wanted: Command | WheelCommand = Command()

    def start(self, robot: RobotInfo, map: WorldMap | None, rng: Generator) -> None:
        """Start at rest."""
        self.wanted = Command()

    def command(self, seen: Observation, belief: Estimate) -> Command | WheelCommand:
        """Return the command of the action."""
        return self.wanted


class Episodes:
    """A running task, used by both kinds of environment."""

    def __init__(self, task: Task) -> None:
        """Compile the world once, for all episodes.

        Raises:
            MjsimError: The world cannot be read, or the task names something that does not exist.
        """
        world = task.loaded()
        self.task, self.robots = task, driven(task, world)
        self.together = task.robots is None or isinstance(task.robots, str)
        """Whether actions and observations are for one robot, not dicts by robot."""
        self.world = _stripped(world, self.robots, task.observations)
        self.sim = Simulation(self.world)
        infos, robots = self.sim.robots, {robot.name: robot for robot in world.robots}
        self.actions = {name: Actions(infos[name], task.actions) for name in self.robots}
        self.channels = {n: channels_of(robots[n], infos[n], world, task.observations) for n in self.robots}
        self._places = {name: Starts(world, robots[name]) for name in self.robots} if task.random_starts else {}
        self.length = world.run.ticks(task.seconds, of="an episode")
        """Length of an episode [ticks]."""
        self._agents = {name: ByAction() for name in self.robots}
        self._pilots: dict[str, Pilot] = {}
        self._held = ExitStack()
        self._noticed: dict[str, Noticed] = {}
        self._step: Step | None = None

    @property
    def step(self) -> Step:
        """The last step.

        Raises:
            UsageError: There was none.
        """
        if self._step is None:
            raise UsageError("reset the environment before its first step")
        return self._step

    def begin(self, seed: int) -> None:
        """Start an episode, which is determined by its seed and the actions."""
        sim = self.sim
        sim.reset(seed)
        self._place(seed)
        sim.happened()
        drivers = drivers_of(self.world)
        for name, agent in self._agents.items():
            drivers[name] = replace(drivers[name], navigator=agent)
        self._held.close()
        self._pilots = {
            name: self._held.enter_context(
                Pilot(driver, self._robot_info(name), dict(sim.catalogue), sim.map, seed=seed)
            )
            for name, driver in drivers.items()
            if name in self._agents or name in self.world.run.drivers
        }
        for name in self._pilots:
            sim.control(name, drivers[name].controllers)
        for channels in self.channels.values():
            for channel in channels.values():
                channel.start()
        self._notice()
        truths = sim.truths()
        self._step = self._made(before=truths, wanted={}, command={})

    def go_on(self, action: Any) -> None:
        """Advance by one tick.

        Args:
            action: An array, or a dict of arrays by robot if there are several.

        Raises:
            UsageError: An action is invalid, or `begin` was not called.
            MjsimError: As `ticks`.
        """
        before = self.step.truth
        for name, each in self._by_robot(action).items():
            self._agents[name].wanted = self.actions[name].command(each)
        orders = {name: pilot.order(self._noticed[name]) for name, pilot in self._pilots.items()}
        for name, order in orders.items():
            self.sim.apply(name, order.command)
        self.sim.step()
        self._notice()
        blocked = {name: tuple(e for e in order.events if e.kind == "blocked") for name, order in orders.items()}
        made = self._made(
            before=before,
            wanted={name: order.wanted for name, order in orders.items()},
            command={name: order.command for name, order in orders.items()},
        )
        events = {name: (*blocked[name], *made.events[name]) for name in blocked}
        self._step = replace(made, events=events)

    def observation(self) -> Seen:
        """Return new arrays with the current observations of the controlled robots."""
        seen = {n: {key: channel.value() for key, channel in each.items()} for n, each in self.channels.items()}
        return seen[self.robots[0]] if self.together else seen

    def reward(self) -> float:
        """Return the reward of the last step.

        Raises:
            ModuleFault: The task's function raised, or returned something other than a finite number.
        """
        value = self._evaluated("reward", self.task.reward)
        try:
            number = float(value)  # type: ignore[arg-type]  # anything but a number is reported below
        # The user's object may raise anything.
        except Exception:
            number = math.nan
        if not math.isfinite(number):
            raise self._wrong("reward", self.task.reward, value, "a finite number")
        return number

    def terminated(self) -> bool:
        """Return whether the last step ended the episode.

        Raises:
            ModuleFault: The task's function raised, or returned something other than True or False.
        """
        value = self._evaluated("terminated", self.task.terminated)
        if type(value).__name__ not in ("bool", "bool_"):
            raise self._wrong("terminated", self.task.terminated, value, "True or False")
        return bool(value)

    @property
    def over(self) -> bool:
        """Whether the episode has reached its time limit."""
        return self.sim.tick >= self.length

    def close(self) -> None:
        """Release the renderer and the modules."""
        self._held.close()
        self.sim.close()

    def _place(self, seed: int) -> None:
        taken: list[Taken] = [
            (pose.x, pose.y, self.sim.robots[name].radius)
            for name, pose in self.sim.truths().items()
            if name not in self._places
        ]
        for name, places in self._places.items():
            pose = places.draw(stream(seed, name, "environment/start"), taken)
            self.sim.move(name, pose, anywhere=True)
            taken.append((pose.x, pose.y, self.sim.robots[name].radius))

    def _robot_info(self, name: str) -> RobotInfo:
        """Return the data sheet of a robot for its modules, with the start of this episode."""
        info = self.sim.robots[name]
        return replace(info, prior=self.sim.truth(name)) if name in self._places else info

    def _notice(self) -> None:
        seen = {name: self.sim.sense(name) for name in self._pilots}
        self._noticed = {name: pilot.notice(seen[name]) for name, pilot in self._pilots.items()}
        for name, channels in self.channels.items():
            for channel in channels.values():
                channel.update(self._noticed[name])

    def _made(
        self,
        *,
        before: Mapping[str, Pose],
        wanted: Mapping[str, Command | WheelCommand],
        command: Mapping[str, Command | WheelCommand],
    ) -> Step:
        return Step(
            time=self.sim.time,
            truth=self.sim.truths(),
            before=before,
            things=self.sim.things(),
            seen={name: noticed.seen for name, noticed in self._noticed.items()},
            belief={name: noticed.belief for name, noticed in self._noticed.items()},
            wanted=wanted,
            command=command,
            events={name: noticed.events for name, noticed in self._noticed.items()},
            happened=self.sim.happened(),
        )

    def _by_robot(self, action: Any) -> Mapping[str, object]:
        if self.together:
            return {self.robots[0]: action}
        if not isinstance(action, Mapping):
            raise UsageError(f"the action is {action!r}; it must be a dict by robot: {', '.join(self.robots)}")
        for name in action:
            if name not in self.actions:
                raise UsageError(f"no robot '{name}' is controlled by actions{did_you_mean(str(name), self.robots)}")
        if missing := [name for name in self.robots if name not in action]:
            raise UsageError(f"no action for robot '{missing[0]}'; each step needs one of {', '.join(self.robots)}")
        return action

    def _evaluated(self, part: str, function: Callable[[Step], object]) -> object:
        """Return the result of a function of the task for the last step."""
        step = self.step
        try:
            return function(step)
        except KeyboardInterrupt:
            raise
        # This is the boundary to user code: all its exceptions are reported in one line.
        except BaseException as error:
            raise self._fault(part, function, error_text(error)) from error

    def _wrong(self, part: str, function: object, value: object, right: str) -> ModuleFault:
        try:
            shown = one_line(repr(value)[:_MAX_CHARACTERS])
        # Its `__repr__` is user code, too.
        except Exception:
            shown = kind_of(value)
        return self._fault(part, function, f"returned {shown}; it must be {right}")

    def _fault(self, part: str, function: object, problem: str) -> ModuleFault:
        name = getattr(function, "__name__", type(function).__name__)
        return ModuleFault(f"{part} {name} at {self.sim.time:.2f} s {problem}")


def _stripped(world: World, driven: Sequence[str], observations: Sequence[str] | None) -> World:
    """Return the world without unused modules and sensors of controlled robots.

    The rest stays the same to the last bit, because each sensor has its own random streams.
    """
    chosen = set(observations or ())
    drivers, robots = dict(world.run.drivers), list(world.robots)
    for index, robot in enumerate(robots):
        if robot.name not in driven:
            continue
        modules = drivers.get(robot.name, Modules()).model_copy(update={"navigator": None})
        if not chosen & {"sightings", "estimate"}:
            modules = modules.model_copy(update={"observer": None})
        if "estimate" not in chosen:
            modules = modules.model_copy(update={"estimator": None})
        drivers[robot.name] = modules
        has_observers = modules.observer or modules.estimator or not isinstance(modules.avoidance, bool)
        if observations is not None and not has_observers:
            sensors = tuple(sensor for sensor in robot.sensors if _is_chosen(sensor, chosen))
            robots[index] = robot.model_copy(update={"sensors": sensors})
    run = world.run.model_copy(update={"drivers": drivers})
    return world.model_copy(update={"robots": tuple(robots), "run": run})


def _is_chosen(sensor: AnySensor, chosen: Collection[str]) -> bool:
    return name_of(sensor) in chosen or codec_of(sensor.kind).field in chosen


MIN_CLEARANCE = 0.05
"""Minimum distance around the body [m]."""
MAX_TRIES = 10_000
"""Number of places tried before giving up."""
MAX_START_DISTANCE = 5.0
"""Maximum distance from the start along each axis, in a world without walls [m]."""

Taken = tuple[float, float, float]
"""Position [m, m] and radius [m] of a robot already placed."""


class Starts:
    """Draws poses for one robot."""

    def __init__(self, world: World, robot: Robot) -> None:
        """Compute the reachable area."""
        from shapely import Polygon, prepare, unary_union

        self._robot, self._solids = robot, Solids(world)
        self._radius = robot.body.radius + MIN_CLEARANCE
        doors = [Polygon(leaf.pose(0.0).transform(leaf.outline())) for leaf in leaves(world)]
        self._doors = unary_union(doors).buffer(self._radius)
        self._free = _reachable(world, robot, self._radius)
        prepare(self._free)
        prepare(self._doors)

    def draw(self, rng: Generator, taken: Sequence[Taken]) -> Pose:
        """Return a pose, uniformly distributed over free places and headings.

        Args:
            rng: Random generator.
            taken: Positions of other robots.

        Raises:
            UsageError: No place was found.
        """
        west, south, east, north = self._free.bounds
        for _ in range(MAX_TRIES):
            x, y, heading = rng.uniform((west, south, -math.pi), (east, north, math.pi)).tolist()
            if self._fits(x, y) and all(
                math.hypot(x - other_x, y - other_y) > self._radius + radius for other_x, other_y, radius in taken
            ):
                return Pose(x, y, heading)
        raise UsageError(f"no free place for robot '{self._robot.name}' in {MAX_TRIES} tries; leave out random_starts")

    def _fits(self, x: float, y: float) -> bool:
        from shapely import Point

        spot = Point(x, y)
        if not self._free.intersects(spot) or self._doors.intersects(spot):
            return False
        around = disc((x, y), self._radius, sides=64)
        return self._solids.reached(around, depth=0.0, low=0.0, high=self._robot.body.height) is None


def _reachable(world: World, robot: Robot, radius: float) -> "BaseGeometry":
    """Return the part of the free plane that contains a robot's start, or is closest to it, with doors open."""
    from shapely import Point, box, get_parts

    start, walls = Point(robot.at), solid(world, height=min(SLICE, robot.body.height / 2))
    bounds = box(*walls.bounds) if world.walls else start.buffer(MAX_START_DISTANCE, cap_style="square")
    free = bounds.difference(walls.buffer(radius))
    if free.is_empty:
        raise UsageError(f"no free place for robot '{robot.name}'; it is too wide for this world")
    nearest: BaseGeometry = min(get_parts(free), key=start.distance)
    return nearest
