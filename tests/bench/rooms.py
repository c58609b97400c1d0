"""A small gallery, and tools that the tests of scenes and pictures share."""

import math

import cv2
import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.world import Beacon, World

GALLERY = """
mjsim: 1
name: small-gallery
walls:
  - {points: [[0, 0], [8, 0], [8, 6], [0, 6]], closed: true, thickness: 0.12}
  - {points: [[4, 0], [4, 6]], openings: [{segment: 0, at: 2.4, width: 1.2}], color: "#b8c4c8"}
obstacles:
  - {box: [0.6, 0.4, 1.1], at: [2, 3], heading_deg: 30}
  - {cylinder: [0.2, 1.3], at: [6, 3.5], name: pillar}
beacons:
  - {name: lion, image: posters/lion.jpg, at: [0.07, 2], heading_deg: 0}
  - {name: owl, image: posters/owl.jpg, at: [0.07, 4.5], heading_deg: 0, width: 0.5, center: 0.9}
  - {name: whale, image: posters/whale.jpg, at: [1.5, 5.93], heading_deg: -90, width: 0.8}
  - {name: moon, image: posters/moon.jpg, at: [2, 0.07], heading_deg: 90}
  - {name: key, image: posters/key.jpg, at: [3.94, 1], heading_deg: 180}
  - {name: cat, image: posters/cat.jpg, at: [4.06, 4.8], heading_deg: 0}
  - {name: fish, image: posters/fish.jpg, at: [7.93, 2], heading_deg: 180, width: 1.0}
  - {name: pear, image: posters/pear.jpg, at: [5.5, 1.2], heading_deg: 70, center: 0.8}
robots:
  - {name: scout, at: [1, 1], sensors: [{camera: front, at: [0.15, 0.02, 0.35], pitch_deg: 8, yaw_deg: -5, noise: 0}]}
"""


def forwarded(model: mujoco.MjModel) -> mujoco.MjData:
    """Return the state at the start, with everything in its place."""
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return data


def place(model: mujoco.MjModel, data: mujoco.MjData, robot: str, pose: NDArray[np.float64]) -> None:
    """Put a robot at (x, y, heading), standing on the floor."""
    start = model.joint(f"{robot}/free").qposadr[0]
    x, y, heading = pose
    data.qpos[start : start + 7] = [x, y, 0.0, math.cos(heading / 2), 0.0, 0.0, math.sin(heading / 2)]
    mujoco.mj_forward(model, data)


def look_from(model: mujoco.MjModel, data: mujoco.MjData, camera: str, at: object, ahead: object) -> None:
    """Turn a camera so that it looks from a place in a direction, upright; until the next mj_forward."""
    z = -np.asarray(ahead, dtype=float) / np.linalg.norm(ahead)
    x = np.cross([0.0, 0.0, 1.0], z) if abs(z[2]) < 0.999 else np.array([1.0, 0.0, 0.0])
    x /= np.linalg.norm(x)
    index = model.camera(camera).id
    data.cam_xpos[index] = at
    data.cam_xmat[index] = np.column_stack([x, np.cross(z, x), z]).ravel()


def beacon_corners(world: World, beacon: Beacon) -> NDArray[np.float64]:
    """Return where a picture hangs by the world file: top left, clockwise, world frame, shape (4, 3) [m]."""
    assert beacon.image is not None
    picture = cv2.imdecode(np.frombuffer(world.read_asset(beacon.image), dtype=np.uint8), cv2.IMREAD_COLOR)
    height = beacon.width * picture.shape[0] / picture.shape[1]
    heading = math.radians(beacon.heading_deg)
    # Who faces the picture has its right where the picture, facing him, has its left turned about.
    right = np.array([-math.sin(heading), math.cos(heading), 0.0]) * beacon.width / 2
    up = np.array([0.0, 0.0, height / 2])
    middle = np.array([*beacon.at, beacon.center])
    return np.array([middle - right + up, middle + right + up, middle + right - up, middle - right - up])


def cast(
    model: mujoco.MjModel, data: mujoco.MjData, start: NDArray[np.float64], directions: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return how far rays go until they meet something solid, in lengths of their directions, shape (n,)."""
    groups = np.array([1, 0, 0, 1, 0, 0], dtype=np.uint8)
    lengths = np.linalg.norm(directions, axis=1)
    distances, geoms = np.zeros(len(directions)), np.zeros(len(directions), dtype=np.int32)
    unit = np.ascontiguousarray(directions / lengths[:, None])
    mujoco.mj_multiRay(
        model, data, start, unit.ravel(), groups, 1, -1, geoms, distances, None, len(unit), mujoco.mjMAXVAL
    )
    return np.where(geoms >= 0, distances / lengths, np.inf)


def png(picture: NDArray[np.uint8]) -> bytes:
    """Return the PNG file of an RGB picture."""
    return bytes(cv2.imencode(".png", picture[..., ::-1])[1])
