"""Onboard cameras: when they look, what they see, and how far their pixels err."""

import math

import cv2
import mujoco
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from mjsim.compile.sensors import robot_from_view
from mjsim.errors import UsageError
from mjsim.geometry import Array
from mjsim.interface import CameraFrame, Intrinsics, Picture, SensorInfo
from mjsim.sim.canvas import Canvas
from mjsim.sim.renderer import Renderer
from mjsim.sim.streams import stream
from mjsim.world.robots import Robot
from mjsim.world.sensors import Camera


def intrinsics_of(camera: Camera) -> Intrinsics:
    """Return the calibration of a camera with square pixels, its middle in the middle of the picture.

    References:
        The pinhole camera, f = (width / 2) / tan(fov / 2); pixel centres at whole numbers put the middle at
        (width - 1) / 2.
    """
    focal = camera.width / 2 / math.tan(math.radians(camera.fov_deg) / 2)
    return Intrinsics(
        width=camera.width,
        height=camera.height,
        fx=focal,
        fy=focal,
        cx=(camera.width - 1) / 2,
        cy=(camera.height - 1) / 2,
    )


def robot_from_camera(camera: Camera) -> Array:
    """Return the pose of the optical frame (x right, y down, z ahead) on the robot, shape (4, 4) [m]."""
    transform = np.eye(4)
    transform[:3, :3] = robot_from_view(camera) * [1.0, -1.0, -1.0]
    transform[:3, 3] = camera.at
    return transform


class OnboardCamera:
    """A camera of a robot in a running simulation."""

    def __init__(
        self, model: mujoco.MjModel, robot: Robot, camera: Camera, *, rate_hz: float, seed: int, canvas: Canvas
    ) -> None:
        """Get ready to look.

        Args:
            model: The compiled world.
            robot: Whose camera it is.
            camera: As the world file has it.
            rate_hz: Of the loop.
            seed: Of the run; the pixels draw from a stream of their own.
            canvas: Shared by all cameras of one quality; the caller closes it.

        Raises:
            UsageError: The camera's rate does not divide the loop's.
        """
        self.name = camera.camera
        self._camera = camera
        self.intrinsics = intrinsics_of(camera)
        self.robot_from_camera = robot_from_camera(camera)
        self._view = f"{robot.name}/{camera.camera}"
        self._ticks = ticks_between(rate_hz, camera.rate_hz)
        self._renderer = Renderer(model, width=camera.width, height=camera.height, canvas=canvas)
        self._noise = (
            PixelNoise(camera.noise, stream(seed, robot.name, f"{self.name}/pixels")) if camera.noise else None
        )

    def due(self, tick: int) -> bool:
        """Say whether the camera takes a picture at a tick, counted from 0."""
        return tick % self._ticks == 0

    def frame(self, data: mujoco.MjData, stamp: float) -> CameraFrame:
        """Return what the camera sees now.

        Args:
            data: Where everything is.
            stamp: The simulated time [s].
        """
        image = self._renderer.render(data, self._view)
        if self._noise is not None:
            self._noise.add_to(image)
        return CameraFrame(stamp=stamp, image=image, intrinsics=self.intrinsics)

    def pass_over(self) -> None:
        """Draw the chance of a picture that nobody asked for."""
        if self._noise is not None:
            self._noise.draw((self.intrinsics.height, self.intrinsics.width, 3))

    def info(self) -> SensorInfo:
        """Return its data sheet."""
        return SensorInfo(
            kind="camera",
            robot_from_sensor=self.robot_from_camera,
            rate_hz=self._camera.rate_hz,
            noise={"noise": self._camera.noise},
            intrinsics=self.intrinsics,
            latency=self._camera.latency,
            fov=math.radians(self._camera.fov_deg),
        )


def ticks_between(loop_hz: float, sensor_hz: float) -> int:
    """Return how many ticks lie between two readings.

    Raises:
        UsageError: The sensor's rate does not divide the loop's.
    """
    ticks = loop_hz / sensor_hz
    if abs(ticks - round(ticks)) > 1e-9 or ticks < 1.0 - 1e-9:
        nearest = loop_hz / max(1, round(ticks))
        raise UsageError(f"rate_hz is {sensor_hz:g}; it must divide the loop's {loop_hz:g}, the nearest is {nearest:g}")
    return round(ticks)


class PixelNoise:
    """Independent normal errors of all values of a picture, rounded and clipped as the pixels are."""

    def __init__(self, deviation: float, stream: Generator) -> None:
        """Tabulate the errors of 65536 equally likely chances: two random bytes a value, and no more to compute.

        Args:
            deviation: Standard deviation, of 255.
            stream: Source of chance.
        """
        from scipy.special import ndtri  # A camera without noise need not wait for it.

        chances = (np.arange(1 << 16) + 0.5) / (1 << 16)
        self._errors: NDArray[np.int16] = np.rint(deviation * ndtri(chances)).astype(np.int16)
        self._stream = stream

    def add_to(self, image: Picture) -> None:
        """Add fresh errors to a picture, in place."""
        cv2.add(image, self._errors[self.draw(image.shape)], dst=image, dtype=cv2.CV_8U)

    def draw(self, shape: tuple[int, ...]) -> NDArray[np.uint16]:
        """Return the chances of a picture's values."""
        return np.frombuffer(self._stream.bytes(2 * math.prod(shape)), dtype=np.uint16).reshape(shape)
