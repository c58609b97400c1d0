"""What the page is told of a run, over the WebSocket and in answers; its protocol.ts is made from these types."""

from typing import Annotated, Any, Literal, NotRequired

from pydantic import ConfigDict, Field, with_config
from typing_extensions import TypeAliasType, TypedDict

_TOLD = with_config(ConfigDict(use_attribute_docstrings=True))

PlanarPose = TypeAliasType(
    "PlanarPose",
    Annotated[tuple[float, float, float], Field(description="x, y [m] and heading [rad, counter-clockwise from x].")],
)
_LANDMARK = Field(description="Mean x, y [m], then covariance xx, xy, yy [m^2].")
LandmarkRow = TypeAliasType("LandmarkRow", Annotated[tuple[float, float, float, float, float], _LANDMARK])
SightingRow = TypeAliasType(
    "SightingRow",
    Annotated[
        tuple[str | None, float, float],
        Field(description="Name, null when anonymous; horizontal range [m]; bearing [rad, left positive]."),
    ],
)
Pixel = TypeAliasType("Pixel", tuple[float, float])
Recognised = TypeAliasType(
    "Recognised",
    Annotated[tuple[str | None, list[Pixel]], Field(description="Name and corners [px] of a beacon in a picture.")],
)
RunState = TypeAliasType("RunState", Literal["idle", "loading", "running", "paused", "ended", "failed"])


@_TOLD
class CameraFacts(TypedDict):
    """A camera of a robot."""

    name: str
    width: int
    """[px]"""
    height: int
    """[px]"""


@_TOLD
class JointFacts(TypedDict):
    """A joint of an arm."""

    name: str
    slides: bool
    lower: float | None
    """[rad], or [m] where it slides; null without a limit."""
    upper: float | None


@_TOLD
class ArmFacts(TypedDict):
    """An arm of a robot."""

    name: str
    joints: list[JointFacts]


@_TOLD
class ArmTick(TypedDict):
    """An arm at one tick."""

    positions: list[float]
    """Of its joints [rad, m]."""
    goal: list[float]
    """Where they are to be [rad, m]."""
    tool: list[float]
    """x, y, z [m], roll, pitch, yaw about fixed axes [rad], in the robot's frame."""


JointRow = TypeAliasType(
    "JointRow",
    Annotated[
        tuple[float | None, float | None, float | None],
        Field(description="Position [rad, m], velocity [1/s], torque or force at the joint [N m, N]."),
    ],
)


@_TOLD
class JointGrip(TypedDict):
    """By which point a hand moves a joint; all in the world frame [m]."""

    of: str
    """`ROBOT/ARM`, or the mechanism."""
    joint: str
    slides: bool
    at: tuple[float, float, float]
    """A point of its axis."""
    axis: tuple[float, float, float]
    """About which, or along which, its value grows."""
    grip: tuple[float, float, float]
    """What the hand takes."""


@_TOLD
class MechanismFacts(TypedDict):
    """A mechanism, and the joints of it that motions lead."""

    name: str
    joints: list[JointFacts]


@_TOLD
class MechanismTick(TypedDict):
    """A mechanism at one tick."""

    positions: list[float]
    """Of the joints that motions lead [rad, m]."""


@_TOLD
class RobotFacts(TypedDict):
    """What is shown of a robot that does not change."""

    name: str
    radius: float
    """[m]"""
    outline: list[tuple[float, float]] | None
    """Of its footprint, in its own frame [m]."""
    rims: list[float]
    """From its origin to where the rays of the ring begin, the first one ahead, counter-clockwise [m]."""
    color: str | None
    cameras: list[CameraFacts]
    can_drive: bool
    """Whether it has a drive."""
    can_strafe: bool
    arms: list[ArmFacts]


@_TOLD
class Chosen(TypedDict):
    """Which modules drive a robot: what `use:` says, null for none."""

    observer: str | None
    estimator: str | None
    navigator: str | None
    avoidance: bool | str


@_TOLD
class NoiseFigure(TypedDict):
    """A figure of the world that may be changed while it runs."""

    key: str
    label: str
    value: float | None
    """null: nothing is said, and there is none."""
    initial: float | None
    """What the world says."""
    unit: str | None
    description: str | None
    slider: list[float] | None
    """Both ends of the useful part of its range; null: the unit is enough to choose one."""


