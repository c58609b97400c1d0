"""Mechanisms as MuJoCo bodies: `MECHANISM/BODY`, joints and motors `MECHANISM/JOINT`, loops as equality constraints.

Bodies are compiled in their initial poses, so that the reference of every joint is its value there. A loop is cut at
one joint; constraints close the cut within one step of the physics.
"""

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from mjsim.compile.geom_groups import DARK, make_decor
from mjsim.compile.mechanism_bodies import add_shape, lowest, set_mass, thickness
from mjsim.compile.mechanism_models import add_file_shape
from mjsim.compile.models import LoadedFile, original
from mjsim.geometry import Array
from mjsim.mechanics import Placement, Solid, inverted
from mjsim.models import pose_keys
from mjsim.world import GROUND, CurvePoint, Mechanism, MechanismBody, MechanismJoint, MechanismModel, Spring, World

if TYPE_CHECKING:  # most worlds have no curve
    from mjsim.mechanics import SpaceCurve

MIN_TIME_CONSTANT = 2.0
"""Time constant of a joint limit, in periods of the physics: MuJoCo's own bound."""
MAX_IMPEDANCE = 0.9999
"""Impedance of a constraint: MuJoCo's own upper bound."""
DIGITS = 12
"""Decimals of angles in degrees, so that 30 degrees stay 30 after conversion through radians."""
HUB = 1.6
"""Radius of the visual shape of a joint, in radii of the thinnest rod that it joins."""
JOINT_KINDS = {
    "slide": mujoco.mjtJoint.mjJNT_SLIDE,
    "turn": mujoco.mjtJoint.mjJNT_HINGE,
    "ball": mujoco.mjtJoint.mjJNT_BALL,
}
GHOST = ".ghost"
"""Suffix of the names of the far sides of cut joints."""
MASSLESS_RATIO = 1e-4
"""Mass and moments of inertia of a ghost, relative to the smallest mass and the largest moment of its mechanism."""
CURVE_SEGMENTS, CURVE_RADIUS = 64, 1.5e-3
"""Number of segments in which a curve is drawn, and their radius relative to its length."""
MIN_DEPTH_BELOW_FLOOR = 1e-3
"""A body that starts this far below the floor does not collide with it [m]."""


def add_mechanisms(spec: mujoco.MjSpec, world: World) -> None:
    """Add all mechanisms in their initial configuration, with idle motors."""
    files: dict[str, LoadedFile] = {}
    for mechanism in world.mechanisms:
        _Builder(spec, mechanism, world.run.step, files).build()


def stiff(equality: mujoco.MjsEquality, step: float) -> None:
    """Set a constraint to bring its residual to 0 in one period of the physics [s]: J a = -r' / h - r / h^2.

    Softer ones dissipate energy: a four-bar whose crank turns at 21 rad/s loses a fifth in 4 s at 4 ms.
    """
    equality.solref = [-MAX_IMPEDANCE / step**2, -MAX_IMPEDANCE / step]
    equality.solimp = [MAX_IMPEDANCE, MAX_IMPEDANCE, 0.001, 0.5, 2.0]


def seen_box(mechanism: Mechanism) -> Array:
    """Return the corners of a box around the visual shapes of a mechanism at the start, world frame, (2, 3) [m]."""
    # The corner of a joint's cylinder is farther away than its radius.
    margin = math.sqrt(2.0) * HUB * max(thickness(body) for body in mechanism.bodies)
    return np.asarray(mechanism.spanned() + np.array([[-margin], [margin]]))


