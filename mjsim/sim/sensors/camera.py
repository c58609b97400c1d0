"""Onboard cameras: timing, rendering and pixel noise."""

import math
from collections.abc import Iterator
from contextlib import contextmanager

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.compile import robot_from_carrier, robot_from_view
from mjsim.geometry import Array
from mjsim.interface import CameraFrame, Picture, SensorInfo
from mjsim.sim.imaging import BentView, Imager, PlainImager, Shutter, StereoDepth, imager_of, intrinsics_of
from mjsim.sim.rendering import Canvas, Renderer, instances_of
from mjsim.sim.sensors.device import Mounting
from mjsim.sim.streams import Streams
from mjsim.world import Camera, Depth, Photons, Robot

OPTICAL = np.array([1.0, -1.0, -1.0])
"""Signs of the axes of MuJoCo's cameras in the optical frame (x right, y down, z ahead)."""


def robot_from_camera(camera: Camera) -> Array:
    """Return the pose of the optical frame (x right, y down, z ahead) on its carrier, shape (4, 4) [m]."""
    transform = np.eye(4)
    transform[:3, :3] = robot_from_view(camera) * OPTICAL
    transform[:3, 3] = camera.at
    return transform


class OnboardCamera:
    """A camera of a robot in a running simulation."""

    def __init__(
        self, model: mujoco.MjModel, robot: Robot, camera: Camera, *, streams: Streams, canvas: Canvas
    ) -> None:
        """Initialise.

        Args:
            model: The compiled world.
            robot: Robot with the camera.
            camera: Camera of the world file.
            streams: Purpose -> random stream of this camera.
            canvas: Shared by all cameras of one quality; the caller closes it.
        """
        self.name = camera.camera
        self._model = model
        self._index = model.camera(f"{robot.name}/{camera.camera}").id
        self.intrinsics = intrinsics_of(camera)
        self.robot_from_camera = robot_from_carrier(robot, camera) @ robot_from_camera(camera)
        self._view = f"{robot.name}/{camera.camera}"
        self._bent = BentView(self.intrinsics, camera.lens) if camera.lens is not None else None
        width, height = (self._bent.width, self._bent.height) if self._bent else (camera.width, camera.height)
        self._renderer = Renderer(model, width=width, height=height, canvas=canvas)
        self.chances = streams("pixels"), streams("depth")
        """The random streams of a picture."""
        self._dirt = int(streams("dirt").integers(1 << 62))
        self.imager = self._imager_of(camera)
        """Makes pictures from renderings; has a memory where its exposure is delayed."""
        self.retune(camera)
        self._shutter = Shutter(model, robot.name, camera, focal=self.intrinsics.fx)
        self._names: tuple[str, ...] = ()
        if camera.segmentation:
            self._instances, self._names = instances_of(model)

    def retune(self, camera: Camera) -> None:
        """Use the noise of this model from now on; random streams continue."""
        self._camera = camera
        before, self.imager = self.imager, self._imager_of(camera)
        self.imager.memory = before.memory
        self._depth = depth_of(camera)
        self._far = self.chances[1] if self._depth is not None and self._depth.noise else None
        stereo = self._depth.stereo if self._depth is not None else None
        self._stereo = StereoDepth(stereo, self.intrinsics, self.chances[1]) if stereo is not None else None

    def frame(self, data: mujoco.MjData, stamp: float) -> CameraFrame:
        """Return the current picture.

        Args:
            data: State of MuJoCo.
            stamp: The simulated time [s].
        """
        shutter, depth, segmentation = self._shutter, None, None
        depths: list[Array] | None = None if self._depth is None else []
        seen = shutter.picture(data, lambda: self._draw(data, depths), self.imager.light)
        if self._depth is not None and depths is not None:
            depth = shutter.nearest(data, lambda: depths.pop(0))
            if self._stereo is not None:
                sharp = np.asarray(seen if seen.dtype == np.uint8 else self._draw(data), dtype=np.uint8)
                depth = self._stereo.measured(depth, sharp)
            depth = self._measured(depth, self._depth)
        image = self.imager.picture(seen, stamp)
        if self._camera.segmentation:
            segmentation = shutter.nearest(data, lambda: self._draw_instances(data))
        return CameraFrame(
            stamp=stamp,
            image=image,
            intrinsics=self.intrinsics,
            depth=depth,
            segmentation=segmentation,
            instances=self._names,
        )

    def pass_over(self) -> None:
        """Draw the random numbers of a picture that was not requested."""
        shape = self._camera.height, self._camera.width
        self.imager.pass_over()
        if self._far is not None:
            self._far.standard_normal(shape, dtype=np.float32)
        if self._stereo is not None:
            self._stereo.pass_over()

    def info(self) -> SensorInfo:
        """Return its data sheet."""
        camera = self._camera
        noise = camera.noise.model_dump() if isinstance(camera.noise, Photons) else {"noise": camera.noise}
        if self._depth is not None:
            noise["depth"] = self._depth.noise if self._stereo is None else self._stereo.deviation
        return SensorInfo(
            kind="camera",
            robot_from_sensor=self.robot_from_camera,
            rate_hz=camera.rate_hz,
            noise=noise,
            intrinsics=self.intrinsics,
            latency=camera.latency,
            range=(self._depth.range[0], self._depth.range[1]) if self._depth is not None else None,
            fov=math.radians(camera.fov_deg),
        )

    def _imager_of(self, camera: Camera) -> Imager | PlainImager:
        return imager_of(camera, self.chances[0], np.random.default_rng(self._dirt))

    def _draw(self, data: mujoco.MjData, depths: list[Array] | None = None) -> Picture:
        """Return the image; its depth is appended to those given."""
        bent = self._bent
        if bent is None:
            return self._renderer.render(data, self._view, depths=depths)
        size, parts = (bent.height, bent.width, 3), None if depths is None else list[Array]()
        pictures = np.empty((len(bent.turned), *size), dtype=np.uint8)
        ahead = -data.cam_xmat[self._index, 2::3]
        with self._straight_views(data) as views:
            for _, picture in zip(views, pictures, strict=True):
                self._renderer.render(data, self._view, picture, depths=parts, towards=ahead)
        if depths is not None and parts is not None:
            depths.append(bent.bend_depth(np.concatenate(parts)))
        return bent.bend(pictures.reshape(-1, *size[1:]))

    def _draw_instances(self, data: mujoco.MjData) -> NDArray[np.int32]:
        if self._bent is None:
            return self._instances_at(self._renderer.segment(data, self._view))
        with self._straight_views(data) as views:
            geoms = np.concatenate([self._renderer.segment(data, self._view) for _ in views])
        return self._bent.bend_instances(self._instances_at(geoms))

    def _instances_at(self, geoms: NDArray[np.int32]) -> NDArray[np.int32]:
        return np.where(geoms >= 0, self._instances[geoms], np.int32(-1))

    @contextmanager
    def _straight_views(self, data: mujoco.MjData) -> Iterator[Iterator[None]]:
        """Give the camera each undistorted view that the lens distorts in turn; restore it at the end."""
        bent, index = self._bent, self._index
        assert bent is not None
        fov, axes = self._model.cam_fovy[index], data.cam_xmat[index].copy()

        def views() -> Iterator[None]:
            for turned in bent.turned:
                # MuJoCo's cameras look along -z, with y up.
                data.cam_xmat[index] = (axes.reshape(3, 3) @ (OPTICAL[:, None] * turned * OPTICAL)).ravel()
                yield

        self._model.cam_fovy[index] = bent.fov_y_deg
        try:
            yield views()
        finally:
            self._model.cam_fovy[index], data.cam_xmat[index] = fov, axes

    def _measured(self, depth: Array, how: Depth) -> Array:
        """Return a depth with measurement errors, made in place."""
        if self._far is not None:
            chance = self._far.standard_normal(depth.shape, dtype=np.float32)
            background = np.isinf(depth)
            depth[background] = 0.0  # without an error
            error = np.square(depth)
            error *= how.noise
            error *= chance
            depth += error
            depth[background] = np.inf
        nearest, farthest = how.range
        depth[depth > farthest] = np.inf
        depth[depth < nearest] = -np.inf
        return depth


class CameraDevice:
    """An onboard camera as a sensor of its robot."""

    def __init__(self, camera: Camera, mounting: Mounting) -> None:
        """Initialise.

        Args:
            camera: Camera of the world file.
            mounting: Its mounting.
        """
        canvas = mounting.canvas(camera.quality)
        self._camera = OnboardCamera(mounting.model, mounting.robot, camera, streams=mounting.streams, canvas=canvas)
        self._data = mounting.data
        self.info, self.retune, self.pass_over = self._camera.info, self._camera.retune, self._camera.pass_over

    def take(self, stamp: float) -> CameraFrame:
        """Return a current picture; `stamp` is the simulated time [s]."""
        return self._camera.frame(self._data, stamp)


def depth_of(camera: Camera) -> Depth | None:
    """Return the depth measurement of a camera, or None."""
    return camera.depth if isinstance(camera.depth, Depth) else Depth() if camera.depth else None
