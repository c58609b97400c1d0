"""Ticks made by hand from seeded numbers, for the tests of the recording."""

from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path

import numpy as np

from mjsim.geometry import Pose, Pose3
from mjsim.interface import (
    CameraFrame,
    Command,
    Estimate,
    Intrinsics,
    Observation,
    Odometry,
    RobotInfo,
    SensorInfo,
    ShownGrid,
    ShownLines,
    ShownPoints,
    ShownText,
    Sighting,
    WheelCommand,
)
from mjsim.record import Order, Recorder, RobotEvent, Tick
from mjsim.world import World, parse_world
from tests.robots import pioneer

ROBOTS = ("scout", "7.tip_top-2")
DT = 0.04
_SHOWN = (
    ShownPoints(name="particles", points=[[1.5, 2.25], [0.1, -3.0]]),
    ShownLines(name="path", points=[[0, 0, 1], [1, 0.3, 1]], frame="estimate"),
    ShownGrid(name="map", cells=[[0.0, 1.0]], resolution=0.5),
    ShownText(name="note", text="here", at=(1.0, 2.0)),
)
TEXT = """mjsim: 1
name: hand-made  # a comment that stays
walls:
  - points: [[0, 0], [6, 0], [6, 4], [0, 4]]
    closed: true
    openings: [{segment: 0, at: 2.0, width: 0.9}]
obstacles:
  - {box: [0.8, 0.5, 1.1], at: [3, 2], heading_deg: 30}
  - {cylinder: [0.2, 1.0], at: [5, 1]}
beacons:
  - {name: lion, at: [5.9, 2], heading_deg: 180}
robots:
  - name: scout
    at: [1, 1]
    sensors: [{camera: front, width: 64, height: 48}]
  - {name: 7.tip_top-2, at: [4, 3]}
"""
INTRINSICS = Intrinsics(64, 48, 55.4, 55.4, 31.5, 23.5)
CAMERA = SensorInfo(
    kind="camera",
    robot_from_sensor=np.array([[0, 0, 1, 0.15], [-1, 0, 0, 0], [0, -1, 0, 0.3], [0, 0, 0, 1.0]]),
    rate_hz=12.5,
    intrinsics=INTRINSICS,
)


def hand_made_world() -> World:
    return parse_world(TEXT)


def infos() -> dict[str, RobotInfo]:
    return {name: pioneer(name=name, dt=DT, sensors={"front": CAMERA} if name == "scout" else {}) for name in ROBOTS}


def record(path: Path, ticks: Iterable[Tick], **metadata: str) -> Path:
    with Recorder(path, world=hand_made_world(), seed=5, robots=infos(), metadata=metadata) as recorder:
        for tick in ticks:
            recorder.write(tick)
    return path


def hand_made_ticks(
    count: int, *, seed: int = 0, landmarks: int = 3, size: tuple[int, int] = (48, 64)
) -> Iterator[Tick]:
    """Yield ticks full of seeded numbers; scout has pictures on every second tick, and a map that grows and rests."""
    rng = np.random.default_rng(seed)
    belief: dict = {}
    for k in range(count):
        now = k * DT
        if k % 2 == 0:
            names = ["lion", 7, "7", "Infinity", *range(100, 100 + landmarks)]
            belief = {name: (rng.normal(size=2), _covariance(rng, 2)) for name in names[: min(len(names), 1 + k // 2)]}
        truth = {name: _pose(rng) for name in ROBOTS}
        yield Tick(
            time=now,
            truth=truth,
            poses={name: Pose3.from_planar(pose) for name, pose in truth.items()},
            seen={name: _observation(rng, now, k, camera=name == "scout" and k % 2 == 0, size=size) for name in ROBOTS},
            orders={name: _order(rng, now, k, belief if name == "scout" else {}) for name in ROBOTS},
            qpos=rng.normal(size=14),
            qvel=rng.normal(size=12),
            timing={"sense": 0.001, "step": 0.002},
        )


def _covariance(rng: np.random.Generator, size: int) -> np.ndarray:
    root = rng.normal(size=(size, size))
    return root @ root.T


def _pose(rng: np.random.Generator) -> Pose:
    return Pose(*rng.uniform(-3, 3, 3).tolist())


def _sighting(rng: np.random.Generator, now: float, name: str | None, corners: bool) -> Sighting:
    return Sighting(
        stamp=now,
        name=name,
        range=rng.uniform(1, 5),
        bearing=rng.uniform(-1, 1),
        covariance=_covariance(rng, 2),
        corners=rng.uniform(0, 60, (4, 2)) if corners else None,
    )


def _observation(rng: np.random.Generator, now: float, k: int, *, camera: bool, size: tuple[int, int]) -> Observation:
    near = rng.uniform(0.1, 2.0, 16)
    near[rng.random(16) < 0.7] = np.inf
    frame = CameraFrame(now, _picture(rng, size), INTRINSICS)
    return Observation(
        time=now,
        dt=DT,
        odometry=Odometry(*rng.normal(size=3).tolist(), covariance=_covariance(rng, 3)),
        sightings=(_sighting(rng, now, None, False),) if k % 3 == 0 else (),
        cameras={"front": frame} if camera else {},
        proximity=near,
        bump=(0.1, -0.2) if k == 4 else (),
    )


@cache
def _pixels(size: tuple[int, int]) -> np.ndarray:
    """Return row and column of each pixel, shape (2, height, width)."""
    return np.mgrid[: size[0], : size[1]]


def _picture(rng: np.random.Generator, size: tuple[int, int]) -> np.ndarray:
    """Return a smooth picture, of which JPEG keeps nearly everything."""
    v, u = _pixels(size)
    red, green = rng.integers(20, 120, 2)
    return np.stack([red + 2 * u % 128, green + v % 128, 0 * u + 60], axis=-1).astype(np.uint8)


def _order(rng: np.random.Generator, now: float, k: int, landmarks: dict) -> Order:
    n = 3 + 2 * len(landmarks)
    joint = _covariance(rng, n) if landmarks else None
    return Order(
        command=WheelCommand((1.0, -2.0)) if k == 3 else Command(*rng.normal(size=3).tolist()),
        wanted=Command(*rng.normal(size=3).tolist()),
        estimate=Estimate(
            _pose(rng),
            _covariance(rng, 3),
            landmarks=landmarks,
            innovations=tuple((name, rng.normal(size=2), _covariance(rng, 2)) for name in list(landmarks)[:2]),
            joint_covariance=joint,
            show=_SHOWN if k == 3 else (),
        ),
        dead_reckoning=_pose(rng),
        dead_reckoning_covariance=_covariance(rng, 3),
        sightings=(_sighting(rng, now, "lion", True), _sighting(rng, now, None, False)) if k % 2 == 0 else (),
        events=(RobotEvent(now, "bump", "touched the wall", 0.1),) if k == 4 else (),
        timing={"estimator": 0.001} if k % 2 == 0 else {},
    )
