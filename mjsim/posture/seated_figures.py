"""Seated figures: hip point on the seat within its travel, back on the backrest, hands, feet and eyes on targets."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from mjsim.geometry import Array
from mjsim.models import pose_keys
from mjsim.people import SIDES, Figure
from mjsim.posture.comfort import SIGHT_DOWN, preferred_values
from mjsim.posture.goals import TOOLS, Goals, Seating
from mjsim.posture.posture_contacts import FEET, HANDS, Contact, GazeContact, PlaneContact, PointContact
from mjsim.posture.solve import Preference, Solution, range_preference, solve_posture, stretch_posture

EYES = "eyes"
"""The site between the pupils."""
PELVIS_TILT = math.radians(40.0)
"""Maximum tilt of the pelvis from the backrest, in both directions; assumed, no source [rad]."""
SIGHT = np.array([math.cos(SIGHT_DOWN), 0.0, -math.sin(SIGHT_DOWN)])
"""The normal line of sight, frame of the head, shape (3,)."""
ROOT = ("seat_along", "seat_up", "pelvis_tilt")
"""Joints of a seated figure before its own."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Seated:
    """A seated figure."""

    values: Array
    """Joint values of the figure, in order, shape (n,) [rad]."""
    world_from_pelvis: Array
    """Pose of the pelvis, shape (4, 4) [m]."""
    set_by: tuple[float, float]
    """Setting of the seat relative to the middle of its travel, along and up [m]."""
    solution: Solution

    @property
    def errors(self) -> Mapping[str, float]:
        """Remaining error by contact [m; the gaze in rad]."""
        return self.solution.errors

    @property
    def missed(self) -> tuple[str, ...]:
        """Contacts that are out of reach."""
        return self.solution.missed


class Sitter:
    """A figure on a seat, compiled once for any posture that its joints and the seat allow."""

    def __init__(self, figure: Figure, seating: Seating) -> None:
        """Compile the figure as a tree of joints."""
        self.figure, self.seating = figure, seating
        self.model: mujoco.MjModel = _tree(figure, seating).compile()
        lean = seating.back or 0.0
        preferred = {"pelvis_tilt": -lean, **preferred_values(lean)}
        self.preference: Preference = range_preference(self.model, preferred, free=ROOT[:2])

    def sit(self, goals: Goals, *, more: Sequence[Contact] = (), starts: Sequence[Array] = ()) -> Seated:
        """Return the posture that meets goals and is closest to the preferred one.

        Args:
            goals: The goals.
            more: Additional contacts.
            starts: Additional initial joint values of the model, shape (nq,) each.
        """
        contacts = [*self.contacts(goals), *more]
        found = solve_posture(self.model, contacts, self.preference, starts=starts)
        return self.seated(found)

    def stretch(self, goals: Goals, contacts: Sequence[Contact], aim: Contact, *, start: Array | None = None) -> Seated:
        """Return the posture that comes as close to an aim as goals and contacts allow.

        Args:
            goals: Goals that must hold.
            contacts: Contacts that must hold.
            aim: The aim, such as a point that is out of reach.
            start: Initial joint values of the model, shape (nq,); by default the preferred ones.
        """
        firm = [*self.contacts(goals), *contacts]
        begin = self.preference.values if start is None else start
        return self.seated(stretch_posture(self.model, firm, aim, self.preference, start=begin))

    def seated(self, solution: Solution) -> Seated:
        """Return a solution as a seated figure."""
        data = mujoco.MjData(self.model)
        data.qpos[:] = solution.values
        mujoco.mj_kinematics(self.model, data)
        pose = np.eye(4)
        pelvis = self.model.body("pelvis").id
        pose[:3, :3], pose[:3, 3] = data.xmat[pelvis].reshape(3, 3), data.xpos[pelvis]
        root = {self.model.joint(number).name: solution.values[number] for number in range(self.model.njnt)}
        own = np.array([root[name] for name in self.figure.joints])
        along, up = (float(root.get(name, 0.0)) for name in ROOT[:2])
        return Seated(values=own, world_from_pelvis=pose, set_by=(along, up), solution=solution)

    def contacts(self, goals: Goals) -> Iterator[Contact]:
        """Yield the contacts for goals."""
        if self.seating.back is not None and goals.leans:
            slope = self.seating.back
            normal = self.seating.world_from_seat[:3, :3] @ (math.cos(slope), 0.0, math.sin(slope))
            yield PlaneContact(name="back", site="chest_back", base="buttock", normal=normal)
        for side in SIDES:
            if side in goals.feet:
                yield PointContact(name=f"{side} foot", site=f"{side}_ball", target=goals.feet[side], rank=FEET)
            elif goals.floor is not None:
                for spot in ("heel", "ball"):
                    yield PlaneContact(
                        name=f"{side} {spot} on the floor",
                        site=f"{side}_{spot}",
                        normal=np.array([0.0, 0.0, 1.0]),
                        offset=goals.floor,
                        rank=FEET,
                    )
        for side, (touch, point) in goals.hands.items():
            yield PointContact(name=f"{side} hand", site=f"{side}_{TOOLS[touch]}", target=point, rank=HANDS)
        if goals.gaze is not None:
            yield GazeContact(name="gaze", site=EYES, target=goals.gaze, sight=SIGHT)


def _tree(figure: Figure, seating: Seating) -> mujoco.MjSpec:
    """Return a figure on a seat as bodies, joints and landmarks only."""
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    bodies: dict[str | None, mujoco.MjsBody] = {None: spec.worldbody.add_body(**pose_keys(seating.world_from_seat))}
    for name, segment in figure.segments.items():
        at = (0.0, 0.0, 0.0) if segment.parent is None else segment.at
        body = bodies[name] = bodies[segment.parent].add_body(name=name, pos=at)
        # Masses do not affect kinematics, but moving bodies must have one.
        body.mass, body.inertia, body.explicitinertial = 1.0, [1.0, 1.0, 1.0], True
        if segment.parent is None:
            _add_root(body, seating)
        for joint in segment.joints:
            _add_joint(body, joint.name, joint.axis, (joint.low, joint.high))
    for name, mark in figure.landmarks.items():
        bodies[mark.segment].add_site(name=name, pos=mark.at)
    pupils = [figure.landmarks[f"{side}_eye"] for side in SIDES]
    bodies[pupils[0].segment].add_site(name=EYES, pos=np.mean([pupil.at for pupil in pupils], axis=0))
    return spec


def _add_root(body: mujoco.MjsBody, seating: Seating) -> None:
    """Add the joints for seat adjustment and tilt of the pelvis."""
    for name, axis, length in zip(ROOT, np.eye(3)[[0, 2]], seating.travel, strict=False):
        if length > 0.0:
            slide = _add_joint(body, name, axis, (-length / 2, length / 2))
            slide.type = mujoco.mjtJoint.mjJNT_SLIDE
    lean = seating.back or 0.0
    _add_joint(body, ROOT[2], (0.0, 1.0, 0.0), (-lean - PELVIS_TILT, -lean + PELVIS_TILT))


def _add_joint(
    body: mujoco.MjsBody, name: str, axis: Sequence[float] | Array, span: tuple[float, float]
) -> mujoco.MjsJoint:
    return body.add_joint(
        name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=axis, limited=mujoco.mjtLimited.mjLIMITED_TRUE, range=span
    )
