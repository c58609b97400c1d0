"""What people would use instead, on the same layouts: ir-sim's lidar world and PyBullet's camera.

Both are optional; `mjsim bench --peers` says how to install them. PyBullet has no wheels for newer Pythons and is
then built.
"""

import contextlib
import importlib.util
import io
import math
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from mjsim.bench.figure import Clock, Figure, Once, Prepare
from mjsim.bench.naive import CAMERA_AT, CAMERA_FOV, Block, blocks_of, pictures_of
from mjsim.bench.scenes import gallery, gallery_places, hall
from mjsim.errors import UsageError, how_to_install
from mjsim.geometry import Pose
from mjsim.world import World

TURN, RATE, BEAMS = 0.3, 25.0, 180
"""Of the robot in the hall [rad/s]; ticks and scans a second; beams over half a turn."""
NEAR, FAR = 0.02, 60.0
"""Of PyBullet's view [m]."""
PACKAGES = {"irsim": "ir-sim", "pybullet": "pybullet"}


def require(module: str) -> None:
    """Raise UsageError unless a package is installed."""
    if importlib.util.find_spec(module) is None:
        raise UsageError(f"{PACKAGES[module]} is not installed; type: {how_to_install(*PACKAGES.values())}")


@contextmanager
def irsim_lidar() -> Iterator[Once]:
    """Measure ir-sim in the hall with 100 walls: a robot that turns, a scan at each of 25 ticks a second."""
    require("irsim")
    import matplotlib as mpl

    mpl.use("Agg")
    with contextlib.redirect_stderr(io.StringIO()), contextlib.redirect_stdout(io.StringIO()):
        import irsim  # tells which windows it cannot open

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "hall.yaml"
        path.write_text(irsim_world(hall()), encoding="utf-8")
        env = irsim.make(str(path), display=False, headless=True, log_level="ERROR")
        command = np.array([[0.0], [TURN]])

        def once(clock: Clock) -> float:
            began = clock()
            for _ in range(50):
                env.step(command)
            return 50 / RATE / (clock() - began)

        yield once
        env.end()


def irsim_world(world: World) -> str:
    """Return a world for ir-sim: a rectangle a wall, and a robot with a lidar."""
    walls = [
        f"  - {{shape: {{name: rectangle, length: {2 * block.half[0]}, width: {2 * block.half[1]}}}, "
        f"state: [{block.at[0]}, {block.at[1]}, {block.heading}]}}"
        for block in blocks_of(world)
    ]
    lidar = (
        f"{{name: lidar2d, range_min: 0.05, range_max: 10, angle_range: {math.pi}, number: {BEAMS}, "
        "noise: true, std: 0.01}"
    )
    return "\n".join(
        [
            f"world: {{height: 80, width: 80, offset: [-40, -40], step_time: {1 / RATE}, sample_time: {1 / RATE}}}",
            "robot:",
            "  - {kinematics: {name: diff}, shape: {name: circle, radius: 0.22}, state: [0, 0, 0],",
            f"     sensors: [{lidar}]}}",
            "obstacle:",
            *walls,
        ]
    )


def pybullet_camera(width: int, height: int, *, shadows: bool = False) -> Prepare:
    """Measure PyBullet's camera in the gallery written naively: TinyRenderer, no segmentation."""

    @contextmanager
    def prepare() -> Iterator[Once]:
        require("pybullet")
        import pybullet

        client = pybullet.connect(pybullet.DIRECT)
        with tempfile.TemporaryDirectory() as folder:
            _build(pybullet, gallery(), Path(folder))
            projection = pybullet.computeProjectionMatrixFOV(
                2 * math.degrees(math.atan(math.tan(CAMERA_FOV / 2) * height / width)), width / height, NEAR, FAR
            )
            places = gallery_places()[::10]

            def once(clock: Clock) -> float:
                began = clock()
                for place in places:
                    picture(pybullet, place, projection, width=width, height=height, shadows=shadows)
                return len(places) / (clock() - began)

            yield once
        pybullet.disconnect(client)

    return prepare


def picture(bullet: Any, place: Pose, projection: Any, *, width: int, height: int, shadows: bool) -> np.ndarray:
    """Return what PyBullet's camera sees from a place, shape (height, width, 4)."""
    c, s = math.cos(place.heading), math.sin(place.heading)
    eye = [place.x + c * CAMERA_AT[0], place.y + s * CAMERA_AT[0], CAMERA_AT[2]]
    view = bullet.computeViewMatrix(eye, [eye[0] + c, eye[1] + s, eye[2]], [0, 0, 1])
    rgba = bullet.getCameraImage(
        width,
        height,
        view,
        projection,
        shadow=int(shadows),
        renderer=bullet.ER_TINY_RENDERER,
        flags=bullet.ER_NO_SEGMENTATION_MASK,
    )[2]
    return np.asarray(rgba, dtype=np.uint8).reshape(height, width, 4)


def _build(bullet: Any, world: World, folder: Path) -> None:
    """Add the blocks of a world, and its floor."""
    blocks, textures = blocks_of(world), {}
    for number, (file, shown) in enumerate(pictures_of(world, blocks).items()):
        path = folder / f"{number}.png"
        cv2.imwrite(str(path), shown[..., ::-1])
        textures[file] = bullet.loadTexture(str(path))
    floor = Block((15.0, 15.0, 0.05), (7.0, 5.0, -0.05), picture=world.floor.texture)
    for block in (*blocks, floor):
        if len(block.half) == 3:
            shape = bullet.createVisualShape(bullet.GEOM_BOX, halfExtents=block.half, rgbaColor=[0.9, 0.88, 0.85, 1])
        else:
            shape = bullet.createVisualShape(bullet.GEOM_CYLINDER, radius=block.half[0], length=2 * block.half[1])
        turn = bullet.getQuaternionFromEuler([0, 0, block.heading])
        body = bullet.createMultiBody(0, -1, shape, block.at, turn)
        if block.picture is not None:
            bullet.changeVisualShape(body, -1, textureUniqueId=textures[block.picture], rgbaColor=[1, 1, 1, 1])


PEER_FIGURES = (
    Figure("irsim-lidar", "simulated seconds a second", irsim_lidar),
    Figure("pybullet-320x240", "pictures a second", pybullet_camera(320, 240)),
    Figure("pybullet-640x480", "pictures a second", pybullet_camera(640, 480)),
    Figure("pybullet-640x480-shadows", "pictures a second", pybullet_camera(640, 480, shadows=True)),
)
