"""Messages to the page about joints: of arms and of mechanisms."""

from typing import Annotated, NotRequired

from pydantic import ConfigDict, Field, with_config
from typing_extensions import TypeAliasType, TypedDict

_DOCUMENTED = with_config(ConfigDict(use_attribute_docstrings=True))


@_DOCUMENTED
class JointFacts(TypedDict):
    """A joint of an arm."""

    name: str
    slides: bool
    lower: float | None
    """[rad], or [m] for a sliding joint; null without a limit."""
    upper: float | None
    held: NotRequired[bool]
    """In a mechanism: whether a hand pulls it against its forces; otherwise the hand replaces its motion."""
    period: NotRequired[float]
    """Length of the closed curve along which it moves [m]; its position grows with each lap."""


@_DOCUMENTED
class ArmFacts(TypedDict):
    """An arm of a robot."""

    name: str
    joints: list[JointFacts]


@_DOCUMENTED
class ArmTick(TypedDict):
    """An arm at one tick."""

    positions: list[float]
    """Joint positions [rad, m]."""
    goal: list[float]
    """Goal positions [rad, m]."""
    tool: list[float]
    """x, y, z [m], roll, pitch, yaw about fixed axes [rad], in the robot's frame."""


JointRow = TypeAliasType(
    "JointRow",
    Annotated[
        tuple[float | None, float | None, float | None],
        Field(description="Position [rad, m], velocity [1/s], torque or force at the joint [N m, N]."),
    ],
)


@_DOCUMENTED
class BallFrame(TypedDict):
    """The frame in which a ball joint has its rotation vector."""

    axes: list[float]
    """Its x, y and z axis in the world frame, nine numbers."""
    way: int
    """1, or -1 if the rotation is that of the carrying body relative to the carried one."""


@_DOCUMENTED
class CurveFrame(TypedDict):
    """The current curve along which a point moves."""

    points: list[float]
    """x, y, z of points at equal distances along it, in sequence, world frame [m]; the last is at its end."""
    length: float
    """[m]"""
    closed: bool
    along: float
    """Position of the point, from the first one [m]."""


@_DOCUMENTED
class JointGrip(TypedDict):
    """The point by which a joint is dragged; all in the world frame [m]."""

    of: str
    """`ROBOT/ARM`, or the mechanism."""
    joint: str
    slides: bool
    at: tuple[float, float, float]
    """A point on its axis."""
    axis: tuple[float, float, float]
    """Unit vector of the axis about or along which its value increases."""
    grip: tuple[float, float, float]
    """The point to drag."""
    ball: NotRequired[BallFrame]
    """Frame of a ball joint, which has no axis; omitted for others."""
    curve: NotRequired[CurveFrame]
    """Curve of a point that slides along it, whose axis is its tangent; omitted for others."""
    toward: NotRequired[tuple[float, float, float]]
    """In a mechanism with one degree of freedom and loops: how the point moves with the value, as its axis moves too
    [m, m/rad]."""
    loop: NotRequired[bool]
    """Whether the joint is in a mechanism with loops: its axis may move with its value."""


@_DOCUMENTED
class MechanismFacts(TypedDict):
    """A mechanism, and the joints of it that can be led."""

    name: str
    joints: list[JointFacts]


@_DOCUMENTED
class MechanismTick(TypedDict):
    """A mechanism at one tick."""

    positions: list[float]
    """Positions of the joints that can be led [rad, m]."""
