"""Writes the preset of a robot from its manufacturer's file: the text of a world with only that robot."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mjsim.exchange.robots.driven_wheels import Gear
from mjsim.exchange.robots.found_wheels import FoundWheel
from mjsim.exchange.robots.mounts import SensorMount
from mjsim.exchange.robots.robot_frame import Stand
from mjsim.exchange.robots.steering import steering_limit
from mjsim.models import PLACEHOLDERS
from mjsim.world import CORNERS, OMNI3_BEARINGS, Slip

WHEEL_SPEED = 12.5
"""Wheel speed if no file states it: the middle of those in data sheets, which are 6 to 24 [rad/s]."""
MAX_GUESSED_SPEED = 1.5
"""Maximum of a guessed speed [m/s]."""
MAX_TURN = 400.0
"""Maximum turn rate that a preset takes from a file [deg/s]."""
MIN_SPEED, MAX_SPEED = 0.02, 5.0
"""Range of plausible speeds in files; a value beyond means that there is no limit [m/s]."""
NO_LIMIT = 100.0
"""A wheel speed of this or more in a file was not measured [rad/s]."""
ACCELERATION = 1.0
"""Acceleration of the drive [m/s^2]."""
TURN_NOISE, DISTANCE_NOISE = 0.02, 0.01
"""Odometry noise of a good robot [rad/sqrt(rad)], [m/sqrt(m)]."""
DRIVE_NOISE = 0.02
LIDAR = {"beams": 360, "fov_deg": 360, "range": [0.12, 8.0], "rate_hz": 5, "noise": {"range": 0.01}}
LIDAR3D = {"rings": 16, "columns": 900, "range": [0.3, 50.0], "rate_hz": 5, "noise": {"range": 0.01}}
CAMERA = {"width": 640, "height": 480, "fov_deg": 60, "rate_hz": 5}
IMU = {"noise": {"acceleration": 0.02, "turn": 0.002}}
SIDES = ("left", "right")
ROLLER_DRIVES = ("mecanum", "omni3")
"""Drives on wheels with rollers; their dimensions are kept when their slip is measured."""
KEYS: Mapping[str, Mapping[str, object]] = {"lidar": LIDAR, "lidar3d": LIDAR3D, "camera": CAMERA, "imu": IMU}
"""Default keys of sensors, where the file does not state them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """The contents of a robot's preset."""

    name: str
    model: str
    """Path of its model relative to the preset."""
    gear: Gear
    stand: Stand
    mounts: Sequence[SensorMount]
    wheel_radius: float
    """Wheel radius used by its odometry [m]."""
    track: float
    """[m]; for a skid-steered robot, the track of the equivalent differential drive; for mecanum wheels, plus the
    wheelbase; for three wheels in a ring, the diameter of the ring."""
    slip: Slip | None = None
    """Slip of its tyres, if measured."""
    strafe: float = 1.0
    """Sideways slip factor of wheels with rollers, as in the drive's key."""
    spin: float = 1.0
    """Turning slip factor of wheels with rollers, as in the drive's key."""

    def measured(self, *, distance: float, turn: float, strafe: float = 1.0) -> "Plan":
        """Return a plan whose odometry matches the measured drives.

        Args:
            distance: True distance per metre of odometry.
            turn: True turn per radian of odometry.
            strafe: True sideways distance per metre of odometry.
        """
        plan = replace(self, wheel_radius=self.wheel_radius * distance)
        if self.gear.drive in ROLLER_DRIVES:
            return replace(plan, strafe=self.strafe * strafe / distance, spin=self.spin * turn / distance)
        return replace(plan, track=self.track * distance / turn)


def first_plan(name: str, model: str, gear: Gear, stand: Stand, mounts: Sequence[SensorMount]) -> Plan:
    """Return a plan based only on dimensions."""
    radius = gear.single[0].radius if gear.single else gear.rows[-1][0][0].radius
    return Plan(
        name=name, model=model, gear=gear, stand=stand, mounts=mounts, wheel_radius=radius, track=_turning(gear, stand)
    )


def _turning(gear: Gear, stand: Stand) -> float:
    """Return the dimension that determines how far a robot turns, defined as `Plan.track` [m]."""
    if gear.drive == "omni3":
        return 2.0 * float(np.mean([np.hypot(*stand.point(wheel.middle)[:2]) for wheel in gear.single]))
    track = track_of(gear)
    if gear.drive == "mecanum":
        return track + wheelbase_of(gear)
    return track if gear.drive != "skid_steer" else (track**2 + wheelbase_of(gear) ** 2) / track


def track_of(gear: Gear) -> float:
    """Return the distance between the left and the right wheels of the last axle [m]."""
    return _track(gear.rows[-1])


def _track(row: tuple[tuple[FoundWheel, ...], tuple[FoundWheel, ...]]) -> float:
    left, right = row[0][0].middle, row[1][0].middle
    return math.dist(left[:2], right[:2])


