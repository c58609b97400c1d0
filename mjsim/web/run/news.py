"""Messages to the page about a run, over the WebSocket and in responses; protocol.ts is generated from these types."""

from typing import Annotated, Any, Literal, NotRequired

from pydantic import ConfigDict, Field, with_config
from typing_extensions import TypeAliasType, TypedDict

from mjsim.web.run.joint_news import (
    ArmFacts,
    ArmTick,
    JointFacts,
    JointGrip,
    JointRow,
    MechanismFacts,
    MechanismTick,
)

_DOCUMENTED = with_config(ConfigDict(use_attribute_docstrings=True))

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


@_DOCUMENTED
class CameraFacts(TypedDict):
    """A camera of a robot."""

    name: str
    width: int
    """[px]"""
    height: int
    """[px]"""


@_DOCUMENTED
class RobotFacts(TypedDict):
    """Constant properties of a robot."""

    name: str
    radius: float
    """[m]"""
    outline: list[tuple[float, float]] | None
    """Footprint, in its own frame [m]."""
    rims: list[float]
    """Distances from its origin to the start of its proximity rays, the first one forward, counter-clockwise [m]."""
    color: str | None
    cameras: list[CameraFacts]
    can_drive: bool
    """Whether it has a drive."""
    can_strafe: bool
    arms: list[ArmFacts]


@_DOCUMENTED
class Chosen(TypedDict):
    """Modules that drive a robot: their `use:`, null for none."""

    observer: str | None
    estimator: str | None
    navigator: str | None
    avoidance: bool | str


@_DOCUMENTED
class NoiseFigure(TypedDict):
    """A parameter of the world that may be changed during a run."""

    key: str
    label: str
    value: float | None
    """null: not set, so there is none."""
    initial: float | None
    """Value in the world."""
    unit: str | None
    description: str | None
    slider: list[float] | None
    """Useful range for a slider; null: choose one from the unit."""


@_DOCUMENTED
class RunNews(TypedDict):
    """The run and its state."""

    kind: Literal["run"]
    number: int
    """Counts the runs, from 1; a restart is the same run. Of states that follow fast on each other only the last is
    certain to arrive."""
    state: RunState
    error: NotRequired[str | None]
    path: str | None
    name: str | None
    time: float
    """Simulated time [s]."""
    seconds: float | None
    """Planned duration [s]; null without end."""
    dt: float
    """Duration of a tick [s]."""
    seed: int | None
    speed: float | None
    """Requested simulated seconds per second; null for as fast as possible."""
    robots: list[RobotFacts]
    mechanisms: NotRequired[list[MechanismFacts]]
    """Mechanisms with a joint that can be dragged."""
    joints: NotRequired[dict[str, list[JointFacts]]]
    """All joints: of arms by `ROBOT/ARM`, of balancing bases by `ROBOT/drive`, of mechanisms by name."""
    controllable: bool
    recording: NotRequired[str | None]
    drivers: NotRequired[dict[str, Chosen]]
    noise: NotRequired[list[NoiseFigure]]
    touched: NotRequired[list[dict[str, Any]]]
    """Manual interventions since the start, as events of a world file."""


@_DOCUMENTED
class EventNews(TypedDict):
    """An event that concerns a robot or the world."""

    kind: Literal["event"]
    time: float
    """Simulated time [s]."""
    robot: str | None
    """null: the world."""
    event: str
    text: str
    motion: NotRequired[int]
    """Number of a motion; a later event with the same number replaces this one."""


@_DOCUMENTED
class TrackHistory(TypedDict):
    """Path and errors of one robot; all lists have the same length."""

    time: list[float]
    truth: list[PlanarPose]
    estimate: list[PlanarPose]
    odometry: list[PlanarPose]
    sigma: list[PlanarPose]
    """Standard deviations of x, y [m] and heading [rad]."""
    error: list[float | None]
    """Distance of the estimate from the truth [m]."""
    heading_error: list[float | None]
    """Heading error [rad]."""
    nees: list[float | None]
    """Null if the covariance is singular, or if there is no estimator."""
    estimated: bool
    """Whether an estimator gives the estimate; otherwise it is dead reckoning."""
    timing: dict[str, list[float | None]]
    """Wall-clock time of each module [ms]."""


