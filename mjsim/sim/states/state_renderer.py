"""Renders any view of a world in a given state: from outside, or of onboard cameras without errors."""

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from mjsim.closing import Closes
from mjsim.compile import overview_of
from mjsim.errors import UsageError, did_you_mean
from mjsim.geometry import Array
from mjsim.interface import CameraFrame, Picture
from mjsim.sentences import Sentence
from mjsim.sim.rendering import SEEN_FROM_OUTSIDE, Canvas, Canvases, Quality, Renderer
from mjsim.sim.sensors import OnboardCamera
from mjsim.sim.states.playback import avoid_walls
from mjsim.sim.states.static_scene import StillScene
from mjsim.sim.streams import streams_of
from mjsim.world import Camera, Looks, World

PORTRAIT_DIRECTION = (215.0, -22.0)
"""Azimuth and elevation of portraits: from the front left [deg]."""
EYE_LEVEL = 0.4
"""Height above the floor of the point that a view from outside looks at [m]."""


@dataclass(frozen=True, slots=True)
class Orbit:
    """Viewpoint of a view from outside."""

    azimuth: float
    """Direction of the view seen from above, counter-clockwise from x [rad]."""
    elevation: float
    """Elevation of the view; negative when looking down [rad]."""
    distance: float
    """Distance from the point that it looks at [m]."""
    at: tuple[float, float]
    """Point that it looks at, world frame [m]."""


class Onlooker(Closes):
    """Renders recorded or running states with its own cameras. Use from one thread, and close when done.

    The world is compiled at the first image. Cameras render without noise, blur and shutter, and with depth or
    instances on request, independent of their outputs for modules.
    """

    def __init__(self, world: World) -> None:
        """Store the world."""
        self._world = world
        self._scene: StillScene | None = None
        self._canvases = Canvases()
        self._outside: dict[tuple[int, int, Quality], Renderer] = {}
        self._cameras: dict[tuple[str, str, bool, bool], OnboardCamera] = {}
        self._moving: list[int] = []
        """Geoms of mechanisms."""
        self._reach: Array | None = None
        """Corners of a box around all poses of mechanisms in the overview so far, world frame, shape (2, 3) [m]."""

    def show(self, qpos: Array, looks: Looks | None) -> None:
        """Set the state to show.

        Args:
            qpos: MuJoCo's positions, shape (nq,), as in ticks and recordings.
            looks: Light and removed objects; by default as at the start.

        Raises:
            UsageError: The state is not of this world.
        """
        if self._scene is None:
            self._scene = StillScene(self._world)
        self._scene.show(qpos, looks=looks)

    def outside(self, view: str | Orbit, *, width: int, height: int, quality: Quality = "normal") -> Picture:
        """Return a view from outside, RGB, shape (height, width, 3).

        Args:
            view: Viewpoint, 'overview', or 'ROBOT/chase'.
            width: [px]
            height: [px]
            quality: Quality, as for cameras.

        Raises:
            UsageError: The view does not exist.
        """
        scene, key = self._shown(), (width, height, quality)
        if key not in self._outside:
            canvas = self._canvas(quality)
            self._outside[key] = Renderer(
                scene.model, width=width, height=height, canvas=canvas, groups=SEEN_FROM_OUTSIDE
            )
        if isinstance(view, str):
            if view.endswith("/chase"):
                avoid_walls(scene.model, scene.data, view)
            elif view == "overview" and self._world.mechanisms:
                self._widen(scene)
            return self._outside[key].render(scene.data, view)
        return self._outside[key].render(scene.data, _free_camera(view))

    def portrait(self, *, width: int, height: int, quality: Quality = "high") -> Picture:
        """Return a picture of all objects on the floor, from the side and above, RGB, (height, width, 3).

        They fill the picture.

        Raises:
            UsageError: There is nothing on the floor.
        """
        scene = self._shown()
        model = scene.model
        seen = np.isin(model.geom_group, SEEN_FROM_OUTSIDE) & (model.geom_rgba[:, 3] > 0.0)
        seen &= (model.geom_type != mujoco.mjtGeom.mjGEOM_PLANE) & (model.geom_type != mujoco.mjtGeom.mjGEOM_HFIELD)
        geoms = [k for k in np.flatnonzero(seen).tolist() if model.geom(k).name != "floor"]
        if not geoms:
            raise UsageError("this world is empty; there is nothing to draw")
        low, high = box_around(model, scene.data, geoms)
        half = math.radians(float(model.vis.global_.fovy)) / 2.0
        camera = mujoco.MjvCamera()
        camera.type = mujoco.mjtCamera.mjCAMERA_FREE
        camera.lookat[:] = (low + high) / 2.0
        camera.distance = float(np.linalg.norm(high - low)) / 2.0 / math.sin(half * min(1.0, width / height))
        camera.azimuth, camera.elevation = PORTRAIT_DIRECTION
        renderer = Renderer(model, width=width, height=height, canvas=self._canvas(quality), groups=SEEN_FROM_OUTSIDE)
        return renderer.render(scene.data, camera)

    def onboard(
        self, robot: str, camera: str, *, stamp: float = 0.0, depth: bool = False, segmentation: bool = False
    ) -> CameraFrame:
        """Return the frame of an onboard camera, without errors.

        Args:
            robot: Name of the robot.
            camera: Name of the camera.
            stamp: Time of the state [s].
            depth: Whether to include the distance of each pixel.
            segmentation: Whether to include the instance of each pixel.

        Raises:
            UsageError: The camera does not exist.
        """
        key = robot, camera, depth, segmentation
        if key not in self._cameras:
            self._cameras[key] = self._mounted(robot, camera, depth=depth, segmentation=segmentation)
        return self._cameras[key].frame(self._shown().data, stamp)

    def close(self) -> None:
        """Release the renderer; a second call does nothing."""
        self._canvases.close()

    def _widen(self, scene: StillScene) -> None:
        """Widen the overview to the current and all earlier poses of mechanisms."""
        model, data = scene.model, scene.data
        if not self._moving:
            self._moving = _geoms_of(model, {item.name for item in self._world.mechanisms})
        reach = box_around(model, data, self._moving)
        if self._reach is not None:
            reach = np.array([np.minimum(reach[0], self._reach[0]), np.maximum(reach[1], self._reach[1])])
        if self._reach is None or (reach != self._reach).any():
            self._reach, place = reach, overview_of(self._world, reach)
            model.camera("overview").pos, data.cam_xpos[model.camera("overview").id] = place, place

    def _mounted(self, robot: str, camera: str, *, depth: bool, segmentation: bool) -> OnboardCamera:
        cameras = {
            (each.name, sensor.camera): (each, sensor)
            for each in self._world.robots
            for sensor in each.sensors
            if isinstance(sensor, Camera)
        }
        if (robot, camera) not in cameras:
            known = did_you_mean(f"{robot}/{camera}", map("/".join, cameras))
            raise UsageError(Sentence("no camera '{robot}/{camera}' in this world{known}", robot, camera, known))
        body, sensor = cameras[robot, camera]
        return OnboardCamera(
            self._shown().model,
            body,
            sensor.without_errors(depth=depth, segmentation=segmentation),
            streams=streams_of(0, robot, camera),
            canvas=self._canvas(sensor.quality),
        )

    def _canvas(self, quality: Quality) -> Canvas:
        scene = self._shown()
        return self._canvases.of(scene.model, quality, scene.light)

    def _shown(self) -> StillScene:
        if self._scene is None:
            raise UsageError("no state is shown; call show first")
        return self._scene