def wheelbase_of(gear: Gear) -> float:
    """Return the distance between the first axle and the last axle or the steered wheel [m]."""
    if gear.single:
        left, right = (side[0].middle for side in gear.rows[0])
        return abs(float((gear.single[0].middle - (left + right) / 2)[:2] @ gear.forward))
    front, rear = gear.rows[0], gear.rows[-1]
    middles = [(row[0][0].middle + row[1][0].middle)[:2] / 2 for row in (front, rear)]
    return math.dist(*middles)


def max_speed(plan: Plan) -> float:
    """Return the maximum speed, from the file or guessed [m/s]."""
    stated = stated_speed(plan.gear)
    return round(stated or min(MAX_GUESSED_SPEED, WHEEL_SPEED * plan.wheel_radius), 2) or 0.05


def stated_speed(gear: Gear) -> float | None:
    """Return the maximum speed that a controller, a plug-in or the limits of wheels state [m/s]; None if none does."""
    speeds = [gear.said.max_speed or 0.0, min(_rim_speeds(gear), default=(0.0, 0.0))[0]]
    return next((speed for speed in speeds if MIN_SPEED < speed <= MAX_SPEED), None)


def _rim_speeds(gear: Gear) -> list[tuple[float, float]]:
    """Return the maximum speed of each wheel's rim [m/s], and of its joint [rad/s], where one is stated."""
    speeds = [(gear.said.wheel_speeds.get(wheel.name, wheel.joint.speed), wheel.radius) for wheel in gear.wheels()]
    return [(s * radius, s) for s, radius in speeds if s is not None and s < NO_LIMIT and s not in PLACEHOLDERS]


def speed_source(plan: Plan) -> str:
    """Return a text that says where the maximum speed comes from."""
    stated, said = stated_speed(plan.gear), plan.gear.said
    if stated is None:
        limits = {wheel.joint.speed for wheel in plan.gear.wheels()} & {*PLACEHOLDERS}
        template = f", as the limit of {limits.pop():g} rad/s in the file is that of a template" if limits else ""
        return f"a guess: wheels that turn at {WHEEL_SPEED} rad/s{template}"
    if stated == said.max_speed:
        return f"by {said.source}"
    return f"by the limits of its wheels, {min(_rim_speeds(plan.gear))[1]:.3g} rad/s"


def preset_turn(plan: Plan) -> float:
    """Return the maximum turn rate, stated or guessed [deg/s]."""
    said = plan.gear.said.max_turn
    guess = min(max(math.degrees(2.0 * max_speed(plan) / plan.track), 20.0), 170.0)
    return float(round(guess if said is None else min(max(math.degrees(said), 1.0), MAX_TURN)))


def preset_text(plan: Plan, notes: Sequence[str]) -> str:
    """Return the text of a preset: a world with only this robot on an empty floor."""
    lines = [f"# {note}" for note in notes]
    lines += [
        "mjsim: 1",
        f"name: {plan.name}",
        "robots:",
        f"  - name: {plan.name}",
        "    at: [0, 0]",
        *_drive(plan),
        *_body(plan),
        "    odometry:",
        f"      noise: {{distance: {DISTANCE_NOISE}, turn: {TURN_NOISE}}}  # a guess, that of a good robot",
        *([f"      tyres: {_inline(plan.slip.model_dump())}  # measured"] if plan.slip is not None else []),
    ]
    if plan.mounts:
        lines += ["    sensors:", *(f"      - {_inline(_sensor(mount))}  # {mount.origin}" for mount in plan.mounts)]
    lines += _run(plan)
    return "\n".join(lines) + "\n"


def _drive(plan: Plan) -> list[str]:
    gear = plan.gear
    keys: dict[str, object] = {"type": gear.drive, "wheel_radius": round(plan.wheel_radius, 6)}
    lines = ["    drive:"]
    keys |= _sizes(plan)
    if gear.drive in ("ackermann", "tricycle"):
        keys["max_steer_deg"] = round(max_steer_deg(plan), 1)
    if gear.drive in ROLLER_DRIVES:
        keys["max_left"] = max_speed(plan)
    lines += [f"      {key}: {value}" for key, value in keys.items()]
    lines += [
        f"      max_speed: {max_speed(plan)}  # {speed_source(plan)}",
        f"      max_turn_deg: {preset_turn(plan):g}",
        f"      max_acceleration: {ACCELERATION}",
        f"      noise: {{speed: {DRIVE_NOISE}, turn: {DRIVE_NOISE}}}  # a guess, that of a good robot",
    ]
    return lines


def _sizes(plan: Plan) -> dict[str, object]:
    """Return the keys of a drive that describe the positions of its wheels."""
    gear = plan.gear
    if gear.drive == "differential":
        return {"track": round(plan.track, 6)}
    if gear.drive == "omni3":
        return {"wheel_circle": round(plan.track / 2, 6), **_slips(plan)}
    base, track = round(wheelbase_of(gear), 5), round(track_of(gear), 5)
    if gear.drive == "ackermann":
        return {"track": round(plan.track, 6), "wheelbase": base}
    if gear.drive == "mecanum":
        return {"track": track, "wheelbase": base, **_slips(plan)}
    if gear.drive == "skid_steer":
        return {"track": track, "wheelbase": base, "effective_track": round(plan.track, 5)}
    ahead = float(plan.stand.point(gear.single[0].middle)[0]) > 0.0
    load = round(gear.rows[0][0][0].radius, 5)
    return {"load_wheel_radius": load, "track": track, "wheelbase": base, "driven": "front" if ahead else "rear"}