@_DOCUMENTED
class PastNews(TypedDict):
    """The history until now, for browsers that join late."""

    kind: Literal["past"]
    robots: dict[str, TrackHistory]
    events: list[EventNews]


@_DOCUMENTED
class ShownNews(TypedDict):
    """An item that an estimator shows: points, lines, a grid or a text; its keys show which."""

    name: str
    frame: Literal["world", "estimate", "base"]
    """Frame of its numbers: the world, the robot as estimated, or the true robot."""
    color: str
    points: NotRequired[list[float]]
    """x, y, z of each point in sequence; for a text, its position [m]."""
    lines: NotRequired[list[float]]
    """The same for the points of lines."""
    joined: NotRequired[bool]
    """Whether consecutive points are connected; otherwise each pair of points is a line."""
    size: NotRequired[float]
    """Size of a point, a line or a cell [m]."""
    text: NotRequired[str]
    png: NotRequired[str]
    """Cells of a grid as grey levels, the first row at the top: 0 occupied to 254 free, 255 unknown; base64."""
    origin: NotRequired[PlanarPose]
    """Pose of the lower left corner of a grid."""
    cells: NotRequired[tuple[int, int]]
    """Columns and rows of a grid."""


@_DOCUMENTED
class RobotTick(TypedDict):
    """One robot at one tick."""

    truth: PlanarPose
    estimate: PlanarPose
    odometry: PlanarPose
    covariance: list[float]
    """Covariance of x, y, heading, row by row."""
    landmarks: dict[str, LandmarkRow]
    sightings: list[SightingRow]
    error: float
    """Distance of the estimate from the truth [m]."""
    heading_error: float
    """Heading error [rad]."""
    nees: float | None
    """Null if the covariance is singular, or if there is no estimator."""
    estimated: bool
    """Whether an estimator gives the estimate; otherwise it is dead reckoning."""
    timing: dict[str, float]
    """[ms]"""
    command: tuple[float, float, float]
    """Forward, left [m/s], turn [rad/s]."""
    proximity: NotRequired[list[float | None]]
    """Ranges of the proximity rays, the first one forward, counter-clockwise [m]; null for no hit."""
    recognised: NotRequired[list[Recognised]]
    """What was recognised in its pictures; only for recordings."""
    bump: NotRequired[list[float]]
    """Bearings of contacts since the last tick [rad]."""
    arms: NotRequired[dict[str, ArmTick]]
    """By name of the arm."""
    scans: NotRequired[dict[str, list[float]]]
    """Points hit by the beams of each lidar: x, y, z of each in sequence, world frame [m]."""
    show: NotRequired[list[ShownNews]]
    """Items that the estimator shows; omitted if there are none."""


@_DOCUMENTED
class TickNews(TypedDict):
    """One tick of the loop."""

    kind: Literal["tick"]
    number: int
    time: float
    """Simulated time [s]."""
    pace: float
    """Simulated seconds per second."""
    robots: dict[str, RobotTick]
    things: dict[str, PlanarPose]
    """Poses of all movable objects except robots, by name in the scene."""
    mechanisms: NotRequired[dict[str, MechanismTick]]
    """Mechanisms with a joint that a motion leads, by name."""
    hands: NotRequired[dict[str, dict[str, tuple[float, float, float]]]]
    """Grip positions of people, by person and side [m]; omitted without people."""
    people: NotRequired[dict[str, list[list[tuple[float, float]]]]]
    """Outlines from above of people whose hands were moved, the lowest part first [m]; omitted if there are none."""
    joints: NotRequired[dict[str, dict[str, JointRow]]]
    """Motion of joints, by arm, base or mechanism and by name; omitted if there are none."""
    bodies: NotRequired[dict[str, list[list[tuple[float, float]]]]]
    """Outlines from above of arms, and of mechanisms away from their start values, the lowest part first [m]."""
    grips: NotRequired[list[JointGrip]]
    """The points by which joints are dragged."""
    removed: NotRequired[list[str]]
    """Names of removed beacons and obstacles; omitted if there are none."""


