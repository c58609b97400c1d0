"""Parts of a scene that can be plants: robots, arms and mechanisms, with their inputs and measured values."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import mujoco
import numpy as np

from mjsim.errors import UsageError, did_you_mean
from mjsim.geometry import Array, headings
from mjsim.lab.effects import BodyPush, ForceEffect, InputEffect, LedJoint, PointsPush
from mjsim.lab.reduced import Setting
from mjsim.mechanics import Constant
from mjsim.sim import Push, Simulation
from mjsim.world import (
    BalancingDrive,
    DifferentialDrive,
    ForceActuator,
    Mechanism,
    Plant,
    Robot,
    TorqueActuator,
    World,
    actuator_kind,
)

SETTLING_SECONDS = 1.0
"""Time for which a robot stands until its wheels have settled [s]."""
JOINTS = {int(mujoco.mjtJoint.mjJNT_SLIDE): "m", int(mujoco.mjtJoint.mjJNT_HINGE): "rad"}
"""Joint types with one value, and its unit."""
FORCES = {"m": "N", "rad": "N m"}
EFFORTS = {"m": ("force", "position"), "rad": ("torque", "angle")}
"""Names of actuators for a joint, by the joint's unit."""

Measure = Callable[[Array], float]
"""Returns a value for positions, shape (nq,)."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlantPart:
    """A part of a scene that can be a plant."""

    name: str
    dofs: tuple[int, ...]
    prefer: tuple[int, ...] = ()
    """Degrees of freedom preferred as coordinates."""
    lockable: bool = False
    """Whether joints that are not named are locked."""
    effects: Mapping[str, InputEffect] = field(default_factory=dict)
    measures: Mapping[str, tuple[str, Measure]] = field(default_factory=dict)
    """Unit and value by name."""
    joints: Mapping[str, int] = field(default_factory=dict)
    """Joints with one value, by name."""


def base_of(name: str) -> str:
    """Return the value of which an output is the rate, or the output itself."""
    return name.removesuffix(".rate")


def moved_joint(part: "PlantPart", name: str) -> int | None:
    """Return the joint on which an input acts by itself; None if there is none."""
    effect = part.effects[name]
    force = effect.force if isinstance(effect, LedJoint) else effect
    return next((joint for key, joint in part.joints.items() if part.effects.get(key) is force), None)


def settled(world: World, of: str) -> tuple[mujoco.MjModel, Setting, Array]:
    """Return the compiled world at its start, and the positions after the part has come to rest, shape (nq,).

    Events and modules are ignored. A robot is rotated to head along x. At the start, its wheels have the radius given
    by its drive; at rest their depth of penetration differs by about 0.05 mm.

    Raises:
        UsageError: The part does not exist.
    """
    run = world.run.model_copy(update={"events": (), "drivers": {}})
    # A robot is settled upright; the lean of its operating point is searched from there.
    upright = tuple(robot.model_copy(update={"lean_deg": 0.0}) for robot in world.robots)
    bare = world.model_copy(update={"run": run, "robots": upright})
    bare._source = world.source
    robot = next((robot for robot in world.robots if robot.name == of), None)
    with Simulation(bare) as sim:
        model, data = sim.model, sim.data
        begun = Setting(data.qpos.copy(), data.act * 0.0)
        if robot is not None and robot.base != "fixed":
            for _ in range(math.ceil(SETTLING_SECONDS / sim.dt)):
                sim.step()
            start = int(model.joint(f"{of}/free").qposadr[0])
            for qpos in (begun.qpos, data.qpos):
                qpos[start + 3 : start + 7] = _level(qpos[start + 3 : start + 7])
        return model, begun, data.qpos.copy()


def part_of(model: mujoco.MjModel, world: World, of: str, qpos: Array) -> PlantPart:
    """Return the named part of a scene.

    Raises:
        UsageError: There is none.
    """
    robots = {robot.name: robot for robot in world.robots}
    if of in robots:
        return _robot(model, robots[of], _measured(model, qpos))
    arms = {f"{robot.name}/{arm.name}" for robot in world.robots for arm in robot.arms}
    mechanisms = {item.name: item for item in world.mechanisms}
    if of not in arms | {*mechanisms}:
        raise UsageError(f"no robot, arm or mechanism '{of}'{did_you_mean(of, [*robots, *arms, *mechanisms])}")
    if of in mechanisms and (tracks := mechanisms[of].assembly.tracks):
        raise UsageError(
            f"mechanism '{of}' has a point on a curve, '{tracks[0].name}', which plants cannot have;"
            " put a revolute joint on a rod in its place, as long as the radius of the curve"
        )
    return _linked(model, of, lockable=of in arms, mechanism=mechanisms.get(of))


def working_point(model: mujoco.MjModel, part: PlantPart, plant: Plant) -> dict[int, float]:
    """Return the joint values at the operating point, by index [m, rad].

    Raises:
        UsageError: The joint does not exist, or the key of an angle does not end in `_deg`.
    """
    found = {}
    for key, value in plant.around.items():
        name = key.removesuffix("_deg")
        if name not in part.joints:
            suggestion = did_you_mean(name, part.joints)
            raise UsageError(
                f"plant '{plant.name}': around has '{key}', but {plant.of} has no joint '{name}'{suggestion}"
            )
        joint = part.joints[name]
        turns = JOINTS[int(model.jnt_type[joint])] == "rad"
        if turns != key.endswith("_deg"):
            right = f"{name}_deg" if turns else name
            raise UsageError(f"plant '{plant.name}': joint {name} {'turns' if turns else 'slides'}; write {right}")
        found[joint] = math.radians(value) if turns else value
    return found


def _level(quaternion: Array) -> Array:
    """Return an orientation without its heading: rotated back about the vertical, with pitch and roll unchanged."""
    heading = _heading(quaternion)
    back, found = np.array([math.cos(heading / 2), 0.0, 0.0, -math.sin(heading / 2)]), np.zeros(4)
    mujoco.mju_mulQuat(found, back, quaternion)
    return found


def _measured(model: mujoco.MjModel, qpos: Array) -> mujoco.MjData:
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    return data


def _joints(model: mujoco.MjModel, of: str) -> dict[str, int]:
    """Return the joints with one value of a part, by their names in it."""
    names = {joint: model.joint(joint).name for joint in range(model.njnt) if int(model.jnt_type[joint]) in JOINTS}
    return {name.removeprefix(f"{of}/"): joint for joint, name in names.items() if name.startswith(f"{of}/")}


def _dofs(model: mujoco.MjModel, of: str) -> tuple[int, ...]:
    """Return the degrees of freedom of all joints of a part."""
    joints = {joint for joint in range(model.njnt) if model.joint(joint).name.startswith(f"{of}/")}
    return tuple(dof for dof in range(model.nv) if int(model.dof_jntid[dof]) in joints)


def _value(model: mujoco.MjModel, joint: int) -> Measure:
    place = int(model.jnt_qposadr[joint])
    return lambda qpos: float(qpos[place])


def _none(model: mujoco.MjModel, unit: str) -> ForceEffect:
    return ForceEffect(unit=unit, ctrl=np.zeros(model.nu), applied=np.zeros(model.nv))


def _force(model: mujoco.MjModel, joint: int) -> ForceEffect:
    """Return the effect of a force at a joint, as of a motor without limits."""
    effect = _none(model, FORCES[JOINTS[int(model.jnt_type[joint])]])
    effect.applied[model.jnt_dofadr[joint]] = 1.0
    return effect


def _linked(model: mujoco.MjModel, of: str, *, lockable: bool, mechanism: Mechanism | None = None) -> PlantPart:
    """Return an arm or a mechanism: inputs are forces and motions of its joints, measured values those of joints."""
    joints = _joints(model, of)
    effects: dict[str, InputEffect] = {}
    for name, joint in joints.items():
        effects |= _joint_effects(model, name, joint)
    if mechanism is not None:
        effects |= _actuator_effects(model, mechanism, effects)
    return PlantPart(
        name=of,
        dofs=_dofs(model, of),
        lockable=lockable,
        effects=effects,
        measures={
            **{name: (JOINTS[int(model.jnt_type[j])], _value(model, j)) for name, j in joints.items()},
            **{
                name.removesuffix(".force"): ("m", _distance(model, effect.sites))
                for name, effect in effects.items()
                if isinstance(effect, PointsPush)
            },
        },
        joints=joints,
    )


def _distance(model: mujoco.MjModel, sites: tuple[int, int]) -> Measure:
    """Return a function that measures the distance of two points [m]."""
    data = mujoco.MjData(model)

    def distance(qpos: Array) -> float:
        data.qpos[:] = qpos
        mujoco.mj_kinematics(model, data)
        return float(np.linalg.norm(data.site_xpos[sites[1]] - data.site_xpos[sites[0]]))

    return distance


def _joint_effects(model: mujoco.MjModel, name: str, joint: int) -> dict[str, InputEffect]:
    """Return the inputs of a joint: its force, also under the joint's own name, and prescribed motions."""
    unit, force = JOINTS[int(model.jnt_type[joint])], _force(model, joint)
    effort, place = EFFORTS[unit]
    dof = int(model.jnt_dofadr[joint])
    return {
        name: force,
        f"{name}.{effort}": force,
        f"{name}.{place}": LedJoint(unit=unit, force=force, dof=dof, is_speed=False),
        f"{name}.velocity": LedJoint(unit=f"{unit}/s", force=force, dof=dof, is_speed=True),
    }


