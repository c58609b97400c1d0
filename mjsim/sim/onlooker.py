"""Any view of a world whose state is given: from outside, and what its onboard cameras would see without errors."""

import math
from dataclasses import dataclass

import mujoco

from mjsim.closing import Closes
from mjsim.compile import compile_world
from mjsim.errors import UsageError, did_you_mean
from mjsim.geometry import Array
from mjsim.interface import CameraFrame, Picture
from mjsim.sim.camera import OnboardCamera
from mjsim.sim.canvas import Canvas, Quality
from mjsim.sim.playback import bring_near
from mjsim.sim.renderer import SEEN_FROM_OUTSIDE, Renderer
from mjsim.sim.scenery import Scenery
from mjsim.world import World
from mjsim.world.looks import Looks
from mjsim.world.sensors import Camera

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
        self._model: mujoco.MjModel | None = None
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
        if self._model is None:
            self._model = compile_world(self._world).compile()
            self._data = mujoco.MjData(self._model)
            self._scenery = Scenery(self._model, self._world)
            self._first_looks = self._scenery.looks
        if qpos.shape != self._data.qpos.shape:
            raise UsageError(f"a state of {len(qpos)} numbers cannot be drawn; this world has {self._model.nq}")
        self._scenery.show(self._first_looks if looks is None else looks)
        self._data.qpos[:] = qpos
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_comPos(self._model, self._data)
        mujoco.mj_camlight(self._model, self._data)

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
        key = width, height, quality
        if key not in self._outside:
            canvas = self._canvas(quality)
            self._outside[key] = Renderer(
                self._model, width=width, height=height, canvas=canvas, groups=SEEN_FROM_OUTSIDE
            )
        if isinstance(view, str):
            if view.endswith("/chase"):
                bring_near(self._model, self._data, view)
            return self._outside[key].render(self._data, view)
        return self._outside[key].render(self._data, _free_camera(view))

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
        return self._cameras[key].frame(self._data, stamp)

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
            self._model,
            body,
            sensor.model_copy(update={**exact, "depth": depth, "segmentation": segmentation}),
            rate_hz=self._world.run.rate_hz,
            seed=0,
            canvas=self._canvas(sensor.quality),
        )

    def _canvas(self, quality: Quality) -> Canvas:
        if self._model is None:
            raise UsageError("nothing to draw yet; show a state first")
        return self._canvases.setdefault(quality, Canvas(self._model, quality=quality))


def _free_camera(view: Orbit) -> mujoco.MjvCamera:
    camera = mujoco.MjvCamera()
    camera.type = mujoco.mjtCamera.mjCAMERA_FREE
    camera.azimuth, camera.elevation = math.degrees(view.azimuth), math.degrees(view.elevation)
    camera.distance = view.distance
    camera.lookat[:] = [*view.at, EYE_LEVEL]
    return camera
