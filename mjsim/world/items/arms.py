"""Arms of a world file, from a table of joints or a file: mounting, tool, and their form in `mjsim.mechanics`."""

import math
from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Field, PrivateAttr, ValidationInfo, model_validator

from mjsim.errors import did_you_mean
from mjsim.geometry import Array
from mjsim.sentences import Sentence
from mjsim.world.files import BUILT, Source, read_asset
from mjsim.world.ground import Color, Degrees, Metres, Model, ModelPath, Name, Point3, RollPitchYaw, fault
from mjsim.world.items.shipped_presets import shipped_keys, shipped_names

if TYPE_CHECKING:
    from mjsim.mechanics import Arm, Link
    from mjsim.models import FileArm


MAX_JOINTS = 32
"""Largest number of joints of an arm."""
LIKELY_KEYS = (("friction", "coulomb"), ("center",), ("inertia",), ("gear",))
"""Keys of a row that `mjsim.mechanics` may reject."""
InUnit = Annotated[float, Field(ge=-1e6, le=1e6)]
"""A length in the unit of the table."""
Figure = Annotated[float, Field(ge=0, le=1e6)]
Above = Annotated[float, Field(gt=0, le=1e9)]


def _ascending(bounds: tuple[float, ...]) -> tuple[float, ...]:
    if bounds[0] >= bounds[1]:
        raise ValueError(
            Sentence("the range is [{low:g}, {high:g}]; the first must be below the second", bounds[0], bounds[1])
        )
    return bounds


def _coulomb_pair(value: Any) -> Any:
    """Return dry friction in both directions as a list; a single number applies to both."""
    return [value, -value] if isinstance(value, int | float) and not isinstance(value, bool) else value


class Friction(Model):
    """Friction of a motor, on the motor side of the gear."""

    viscous: Figure = 0.0
    """[N m s/rad]"""
    coulomb: Annotated[
        tuple[Annotated[float, Field(ge=-1e6, le=1e6)], ...],
        BeforeValidator(_coulomb_pair),
        Field(strict=False, min_length=2, max_length=2),
    ] = (0.0, 0.0)
    """Dry friction, one number, or [plus, minus] by direction, the second not above 0 [N m]."""


class DhRow(Model):
    """One joint and its link; the joint value is added to theta, or to d for a sliding joint."""

    theta_deg: Degrees = 0.0
    """Rotation about z."""
    d: InUnit = 0.0
    """Translation along z, in the unit of the table."""
    a: InUnit = 0.0
    """Translation along x, in the unit of the table."""
    alpha_deg: Degrees = 0.0
    """Rotation about x."""
    slide: bool = False
    """Whether the joint slides; otherwise it is revolute."""
    range_deg: (
        Annotated[tuple[Degrees, ...], Field(strict=False, min_length=2, max_length=2), AfterValidator(_ascending)]
        | None
    ) = None
    """Limits [lower, upper] of a revolute joint; default: unlimited."""
    range: (
        Annotated[tuple[InUnit, ...], Field(strict=False, min_length=2, max_length=2), AfterValidator(_ascending)]
        | None
    ) = None
    """Limits [lower, upper] of a sliding joint, in the unit of the table; default: unlimited."""
    velocity_deg: Above | None = None
    """Maximum speed of a revolute joint [deg/s]."""
    velocity: Above | None = None
    """Maximum speed of a sliding joint, in the unit of the table [1/s]."""
    torque: Above | None = None
    """Maximum motor torque at the joint in N m, or force of a sliding joint in N; default: unlimited."""
    mass: Annotated[float, Field(ge=0, le=1e5)] | None = None
    """Mass; default: that of a capsule of 1000 kg/m^3 [kg]."""
    center: Annotated[tuple[InUnit, ...], Field(strict=False, min_length=3, max_length=3)] | None = None
    """Centre of mass [x, y, z] in the frame of the link, in the unit of the table."""
    inertia: (
        Annotated[tuple[Annotated[float, Field(ge=-1e6, le=1e6)], ...], Field(strict=False, min_length=6, max_length=6)]
        | None
    ) = None
    """Inertia [ixx, iyy, izz, ixy, iyz, ixz] about the centre of mass, along the axes of the link [kg m^2]."""
    radius: Annotated[float, Field(gt=0, le=1e6)] | None = None
    """Radius of the capsule, in the unit of the table; default: 4 % of the arm's length."""
    gear: Annotated[float, Field(ge=-1e6, le=1e6)] = 1.0
    """Gear ratio: motor revolutions per joint revolution; negative for opposite directions."""
    rotor_inertia: Figure = 0.0
    """Inertia of the rotor, on the motor side of the gear [kg m^2]."""
    friction: Friction = Friction()
    """Friction of the motor, on the motor side of the gear."""

    @model_validator(mode="after")
    def _is_a_link(self) -> Self:
        from mjsim.mechanics import Arm

        moves, wrong, right = ("slides", "{}_deg", "{}") if self.slide else ("revolves", "{}", "{}_deg")
        for name in ("range", "velocity"):
            if getattr(self, key := wrong.format(name)) is not None:
                raise fault(
                    Sentence("{key} is not for a joint that {moves}; give {other}", key, moves, right.format(name)), key
                )
        try:
            Arm.from_dh([self.as_row()])
        except ValueError as error:
            message = str(error).removeprefix("row 1: ")
            raise fault(message, *next((path for path in LIKELY_KEYS if path[-1] in message), ())) from None
        return self

    def as_row(self) -> dict[str, Any]:
        """Return the row in the form of `mjsim.mechanics`."""
        return self.model_dump(exclude_none=True)