def _actuator_effects(
    model: mujoco.MjModel, mechanism: Mechanism, joints: Mapping[str, InputEffect]
) -> dict[str, InputEffect]:
    """Return the inputs of a mechanism's actuators by name; those on bodies also by what they act on.

    For an actuator that prescribes a distance, the input is the force between its points, `NAME.force`.
    """
    found: dict[str, InputEffect] = {}
    for actuator in mechanism.actuators:
        if actuator_kind(actuator) == "distance":
            full = f"{mechanism.name}/{actuator.target}"
            sites = (model.site(f"{full}.a").id, model.site(f"{full}.b").id)
            force = PointsPush(unit="N", model=model, sites=sites, equality=model.equality(full).id)
            found[f"{actuator.target}.force"] = force
            continue
        if (effect := joints.get(f"{actuator.target}.{actuator_kind(actuator)}")) is None:
            assert isinstance(actuator, TorqueActuator | ForceActuator)
            unit = "N" if isinstance(actuator, ForceActuator) else "N m"
            effect = BodyPush(unit=unit, model=model, push=Push(model, mechanism, actuator, Constant(level=1.0)))
            found[actuator.target] = effect
        if actuator.name is not None:
            found[actuator.name] = effect
    return found


def _servo(model: mujoco.MjModel, robot: str, unit: str, shares: Mapping[str, float]) -> ForceEffect:
    """Return the effect that commands each motor of a robot with a multiple of the input."""
    effect = _none(model, unit)
    for name, share in shares.items():
        effect.ctrl[model.actuator(f"{robot}/{name}").id] = share
    return effect