def _slips(plan: Plan) -> dict[str, object]:
    """Return the keys of a drive that describe the slip of its rollers."""
    return {"strafe": round(plan.strafe, 5), "spin": round(plan.spin, 5)}


def max_steer_deg(plan: Plan) -> float:
    """Return the steering limit of a virtual wheel midway between the steered ones, from the inner wheel's [deg]."""
    if plan.gear.single:
        joint = plan.gear.single[0].steer
        free = joint is None or joint.range is None
        return 90.0 if free or joint is None else min(90.0, math.degrees(steering_limit([joint], limit=math.pi / 2)))
    joints = [w.steer for side in plan.gear.rows[0] for w in side if w.steer is not None]
    inner, base, half = 0.95 * steering_limit(joints), wheelbase_of(plan.gear), _track(plan.gear.rows[0]) / 2
    return math.degrees(math.atan(base / (base / math.tan(inner) + half)))


def _body(plan: Plan) -> list[str]:
    stand, gear = plan.stand, plan.gear
    lines = [
        "    body:",
        f"      model: {json.dumps(plan.model)}",
        f"      origin: {_numbers(stand.origin.tolist(), 5)}",
        f"      forward_deg: {round(math.degrees(stand.heading), 3) + 0.0:g}",
        f"      radius: {math.ceil(stand.radius * 1000) / 1000:g}",
        f"      height: {round(stand.height, 3):g}",
        "      wheels:",
    ]
    for name, wheels in wheels_by_name(gear).items():
        first, *others = wheels
        keys: dict[str, object] = {
            "joint": first.name,
            "y": round(float(stand.point(first.middle)[1]), 5) + 0.0,
            "radius": round(first.radius, 5),
            "width": round(max(first.width, 0.004), 5),
        }
        follow = [other.name for other in others if other.name != first.name]
        lines.append(f"        {name}: {_inline(keys | ({'follow': follow} if follow else {}))}")
    if gear.drive == "tricycle" and gear.single[0].steer is not None:
        lines.append(f"      steering: {_inline({'steer': gear.single[0].steer.name})}")
    if gear.drive == "ackermann":
        steer = {f"steer_front_{side}": row[0].steer for side, row in zip(SIDES, gear.rows[0], strict=True)}
        lines.append(f"      steering: {_inline({key: joint.name for key, joint in steer.items() if joint})}")
    if stand.casters:
        lines.append(f"      casters: [{', '.join(_numbers(caster, 4) for caster in stand.casters)}]")
    return lines


def wheels_by_name(gear: Gear) -> dict[str, list[FoundWheel]]:
    """Return the wheels by the drive's names for them, grouped with those that turn alike."""
    if gear.drive == "omni3":
        return {name: [wheel] for name, wheel in zip(OMNI3_BEARINGS, gear.single, strict=True)}
    if len(gear.rows) == 1:
        axle = {side: list(gear.rows[0][number]) for number, side in enumerate(SIDES)}
        return axle | ({"drive": list(gear.single)} if gear.single else {})
    found: dict[str, list[FoundWheel]] = {}
    for name, x, y in CORNERS:
        side, row = (0 if y > 0 else 1), gear.rows[0 if x > 0 else -1]
        between = [wheel for middle in gear.rows[1:-1] for wheel in middle[side]] if x > 0 else []
        found[name] = [*row[side], *between]
    return found


def _sensor(mount: SensorMount) -> dict[str, object]:
    keys: dict[str, object] = {mount.kind: mount.name, "at": list(mount.at)}
    if mount.yaw_deg:
        keys["yaw_deg"] = mount.yaw_deg
    if mount.pitch_deg:
        keys["pitch_deg"] = mount.pitch_deg
    return keys | {**KEYS[mount.kind], **mount.keys}


def _run(plan: Plan) -> list[str]:
    """Return the `run` section: the robot drives a square, or a path that a car can follow."""
    side = max(1.0, round(4.0 * plan.stand.radius, 1)) * (3.0 if plan.gear.drive in ("ackermann", "tricycle") else 1.0)
    points = f"[[{side:g}, 0], [{side:g}, {side:g}], [0, {side:g}], [0, 0]]"
    return [
        "run:",
        "  seconds: 30",
        "  drivers:",
        f"    {plan.name}:",
        f'      navigator: {{use: "mjsim.algorithms.waypoints:Waypoints", points: {points}}}',
    ]


def _numbers(values: Sequence[float], digits: int) -> str:
    return f"[{', '.join(f'{round(float(value), digits) + 0.0:g}' for value in values)}]"


def _inline(value: object) -> str:
    """Return a value as YAML on one line."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key}: {_inline(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_inline(item) for item in value) + "]"
    if isinstance(value, float):
        return f"{value:.10g}"
    return json.dumps(value)
