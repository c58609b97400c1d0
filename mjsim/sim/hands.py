"""Hands of people that events have moved: upper bodies are turned as inverse kinematics have them."""

from collections.abc import Mapping

import mujoco
import numpy as np

from mjsim.geometry import Array
from mjsim.world import Person, World

UPPER = (
    *("abdomen", "thorax", "neck", "head"),
    *("left_upper_arm", "left_forearm", "left_hand", "right_upper_arm", "right_forearm", "right_hand"),
)
"""Segments that move when a hand does; hips and legs stay."""

Reach = tuple[str, tuple[float, float, float]]
"""Which hand, and where its grip is to be, world frame [m]."""


class LedPeople:
    """Postures of the people of a world whose hands were led; each on the way to the last is worked out once."""

    def __init__(self, world: World) -> None:
        """Know nothing yet."""
        self._world = world
        self._people = {person.name: person for person in world.people}
        self._starts: dict[str, tuple[Array, Array]] = {}
        self._ways: dict[str, tuple[list[Reach], list[Array]]] = {}
        self._grips: dict[str, tuple[tuple[Reach, ...], dict[str, Array]]] = {}

    def values(self, name: str, reaches: tuple[Reach, ...]) -> Array:
        """Return the values of a figure's joints after reaches, shape (n,) [rad]."""
        if name not in self._ways:
            self._ways[name] = [], [self._start(self._people[name])[0]]
        way, postures = self._ways[name]
        shared = next((k for k, (old, new) in enumerate(zip(way, reaches, strict=False)) if old != new), None)
        shared = min(len(way), len(reaches)) if shared is None else shared
        if shared < len(reaches):
            del way[shared:], postures[shared + 1 :]
            for reach in reaches[shared:]:
                postures.append(self._led(name, postures[-1], reach))
                way.append(reach)
        return postures[len(reaches)]

    def grips(self, reached: Mapping[str, tuple[Reach, ...]]) -> dict[str, dict[str, Array]]:
        """Return where the grips of all hands are, by person and side, world frame, shape (3,) each [m]."""
        for name, person in self._people.items():
            reaches = reached.get(name, ())
            if name not in self._grips or self._grips[name][0] != reaches:
                self._grips[name] = reaches, self._placed(person, reaches)
        return {name: grips for name, (_, grips) in self._grips.items()}

    def _placed(self, person: Person, reaches: tuple[Reach, ...]) -> dict[str, Array]:
        poses = person.figure.poses(self.values(person.name, reaches), self._start(person)[1])
        marks = {side: person.figure.landmarks[f"{side}_grip"] for side in ("left", "right")}
        return {
            side: poses[mark.segment][:3, :3] @ mark.at + poses[mark.segment][:3, 3] for side, mark in marks.items()
        }

    def _start(self, person: Person) -> tuple[Array, Array]:
        """Return the values of the joints before any reach, and world from pelvis."""
        if person.name not in self._starts:
            self._starts[person.name] = self._seated(person) if person.seat is not None else _standing(person)
        return self._starts[person.name]

    def _seated(self, person: Person) -> tuple[Array, Array]:
        from mjsim.posture import seated

        found = seated(self._world, person)
        return found.values, found.world_from_pelvis

    def _led(self, name: str, values: Array, reach: Reach) -> Array:
        """Return the values of a figure's joints after one reach more."""
        from mjsim.posture import lead_hands

        (side, to), person = reach, self._people[name]
        return lead_hands(person.figure, values, self._start(person)[1], {side: np.array(to)}).values


class LedHands:
    """Turns the segments of people in a model, forwards or backwards in time; the model is changed in place."""

    def __init__(self, model: mujoco.MjModel, world: World) -> None:
        """Keep how the segments are turned at the start."""
        self._model, self._led = model, LedPeople(world)
        self._people = {person.name: person for person in world.people}
        self._start = model.body_quat.copy()
        self._shown: Mapping[str, tuple[Reach, ...]] = {}

    def show(self, reached: Mapping[str, tuple[Reach, ...]]) -> None:
        """Let hands be where they were led, one after the other; those of all others as at the start."""
        changed = [name for name in {**self._shown, **reached} if self._shown.get(name) != reached.get(name)]
        for name in changed:
            if name in self._people:
                self._turn(self._people[name], reached.get(name, ()))
        self._shown = dict(reached)

    def _turn(self, person: Person, reaches: tuple[Reach, ...]) -> None:
        bodies = {segment: self._model.body(f"{person.name}/{segment}").id for segment in UPPER}
        if not reaches:
            for body in bodies.values():
                self._model.body_quat[body] = self._start[body]
            return
        segments, poses = person.figure.segments, person.figure.poses(self._led.values(person.name, reaches))
        for segment, body in bodies.items():
            turned = poses[str(segments[segment].parent)][:3, :3].T @ poses[segment][:3, :3]
            mujoco.mju_mat2Quat(self._model.body_quat[body], turned.ravel())


def _standing(person: Person) -> tuple[Array, Array]:
    return person.posture(), person.poses()["pelvis"]


def is_upper(model: mujoco.MjModel, body: int) -> bool:
    """Return whether a body is a segment of a person that moves when a hand does."""
    person, _, segment = model.body(body).name.rpartition("/")
    return segment in UPPER and mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, f"{person}/pelvis") > 0
