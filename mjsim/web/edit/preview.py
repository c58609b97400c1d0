"""The picture of an onboard camera at the position to which its robot is being moved in the editor."""

import math
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace

import cv2
import numpy as np

from mjsim.closing import awaited
from mjsim.geometry import Pose
from mjsim.sentences import Sentence
from mjsim.sim import Canvas, OnboardCamera, Simulation, streams_of
from mjsim.web.server import RefusedError
from mjsim.web.worlds import Signs, encoded
from mjsim.world import Camera, World

PICTURE_TIMEOUT = 60.0
"""Time limit for a picture, for which its world may have to be compiled [s]."""
MIN_WIDTH, MAX_WIDTH = 64, 1280
"""Minimum and maximum width of a picture [px]."""


@dataclass(frozen=True, slots=True)
class PreviewRequest:
    """The requested picture."""

    world: World
    robot: str
    camera: str
    pose: Pose
    """Pose of the robot, world frame."""
    width: int
    """Width of the picture [px]."""
    signs: Signs = field(default_factory=dict)
    """Signs of the files that the world names."""


class Preview:
    """Renders one picture at a time in a separate thread; of several waiting requests only the newest is served."""

    def __init__(self) -> None:
        """Start lazily; threads, models and contexts are created with the first picture."""
        self._pool = ThreadPoolExecutor(1, thread_name_prefix="preview")
        self._lock = threading.Lock()
        self._newest = 0
        self._set: _Set | None = None

    def picture(self, request: PreviewRequest) -> tuple[bytes, float]:
        """Return a JPEG and its rendering time [ms]; blocks until it is ready.

        Raises:
            RefusedError: A newer request arrived meanwhile, or there is no such camera.
            MjsimError: The world cannot be compiled or rendered.
        """
        with self._lock:
            self._newest += 1
            number = self._newest
        return awaited(self._pool.submit(self._draw, request, number), "a picture", within=PICTURE_TIMEOUT)

    def close(self) -> None:
        """Release the renderer."""
        awaited(self._pool.submit(self._clear), "the end of a picture", within=PICTURE_TIMEOUT)
        self._pool.shutdown()

    def _draw(self, request: PreviewRequest, number: int) -> tuple[bytes, float]:
        if number != self._newest:
            raise RefusedError(409, "a newer view was requested", superseded=True)
        request = replace(request, world=_with_fixed(request))
        began = time.perf_counter()
        if self._set is None or not self._set.serves(request):
            self._clear()
            self._set = _Set(request.world, request.signs)
        data = self._set.picture(request)
        return data, 1e3 * (time.perf_counter() - began)

    def _clear(self) -> None:
        if self._set is not None:
            self._set.close()
            self._set = None


class _Set:
    """A compiled world whose robots can be placed anywhere; those with a fixed base are part of the scene."""

    def __init__(self, world: World, signs: Signs) -> None:
        self.world, self._signs = world, signs
        # A world that is being edited would be baked after every change.
        self._sim = Simulation(world.model_copy(update={"shading": "plain"}))
        self._canvases: dict[str, Canvas] = {}
        self._cameras: dict[tuple[str, str, int], OnboardCamera] = {}

    def serves(self, request: PreviewRequest) -> bool:
        """Return whether a request is for this world, except for the poses of its robots."""
        return self._signs == request.signs and _differ_in_poses_alone(self.world, request.world)

    def picture(self, request: PreviewRequest) -> bytes:
        """Return the requested picture as JPEG."""
        camera = self._camera(request)
        for robot in request.world.robots:
            if robot.base == "fixed":
                continue
            place = Pose(robot.at[0], robot.at[1], math.radians(robot.heading_deg))
            self._sim.move(robot.name, request.pose if robot.name == request.robot else place, anywhere=True)
        image = camera.frame(self._sim.data, 0.0).image
        return encoded(np.asarray(cv2.cvtColor(image, cv2.COLOR_RGB2BGR), dtype=np.uint8), ".jpg")

    def close(self) -> None:
        for canvas in self._canvases.values():
            canvas.close()
        self._sim.close()

    def _camera(self, request: PreviewRequest) -> OnboardCamera:
        key = request.robot, request.camera, request.width
        if key not in self._cameras:
            robot = next((robot for robot in self.world.robots if robot.name == request.robot), None)
            sensors = () if robot is None else robot.sensors
            found = [each for each in sensors if isinstance(each, Camera) and each.camera == request.camera]
            if robot is None or not found:
                raise RefusedError(
                    404, Sentence("no camera '{robot}/{camera}' in this world", request.robot, request.camera)
                )
            canvas = self._canvases.setdefault(found[0].quality, Canvas(self._sim.model, quality=found[0].quality))
            calm, streams = _calm(found[0], request.width), streams_of(0, request.robot, request.camera)
            self._cameras[key] = OnboardCamera(self._sim.model, robot, calm, streams=streams, canvas=canvas)
        return self._cameras[key]


def _calm(camera: Camera, width: int) -> Camera:
    """Return a camera with a given picture width and without noise, and without effects of the robot's motion."""
    width = max(MIN_WIDTH, min(width, MAX_WIDTH))
    height = max(16, round(width * camera.height / camera.width))
    still = {"noise": 0.0, "shutter": 0.0, "rolling_shutter": 0.0, "depth": False, "segmentation": False}
    return camera.model_copy(update={**still, "width": width, "height": height})


def _differ_in_poses_alone(one: World, other: World) -> bool:
    """Return whether two worlds look the same except for the poses of their robots."""
    return _unplaced(one) == _unplaced(other)


def _with_fixed(request: PreviewRequest) -> World:
    """Return the world with its robot at the requested pose if its base is fixed: such robots are compiled there."""
    pose = {"at": (request.pose.x, request.pose.y), "heading_deg": math.degrees(request.pose.heading)}
    robots = tuple(
        robot.model_copy(update=pose) if robot.base == "fixed" and robot.name == request.robot else robot
        for robot in request.world.robots
    )
    return request.world.model_copy(update={"robots": robots})


def _unplaced(world: World) -> World:
    nowhere = {"at": (0.0, 0.0), "heading_deg": 0.0}
    robots = tuple(robot if robot.base == "fixed" else robot.model_copy(update=nowhere) for robot in world.robots)
    return world.model_copy(update={"robots": robots})
