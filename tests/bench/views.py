"""A room with pictures or markers, drawn from any place with the truth beside it, for tests of recognition."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path

import cv2
import mujoco
import numpy as np

from mjsim.bench.rooms import forwarded, look_from
from mjsim.compile import compile_world
from mjsim.geometry import Array
from mjsim.interface import Detection, Intrinsics, Picture
from mjsim.sim import Canvas, Renderer
from mjsim.sim.imaging.lens import intrinsics_of
from mjsim.world import Camera, Source, World, parse_world

POSTERS = Path(str(files("mjsim.assets"))) / "posters"
KNOWN = ("lion", "owl", "whale", "moon", "key", "cat", "fish", "pear", "anchor", "rocket", "tulip", "castle")
STRANGE = ("crown", "daisy", "kite", "snail")
"""They hang here too, but are not searched for."""
ABSENT = ("guitar", "penguin", "teapot", "volcano", "sunrise", "mushroom")
WIDTH = 0.6


def project(points: Array, intrinsics: Intrinsics) -> Array:
    """Return the image of points in the camera's frame, shape (n, 2) [px]."""
    focal, middle = (intrinsics.fx, intrinsics.fy), (intrinsics.cx, intrinsics.cy)
    return np.asarray(points[:, :2] / points[:, 2:] * focal + middle)


def read_posters(names: tuple[str, ...]) -> dict[str, Picture]:
    return {
        name: np.asarray(cv2.imread(str(POSTERS / f"{name}.jpg"), cv2.IMREAD_COLOR_RGB), dtype=np.uint8)
        for name in names
    }


PICTURES = read_posters(KNOWN + STRANGE)
SIZES = {name: (WIDTH, WIDTH * picture.shape[0] / picture.shape[1]) for name, picture in PICTURES.items()}
INTRINSICS = intrinsics_of(Camera(camera="front"))
HANGING = "".join(
    f"  - {{name: {name}, image: posters/{name}.jpg, at: [0.07, {2.0 + 1.1 * k:.1f}], width: {WIDTH}, center: 1.2}}\n"
    for k, name in enumerate(KNOWN + STRANGE)
)
ROOM = f"""
mjsim: 1
walls:
  - {{points: [[0, -4], [9, -4], [9, 24], [0, 24]], closed: true}}
floor: {{texture: floors/oak.jpg}}
beacons:
{HANGING}robots:
  - {{name: scout, at: [4, 4], sensors: [{{camera: front, noise: 0}}]}}
"""


@dataclass(frozen=True)
class Shot:
    """A view with its truth."""

    image: Picture
    positions: dict[str, Array]
    """Of the pictures' middles in the optical frame [m]."""
    whole: frozenset[str]
    """Which pictures are whole in the image."""
    right: Array
    """To the right along the pictures, in the optical frame, shape (3,)."""


class Studio:
    """Draws views of the room."""

    def __init__(
        self,
        text: str = ROOM,
        sizes: Mapping[str, tuple[float, float]] = SIZES,
        files: Mapping[str, bytes] | None = None,
    ) -> None:
        """Build a room whose beacons have given widths and heights [m]; files are those that it names."""
        self.sizes = sizes
        self.world: World = parse_world(text, source=Source(attached=files or {}))
        self.model = compile_world(self.world).compile()
        self.data = forwarded(self.model)
        self.canvas = Canvas(self.model)
        self.renderer = Renderer(self.model, width=640, height=480, canvas=self.canvas)

    def shoot(self, at: Array, ahead: Array, *, noise: float = 0.0, rng: np.random.Generator | None = None) -> Shot:
        """Look from a place [m] in a level direction."""
        mujoco.mj_forward(self.model, self.data)
        look_from(self.model, self.data, "scout/front", at, ahead)
        image = self.renderer.render(self.data, "scout/front").copy()
        if rng is not None:
            image = np.clip(np.rint(image + rng.normal(0.0, noise, image.shape)), 0, 255).astype(np.uint8)
        z = ahead / np.linalg.norm(ahead)
        x = np.array([z[1], -z[0], 0.0])
        camera_from_world = np.stack([x, np.cross(z, x), z])
        positions, whole = {}, set()
        for beacon in self.world.beacons:
            middle = np.array([*beacon.at, beacon.center])
            positions[beacon.name] = camera_from_world @ (middle - at)
            half = np.array([0.0, *self.sizes[beacon.name]]) / 2
            corners = (middle + half * [[0, -1, -1], [0, -1, 1], [0, 1, 1], [0, 1, -1]] - at) @ camera_from_world.T
            if corners[:, 2].min() > 0.1:
                pixels = project(corners, INTRINSICS)
                if np.all((pixels > 2.0) & (pixels < (637.0, 477.0))):
                    whole.add(beacon.name)
        # Who looks at the pictures, against x, has y to the right.
        return Shot(image, positions, frozenset(whole), camera_from_world @ [0.0, 1.0, 0.0])

    def before(
        self,
        name: str,
        distance: float,
        yaw_deg: float,
        *,
        aside_deg: float = 0.0,
        rng: np.random.Generator | None = None,
    ) -> Shot:
        """Look at a picture from a distance [m], from the side by yaw, with it aside from the image's middle."""
        beacon = next(beacon for beacon in self.world.beacons if beacon.name == name)
        yaw, look = np.radians(yaw_deg), np.radians(yaw_deg + 180.0 + aside_deg)
        at = np.array([*beacon.at, beacon.center]) + distance * np.array([np.cos(yaw), np.sin(yaw), 0.0])
        return self.shoot(at, np.array([np.cos(look), np.sin(look), 0.0]), noise=2.0, rng=rng)


