"""Sensors of mechanisms: their readings of the state, with names and units."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import mujoco
import numpy as np

from mjsim.geometry import Array
from mjsim.sim.mechanisms.mechanism_state import equality_forces
from mjsim.world import (
    GROUND,
    ActuatorSensor,
    BodySensor,
    JointSensor,
    Mechanism,
    Place,
    ReactionSensor,
    place_of,
)

XYZ = ("x", "y", "z")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MechanismState:
    """State of a mechanism at one instant; arrays have shape (values,) [rad, m, N m, N]."""

    model: mujoco.MjModel
    data: mujoco.MjData
    """State of the entire world, with all forces computed."""
    values: Array
    speeds: Array
    accelerations: Array
    efforts: Array
    """Torques and forces of the actuators at the joints."""
    pulls: Mapping[str, tuple[float, float]]
    """Force and speed of each distance that follows a motion, by name [N, m/s]."""
    work: float
    """Work of the actuators since the start [J]."""
    lost: float
    """Losses to damping and friction since the start [J]."""


@dataclass(frozen=True, slots=True, eq=False)
class Probe:
    """One sensor: the names and units of its readings, and its function."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    read: Callable[[MechanismState], Array]
    """Returns the numbers, shape (names,)."""


def probes_of(model: mujoco.MjModel, mechanism: Mechanism) -> tuple[Probe, ...]:
    """Return the probes of a mechanism's sensors and of its energy."""
    probes = list[Probe]()
    for sensor in mechanism.sensors:
        if isinstance(sensor, JointSensor):
            probes.append(_of_joint(mechanism, sensor.joint))
        elif isinstance(sensor, ReactionSensor):
            probes.append(_of_reaction(model, mechanism, sensor.reaction))
        elif isinstance(sensor, ActuatorSensor):
            probes.append(_of_actuator(mechanism, sensor.actuator))
        elif isinstance(sensor, BodySensor):
            probes.append(_of_body(model, mechanism, sensor))
    return (*probes, _energy(model, mechanism))


def _of_joint(mechanism: Mechanism, joint: str) -> Probe:
    assembly = mechanism.assembly
    columns = list(assembly.columns[joint]) if joint in assembly.columns else [assembly.column(joint)]
    names, units = list[str](), list[str]()
    for column in columns:
        name, slides = assembly.names[column], assembly.slides[column]
        length, effort = ("m", "N") if slides else ("rad", "N m")
        names += [
            f"{name}.position",
            f"{name}.velocity",
            f"{name}.acceleration",
            f"{name}.{'force' if slides else 'torque'}",
        ]
        units += [length, f"{length}/s", f"{length}/s^2", effort]

    def read(now: MechanismState) -> Array:
        parts = np.array([now.values, now.speeds, now.accelerations, now.efforts])
        return np.asarray(parts[:, columns].T.ravel())

    return Probe(tuple(names), tuple(units), read)


def _of_reaction(model: mujoco.MjModel, mechanism: Mechanism, joint: str) -> Probe:
    if joint in [track.name for track in mechanism.assembly.tracks]:
        return Probe(
            tuple(f"{joint}.force.{axis}" for axis in XYZ), ("N",) * 3, _curve_reaction(model, mechanism, joint)
        )
    names = tuple(f"{joint}.{quantity}.{axis}" for quantity in ("force", "torque") for axis in XYZ)
    units = ("N",) * 3 + ("N m",) * 3
    cut = mechanism.assembly.cuts.get(joint)
    if cut is not None and not mechanism.assembly.bodies[cut[0]]:
        return Probe(names, units, _cut_reaction(model, mechanism, joint))
    return Probe(names, units, _tree_reaction(model, mechanism, joint))


def _tree_reaction(model: mujoco.MjModel, mechanism: Mechanism, joint: str) -> Callable[[MechanismState], Array]:
    assembly, second = mechanism.assembly, mechanism.assembly.places[joint][1]
    number = next(k for k, tree in enumerate(assembly.linkage.joints, start=1) if tree.name == joint)
    body, sign = model.body(f"{mechanism.name}/{assembly.bodies[number]}").id, assembly.linkage.joints[number - 1].sign
    place = second if sign > 0 else assembly.places[joint][0]

    def read(now: MechanismState) -> Array:
        data = now.data
        # About the centre of mass of the whole tree, torque first.
        torque, force = data.cfrc_int[body, :3], data.cfrc_int[body, 3:]
        point = data.xmat[body].reshape(3, 3) @ place.at + data.xpos[body]
        about = torque + np.cross(data.subtree_com[model.body_rootid[body]] - point, force)
        return np.asarray(sign * np.concatenate([force, about]))

    return read


def _cut_reaction(model: mujoco.MjModel, mechanism: Mechanism, joint: str) -> Callable[[MechanismState], Array]:
    prefix = f"{mechanism.name}/{joint}."
    found = [k for k in range(model.neq) if model.equality(k).name.startswith(prefix)]
    sites = [model.site(f"{prefix}b{count}").id for count in range(len(found))]

    def read(now: MechanismState) -> Array:
        data, count = now.data, int(now.data.ne)
        force, torque = np.zeros(3), np.zeros(3)
        for equality, site in zip(found, sites, strict=True):
            own = (data.efc_id[:count] == equality) & (data.efc_type[:count] == mujoco.mjtConstraint.mjCNSTR_EQUALITY)
            # It pushes the first point along the direction, the second one against it.
            pushed = -data.efc_force[:count][own]
            force += pushed
            torque += np.cross(data.site_xpos[site] - data.site_xpos[sites[0]], pushed)
        return np.concatenate([force, torque])

    return read


