"""Any view of a world whose state is given: from outside, and what its onboard cameras would see without errors."""

import math
from dataclasses import dataclass

import mujoco

from mjsim.closing import Closes
from mjsim.errors import UsageError, did_you_mean
from mjsim.geometry import Array
from mjsim.interface import CameraFrame, Picture
from mjsim.sim.canvas import Canvas, Quality
from mjsim.sim.playback import bring_near
from mjsim.sim.renderer import SEEN_FROM_OUTSIDE, Renderer
from mjsim.sim.sensors import OnboardCamera
from mjsim.sim.still import StillScene
from mjsim.sim.streams import streams_of
from mjsim.world import Camera, Looks, World

EYE_LEVEL = 0.4
"""Height over the floor that a view from outside looks at [m]."""


@dataclass(frozen=True, slots=True)
class Orbit:
    """From where a view from outside looks."""

    azimuth: float
    """Direction of the view seen from above, counter-clockwise from x [rad]."""
    elevation: float
    """How far it looks up; negative from above [rad]."""
    distance: float
    """From the place that it looks at [m]."""
    at: tuple[float, float]
    """That place, world frame [m]."""


class Onlooker(Closes):
    """Looks at recorded or running states with cameras of its own. Use from one thread, and close when done.

    The world is compiled at the first picture. Cameras see without noise, blur and shutter, and with depth or instances
    when asked, whatever they give to modules.
    """

    def __init__(self, world: World) -> None:
        """Keep the world."""
        self._world = world
        self._scene: StillScene | None = None
        self._canvases: dict[Quality, Canvas] = {}
        self._outside: dict[tuple[int, int, Quality], Renderer] = {}
        self._cameras: dict[tuple[str, str, bool, bool], OnboardCamera] = {}

    def show(self, qpos: Array, looks: Looks | None) -> None:
        """Bring everything to a state.

        Args:
            qpos: MuJoCo's positions, shape (nq,), as ticks and recordings hold them.
            looks: Light, and what is no longer there; as at the start unless told.

        Raises:
            UsageError: The state is not of this world.
        """
        if self._scene is None:
            self._scene = StillScene(self._world)
        self._scene.show(qpos, looks=looks)

    def outside(self, view: str | Orbit, *, width: int, height: int, quality: Quality = "normal") -> Picture:
        """Return a view from outside, RGB, shape (height, width, 3).

        Args:
            view: From where; or 'overview', or 'ROBOT/chase'.
            width: [px]
            height: [px]
            quality: As a camera has it.

        Raises:
            UsageError: There is no such view.
        """
        scene, key = self._shown(), (width, height, quality)
        if key not in self._outside:
            canvas = self._canvas(quality)
            self._outside[key] = Renderer(
                scene.model, width=width, height=height, canvas=canvas, groups=SEEN_FROM_OUTSIDE
            )
        if isinstance(view, str):
            if view.endswith("/chase"):
                bring_near(scene.model, scene.data, view)
            return self._outside[key].render(scene.data, view)
        return self._outside[key].render(scene.data, _free_camera(view))

    def onboard(
        self, robot: str, camera: str, *, stamp: float = 0.0, depth: bool = False, segmentation: bool = False
    ) -> CameraFrame:
        """Return what an onboard camera would see, without errors.

        Args:
            robot: Whose camera it is.
            camera: Its name.
            stamp: Of the state [s].
            depth: Whether the distance of each pixel is given too.
            segmentation: Whether what each pixel shows is given too.

        Raises:
            UsageError: There is no such camera.
        """
        key = robot, camera, depth, segmentation
        if key not in self._cameras:
            self._cameras[key] = self._mounted(robot, camera, depth=depth, segmentation=segmentation)
        return self._cameras[key].frame(self._shown().data, stamp)

    def close(self) -> None:
        """Give back what was made for drawing; a second call does nothing."""
        for canvas in self._canvases.values():
            canvas.close()

    def _mounted(self, robot: str, camera: str, *, depth: bool, segmentation: bool) -> OnboardCamera:
        cameras = {
            (each.name, sensor.camera): (each, sensor)
            for each in self._world.robots
            for sensor in each.sensors
            if isinstance(sensor, Camera)
        }
        if (robot, camera) not in cameras:
            known = did_you_mean(f"{robot}/{camera}", map("/".join, cameras))
            raise UsageError(f"no camera '{robot}/{camera}' in this world{known}")
        body, sensor = cameras[robot, camera]
        exact = {"noise": 0.0, "blur": 0.0, "shutter": 0.0, "rolling_shutter": 0.0}
        return OnboardCamera(
            self._shown().model,
            body,
            sensor.model_copy(update={**exact, "depth": depth, "segmentation": segmentation}),
            streams=streams_of(0, robot, camera),
            canvas=self._canvas(sensor.quality),
        )

    def _canvas(self, quality: Quality) -> Canvas:
        return self._canvases.setdefault(quality, Canvas(self._shown().model, quality=quality))

    def _shown(self) -> StillScene:
        if self._scene is None:
            raise UsageError("nothing to draw yet; show a state first")
        return self._scene


def _free_camera(view: Orbit) -> mujoco.MjvCamera:
    camera = mujoco.MjvCamera()
    camera.type = mujoco.mjtCamera.mjCAMERA_FREE
    camera.azimuth, camera.elevation = math.degrees(view.azimuth), math.degrees(view.elevation)
    camera.distance = view.distance
    camera.lookat[:] = [*view.at, EYE_LEVEL]
    return camera