def polar(position: Array) -> tuple[float, float]:
    """Return horizontal range [m] and bearing [deg] of a position in the optical frame."""
    return float(np.hypot(position[0], position[2])), float(np.degrees(np.arctan2(-position[0], position[2])))


def distance_squared(found: Detection, truth: Array) -> float:
    """Return the squared Mahalanobis distance of a detection from the truth."""
    error = found.position - truth
    return float(error @ np.linalg.solve(found.covariance, error))


MARKERS = {f"tag-{k}": 3 * k for k in range(12)}
"""Name -> number."""
STRANGE_MARKERS = (1, 2)


def marker_room(dictionary: str, width: float) -> str:
    """Return a room like the other, with markers."""
    numbers = [*MARKERS.items(), *((f"stranger-{number}", number) for number in STRANGE_MARKERS)]
    hanging = "".join(
        f"  - {{name: {name}, marker: {{dictionary: {dictionary}, id: {number}}}, at: [0.07, {2.0 + 1.1 * k:.1f}],"
        f" width: {width}, center: 1.2}}\n"
        for k, (name, number) in enumerate(numbers)
    )
    return ROOM.replace(HANGING, hanging).replace("[9, -4], [9, 24]", "[12, -4], [12, 24]")


def marker_sizes(width: float) -> dict[str, tuple[float, float]]:
    """Return width and height of each marker of `marker_room` [m]."""
    return {name: (width, width) for name in (*MARKERS, *(f"stranger-{number}" for number in STRANGE_MARKERS))}


@dataclass
class Tally:
    """What many views show of a finder."""

    found: dict[int, list[int]] = field(default_factory=lambda: {30: [0, 0], 45: [0, 0]})
    """Of views with yaw up to 30 and up to 45 degrees: in how many it was found, and how many there were."""
    errors: list[tuple[float, float]] = field(default_factory=list)
    """Range error as a share, bearing error [deg]."""
    distances: list[float] = field(default_factory=list)
    """Squared Mahalanobis distances of positions, three states."""
    gross: int = 0
    """Wrong identity, or over 10 % range or 2 degrees off."""

    def add(self, name: str, yaw_deg: float, shot: Shot, detections: Iterable[Detection]) -> None:
        """Count one view that was taken of one beacon."""
        found = {each.name: each for each in detections}
        for each in found.values():
            if each.name not in shot.positions:
                self.gross += 1
                continue
            (distance, bearing), (truth, direction) = polar(each.position), polar(shot.positions[each.name])
            self.errors.append((abs(distance / truth - 1.0), abs(bearing - direction)))
            self.gross += self.errors[-1][0] > 0.1 or self.errors[-1][1] > 2.0
        if name in shot.whole:
            count = self.found[30 if abs(yaw_deg) <= 30.0 else 45]
            count[0] += name in found
            count[1] += 1
            if name in found:
                self.distances.append(distance_squared(found[name], shot.positions[name]))
