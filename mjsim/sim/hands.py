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


class LedHands:
    """Turns the segments of people in a model, forwards or backwards in time; the model is changed in place."""

    def __init__(self, model: mujoco.MjModel, world: World) -> None:
        """Keep how the segments are turned at the start."""
        self._model, self._world = model, world
        self._people = {person.name: person for person in world.people}
        self._start = model.body_quat.copy()
        self._shown: Mapping[str, tuple[Reach, ...]] = {}
        self._known: dict[tuple[str, tuple[Reach, ...]], Array] = {}

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
        segments, poses = person.figure.segments, person.figure.poses(self._values(person, reaches))
        for segment, body in bodies.items():
            turned = poses[str(segments[segment].parent)][:3, :3].T @ poses[segment][:3, :3]
            mujoco.mju_mat2Quat(self._model.body_quat[body], turned.ravel())

    def _values(self, person: Person, reaches: tuple[Reach, ...]) -> Array:
        """Return the values of the figure's joints after reaches, shape (n,) [rad]."""
        key = person.name, reaches
        if key not in self._known:
            self._known[key] = self._led(person, reaches)
        return self._known[key]

    def _led(self, person: Person, reaches: tuple[Reach, ...]) -> Array:
        from mjsim.posture import lead_hands, seated

        if person.seat is None:
            values, root = person.posture(), person.poses()["pelvis"]
        else:
            found = seated(self._world, person)
            values, root = found.values, found.world_from_pelvis
        if not reaches:
            return values
        *before, (side, to) = reaches
        values = self._values(person, tuple(before))
        return lead_hands(person.figure, values, root, {side: np.array(to)}).values


def is_upper(model: mujoco.MjModel, body: int) -> bool:
    """Return whether a body is a segment of a person that moves when a hand does."""
    person, _, segment = model.body(body).name.rpartition("/")
    return segment in UPPER and mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, f"{person}/pelvis") > 0
