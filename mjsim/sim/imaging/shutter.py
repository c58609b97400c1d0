"""Motion blur and rolling shutter: pictures of a moving camera from the first row to the last."""

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, TypeVar

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.interface import Picture
from mjsim.models import matrix_of
from mjsim.world import Camera

MAX_EXPOSURES = 24
"""Maximum number of images averaged into one."""
MIN_OBJECT_DISTANCE = 1.0
"""Minimum distance of objects assumed for their motion in the image [m]."""

V = TypeVar("V", bound=np.generic)


class Shutter:
    """The instants at which the rows of a camera are exposed, seen from the camera as it moves.

    Rows are read out in sequence, the middle one at the stamp of the image, and each is the mean over its
    exposure time. The camera moves with the velocity of the robot at the stamp; everything else is assumed to be at
    rest.
    """

    def __init__(self, model: mujoco.MjModel, robot: str, camera: Camera, *, focal: float) -> None:
        """Initialise.

        Args:
            model: The compiled world.
            robot: Name of the robot.
            camera: Camera of the world file.
            focal: Its focal length [px].
        """
        self._camera, self._focal = camera, focal
        self._index = model.camera(f"{robot}/{camera.camera}").id
        self._base = model.body(f"{robot}/base").id
        start = int(model.body_dofadr[self._base])
        self._moved = slice(start, start + 6) if start >= 0 else None
        """Indices of the base's velocities; None for a fixed base."""
        middles = (np.arange(camera.height) + 0.5) / camera.height - 0.5
        self._rows = camera.rolling_shutter * middles
        self._window = camera.rolling_shutter + camera.exposed

    def picture(
        self, data: mujoco.MjData, draw: Callable[[], Picture], light: Callable[[Picture], NDArray[Any]]
    ) -> Picture | NDArray[np.float32]:
        """Return the only image, or the mean light of all instants; the camera in `data` is moved, and then restored.

        Args:
            data: State of MuJoCo.
            draw: Draws the image of an instant.
            light: Returns the light of an image, which adds up.
        """
        instants = self._instants(data)
        if len(instants) == 1:
            return draw()
        weights = self._weights(instants)
        total = np.zeros((self._camera.height, self._camera.width, 3), dtype=np.float32)
        for instant, weight in zip(instants, weights.T, strict=True):
            rows = np.flatnonzero(weight)
            with self._moved_on(data, instant):
                picture = light(draw())
            total[rows] += weight[rows, None, None].astype(np.float32) * picture[rows]
        return total

    def nearest(self, data: mujoco.MjData, draw: Callable[[], NDArray[V]]) -> NDArray[V]:
        """Return data that cannot be averaged, such as depth: each row at the instant nearest to its own."""
        instants = self._instants(data)
        if len(instants) == 1:
            return draw()
        closest = np.abs(self._rows[:, None] - instants).argmin(axis=1)
        whole: list[NDArray[V]] = []
        for instant in instants:
            with self._moved_on(data, instant):
                whole.append(draw())
        return np.concatenate([whole[number][row : row + 1] for row, number in enumerate(closest)])

    def _instants(self, data: mujoco.MjData) -> Array:
        """Return as many instants about the stamp as the image moves by pixels during exposure, shape (n,) [s]."""
        velocity, turn = self._velocities(data)
        pixels = (
            self._focal
            * self._window
            * (float(np.linalg.norm(turn)) + float(np.linalg.norm(velocity)) / MIN_OBJECT_DISTANCE)
        )
        count = min(max(math.ceil(pixels), 1), MAX_EXPOSURES)
        return np.asarray(self._window * ((np.arange(count) + 0.5) / count - 0.5), dtype=float)

    def _weights(self, instants: Array) -> Array:
        """Return the weight of each instant in each row, shape (rows, instants)."""
        step = float(instants[1] - instants[0])
        # An instant represents the time around it, and a row takes at least that long: the pictures blend without a
        # seam.
        half_row, half = max(self._camera.exposed, step) / 2, step / 2
        rows = self._rows[:, None]
        shared = np.minimum(rows + half_row, instants + half) - np.maximum(rows - half_row, instants - half)
        shares = np.maximum(shared, 0.0)
        return np.asarray(shares / shares.sum(axis=1, keepdims=True), dtype=float)

    def _velocities(self, data: mujoco.MjData) -> tuple[Array, Array]:
        """Return velocity [m/s] and angular velocity [rad/s] of the base, world frame, shapes (3,)."""
        if self._moved is None:
            return np.zeros(3), np.zeros(3)
        moved = data.qvel[self._moved]
        return moved[:3].copy(), data.xmat[self._base].reshape(3, 3) @ moved[3:]

    @contextmanager
    def _moved_on(self, data: mujoco.MjData, instant: float) -> Iterator[None]:
        """Move the camera to its pose at an instant about the stamp, and back."""
        index = self._index
        place, axes = data.cam_xpos[index].copy(), data.cam_xmat[index].copy()
        velocity, turn = self._velocities(data)
        quaternion = np.empty(4)
        angle = float(np.linalg.norm(turn)) * instant
        mujoco.mju_axisAngle2Quat(quaternion, turn / max(float(np.linalg.norm(turn)), 1e-12), angle)
        rotation, base = matrix_of(quaternion), data.xpos[self._base]
        data.cam_xpos[index] = base + velocity * instant + rotation @ (place - base)
        data.cam_xmat[index] = (rotation @ axes.reshape(3, 3)).ravel()
        try:
            yield
        finally:
            data.cam_xpos[index], data.cam_xmat[index] = place, axes