class DhTable(Model):
    """A Denavit-Hartenberg table."""

    convention: Literal["standard", "modified"] = "standard"
    """A row is Rz(theta) Tz(d) Tx(a) Rx(alpha); modified (Craig): Rx(alpha) Tx(a) Rz(theta) Tz(d)."""
    unit: Literal["m", "mm"] = "m"
    """Unit of all lengths in the table."""
    rows: Annotated[tuple[DhRow, ...], Field(strict=False, min_length=1, max_length=MAX_JOINTS)]
    """One row per joint, from the base outwards."""

    @model_validator(mode="after")
    def _moves_something(self) -> Self:
        number = faulty_joint(self.arm("arm"))
        if number is not None:
            raise fault(
                Sentence(
                    "joint{number} moves nothing that has mass; give link{number} or one beyond it a mass"
                    " and an inertia, or the motor a rotor_inertia",
                    number + 1,
                ),
                *("rows", number),
            )
        return self

    def arm(self, name: str) -> "Arm":
        """Return the arm of the table, with its base at the origin and without a tool."""
        from mjsim.mechanics import Arm

        return Arm.from_dh([row.as_row() for row in self.rows], self.convention, self.unit, name=name)


class Tool(Model):
    """The tool on the flange; its frame is that of tool poses."""

    at: Point3 = (0.0, 0.0, 0.0)
    """Position [x, y, z] in the frame of the flange [m]."""
    rpy_deg: RollPitchYaw = (0.0, 0.0, 0.0)
    """Rotation [roll, pitch, yaw] about the axes of the flange, right-handed, in this order."""

    def pose(self) -> Array:
        """Return flange_from_tool, shape (4, 4) [m]."""
        from mjsim.mechanics import placed

        return placed(self.at, np.radians(self.rpy_deg))