def _robot(model: mujoco.MjModel, robot: Robot, data: mujoco.MjData) -> PlantPart:
    """Return a robot: inputs are its motors; measured values are its position, its lean, and its wheels."""
    joints = _joints(model, robot.name)
    effects: dict[str, InputEffect] = {
        name: _servo(model, robot.name, _unit_of(model, f"{robot.name}/{name}"), {name: 1.0})
        for name in joints
        if _has_motor(model, f"{robot.name}/{name}")
    }
    measures = {name: (JOINTS[int(model.jnt_type[j])], _value(model, j)) for name, j in joints.items()}
    prefer: tuple[int, ...] = ()
    if robot.base != "fixed":
        free = model.joint(f"{robot.name}/free")
        start, dof = int(free.qposadr[0]), int(free.dofadr[0])
        prefer = (dof, dof + 5, dof + 4)
        axle = float(model.body(f"{robot.name}/wheel_left").pos[2]) if isinstance(robot.drive, BalancingDrive) else 0.0
        measures |= {
            "way": ("m", lambda q: float(q[start]) + axle * math.sin(_pitch(q[start + 3 : start + 7]))),
            "lean": ("rad", lambda q: _pitch(q[start + 3 : start + 7])),
            "heading": ("rad", lambda q: _heading(q[start + 3 : start + 7])),
        }
    effects |= _base_effects(model, robot)
    dofs = _dofs(model, robot.name)
    return PlantPart(name=robot.name, dofs=dofs, prefer=prefer, effects=effects, measures=measures, joints=joints)


def _base_effects(model: mujoco.MjModel, robot: Robot) -> Mapping[str, InputEffect]:
    """Return the inputs that drive both wheels of a base together, and in opposite directions."""
    drive, name = robot.drive, robot.name
    if isinstance(drive, DifferentialDrive):
        r, half = drive.wheel_radius, drive.track / 2
        return {
            "forward": _servo(model, name, "m/s", {"wheel_left": 1 / r, "wheel_right": 1 / r}),
            "turn": _servo(model, name, "rad/s", {"wheel_left": -half / r, "wheel_right": half / r}),
        }
    if isinstance(drive, BalancingDrive):
        return {
            "torque": _servo(model, name, "N m", {"wheel_left": 0.5, "wheel_right": 0.5}),
            "twist": _servo(model, name, "N m", {"wheel_left": -0.5, "wheel_right": 0.5}),
        }
    return {}


def _has_motor(model: mujoco.MjModel, name: str) -> bool:
    return any(model.actuator(number).name == name for number in range(model.nu))


def _unit_of(model: mujoco.MjModel, name: str) -> str:
    """Return the unit of a motor's command: a torque, a speed, or an angle."""
    number = model.actuator(name).id
    _, kp, kv = (-float(value) for value in model.actuator_biasprm[number, :3])
    return "rad" if kp else "rad/s" if kv else "N m"


def _pitch(quaternion: Array) -> float:
    """Return the pitch [rad]: how far x points below the horizon."""
    w, x, y, z = quaternion.tolist()
    return math.asin(min(max(2 * (w * y - z * x), -1.0), 1.0))


def _heading(quaternion: Array) -> float:
    return float(headings(np.roll(quaternion, -1)))
