"""SLAM with natural features: one camera, with or without depth, and odometry."""

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.random import Generator

from mjsim.geometry import Array, Pose
from mjsim.interface import BeaconInfo, CameraFrame, Estimate, Observation, RobotInfo

from ..estimation.ekf_models import odometry_motion
from ..estimation.pose_graph import PoseGraph, compose, composed, step_between
from ..estimation.recent_motion import RecentMotion
from .picture_points import PointCamera
from .view_map import ViewMap
from .view_pose import MIN_MATCHES, Located

SLIP = np.array([0.02, 0.02, 0.02])
"""Errors of odometry beyond its data sheet: relative to the distance, to the sideways distance, and to the turn."""
MIN_COVARIANCE = np.diag([0.001, 0.001, 0.0005]) ** 2
"""Minimum covariance of a step [m^2, rad^2]."""
UNSEEN = np.diag([0.1, 0.1, 0.03]) ** 2
"""Covariance, beyond that of odometry, of a step to a picture that shows nothing seen in the last ones."""
SHAKEN = np.diag([0.5, 0.5, 0.5]) ** 2
"""Covariance of the pose while pictures do not show the expected landmarks [m^2, rad^2]."""
EXPECTED, CONTRARY = 60, 0.06
"""Number of visible landmarks below which a picture is no evidence, and the proportion of them below which it
contradicts the estimate."""
LOST = 5, 1.0
"""Number of such pictures in a row, and their duration [s], after which the robot is lost."""
NEW_VIEW = 0.7, 0.6
"""Motion by odometry after which a robot that sees none of the expected landmarks faces a new view [m, rad]."""


