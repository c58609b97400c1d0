"""An observer that detects the catalogue's pictures and markers in a camera and measures their positions.

Detected pictures are tracked: odometry predicts their position in the next image, and a direct comparison measures them
there. The whole image is searched, at several times the cost, when the view has changed enough.
"""

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.random import Generator

from mjsim.geometry import Array, Pose
from mjsim.interface import BeaconInfo, CameraFrame, Observation, RobotInfo, Sighting, sightings_from

from ..balance import TickLean
from ..scans.level_scan import leaning
from .marker_beacons import MarkerBeacons
from .picture_beacons import FoundPicture, PictureBeacons, PreparedImage
from .rectification import Rectifier

__all__ = ["BeaconVision", "MarkerBeacons", "PictureBeacons"]


class BeaconVision:
    """Sightings of picture and marker beacons from one camera."""

    def __init__(
        self,
        camera: str = "front",
        *,
        search_turn_deg: float = 15.0,
        search_distance: float = 0.5,
        search_frames: int = 15,
        range: Sequence[float] = (0.0, math.inf),
    ) -> None:
        """Set the camera, when to search the whole image again, and the range.

        Args:
            camera: Its name.
            search_turn_deg: Turn after which a search is due [deg].
            search_distance: Distance after which a search is due [m].
            search_frames: Images after which a search is due even at rest.
            range: [minimum, maximum] horizontal distance at which a beacon counts as seen [m]; for experiments with
                estimators.
        """
        if len(range) != 2 or not range[0] < range[1]:
            raise ValueError(f"range is {list(range)}; write [nearest, farthest] in metres")
        self._nearest, self._farthest = range
        self._camera = camera
        self._search_turn = math.radians(search_turn_deg)
        self._search_distance = search_distance
        self._search_frames = search_frames

    def start(self, robot: RobotInfo, catalogue: Mapping[str, BeaconInfo], rng: Generator) -> None:
        """Prepare to look for the pictures and markers of the catalogue."""
        sensor = robot.sensors.get(self._camera)
        if sensor is None or sensor.intrinsics is None:
            cameras = [name for name, info in robot.sensors.items() if info.intrinsics is not None]
            raise ValueError(f"no camera '{self._camera}' on this robot; it has {', '.join(cameras) or 'none'}")
        self._robot_from_camera = sensor.robot_from_sensor
        self._lean = TickLean(robot)
        self._rectifier = Rectifier(sensor.intrinsics)
        self._finders = _finders(catalogue)
        self._finder_of: dict[str, PictureBeacons | MarkerBeacons] = {}
        self._moved = Pose(0.0, 0.0, 0.0)
        self._newness = 1.0
        self._followed: dict[str, FoundPicture] = {}

    def observe(self, seen: Observation) -> Sequence[Sighting]:
        """Return the pictures seen at this tick; none without an image."""
        step = seen.odometry
        self._moved = self._moved @ Pose(step.forward, step.left, step.turn)
        pitch = self._lean.update(seen)
        frame = seen.cameras.get(self._camera)
        if frame is None:
            return ()
        found = self._detect(self._rectifier.straight(frame))
        self._followed = {picture.detection.name: picture for picture in found}
        self._moved = Pose(0.0, 0.0, 0.0)
        detections = [picture.detection for picture in found]
        # Sightings are level; the camera of a robot that balances leans with it.
        level_from_camera = leaning(pitch) @ self._robot_from_camera if pitch else self._robot_from_camera
        sightings = sightings_from(detections, level_from_camera, stamp=frame.stamp)
        return tuple(each for each in sightings if self._nearest <= each.range <= self._farthest)

    def _detect(self, frame: CameraFrame) -> list[FoundPicture]:
        view = PreparedImage(frame.image, frame.intrinsics)
        found = self._follow(view)
        self._newness += (
            abs(self._moved.heading) / self._search_turn
            + math.hypot(self._moved.x, self._moved.y) / self._search_distance
            + 1.0 / self._search_frames
        )
        if self._newness >= 1.0:
            self._newness = 0.0
            for finder in self._finders:
                fresh = finder.search(view, known=found)
                self._finder_of |= {picture.detection.name: finder for picture in fresh}
                found += fresh
        return found

    def _follow(self, view: PreparedImage) -> list[FoundPicture]:
        """Return the pictures of the last image that are still visible."""
        now_from_before = self._camera_motion()
        found = []
        for name, before in self._followed.items():
            rotation = now_from_before[:3, :3] @ before.pose.rotation
            position = now_from_before[:3, :3] @ before.pose.position + now_from_before[:3, 3]
            picture = self._finder_of[name].track(name, rotation, position, view)
            if picture is not None:
                found.append(picture)
        return found

    def _camera_motion(self) -> Array:
        """Return camera_now_from_camera_before, shape (4, 4) [m]."""
        back = self._moved.inverse()
        now_from_before = np.eye(4)
        now_from_before[:2, :2], now_from_before[:2, 3] = back.matrix()[:2, :2], back.matrix()[:2, 2]
        return np.linalg.inv(self._robot_from_camera) @ now_from_before @ self._robot_from_camera


def _finders(catalogue: Mapping[str, BeaconInfo]) -> list[PictureBeacons | MarkerBeacons]:
    """Return the detectors for a catalogue: one for all pictures, one per kind and size of markers."""
    finders: list[PictureBeacons | MarkerBeacons] = []
    pictures = {name: (info.picture, info.width) for name, info in catalogue.items() if info.picture is not None}
    if pictures:
        finders.append(PictureBeacons(pictures))
    kinds: dict[tuple[str, float], dict[int, str]] = {}
    for name, info in catalogue.items():
        if info.marker is not None:
            kinds.setdefault((info.marker.dictionary, info.width), {})[info.marker.id] = name
    return finders + [MarkerBeacons(dictionary, width, names=names) for (dictionary, width), names in kinds.items()]