def _geoms_of(model: mujoco.MjModel, mechanisms: Collection[str]) -> list[int]:
    """Return the geoms of all bodies of mechanisms, by the names of the bodies."""
    return [k for k in range(model.ngeom) if model.body(model.geom_bodyid[k]).name.partition("/")[0] in mechanisms]


def box_around(model: mujoco.MjModel, data: mujoco.MjData, geoms: Sequence[int]) -> Array:
    """Return corners of a box around geoms, world frame, shape (2, 3) [m].

    Args:
        model: The compiled world.
        data: A state of it, with poses computed.
        geoms: Numbers of the geoms, at least one.
    """
    turned, boxes = data.geom_xmat[geoms].reshape(-1, 3, 3), model.geom_aabb[geoms]
    middle = data.geom_xpos[geoms] + np.einsum("kij,kj->ki", turned, boxes[:, :3])
    half = np.einsum("kij,kj->ki", np.abs(turned), boxes[:, 3:])
    return np.array([(middle - half).min(axis=0), (middle + half).max(axis=0)])


def _free_camera(view: Orbit) -> mujoco.MjvCamera:
    camera = mujoco.MjvCamera()
    camera.type = mujoco.mjtCamera.mjCAMERA_FREE
    camera.azimuth, camera.elevation = math.degrees(view.azimuth), math.degrees(view.elevation)
    camera.distance = view.distance
    camera.lookat[:] = [*view.at, EYE_LEVEL]
    return camera
