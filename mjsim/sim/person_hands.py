"""Moved hands of people: poses of their upper bodies by inverse kinematics."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import overload

import mujoco
import numpy as np

from mjsim.geometry import Array
from mjsim.models import quaternion_of
from mjsim.people import columns
from mjsim.sim.person_segments import UPPER
from mjsim.world import HandLed, HandMotion, Looks, Person, World

USUAL_SPEED = 0.8
"""Peak speed of a hand [m/s]."""
MAX_SPEED = 1.0
"""Largest speed of a hand, also when its goal changes during the motion [m/s]."""
MIN_DURATION = 0.1
"""Shortest duration of a motion [s]."""
DURATION_SAMPLES = 64
"""Samples of a motion for its duration."""
STRETCH_RATIO = 1.2
"""Factor by which a motion that would be too fast, during another one, is lengthened, repeatedly."""
MAX_STRETCHES = 12
"""Maximum number of such repetitions."""
ARRIVAL_DISTANCE = 0.002
"""Distance from its goal within which a hand counts as arrived [m]."""


@dataclass(slots=True)
class _LedCourse:
    """Motions of the hands of one person: the posture at the end of each motion, and its times."""

    aims: list[tuple[str, tuple[float, float, float] | None]]
    """Hand and goal of each motion."""
    postures: list[Array]
    """Joint values before all motions, then those at the end of each [rad]."""
    short: list[float]
    """Remaining distance of the hand from its goal [m]."""
    times: list[tuple[float, float]]
    """Start and duration of each motion [s]."""
    requested: Sequence[HandLed] | None = None
    """The last requested motions, which are computed."""


class LedPeople:
    """Postures of the people of a world whose hands were moved; each motion is computed once.

    Hands move like those of people: the joints move from posture to posture with minimum jerk, so that hands reach
    `USUAL_SPEED`. If the goal of a hand changes during a motion, the motions blend without a stop.

    References:
        Flash, Hogan: The Coordination of Arm Movements, Journal of Neuroscience 5 (1985), equation 2.
    """

    def __init__(self, world: World) -> None:
        """Start without motions."""
        self._world = world
        self._people = {person.name: person for person in world.people}
        self._starts: dict[str, tuple[Array, Array]] = {}
        self._courses: dict[str, _LedCourse] = {}
        self._grips: dict[str, tuple[object, dict[str, Array]]] = {}
        self._outlines: dict[str, tuple[object, list[tuple[Array, str]]]] = {}

    def values(self, name: str, turns: Sequence[HandLed], time: float = math.inf) -> Array:
        """Return the values of a figure's joints, shape (n,) [rad].

        Args:
            name: Name of the person.
            turns: Motions of its hands, in order of time.
            time: Time [s]; by default after all motions.
        """
        return self._blend(self._course(name, turns), len(turns), time)

    def arrival(self, name: str, turns: Sequence[HandLed]) -> float:
        """Return the time at which the hands of a person reach their last goals [s]; -inf without motions."""
        begin, seconds = self._course(name, turns).times[len(turns) - 1] if turns else (-math.inf, 0.0)
        return begin + seconds

    def short(self, name: str, turns: Sequence[HandLed]) -> float:
        """Return the remaining distance of the last moved hand from its goal [m]; 0 if it reaches it."""
        far = self._course(name, turns).short[len(turns) - 1] if turns else 0.0
        return far if far > ARRIVAL_DISTANCE else 0.0

    def computed(self, reached: Mapping[str, tuple[HandLed, ...]]) -> dict[str, tuple[HandLed, ...]]:
        """Return motions with computed joint values, so that other viewers need not compute them again."""
        found = {}
        for name, turns in reached.items():
            course = self._course(name, turns)
            found[name] = tuple(
                turn if turn.motion else replace(turn, motion=HandMotion(values, short, seconds))
                for turn, values, short, (_, seconds) in zip(
                    turns, course.postures[1:], course.short, course.times, strict=False
                )
            )
        return found

    def grips(self, looks: Looks | None) -> dict[str, dict[str, Array]]:
        """Return the positions of the grips of all hands, by person and side, world frame, shape (3,) each [m]."""
        for name, person in self._people.items():
            turns, time = key = self._moment(name, looks)
            if name not in self._grips or self._grips[name][0] != key:
                self._grips[name] = key, self._placed(person, self.values(name, turns, time))
        return {name: grips for name, (_, grips) in self._grips.items()}

    def outlines(self, looks: Looks | None) -> dict[str, list[tuple[Array, str]]]:
        """Return the outlines from above of people whose hands were moved, by name.

        Outlines of segments, the lowest first, each with its colour; convex, world frame, counter-clockwise, shape
        (n, 2) [m].
        """
        found: dict[str, list[tuple[Array, str]]] = {}
        for name, person in self._people.items():
            turns, time = key = self._moment(name, looks)
            if not turns:
                continue
            if name not in self._outlines or self._outlines[name][0] != key:
                poses = person.figure.poses(self.values(name, turns, time), self._start(person)[1])
                segments = columns(person.skins, poses).items()
                self._outlines[name] = key, [(outline, person.color_of(segment)) for segment, (outline, *_) in segments]
            found[name] = self._outlines[name][1]
        return found

    def _moment(self, name: str, looks: Looks | None) -> tuple[tuple[HandLed, ...], float]:
        """Return the motions of a person's hands up to a time, and that time, at most the end of the motions [s]."""
        turns = () if looks is None else looks.reached.get(name, ())
        return turns, math.inf if looks is None else min(looks.time, self.arrival(name, turns))

    def _placed(self, person: Person, values: Array) -> dict[str, Array]:
        """Return the positions of the grips by side, shape (..., 3) [m], for values of shape (..., n)."""
        spots = person.figure.spots(person.figure.poses(values, self._start(person)[1]))
        return {side: spots[f"{side}_grip"] for side in ("left", "right")}

    def _start(self, person: Person) -> tuple[Array, Array]:
        """Return the joint values before any motion, and world_from_pelvis."""
        if person.name not in self._starts:
            self._starts[person.name] = self._seated(person) if person.seat is not None else _standing(person)
        return self._starts[person.name]

    def _seated(self, person: Person) -> tuple[Array, Array]:
        from mjsim.posture import seated

        found = seated(self._world, person)
        return found.values, found.world_from_pelvis

    def _course(self, name: str, turns: Sequence[HandLed]) -> _LedCourse:
        """Return a person's motions, up to these at least; new ones are computed."""
        if name not in self._courses:
            self._courses[name] = _LedCourse([], [self._start(self._people[name])[0]], [], [])
        course = self._courses[name]
        if course.requested is turns:
            return course
        aims = [(turn.hand, turn.to) for turn in turns]
        if (known := _shared(course.aims, aims)) < len(aims):
            del course.aims[known:], course.postures[known + 1 :], course.short[known:], course.times[known:]
            for number in range(known, len(aims)):
                known_motion = turns[number].motion
                if known_motion is not None:
                    values, far = known_motion.values, known_motion.short
                else:
                    values, far = self._aimed(name, course.postures, aims[: number + 1])
                course.aims.append(aims[number])
                course.postures.append(values)
                course.short.append(far)
        begins = [turn.time for turn in turns]
        if (known := _shared([begin for begin, _ in course.times], begins)) < len(begins):
            del course.times[known:]
            for number in range(known, len(begins)):
                course.times.append((begins[number], 0.0))
                motion = turns[number].motion
                seconds = self._duration(name, course, number + 1) if motion is None else motion.seconds
                course.times[number] = begins[number], seconds
        course.requested = turns
        return course

    def _aimed(
        self, name: str, postures: Sequence[Array], aims: Sequence[tuple[str, tuple[float, float, float] | None]]
    ) -> tuple[Array, float]:
        """Return the joint values after the last motion, and the remaining distance of the hand [m]."""
        from mjsim.posture import lead_hands

        (side, to), before, start = aims[-1], postures[-1], postures[0]
        if to is None:
            # The trunk is released as well, as far as the other hand permits.
            side, to = next(((other, place) for other, place in reversed(aims) if other != side), (side, None))
            before = start
        if to is None:
            return start, 0.0
        person = self._people[name]
        found = lead_hands(person.figure, before, self._start(person)[1], {side: np.array(to)})
        return found.values, 0.0 if aims[-1][1] is None else found.short.get(side, 0.0)

    def _blend(self, course: _LedCourse, count: int, time: float) -> Array:
        """Return the joint values at a time, after a number of motions, shape (n,) [rad]."""
        arrived = (k for k in range(count, 0, -1) if sum(course.times[k - 1]) <= time)
        first = next(arrived, 0)
        values = course.postures[first]
        for (begin, seconds), aim in zip(
            course.times[first:count], course.postures[first + 1 : count + 1], strict=True
        ):
            if time > begin:
                values = values + _least_jerk((time - begin) / seconds) * (aim - values)
        return values

    def _duration(self, name: str, course: _LedCourse, count: int) -> float:
        """Return the duration of the last of a number of motions, so that no hand is too fast [s]."""
        person, begin, aim = self._people[name], course.times[count - 1][0], course.postures[count]
        share = _least_jerk(np.linspace(0.0, 1.0, DURATION_SAMPLES + 1))[:, None]

        def fastest(values: Array, seconds: float) -> float:
            grips = self._placed(person, values + share * (aim - values)).values()
            return (
                max(float(np.linalg.norm(np.diff(grip, axis=0), axis=1).max()) for grip in grips)
                * DURATION_SAMPLES
                / seconds
            )

        def before(seconds: float) -> Array:
            times = begin + seconds * np.linspace(0.0, 1.0, DURATION_SAMPLES + 1)
            return np.stack([self._blend(course, count - 1, time) for time in times.tolist()])

        seconds = max(MIN_DURATION, fastest(before(0.0), 1.0) / USUAL_SPEED)
        for _ in range(MAX_STRETCHES):
            if fastest(before(seconds), seconds) <= MAX_SPEED:
                break
            seconds *= STRETCH_RATIO
        return seconds