class VisualSlam:
    """Estimates the pose from odometry and a camera, and keeps a map of landmarks: features of pictures.

    The robot must stand level: a balancing robot leans by more than is assumed.
    """

    def __init__(
        self,
        camera: str | None = None,
        *,
        features: int = 400,
        distance: float = 0.25,
        turn_deg: float = 10.0,
        odometry_scale: float = 1.5,
    ) -> None:
        """Set the rules.

        Args:
            camera: Name of the camera; None for the first. If it measures depth, depth is used.
            features: Maximum number of features in a picture.
            distance: Distance between two keyframes [m].
            turn_deg: Turn between two keyframes.
            odometry_scale: Factor on the standard deviation of odometry, for slip that its data sheet does not include.

        Raises:
            ValueError: A number is too small.
        """
        if features < MIN_MATCHES:
            raise ValueError(f"features is {features}; it must be at least {MIN_MATCHES}")
        rules = {"distance": distance, "turn_deg": turn_deg, "odometry_scale": odometry_scale}
        for name, value in rules.items():
            if not value > 0.0:
                raise ValueError(f"{name} is {value}; it must be above 0")
        self._name, self._features = camera, features
        self._distance, self._turn, self._scale = distance, math.radians(turn_deg), odometry_scale

    def start(self, robot: RobotInfo, catalogue: Mapping[str, BeaconInfo], rng: Generator) -> None:
        """Begin at the robot's prior with an empty map.

        Raises:
            ValueError: The robot has no such camera.
        """
        self._camera = PointCamera(robot, self._name, features=self._features)
        self._motion = odometry_motion()
        covariance = np.asarray(robot.prior_covariance, dtype=float)
        self._map = ViewMap(robot.prior.as_array(), covariance, self._camera)
        self._recent = RecentMotion()
        self._trajectory: list[tuple[float, int, Array]] = []
        self._contrary: list[tuple[float, Array]] = []
        self._rest(np.zeros(3), np.zeros((3, 3)))

    def _rest(self, since: Array, covariance: Array) -> None:
        """Begin at a new keyframe, given the motion since its picture."""
        self._step, self._step_covariance = since, covariance
        self._seen, self._seen_covariance = np.zeros(3), np.zeros((3, 3))
        self._after, self._after_covariance = since, covariance

    @property
    def graph(self) -> PoseGraph:
        """Pose graph of the keyframes."""
        return self._map.graph

    @property
    def loops(self) -> int:
        """Number of closed loops."""
        return self._map.loops.closed

    def lost(self) -> bool:
        """Return whether pictures show neither the expected landmarks nor, so far, any other known place."""
        return self._map.lost

    def update(self, seen: Observation) -> Estimate:
        """Return the belief after this tick's odometry and picture."""
        moved = seen.odometry
        control = np.array([moved.forward, moved.left, moved.turn])
        noise = np.asarray(self._scale**2 * moved.covariance)
        self._recent.move(moved, seen.moment)
        self._step, self._step_covariance = self._advanced(self._step, self._step_covariance, control, noise)
        self._after, self._after_covariance = self._advanced(self._after, self._after_covariance, control, noise)
        frame = seen.cameras.get(self._camera.name)
        if frame is not None:
            self._look(frame)
        step = compose(self._seen, self._after)
        self._trajectory.append((seen.moment, len(self._map.keyframes) - 1, step))
        return self._belief()

    def path(self) -> Sequence[tuple[float, Pose]]:
        """Return the final trajectory: pose at the end of each tick's motion and its time [s], from the whole map."""
        self._map.finish()
        times = [time for time, _, _ in self._trajectory]
        numbers, steps = (
            [max(number, 0) for _, number, _ in self._trajectory],
            [step for _, _, step in self._trajectory],
        )
        poses = composed(self._map.graph.poses[numbers], np.array(steps).reshape(-1, 3))
        return [(time, Pose.from_array(pose)) for time, pose in zip(times, poses, strict=True)]

    def _slip(self, step: Array) -> Array:
        """Return the covariance of the errors of odometry over a step beyond its data sheet, shape (3, 3)."""
        distance = float(np.hypot(*step[:2]))
        slip = np.diag((SLIP * (distance, distance, abs(step[2]))) ** 2)
        return np.asarray(slip + MIN_COVARIANCE)

    def _advanced(self, pose: Array, covariance: Array, control: Array, noise: Array) -> tuple[Array, Array]:
        """Return a pose and its covariance after a motion with independent noise."""
        pose, F, G = self._motion(pose, control)
        return pose, F @ covariance @ F.T + G @ noise @ G.T

    def _look(self, frame: CameraFrame) -> None:
        """Use a picture."""
        points = self._camera.find(frame)
        late, late_covariance = self._recent.since(frame.stamp)
        back = step_between(late, np.zeros(3))
        by_odometry, expected = compose(self._step, back), compose(self._seen, compose(self._after, back))
        if not self._map.keyframes:
            nothing = np.zeros(0, dtype=np.intp)
            self._map.add(points, Located(np.zeros(5), np.zeros((5, 5)), nothing, nothing, nothing), nothing, np.eye(3))
            self._rest(late, late_covariance)
            self._localise()
            return
        covariance = self._step_covariance + self._slip(by_odometry)
        prior = np.array([*by_odometry, 0.0, 0.0])
        located = self._map.located(
            points, self._rays, self._descriptors, np.array([*expected, 0.0, 0.0]), (prior, covariance)
        )
        self._after, self._after_covariance = late, late_covariance
        # The robot may have been pushed, or its wheels slipped: find out where it is.
        moved = self._map.recognised(points, self._rays, self._descriptors) if len(self._contrary) > 1 else None
        located = moved or located
        begins = self._judge(frame.stamp, by_odometry, located, len(points)) or moved is not None
        if self._contrary and not begins:
            # The features of such a picture do not belong in the map.
            self._seen, self._seen_covariance = by_odometry, covariance
            return
        self._seen, self._seen_covariance = located.state[:3], located.covariance[:3, :3]
        if begins or math.hypot(*self._seen[:2]) > self._distance or abs(self._seen[2]) > self._turn:
            doubt = UNSEEN if begins and moved is None else MIN_COVARIANCE
            self._map.add(points, located, self._landmarks, self._seen_covariance + doubt)
            self._rest(late, late_covariance)
            self._map.work()
            self._localise()

    def _localise(self) -> None:
        """Prepare the landmarks that the next pictures may show."""
        self._landmarks = self._map.local()
        self._rays = self._map.rays(self._landmarks, len(self._map.keyframes) - 1)
        self._descriptors = self._map.descriptors(self._landmarks)

    def _judge(self, stamp: float, by_odometry: Array, located: Located, features: int) -> bool:
        """Record whether a picture contradicts the estimate, and return whether another part of the map begins with it.

        Args:
            stamp: Time of the picture [s].
            by_odometry: Pose by odometry since the last keyframe, shape (3,).
            located: Pose by the picture.
            features: Number of features in it.
        """
        enough = min(len(located.visible), features)
        if enough < EXPECTED:
            begins = len(self._contrary) > 0
            self._contrary.clear()
            return begins
        if len(located.landmarks) >= max(CONTRARY * enough, MIN_MATCHES):
            self._contrary.clear()
            return False
        self._contrary.append((stamp, by_odometry))
        since, place = self._contrary[0]
        moved = step_between(place, by_odometry)
        if math.hypot(*moved[:2]) > NEW_VIEW[0] or abs(moved[2]) > NEW_VIEW[1]:
            # The view is new because the robot went there.
            self._contrary.clear()
            return True
        if len(self._contrary) < LOST[0] or stamp - since < LOST[1]:
            return False
        self._contrary.clear()
        self._map.lose()
        return True

    def _belief(self) -> Estimate:
        """Return the pose of the newest keyframe, propagated by the last picture and odometry."""
        pose, covariance = self._map.belief()
        pose, covariance = self._advanced(pose, covariance, self._seen, self._seen_covariance)
        pose, covariance = self._advanced(pose, covariance, self._after, self._after_covariance)
        if len(self._contrary) > 1:
            covariance = covariance + SHAKEN
        return Estimate(Pose.from_array(pose), covariance)
