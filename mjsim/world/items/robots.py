"""Robots as described in a world file: body, drive, odometry and sensors."""

from typing import Annotated, Any, Literal, Self

from pydantic import Field, ValidationInfo, model_validator

from mjsim.sentences import Sentence
from mjsim.world.files import BUILT
from mjsim.world.ground import (
    PLAIN_PATTERN,
    RESERVED,
    RUN,
    Degrees,
    Length,
    Model,
    Name,
    Point,
    TakenNames,
    fault,
    reserved_fault,
)
from mjsim.world.items.arms import RobotArm
from mjsim.world.items.bodies import Body, BoxBody, CylinderBody, ModelBody, NoBody
from mjsim.world.items.drives import (
    AnyDrive,
    BalancingDrive,
    DifferentialDrive,
    Drive,
    FixedDrive,
    UserDrive,
    WheelOdometry,
)
from mjsim.world.items.presets import over_preset
from mjsim.world.items.sensing import Imu, Sensor, name_of

Preset = Annotated[str, Field(pattern=PLAIN_PATTERN, max_length=200)]
"""Name of a preset, or path of its file."""


class Robot(Model):
    """A wheeled robot."""

    name: Name
    """Name in drivers, recordings and plans."""
    at: Point
    """Initial position, [x, y] [m]."""
    heading_deg: Degrees = 0.0
    """Initial heading, counter-clockwise from x."""
    lean_deg: Annotated[float, Field(ge=-60, le=60)] = 0.0
    """Initial pitch of a balancing base, forward positive; it is then released."""
    preset: Preset | None = None
    """A robot of `assets/robots`, or a preset file written by `mjsim new --robot-from`; keys beside this one override
    it."""
    base: Literal["fixed"] | None = None
    """fixed: the base does not move; it has no drive, and no body unless one is given."""
    drive: Drive = DifferentialDrive()
    """The drive."""
    body: Body = CylinderBody()
    """The body: shape for collisions, mass and appearance."""
    odometry: WheelOdometry = WheelOdometry()
    """Wheel odometry."""
    sensors: Annotated[tuple[Sensor, ...], Field(strict=False)] = ()
    """Sensors."""
    arms: Annotated[tuple[RobotArm, ...], Field(strict=False, max_length=8)] = ()
    """Arms on the robot."""
    proximity_range: Length = 2.0
    """Range of the ring of 16 proximity rays [m]."""
    group: Name | None = None
    """Group that the studio selects, moves and rotates together; no effect on runs."""

    @property
    def own_imu(self) -> Imu | None:
        """The inertial sensor available only to its controller; None if `sensors` has one, or none is needed."""
        return None if any(isinstance(sensor, Imu) for sensor in self.sensors) else self.drive.own_imu

    @model_validator(mode="after")
    def _has_a_name_of_its_own(self) -> Self:
        if message := reserved_fault(self.name, reserved=(*RESERVED, RUN)):
            raise fault(message, "name")
        return self

    @model_validator(mode="after")
    def _drive_on_its_body(self) -> Self:
        own = isinstance(self.drive, UserDrive)
        if own and not isinstance(self.body, ModelBody):
            raise fault("a user-defined drive needs a body from a model; give both drive: {use} and body: {model}")
        if isinstance(self.body, ModelBody):
            wrong = _own_misfit(self.body) if own else _model_misfit(self.body, self.drive)
            if wrong is not None:
                raise fault(wrong, "body")
        return self

    @model_validator(mode="after")
    def _balances_or_not(self) -> Self:
        if isinstance(self.drive, BalancingDrive):
            _check_balancing(self, self.drive)
        elif self.lean_deg:
            raise fault("only a balancing base leans at the start; leave it out", "lean_deg")
        elif isinstance(self.body, BoxBody) and self.body.center is not None:
            raise fault("center is measured from the axle of a balancing base; leave it out", "body", "center")
        return self

    @model_validator(mode="after")
    def _carries_its_sensors(self) -> Self:
        for index, sensor in enumerate(self.sensors):
            wrong = sensor.misfit(self)
            if wrong is not None:
                raise fault(wrong, "sensors", index, sensor.kind)
        return self

    @model_validator(mode="after")
    def _stands_or_rolls(self) -> Self:
        if self.base != "fixed" and isinstance(self.drive, FixedDrive):
            raise fault("a fixed robot has no drive; write base: fixed instead", "drive")
        if self.base != "fixed" and isinstance(self.body, NoBody):
            raise fault("a robot that drives has a body; give it one", "body")
        return self

    @model_validator(mode="after")
    def _fixed_base_feels_nothing(self) -> Self:
        for index, sensor in enumerate(self.sensors if self.base == "fixed" else ()):
            if sensor.kind in ("imu", "encoders") and getattr(sensor, "on", None) is None:
                message = Sentence("a fixed base has nothing that {kind} could measure; leave it out", sensor.kind)
                raise fault(message, "sensors", index, sensor.kind)
        return self

    @model_validator(mode="after")
    def _arms_have_names_of_their_own(self) -> Self:
        taken = TakenNames()
        for sensor in self.sensors:
            taken.fault(name_of(sensor), "a sensor of this robot")
        for index, arm in enumerate(self.arms):
            if arm.name == "drive" or arm.name.startswith("wheel_"):
                raise fault(
                    Sentence("arm name '{name}' is taken by a part of the base; give it another", arm.name),
                    "arms",
                    index,
                    "name",
                )
            if message := taken.fault(arm.name, "another arm of this robot"):
                raise fault(message, "arms", index, "name")
        return self

    @model_validator(mode="before")
    @classmethod
    def _over_preset(cls, keys: Any, info: ValidationInfo) -> Any:
        if isinstance(keys, dict) and isinstance(keys.get("preset"), str):
            source = (info.context or {}).get("source", BUILT)
            try:
                keys = over_preset(keys["preset"], keys, source)
            except ValueError as error:
                raise fault(str(error), "preset") from None
        return _standing(keys) if isinstance(keys, dict) and keys.get("base") == "fixed" else keys