class _Builder:
    """Adds one mechanism to a scene."""

    def __init__(self, spec: mujoco.MjSpec, mechanism: Mechanism, step: float, files: dict[str, LoadedFile]) -> None:
        self._spec, self._mechanism, self._step, self._files = spec, mechanism, step, files
        self._assembly = mechanism.assembly
        self._placed: Placement = self._assembly.linkage.place(self._assembly.start)
        self._ground = mechanism.world_from_ground
        self._bodies: dict[str, mujoco.MjsBody] = {GROUND: spec.worldbody}

    def build(self) -> None:
        """Add bodies, joints, loops and motors."""
        for number, joint in enumerate(self._assembly.linkage.joints, start=1):
            name = self._assembly.bodies[number]
            if name.endswith(GHOST):
                self._add_ghost(number, joint.parent, name)
            elif name:
                self._add_body(number, joint.parent, self._mechanism.body(name))
            if name:
                self._add_joints(number, joint.name)
        for name, (ghost, body) in self._assembly.cuts.items():
            if self._assembly.bodies[ghost]:
                self._hold(name, ghost, body)
            else:
                self._close(name)
        self._add_couplings()
        self._add_rods()
        for spring in self._assembly.springs:
            self._add_spring(spring)
        for track in self._assembly.tracks:
            self._add_track(track)
        for item in self._mechanism.joints:
            self._add_hub(item)
        self._add_motors()
        self._let_pass()

    def _full(self, name: str) -> str:
        return f"{self._mechanism.name}/{name}"

    def _add_body(self, number: int, parent: int, item: MechanismBody) -> None:
        poses = self._placed.poses
        pose = inverted(poses[parent]) @ poses[number]
        if parent == 0:
            pose = self._ground @ pose
        body = self._bodies[self._assembly.bodies[parent]].add_body(name=self._full(item.name), **pose_keys(pose))
        set_mass(body, item.solid())
        self._add_shape(body, item)
        self._bodies[item.name] = body

    def _add_shape(self, body: mujoco.MjsBody, item: MechanismBody) -> None:
        if not isinstance(item, MechanismModel):
            add_shape(body, item, self._full(item.name))
            return
        if item.model not in self._files:
            key = f"mechanism:model{len(self._files) + 1}"
            self._files[item.model] = original(self._spec, item.shape, key=key)
        add_file_shape(self._spec, body, item, self._files[item.model], name=self._full(item.name))

    def _add_ghost(self, number: int, parent: int, name: str) -> None:
        """Add an almost massless body for the far side of a joint at which a loop is cut."""
        pose = inverted(self._placed.poses[parent]) @ self._placed.poses[number]
        if parent == 0:
            pose = self._ground @ pose
        carrier = self._bodies[self._assembly.bodies[parent]]
        body = carrier.add_body(name=self._full(name), **pose_keys(pose))
        solids = [each.solid() for each in self._mechanism.bodies]
        body.explicitinertial, body.mass = True, MASSLESS_RATIO * min(solid.mass for solid in solids)
        moment = MASSLESS_RATIO * max(max(solid.inertia[:3]) for solid in solids)
        body.inertia = [max(moment, 1e-9)] * 3
        self._bodies[name] = body

    def _add_joints(self, number: int, name: str) -> None:
        """Add the primitives of a joint to the body that it moves, in their order from the base."""
        tree, item = self._assembly.linkage.joints[number - 1], self._item(name)
        body, pose = self._bodies[self._assembly.bodies[number]], self._placed.poses[number]
        for primitive, column in zip(tree.primitives, tree.columns(), strict=True):
            axis = pose[:3, :3].T @ self._placed.axes[column]
            anchor = pose[:3, :3].T @ (self._placed.anchors[column] - pose[:3, 3])
            value_name = self._assembly.names[column] if primitive.kind != "ball" else name
            added = body.add_joint(name=self._full(value_name), type=JOINT_KINDS[primitive.kind], pos=anchor)
            if primitive.kind != "ball":
                added.axis = axis
                added.ref = self._spec_value(column, float(self._assembly.start[column]))
            self._set_figures(added, item, column - self._assembly.columns[name].start, column)

    def _spec_value(self, column: int, value: float) -> float:
        return value if self._assembly.slides[column] else round(math.degrees(value), DIGITS)

    def _set_figures(self, added: mujoco.MjsJoint, item: MechanismJoint, place: int, column: int) -> None:
        """Set range, spring, damping and friction of one coordinate of a joint."""
        added.stiffness[0], added.damping[0] = item.figures("stiffness")[place], item.figures("damping")[place]
        added.frictionloss = item.figures("friction")[place]
        if added.type == mujoco.mjtJoint.mjJNT_BALL:
            return
        added.springref = self._spec_value(column, item.spread("rest")[place] or 0.0)
        pair = item.range if self._assembly.slides[column] else item.range_deg
        if pair is not None:
            added.limited, added.range = True, list(pair)
            added.solref_limit = [MIN_TIME_CONSTANT * self._step, 1.0]

    def _item(self, name: str) -> MechanismJoint:
        return next(joint for joint in self._mechanism.all_joints if joint.name == name)

    def _hold(self, name: str, ghost: int, body: int) -> None:
        """Weld the far side of a cut joint to its body."""
        sites = []
        for side, number in (("a", ghost), ("b", body)):
            # Both frames coincide at the start.
            sites.append(self._add_site(f"{name}.{side}", number, np.zeros(3)))
        added = self._spec.add_equality(
            name=self._full(f"{name}.0"), type=mujoco.mjtEq.mjEQ_WELD, name1=sites[0], name2=sites[1]
        )
        added.objtype = mujoco.mjtObj.mjOBJ_SITE
        added.data[10] = 1.0  # the same for a torque and a force
        stiff(added, self._step)

    def _add_couplings(self) -> None:
        """Add gears and screws; joint values are relative to the start."""
        for each in self._assembly.couplings:
            names = [self._full(self._assembly.names[column]) for column in (each.first, each.second)]
            added = self._spec.add_equality(
                name=self._full(each.name), type=mujoco.mjtEq.mjEQ_JOINT, name1=names[0], name2=names[1]
            )
            added.objtype = mujoco.mjtObj.mjOBJ_JOINT
            added.data[:5] = [0.0, each.ratio, 0.0, 0.0, 0.0]
            stiff(added, self._step)

    def _add_rods(self) -> None:
        """Add distance constraints between two points: rods, and distances that follow a motion."""
        ends = [(rod.name, rod.ends) for rod in self._assembly.rods]
        ends += [(drive.name, drive.ends) for drive in self._assembly.drives if drive.ends is not None]
        for name, spots in ends:
            first, second = (
                self._add_site(f"{name}.{side}", s.body, s.at) for side, s in zip("ab", spots, strict=True)
            )
            self._tie(name, (first, second), rgba=[0.2, 0.2, 0.2, 1.0])

    def _add_spring(self, spring: Spring) -> None:
        """Add a spring with a damper between two points."""
        tendon = self._spec.add_tendon(name=self._full(spring.name), width=0.012, rgba=[0.75, 0.45, 0.2, 1.0])
        for side, end in zip("ab", spring.ends, strict=True):
            tendon.wrap_site(self._add_site(f"{spring.name}.{side}", end.body, end.at))
        tendon.stiffness, tendon.damping = [spring.stiffness, 0.0, 0.0], [spring.damping, 0.0, 0.0]
        # For MuJoCo, -1 means the initial length.
        tendon.springlength = [-1.0 if spring.rest is None else spring.rest] * 2

    def _tie(self, name: str, sites: tuple[str, str], *, rgba: list[float]) -> None:
        """Keep two sites at their initial distance."""
        tendon = self._spec.add_tendon(name=self._full(name), width=0.008, rgba=rgba)
        for site in sites:
            tendon.wrap_site(site)
        added = self._spec.add_equality(name=self._full(name), type=mujoco.mjtEq.mjEQ_TENDON, name1=self._full(name))
        added.objtype = mujoco.mjtObj.mjOBJ_TENDON
        added.data[:5] = [0.0] * 5
        stiff(added, self._step)

    def _add_track(self, track: CurvePoint) -> None:
        """Hold a point on a curve: constraints of constant length, across the curve at the point."""
        joint = self._assembly.linkage.joints[track.ghost - 1]
        curve, along = joint.primitives[0].curve, float(self._assembly.start[track.column])
        assert curve is not None, "made for it"
        point, lever = self._add_site(f"{track.name}.b", track.spot.body, track.spot.at), curve.length / 4.0
        for count in self._assembly.across(track):
            across = curve.normals(along)[count]
            far = joint.before[:3, :3] @ (curve.place(along) + lever * across) + joint.before[:3, 3]
            name = f"{track.name}.{count}"
            self._tie(name, (self._add_site(f"{track.name}.a{count}", joint.parent, far), point), rgba=[0.0] * 4)
        self._show_curve(curve, joint.parent, joint.before)

    def _show_curve(self, curve: "SpaceCurve", body: int, body_from_curve: Array) -> None:
        """Add the visual shape of a curve."""
        pose = self._ground @ body_from_curve if body == 0 else body_from_curve
        points = curve.sampled(CURVE_SEGMENTS) @ pose[:3, :3].T + pose[:3, 3]
        for ends in pairwise(points):
            geom = self._bodies[self._assembly.bodies[body]].add_geom(
                type=mujoco.mjtGeom.mjGEOM_CAPSULE,
                fromto=np.concatenate(ends),
                size=[curve.length * CURVE_RADIUS, 0.0, 0.0],
            )
            make_decor(geom, DARK)

    def _close(self, name: str) -> None:
        """Hold both sides of a cut together: at one point, and at a second one along its axis if needed."""
        joint, ends = self._item(name), self._assembly.places[name]
        ghost, number = self._assembly.cuts[name]
        placement = self._placed
        tree = self._assembly.linkage.joints[ghost - 1]
        carrier, axis = placement.poses[tree.parent], placement.axes[self._assembly.columns[name].start]
        point = carrier[:3, :3] @ ends[0].at + carrier[:3, 3]
        offsets = [np.zeros(3)]
        if joint.kind != "spherical" and self._assembly.needs_axis(name):
            offsets.append(self._lever() * axis)
        for count, offset in enumerate(offsets):
            sites = []
            for side, body in (("a", tree.parent), ("b", number)):
                pose = placement.poses[body]
                at = pose[:3, :3].T @ (point + offset - pose[:3, 3])
                sites.append(self._add_site(f"{name}.{side}{count}", body, at))
            added = self._spec.add_equality(
                name=self._full(f"{name}.{count}"), type=mujoco.mjtEq.mjEQ_CONNECT, name1=sites[0], name2=sites[1]
            )
            added.objtype = mujoco.mjtObj.mjOBJ_SITE
            stiff(added, self._step)

    def _lever(self) -> float:
        """Return the distance along an axis to the second point of a cut [m]: about the mechanism's size."""
        points = self._placed.poses[:, :3, 3]
        return max(float(np.linalg.norm(np.ptp(points, axis=0))) / 4.0, 0.05)

    def _add_site(self, name: str, body: int, at: Array) -> str:
        full = self._full(name)
        if body == 0:
            at = self._ground[:3, :3] @ at + self._ground[:3, 3]
        self._bodies[self._assembly.bodies[body]].add_site(name=full, pos=at, size=[0.004] * 3, group=4)
        return full

    def _add_hub(self, joint: MechanismJoint) -> None:
        """Add the visual shape of a joint."""
        ends, parts = self._assembly.places[joint.name], joint.primitives((0.0, 0.0, 1.0))
        if not parts:
            return
        number = self._assembly.number(ends[1].body if ends[1].body != GROUND else ends[0].body)
        end = ends[1] if ends[1].body != GROUND else ends[0]
        body, pose = self._bodies[end.body], self._placed.poses[number]
        radius = HUB * min(thickness(self._mechanism.body(each.body)) for each in ends if each.body != GROUND)
        axis = pose[:3, :3].T @ self._placed.axes[self._assembly.columns[joint.name].start]
        kinds = {part.kind for part in parts}
        if kinds == {"ball"}:
            shape = {"type": mujoco.mjtGeom.mjGEOM_SPHERE, "size": [radius, 0.0, 0.0], "pos": end.at}
        elif kinds == {"slide"}:
            shape = {
                "type": mujoco.mjtGeom.mjGEOM_BOX,
                "size": [1.6 * radius, radius, radius],
                **pose_keys(_along(axis, end.at, which=0)),
            }
        else:
            shape = {
                "type": mujoco.mjtGeom.mjGEOM_CYLINDER,
                "size": [radius, radius, 0.0],
                **pose_keys(_along(axis, end.at, which=2)),
            }
        make_decor(body.add_geom(**shape), DARK)

    def _add_motors(self) -> None:
        """Add a motor for each coordinate driven by a torque or force, and constraints for those with a motion."""
        drives = {drive.number: drive for drive in self._assembly.drives}
        for number, actuator in enumerate(self._mechanism.actuators):
            if number in drives:
                if drives[number].column >= 0:
                    self._add_follower(self._assembly.names[drives[number].column])
            elif (target := actuator.target) in self._assembly.names or target in self._assembly.columns:
                name = self._full(target)
                self._spec.add_actuator(name=name, trntype=mujoco.mjtTrn.mjTRN_JOINT, target=name)

    def _add_follower(self, value: str) -> None:
        name = self._full(value)
        added = self._spec.add_equality(name=name, type=mujoco.mjtEq.mjEQ_JOINT, name1=name)
        added.objtype = mujoco.mjtObj.mjOBJ_JOINT
        added.data[:5] = [0.0, 0.0, 0.0, 0.0, 0.0]
        stiff(added, self._step)

    def _let_pass(self) -> None:
        """Exclude collisions among the bodies, and of those that start below the floor with static objects."""
        names = [self._full(body.name) for body in self._mechanism.bodies]
        if not self._mechanism.collide:
            for place, first in enumerate(names):
                for second in names[:place]:
                    self._spec.add_exclude(bodyname1=first, bodyname2=second)
        for body in self._mechanism.bodies:
            pose = self._ground @ self._placed.poses[self._assembly.number(body.name)] @ body.frame()
            if lowest(body, pose) < -MIN_DEPTH_BELOW_FLOOR:
                self._spec.add_exclude(bodyname1="world", bodyname2=self._full(body.name))


def _along(axis: Array, at: tuple[float, ...], *, which: int) -> Array:
    """Return a frame at a point with one axis along a given direction, shape (4, 4)."""
    pose, start = np.eye(4), np.eye(3)[int(np.argmin(np.abs(axis)))]
    first = np.cross(axis, start)
    first /= np.linalg.norm(first)
    columns = [axis, first, np.cross(axis, first)]
    pose[:3, :3] = np.column_stack(columns[-which:] + columns[:-which])
    pose[:3, 3] = at
    return pose


def solids_of(world: World) -> Iterator[tuple[str, Solid]]:
    """Yield masses and inertias of the bodies of all mechanisms, each with its name in the scene."""
    for mechanism in world.mechanisms:
        for body in mechanism.bodies:
            yield f"{mechanism.name}/{body.name}", body.solid()
