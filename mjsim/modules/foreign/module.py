"""A module in a separate process, in all roles of modules."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from numpy.random import Generator

from mjsim.interface import (
    BeaconInfo,
    Command,
    Estimate,
    FastReading,
    Numbers,
    Observation,
    RobotInfo,
    Shown,
    Sighting,
    Tree,
    WheelCommand,
    WorldMap,
    command_tree,
    estimate_tree,
    fast_tree,
    observation_tree,
    octave_names,
    robot_tree,
)
from mjsim.modules.foreign.module_answers import FIELDS, Answer, command_of, estimate_of, sightings_of, torques_of
from mjsim.modules.foreign.module_process import Ended
from mjsim.modules.foreign.shown_values import shown_of
from mjsim.modules.hosts import Failed, Hosted


class Engine(ABC):
    """Communicates with a process in its language."""

    counts_last: bool
    """Whether the item index of stacks is the last in its answers."""

    @abstractmethod
    def start(self, robot: Mapping[str, Tree], rng: Generator, fields: Sequence[str]) -> bool:
        """Start the process; return whether it needs pictures."""

    @abstractmethod
    def call(self, method: str, given: Mapping[str, Tree]) -> Answer:
        """Return the answer of the process."""

    @abstractmethod
    def close(self) -> None:
        """End the process; a second call does nothing."""


class ForeignModule(Hosted):
    """A module of one role: its methods encode the arguments, and decode the answers."""

    def __init__(self, engine: Engine, *, role: str, name: str, place: str, options: Mapping[str, Any]) -> None:
        """Store the parts; the process is not started."""
        self._engine, self._role, self._name, self._options = engine, role, name, dict(options)
        self.place = place
        self._catalogue: Mapping[str, BeaconInfo] = {}
        self._map: WorldMap | None = None
        self._numbers, self._pictures = Numbers(), False
        self._arms: dict[str, str] = {}
        self._shown: tuple[Shown, ...] = ()

    @property
    def name(self) -> str:
        """The file, or the program."""
        return self._name

    def take_world(self, catalogue: Mapping[str, BeaconInfo], map: WorldMap | None) -> None:
        """Store the data for its start."""
        self._catalogue, self._map = catalogue, map

    def start(self, robot: RobotInfo, *given: Any) -> None:
        """Start the process and send it all constant data."""
        *parts, rng = given
        self._numbers = Numbers(list(self._catalogue))
        fields = octave_names(robot.arms) if self._engine.counts_last else {name: name for name in robot.arms}
        self._arms = {field: name for name, field in fields.items()}
        tree = robot_tree(robot, self._catalogue, self._map, pictures=self._role == "observer")
        part = {"part": parts[0]} if self._role == "controller" else {}
        sheet = {**tree, **part, "role": self._role, "options": self._options}
        self._pictures = self._begin(sheet, rng)

    def observe(self, seen: Observation) -> Sequence[Sighting]:
        """Return the sightings of an observer."""
        answer = self._call("observe", obs=self._seen(seen))
        return sightings_of(answer, self._numbers, seen, counts_last=self._engine.counts_last)

    def update(self, seen: Observation) -> Estimate:
        """Return the estimate of an estimator."""
        answer = self._call("update", obs=self._seen(seen))
        return estimate_of(answer, self._numbers, counts_last=self._engine.counts_last)

    def command(self, seen: Observation, belief: Estimate) -> Command | WheelCommand:
        """Return the command of a navigator."""
        answer = self._call("command", obs=self._seen(seen), est=estimate_tree(belief, self._numbers))
        self._shown = shown_of(answer.get("show"), "cmd")
        return command_of(answer, self._arms, counts_last=self._engine.counts_last)

    def show(self) -> tuple[Shown, ...]:
        """Return the items that a navigator showed with its last command."""
        return self._shown

    def adjust(self, command: Command, seen: Observation) -> Command | WheelCommand:
        """Return the command changed by an avoidance."""
        answer = self._call("adjust", cmd=command_tree(command), obs=self._seen(seen))
        safe = command_of(answer, self._arms, counts_last=self._engine.counts_last)
        # An avoidance need not handle arms.
        return replace(safe, joints=command.joints) if isinstance(safe, Command) and not safe.joints else safe

    def torques(self, sensed: FastReading, wanted: Command) -> Sequence[float]:
        """Return the torques of a controller."""
        answer = self._call("torques", fast=fast_tree(sensed), wanted=command_tree(wanted))
        return torques_of(answer, counts_last=self._engine.counts_last)

    def close(self) -> None:
        """End the process."""
        self._engine.close()

    def _seen(self, seen: Observation) -> Tree:
        return observation_tree(seen, self._numbers, pictures=self._pictures)

    def _begin(self, sheet: Mapping[str, Tree], rng: Generator) -> bool:
        try:
            return self._engine.start(sheet, rng, FIELDS[self._role])
        except Ended as ended:
            raise self._failed(ended) from ended

    def _call(self, method: str, **given: Tree) -> Answer:
        try:
            return self._engine.call(method, given)
        except Ended as ended:
            raise self._failed(ended) from ended

    def _failed(self, ended: Ended) -> Failed:
        return Failed(f"{ended}{f' ({self.place})' if self.place else ''}")