class RobotArm(Model):
    """An arm on a robot: links `ROBOT/ARM/link1`, joints `ROBOT/ARM/joint1`, and sites `flange` and `tool`."""

    name: Name = "arm"
    """Name in commands, recordings and `on` of sensors."""
    preset: Name | None = None
    """Preset from `assets/arms`; keys given here override it."""
    dh: DhTable | None = None
    """Its joints and links, unless a preset or a model gives them."""
    model: ModelPath | None = None
    """An MJCF, URDF or xacro file with joints, links and appearance, instead of `dh`; each joint gets a torque motor
    with the limits of the file. Fingers beyond the end of the chain are the last joints of the arm."""
    end: Annotated[str, Field(min_length=1, max_length=200)] | None = None
    """Body, site or joint of the model at the end of its chain, with the frame of the flange; needed only if
    ambiguous."""
    arguments: Annotated[dict[str, str], Field(default_factory=dict, max_length=100)]
    """Values of `xacro:arg`, for a model in xacro."""
    at: Point3 = (0.0, 0.0, 0.0)
    """Position [x, y, z] of its base in the robot frame [m]."""
    rpy_deg: RollPitchYaw = (0.0, 0.0, 0.0)
    """Rotation [roll, pitch, yaw] of its base about the axes of the robot, right-handed, in this order."""
    tool: Tool = Tool()
    """The tool on the flange."""
    start_deg: Annotated[tuple[Metres, ...], Field(strict=False, max_length=MAX_JOINTS)] = ()
    """Initial joint values [deg, m]; default: 0, or the nearest value within limits."""
    color: Color = "#e8a33d"
    """'#rrggbb'; default for a model: its own."""
    _source: Source = PrivateAttr(default=BUILT)

    @model_validator(mode="before")
    @classmethod
    def _over_preset(cls, keys: Any) -> Any:
        if isinstance(keys, dict) and isinstance(keys.get("preset"), str):
            try:
                return over_arm(keys["preset"], keys)
            except ValueError as error:
                raise fault(str(error), "preset") from None
        return keys

    @model_validator(mode="after")
    def _has_joints(self, info: ValidationInfo) -> Self:
        if (self.dh is None) == (self.model is None):
            conflict = "an arm has a table of joints or a model, not both; leave one out"
            none = "an arm has joints; give dh: {rows: [...]}, a preset, or model: FILE"
            raise fault(none) if self.dh is None else fault(conflict, "model")
        if self.model is None:
            if self.arguments:
                raise fault("arguments are for a model in xacro; leave them out", "arguments")
            if self.end is not None:
                raise fault("end names a part of a model; an arm of a table ends at its last row", "end")
            return self
        context = info.context or {}
        self._source = context.get("source") or BUILT
        # Arms of the same file share one reading of it, also if the file is broken.
        read: dict[Any, Any] = context.setdefault("models", {})
        key = ("arm", self.model, self.end, *sorted(self.arguments.items()))
        if key not in read:
            try:
                read[key] = self.file_arm
                self._check_joints()
            except ValueError as error:
                read[key] = str(error)
        if isinstance(read[key], str):
            raise fault(read[key], "model" if self.end is None or f"'{self.end}'" not in read[key] else "end")
        self.__dict__["file_arm"] = read[key]
        return self

    def _check_joints(self) -> None:
        """Raise ValueError if the file has too many joints, or one that moves no mass."""
        arm = self.arm
        if arm.n > MAX_JOINTS:
            raise ValueError(
                Sentence(
                    "'{model}' has {joints} joints; an arm has at most {max_joints}", self.model, arm.n, MAX_JOINTS
                )
            )
        number = faulty_joint(arm)
        if number is not None:
            name = arm.links[number].label
            raise ValueError(
                Sentence(
                    "joint '{name}' of '{model}' moves nothing that has mass; give what it moves a mass",
                    name,
                    self.model,
                )
            )

    @cached_property
    def file_arm(self) -> "FileArm":
        """The arm as its file defines it, if it has a model; ValueError if the file cannot be read."""
        from mjsim.models import read_arm

        assert self.model is not None, "asked of arms with a model only"
        return read_arm(self.model, lambda path: read_asset(path, self._source), self.end, self.arguments)

    @model_validator(mode="after")
    def _starts_within_limits(self) -> Self:
        links = self.arm.links
        if self.start_deg and len(self.start_deg) != len(links):
            raise fault(
                Sentence(
                    "start_deg holds {given} values; the arm has {joints} joints", len(self.start_deg), len(links)
                ),
                "start_deg",
            )
        for number, (link, value, given) in enumerate(zip(links, self.start(), self.start_deg, strict=False)):
            if not link.lower - 1e-9 <= value <= link.upper + 1e-9:
                scale = 1.0 if link.slide else 180.0 / math.pi
                bounds = f"[{link.lower * scale:g}, {link.upper * scale:g}]"
                raise fault(
                    Sentence("joint{number} starts at {given:g}; its range is {bounds}", number + 1, given, bounds),
                    "start_deg",
                    number,
                )
        return self

    @cached_property
    def arm(self) -> "Arm":
        """The arm with its base placed in the robot's frame, in which its poses are."""
        from mjsim.mechanics import placed

        base = placed(self.at, np.radians(self.rpy_deg))
        arm = arm_of(self.file_arm, self.name) if self.dh is None else self.dh.arm(self.name)
        return arm.moved(base, tool=self.tool.pose())

    def parts(self) -> tuple[str, ...]:
        """Return the names of frames that may carry sensors: ARM/link1 and so on, and ARM/tool."""
        return tuple(f"{self.name}/{part}" for part in [*(f"link{k + 1}" for k in range(self.arm.n)), "tool"])

    def start(self) -> tuple[float, ...]:
        """Return the joint values at the start [rad, m]."""
        if not self.start_deg:
            return tuple(min(max(0.0, link.lower), link.upper) for link in self.arm.links)
        pairs = zip(self.arm.links, self.start_deg, strict=True)
        return tuple(value if link.slide else math.radians(value) for link, value in pairs)