def _curve_reaction(model: mujoco.MjModel, mechanism: Mechanism, track: str) -> Callable[[MechanismState], Array]:
    full = f"{mechanism.name}/{track}."
    ties = [model.equality(k).id for k in range(model.neq) if model.equality(k).name.startswith(full)]
    point = model.site(f"{full}b").id
    sites = [model.site(f"{full}a{model.equality(tie).name.removeprefix(full)}").id for tie in ties]

    def read(now: MechanismState) -> Array:
        force = np.zeros(3)
        for tie, site in zip(ties, sites, strict=True):
            across = now.data.site_xpos[point] - now.data.site_xpos[site]
            force += across / np.linalg.norm(across) * equality_forces(now.data, tie).sum()
        return force

    return read


def _of_actuator(mechanism: Mechanism, target: str) -> Probe:
    assembly = mechanism.assembly
    if target not in assembly.names:
        names = (f"{target}.actuator.force", f"{target}.actuator.power")
        return Probe(names, ("N", "W"), lambda now: np.array([now.pulls[target][0], np.prod(now.pulls[target])]))
    column = assembly.column(target)
    effort, unit = ("force", "N") if assembly.slides[column] else ("torque", "N m")
    return Probe(
        (f"{target}.actuator.{effort}", f"{target}.actuator.power"),
        (unit, "W"),
        lambda now: np.array([now.efforts[column], now.efforts[column] * now.speeds[column]]),
    )


def _of_body(model: mujoco.MjModel, mechanism: Mechanism, sensor: BodySensor) -> Probe:
    points = {GROUND: dict[str, tuple[float, ...]](), **{body.name: body.points() for body in mechanism.bodies}}
    place = place_of(sensor.body, points)
    name = sensor.called
    kinds = {"": "m", "velocity": "m/s", "acceleration": "m/s^2", "turn_rate": "rad/s", "turn_acceleration": "rad/s^2"}
    names = [f"{name}.{kind}.{axis}" if kind else f"{name}.{axis}" for kind in kinds for axis in XYZ]
    units = [unit for unit in kinds.values() for _ in XYZ]
    body = model.body(f"{mechanism.name}/{place.body}").id
    return Probe(
        (*names, *(f"{name}.q{axis}" for axis in "wxyz")), (*units, *("",) * 4), lambda now: _point(now, body, place)
    )


def _point(now: MechanismState, body: int, place: Place) -> Array:
    """Return the motion of a point, world frame, shape (19,).

    Position, velocity, acceleration, angular velocity, angular acceleration, quaternion.
    """
    model, data, kind = now.model, now.data, mujoco.mjtObj.mjOBJ_XBODY
    speed, change = np.zeros(6), np.zeros(6)
    mujoco.mj_objectVelocity(model, data, kind, body, speed, 0)
    mujoco.mj_objectAcceleration(model, data, kind, body, change, 0)
    arm = data.xmat[body].reshape(3, 3) @ place.at
    velocity = speed[3:] + np.cross(speed[:3], arm)
    # MuJoCo gives the acceleration that an accelerometer would measure.
    felt = change[3:] + np.cross(change[:3], arm) + np.cross(speed[:3], np.cross(speed[:3], arm))
    acceleration = felt + model.opt.gravity
    return np.concatenate([data.xpos[body] + arm, velocity, acceleration, speed[:3], change[:3], data.xquat[body]])


def _energy(model: mujoco.MjModel, mechanism: Mechanism) -> Probe:
    bodies = np.array([model.body(f"{mechanism.name}/{body.name}").id for body in mechanism.bodies])
    count = sum(len(mechanism.assembly.columns[joint.name]) for joint in mechanism.all_joints)
    stiffness = np.concatenate([joint.figures("stiffness") for joint in mechanism.all_joints])
    rest = np.concatenate([[value or 0.0 for value in joint.spread("rest")] for joint in mechanism.all_joints])

    tied = np.array(
        [model.tendon(f"{mechanism.name}/{each.name}").id for each in mechanism.assembly.springs], dtype=int
    )

    def read(now: MechanismState) -> Array:
        data, kinetic = now.data, 0.0
        for body in bodies:
            speed = np.zeros(6)
            mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_BODY, int(body), speed, 1)
            inertia = model.body_inertia[body]
            kinetic += 0.5 * float(model.body_mass[body] * speed[3:] @ speed[3:] + inertia @ speed[:3] ** 2)
        height = -float((model.body_mass[bodies] * (data.xipos[bodies] @ model.opt.gravity)).sum())
        springs = 0.5 * float(stiffness @ (now.values[:count] - rest) ** 2)
        stretched = data.ten_length[tied] - model.tendon_lengthspring[tied, 0]
        springs += 0.5 * float(stretched**2 @ model.tendon_stiffness[tied])
        return np.array([kinetic, height, springs, now.work, now.lost])

    names = ("kinetic", "potential", "springs", "work", "lost")
    return Probe(tuple(f"energy.{name}" for name in names), ("J",) * 5, read)