def _standing(keys: dict[str, Any]) -> dict[str, Any]:
    """Return the keys of a robot with a fixed base, with placeholders for drive and body."""
    drive = keys.get("drive", _NO_DRIVE)
    if drive != _NO_DRIVE and not (isinstance(drive, dict) and drive.get("type") == "fixed"):
        raise fault("a fixed base has no drive; leave out the drive, or 'base: fixed'", "drive")
    return {"body": NoBody(shape="none"), **keys, "drive": _NO_DRIVE}


_NO_DRIVE = FixedDrive(type="fixed")
BALANCING_BODY = "a balancing base has body: {box: [length, width, height], mass, center}"


def _own_misfit(body: ModelBody) -> str | None:
    """Return why a body from a file does not fit a user-defined drive, or None."""
    if body.ready or body.steering or body.casters:
        return "a drive of your own names its wheels itself; leave out wheels, steering and casters"
    return None


def _model_misfit(body: ModelBody, drive: AnyDrive) -> str | None:
    """Return why a body from a file does not fit a built-in drive, or None."""
    if isinstance(drive, FixedDrive):
        return "a fixed base needs a plain body; a model is for robots that drive"
    if isinstance(drive, BalancingDrive):
        return BALANCING_BODY
    if not body.ready:
        return Sentence(
            "it does not name the joints of '{model}' that are its wheels; mjsim new --robot-from {model} -o"
            " ROBOT.yaml finds them",
            body.model,
        )
    for key, given, expected in (
        ("wheels", body.wheels, [wheel.name for wheel in drive.wheels]),
        ("steering", body.steering, list(drive.steering)),
    ):
        if sorted(given) != sorted(expected):
            found = Sentence("{key} are {given}", key, ", ".join(given)) if given else Sentence("it has no {key}", key)
            return Sentence("{found}; this drive has {expected}", found, ", ".join(expected) or "none")
    return None


def _check_balancing(robot: Robot, drive: BalancingDrive) -> None:
    """Raise if a balancing base has a body that cannot balance, or no inertial sensor."""
    body = robot.body
    if not isinstance(body, BoxBody) or body.center is None:
        raise fault(BALANCING_BODY, "body")
    body.stand_on(drive.wheel_radius, (drive.wheel_radius, drive.track / 2 + drive.wheels[0].half_width))
    low = body.height - body.box[2]
    if low <= 0.0:
        lowest = body.box[2] / 2 - drive.wheel_radius
        raise fault(
            Sentence("the body reaches {low:g} m into the floor; set center above {lowest:g}", -low, lowest),
            "body",
            "center",
        )