@_TOLD
class RunNews(TypedDict):
    """What the run is and does."""

    kind: Literal["run"]
    state: RunState
    error: NotRequired[str | None]
    path: str | None
    name: str | None
    time: float
    """Simulated [s]."""
    seconds: float | None
    """How long it is to be [s]; null without end."""
    dt: float
    """One tick [s]."""
    seed: int | None
    speed: float | None
    """Simulated seconds per second that are wanted; null for as fast as it goes."""
    robots: list[RobotFacts]
    mechanisms: NotRequired[list[MechanismFacts]]
    """Those of which a joint can be led by hand."""
    joints: NotRequired[dict[str, list[JointFacts]]]
    """All joints: of arms by `ROBOT/ARM`, of balancing bases by `ROBOT/drive`, of mechanisms by their names."""
    controllable: bool
    recording: NotRequired[str | None]
    drivers: NotRequired[dict[str, Chosen]]
    noise: NotRequired[list[NoiseFigure]]
    touched: NotRequired[list[dict[str, Any]]]
    """What was done by hand since the start, as events of a world file."""


@_TOLD
class EventNews(TypedDict):
    """Something that happened to a robot or to the world."""

    kind: Literal["event"]
    time: float
    """Simulated [s]."""
    robot: str | None
    """null: to the world."""
    event: str
    text: str


@_TOLD
class TrackHistory(TypedDict):
    """Path and figures of one robot; all lists are equally long."""

    time: list[float]
    truth: list[PlanarPose]
    estimate: list[PlanarPose]
    odometry: list[PlanarPose]
    sigma: list[PlanarPose]
    """Standard deviations of x, y [m] and heading [rad]."""
    error: list[float | None]
    """Distance of the estimate from the truth [m]."""
    heading_error: list[float | None]
    """[rad]"""
    nees: list[float | None]
    """Null where the covariance is singular, or no estimator there."""
    estimated: bool
    """Whether an estimator gives the estimate; else it is dead reckoning."""
    timing: dict[str, list[float | None]]
    """Wall-clock time of each module [ms]."""


@_TOLD
class PastNews(TypedDict):
    """All that was until now, for browsers that come late."""

    kind: Literal["past"]
    robots: dict[str, TrackHistory]
    events: list[EventNews]


@_TOLD
class ShownNews(TypedDict):
    """Something that an estimator shows: points, lines, a grid or a text; which it is, its keys tell."""

    name: str
    frame: Literal["world", "estimate", "base"]
    """Of its numbers: the world, the robot as estimated, or as it truly is."""
    color: str
    points: NotRequired[list[float]]
    """x, y, z of one after the other; of a text where it stands [m]."""
    lines: NotRequired[list[float]]
    """The same, of lines through them."""
    joined: NotRequired[bool]
    """Whether each point of lines is joined to the next; else every two are a line."""
    size: NotRequired[float]
    """Across a point, a line or a cell [m]."""
    text: NotRequired[str]
    png: NotRequired[str]
    """Cells of a grid as grey levels, the first row at the top: 0 occupied to 254 free, 255 unknown; base64."""
    origin: NotRequired[PlanarPose]
    """Of the lower left corner of a grid."""
    cells: NotRequired[tuple[int, int]]
    """Columns and rows of a grid."""


@_TOLD
class RobotTick(TypedDict):
    """One robot at one tick."""

    truth: PlanarPose
    estimate: PlanarPose
    odometry: PlanarPose
    covariance: list[float]
    """Of x, y, heading, row by row."""
    landmarks: dict[str, LandmarkRow]
    sightings: list[SightingRow]
    error: float
    """Distance of the estimate from the truth [m]."""
    heading_error: float
    """[rad]"""
    nees: float | None
    """Null where the covariance is singular, or no estimator there."""
    estimated: bool
    """Whether an estimator gives the estimate; else it is dead reckoning."""
    timing: dict[str, float]
    """[ms]"""
    command: tuple[float, float, float]
    """Forward, left [m/s], turn [rad/s]."""
    proximity: NotRequired[list[float | None]]
    """Ranges of the ring, the first one ahead, counter-clockwise [m]; null for nothing near."""
    recognised: NotRequired[list[Recognised]]
    """What was recognised in its pictures; of recordings alone."""
    bump: NotRequired[list[float]]
    """Bearings of contacts now [rad]."""
    arms: NotRequired[dict[str, ArmTick]]
    """By name."""
    scans: NotRequired[dict[str, list[float]]]
    """Where the beams of each lidar met something: x, y, z of one after the other, world frame [m]."""
    show: NotRequired[list[ShownNews]]
    """What the estimator shows; left out for nothing."""