class LedHands:
    """Rotates the segments of people in a model, forwards or backwards in time; changes the model in place."""

    def __init__(self, model: mujoco.MjModel, world: World) -> None:
        """Store the initial orientations of the segments."""
        self._model = model
        self.people = LedPeople(world)
        """Motions of their hands."""
        self._people = {person.name: person for person in world.people}
        self._start = model.body_quat.copy()
        self._shown: dict[str, tuple[tuple[HandLed, ...], float]] = {}

    def show(self, reached: Mapping[str, tuple[HandLed, ...]], time: float) -> None:
        """Set the hands to a time [s] of successive motions; those of all other people as at the start."""
        for name in {**self._shown, **reached}:
            if name in self._people:
                turns = reached.get(name, ())
                shown = turns, min(time, self.people.arrival(name, turns))
                if self._shown.get(name) != shown:
                    self._turn(self._people[name], *shown)
                    self._shown[name] = shown

    def _turn(self, person: Person, turns: tuple[HandLed, ...], time: float) -> None:
        bodies = {segment: self._model.body(f"{person.name}/{segment}").id for segment in UPPER}
        if not turns:
            for body in bodies.values():
                self._model.body_quat[body] = self._start[body]
            return
        segments, poses = person.figure.segments, person.figure.poses(self.people.values(person.name, turns, time))
        for segment, body in bodies.items():
            turned = poses[str(segments[segment].parent)][:3, :3].T @ poses[segment][:3, :3]
            self._model.body_quat[body] = quaternion_of(turned)


@overload
def _least_jerk(share: float) -> float: ...
@overload
def _least_jerk(share: Array) -> Array: ...
def _least_jerk(share: float | Array) -> float | Array:
    """Return the progress of a minimum-jerk motion at a relative time, both 0 to 1."""
    return share**3 * (10.0 - 15.0 * share + 6.0 * share**2)


def _shared(old: Sequence[object], new: Sequence[object]) -> int:
    """Return the length of the common prefix of two sequences."""
    different = (k for k, (first, second) in enumerate(zip(old, new, strict=False)) if first != second)
    return next(different, min(len(old), len(new)))


def _standing(person: Person) -> tuple[Array, Array]:
    return person.posture(), person.poses()["pelvis"]