def over_arm(name: str, keys: Mapping[str, Any]) -> dict[str, Any]:
    """Return the keys of an arm merged with those of its preset; a key replaces that of the preset as a whole.

    Raises:
        ValueError: The preset does not exist.
    """
    if name not in arm_names():
        raise ValueError(Sentence("no arm preset '{name}'{meant}", name, did_you_mean(name, arm_names())))
    return {**shipped_keys("arms", name), **keys}


def arm_names() -> tuple[str, ...]:
    """Return the names of all arm presets, sorted."""
    return shipped_names("arms")


POSTURES = 4
"""Number of postures at which each joint is checked for mass that it moves."""
MIN_INERTIA = 1e-12
"""Smallest inertia or mass that a joint must move [kg m^2, kg]."""
THIN, THINNEST = 0.04, 0.01
"""Radius of a link that is drawn as a line or has no mass: as a fraction of the arm's length, and the minimum [m]."""


def arm_of(file: "FileArm", name: str) -> "Arm":
    """Return the arm of a file, with its base at the origin of the file and without a tool."""
    from mjsim.mechanics import Arm

    length = sum(float(np.linalg.norm(link.before[:3, 3])) for link in file.links)
    radius = max(THIN * length, THINNEST)
    links = tuple(_link(file, number, radius) for number in range(len(file.links)))
    return Arm(links=links, name=name, flange=file.flange, end=file.end)


def faulty_joint(arm: "Arm") -> int | None:
    """Return the index of a joint that moves no mass, from 0; None if there is none."""
    q = np.random.default_rng(0).uniform(-1.0, 1.0, (POSTURES, arm.n))
    moved = np.diagonal(arm.inertia(q), axis1=-2, axis2=-1).max(axis=0)
    return next((number for number, inertia in enumerate(moved.tolist()) if inertia < MIN_INERTIA), None)


def _link(file: "FileArm", number: int, radius: float) -> "Link":
    from mjsim.mechanics import Link, Solid, capsule, inverted

    link = file.links[number]
    start, end = inverted(link.after)[:3, 3], _far_end(file, number)
    x, y, z = link.center.tolist()
    xx, yy, zz, xy, yz, xz = link.inertia[[0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]].tolist()
    solid = Solid(link.mass, (x, y, z), (xx, yy, zz, xy, yz, xz)) if link.mass is not None else None
    solid = solid or capsule(start, end, radius)
    return Link(
        before=link.before,
        after=link.after,
        slide=link.slide,
        lower=link.bounds[0],
        upper=link.bounds[1],
        mass=solid.mass,
        center=solid.center,
        inertia=solid.inertia,
        rotor_inertia=link.armature,
        viscous=link.damping,
        coulomb=(link.friction, -link.friction),
        max_torque=link.max_torque,
        max_velocity=link.max_velocity,
        bone=(_point(start), _point(end)),
        radius=radius,
        label=link.name,
        parent=link.parent,
    )


def _far_end(file: "FileArm", number: int) -> Array:
    """Return the end of a link's line, link frame, shape (3,) [m]: the next joint, the flange or the centre of mass."""
    ahead = [link.before[:3, 3] for link in file.links if link.parent == number]
    if number == file.end:
        return np.asarray(file.flange[:3, 3], dtype=float)
    return ahead[0] if ahead else file.links[number].center


def _point(values: Array) -> tuple[float, float, float]:
    x, y, z = values.tolist()
    return x, y, z