@_TOLD
class TickNews(TypedDict):
    """One tick of the loop."""

    kind: Literal["tick"]
    number: int
    time: float
    """Simulated [s]."""
    pace: float
    """Simulated seconds per second."""
    robots: dict[str, RobotTick]
    things: dict[str, PlanarPose]
    """Where everything is that can move but robots, by its name in the scene."""
    mechanisms: NotRequired[dict[str, MechanismTick]]
    """Those that have a joint that a motion leads, by name."""
    hands: NotRequired[dict[str, dict[str, tuple[float, float, float]]]]
    """Where the grips of people are, by person and side [m]; left out where there is nobody."""
    people: NotRequired[dict[str, list[list[tuple[float, float]]]]]
    """Outlines from above of people whose hands were led, the lowest part first [m]; left out for none."""
    joints: NotRequired[dict[str, dict[str, JointRow]]]
    """How joints move, by arm, base or mechanism and by their names; left out where there are none."""
    bodies: NotRequired[dict[str, list[list[tuple[float, float]]]]]
    """Outlines from above of arms, and of mechanisms that do not stand as at the start, the lowest part first [m]."""
    grips: NotRequired[list[JointGrip]]
    """By which points joints are moved by hand."""
    removed: NotRequired[list[str]]
    """Names of the beacons and obstacles that are away; left out for none."""


@_TOLD
class Item(TypedDict):
    """An item of a world as the plan, the panel and the outline show it."""

    path: list[str | int]
    kind: str
    name: str | None
    label: str
    at: tuple[float, float] | None
    heading_deg: float | None
    polygons: list[list[tuple[float, float]]]
    """Outlines in the world frame [m]."""
    values: dict[str, object]
    written: list[str]
    raw: NotRequired[dict[str, object]]
    """As it stands in the text: before defaults, presets and arithmetic."""
    computed: NotRequired[list[str]]
    """Keys whose values are arithmetic; those cannot be set from here."""
    type: str
    """Name of its definition in the schema."""
    fixed: str | None
    """Why it cannot be changed here."""
    origin: Literal["repeat", "include"] | None
    """Where it comes from when it is no item of the text itself."""
    line: int


@_TOLD
class SceneNews(TypedDict):
    """What a plan of the run's world shows."""

    kind: Literal["scene"]
    items: list[Item]
    bounds: tuple[float, float, float, float]


@_TOLD
class RefusedNews(TypedDict):
    """A request that was refused."""

    kind: Literal["refused"]
    do: str
    error: str
    needs_trust: NotRequired[dict[str, str]]
    """Code that the person has not allowed yet: files with the SHA-256 of their content, installed classes with ''."""


@_TOLD
class ShortNews(TypedDict):
    """A hand that was led by the page does not reach its target."""

    kind: Literal["short"]
    person: str
    hand: str
    """left or right."""
    metres: float
    """How far it stays away [m]."""


@_TOLD
class FrameHead(TypedDict):
    """What stands before a picture, or before where bodies are."""

    number: int
    view: str
    """`ROBOT/CAMERA`, the same with `:depth` or `:segmentation`, `outside`, or `bodies`."""
    time: float
    """Simulated [s]."""
    recognised: list[Recognised]
    scale: NotRequired[tuple[float, float]]
    """Distances at the near and the far end of the colours of a picture of depth [m]."""


News = TypeAliasType("News", RunNews | SceneNews | PastNews | TickNews | EventNews | RefusedNews | ShortNews)