@_DOCUMENTED
class PlanShape(TypedDict):
    """A part of an item's drawing; an area to scale fills polygons of the item, all others have parts of their own."""

    role: str
    """Its look is that of `ROLES`."""
    tint: NotRequired[str]
    """Own colour of the thing, '#rrggbb'."""
    level: NotRequired[float]
    """Strength of its fill, from 0 to 1; 1 if omitted."""
    count: NotRequired[int]
    """How many polygons of the item it fills, in turn."""
    parts: NotRequired[list[list[tuple[float, float]]]]
    """Lines, or outlines if `closed`, from the pose of the item [m]."""
    closed: NotRequired[bool]
    anchor: NotRequired[tuple[float, float, float]]
    """A symbol of the same size at each scale: its pose from that of the item (x, y [m], heading [deg]); its parts are
    in millimetres on paper from there."""
    fixed: NotRequired[bool]
    """Whether it stays where it is when the item moves in a run."""
    carrier: NotRequired[tuple[float, float, float]]
    """Initial pose of what it moves with, world frame (x, y [m], heading [deg]); that of the item if omitted."""


@_DOCUMENTED
class Item(TypedDict):
    """An item of a world for the plan, the panel and the outline."""

    path: list[str | int]
    kind: str
    name: str | None
    label: str
    at: tuple[float, float] | None
    heading_deg: float | None
    polygons: list[list[tuple[float, float]]]
    """Outlines in the world frame [m]."""
    shapes: list[PlanShape]
    """What is drawn of it, from the floor up."""
    values: dict[str, object]
    written: list[str]
    raw: NotRequired[dict[str, object]]
    """Its keys as in the text, before defaults, presets and arithmetic."""
    computed: NotRequired[list[str]]
    """Keys with expressions as values; these cannot be set here."""
    type: str
    """Name of its definition in the schema."""
    fixed: str | None
    """Why it cannot be changed here."""
    origin: Literal["repeat", "include"] | None
    """Where it comes from, if it is not an item of the text itself."""
    line: int


@_DOCUMENTED
class SceneNews(TypedDict):
    """The plan of the run's world."""

    kind: Literal["scene"]
    items: list[Item]
    bounds: tuple[float, float, float, float]


@_DOCUMENTED
class RefusedNews(TypedDict):
    """A request that was refused."""

    kind: Literal["refused"]
    do: str
    error: str
    needs_trust: NotRequired[dict[str, str]]
    """Code that the user has not allowed yet: files with the SHA-256 of their content, installed classes with ''."""


@_DOCUMENTED
class ShortNews(TypedDict):
    """A hand or tool that the page moved does not reach its target.

    A hand, and a tool that is dragged, comes as near as it can; otherwise a tool stays where it was.
    """

    kind: Literal["short"]
    of: str
    part: str
    """left or right for a person's hand, else the arm of a robot."""
    metres: float
    """Distance to the target [m]."""


@_DOCUMENTED
class TouchedNews(TypedDict):
    """A touch of this page was accepted; a touch is answered with this, `short` or `refused`."""

    kind: Literal["touched"]


@_DOCUMENTED
class FrameHead(TypedDict):
    """Header of a picture, or of the poses of bodies."""

    number: int
    view: str
    """`ROBOT/CAMERA`, the same with `:depth` or `:segmentation`, `outside`, or `bodies`."""
    time: float
    """Simulated time [s]."""
    recognised: list[Recognised]
    scale: NotRequired[tuple[float, float]]
    """Distances at the near and the far end of the colour scale of a depth picture [m]."""


News = TypeAliasType(
    "News", RunNews | SceneNews | PastNews | TickNews | EventNews | RefusedNews | ShortNews | TouchedNews
)
