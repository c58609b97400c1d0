"""A map of pictures: landmarks on rays from keyframes, and a graph of the keyframes' poses that closes loops."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array, wrap_angles

from ..estimation.ekf_models import odometry_motion
from ..estimation.pose_graph import COMMON, PoseGraph, carried, compose, composed, step_between
from ..estimation.pose_matrices import inverse
from ..estimation.relocation import ANY_HEADING, ANYWHERE
from ..scans.loop_closing import GraphLoops, Loop, is_certain
from ..scans.odometry_bias import OdometryBias
from .picture_points import PicturePoints, PointCamera
from .places_seen import PlacesSeen
from .view_geometry import LandmarkRays, rays_of, seen_from
from .view_pose import Located, locate, locate_anywhere

LEAN = np.array([0.004, 0.002])
"""Standard deviation of the pitch and the roll of the body of a robot that drives [rad]."""
UNKNOWN = 0.3, 1.0
"""Mean and standard deviation of an inverse depth that was not measured [1/m]."""
NEAREST, GROWTH = 10.0, 1e-5
"""Maximum inverse depth [1/m], and the variance that each sighting adds to one, relative to its square."""
LOCAL, MAX_LOCAL = 12, 600
"""Number of keyframes after which a landmark is no longer looked for, and number of those that are."""
DELAY = 2
"""Number of keyframes after which a keyframe is compared with old ones: its depths are better known by then."""
REACH, TURN = 2.0, 0.8
"""Distance and turn to an old keyframe that may show the same, without drift [m, rad]."""
DETOUR, MIN_WAY = 3.0, 3.0
"""The robot has returned to an old keyframe if its path since then exceeds the step between them times the first, plus
the second [m]; a radian counts as half a metre."""
AROUND = 2
"""Landmarks of this many keyframes on either side of an old one are compared too."""
MIN_INLIERS, MIN_SHARE = 25, 0.25
"""Minimum number of landmarks that agree with a loop, and of those that should be visible."""
LOOP_FLOOR = np.diag([0.02, 0.02, 0.004]) ** 2
"""Covariance of a loop in addition to that of its pose [m^2, rad^2]."""
APART, NEIGHBOURS = 2.5, 30
"""Distance [m], and maximum number of keyframes, between two loops that confirm each other."""
GATE = 16.3
"""Squared normalised difference of a loop from what the graph expects, above which it is wrong (chi-square, 3 degrees
of freedom: 99.9 %)."""
SYSTEMATIC = np.array([0.01, 0.005, 0.002, 1e-4, 1e-3, 1e-3])
"""Standard deviations of the systematic errors of steps by one camera, in the order of `odometry_bias.PRIOR`: depths
and poses of neighbours err together."""
DEPTH_SYSTEMATIC = np.array([0.004, 0.004, 0.001, 1e-4, 1e-3, 1e-3])
"""The same with depth."""
SETTLED = 0.003
"""The graph is iterated while poses move by more than this [m, rad]."""
TRIED = 4
"""Number of places with which each keyframe of a lost robot is compared."""
SURE_SHARE = 0.4
"""Minimum proportion of the features of a keyframe that agree with a place where a lost robot is found: floors and
walls repeat."""
AGREEING = np.array([0.4, 0.4, 0.15])
"""Maximum difference between two consecutive keyframes in where they find a lost robot [m, m, rad]."""
UNIQUE = 0.6
"""Another place must have less than this proportion of the inliers of the best one."""
LOOSE = np.diag([0.3, 0.3, 0.1]) ** 2
"""Covariance of a pose from two matches, before all are used."""


class ViewKeyframe(NamedTuple):
    """A picture of the map."""

    points: PicturePoints
    landmarks: NDArray[np.intp]
    """Number of the landmark of each feature."""


class ViewMap:
    """Keyframes, landmarks and loops of one robot.

    References:
        Mur-Artal, Montiel, Tardos, ORB-SLAM, IEEE T-RO 31(5), 2015: keyframes, recognised places, verified loops.
    """

    def __init__(self, prior: Array, prior_covariance: Array, camera: PointCamera) -> None:
        """Start without pictures.

        Args:
            prior: Start of the robot, world frame, shape (3,) [m, m, rad].
            prior_covariance: Covariance of it, shape (3, 3).
            camera: The camera.
        """
        self._prior_covariance, self._camera = prior_covariance, camera
        self._motion = odometry_motion()
        self.graph = PoseGraph(prior[None])
        """Poses of the keyframes."""
        self.keyframes: list[ViewKeyframe] = []
        self.loops = GraphLoops(self.graph, settled=SETTLED, apart=APART, neighbours=NEIGHBOURS)
        self._places, self._ways = PlacesSeen(), np.zeros(0)
        self._bias = OdometryBias()
        self._systematic = np.zeros((COMMON, COMMON))
        # Of the newest keyframe: covariance given the systematic errors, and derivative of its pose by them.
        self._own, self._slopes = prior_covariance, np.zeros((3, COMMON))
        self._begin: int | None = None
        self._start: Array | None = None
        self._count = 0
        self._anchors, self._last, self._times = (np.zeros(1024, dtype=np.intp) for _ in range(3))
        self._descriptors = np.zeros((1024, 4), dtype=np.uint64)
        self._rays = LandmarkRays(np.zeros((1024, 3)), np.zeros((1024, 3)), *(np.zeros(1024) for _ in range(3)))

    @property
    def lost(self) -> bool:
        """Whether the pose of the newest keyframes relative to earlier ones is unknown."""
        return self._begin is not None

    def lose(self) -> None:
        """Begin a new part of the map at the next keyframe: the robot may be anywhere."""
        self._begin, self._start = len(self.keyframes), None

    def belief(self) -> tuple[Array, Array]:
        """Return the pose of the newest keyframe in the world, shape (3,), and its covariance, shape (3, 3)."""
        return self.graph.poses[-1], self._covariance

    @property
    def _covariance(self) -> Array:
        """Covariance of the pose of the newest keyframe, shape (3, 3)."""
        return np.asarray(self._own + self._slopes @ self._systematic @ self._slopes.T)

    def rays(self, landmarks: NDArray[np.intp], frame: int) -> LandmarkRays:
        """Return landmarks in the frame of a keyframe."""
        poses = step_between(self.graph.poses[frame], self.graph.poses[self._anchors[landmarks]])
        return self._rays.only(landmarks).placed(poses)

    def add(self, points: PicturePoints, located: Located, numbers: NDArray[np.intp], covariance: Array) -> None:
        """Add a keyframe.

        Args:
            points: Features of its picture.
            located: Its pose in the frame of the previous keyframe, and which landmarks it shows.
            numbers: The landmarks to which the indices in `located` refer.
            covariance: Covariance of the step from the previous keyframe, shape (3, 3).
        """
        step, number = located.state[:3], len(self.keyframes)
        if not number:
            has_depth = bool((points.rays[:, 2] > 0.0).any())
            self._systematic = np.diag(np.square(DEPTH_SYSTEMATIC if has_depth else SYSTEMATIC))
            self.graph.expect(np.zeros(COMMON), self._systematic)
        if number:
            covariance = (
                np.diag(np.square((*ANYWHERE[:2], np.sqrt(ANY_HEADING)))) if number == self._begin else covariance
            )
            slopes = self._bias.slopes(step, float(np.hypot(*step[:2])), 0.0)
            pose, F, G = self._motion(self.graph.poses[-1], step)
            self._own, self._slopes = F @ self._own @ F.T + G @ covariance @ G.T, F @ self._slopes + G @ slopes
            self._refine(points, located, numbers)
            self.graph.add_pose(pose)
            at = step - slopes @ self.graph.errors
            self.graph.add_step(number - 1, number, at, inverse(covariance), slopes=slopes)
        self._ways = np.append(
            self._ways, self._ways[-1:] + np.hypot(*step[:2]) + 0.5 * abs(step[2]) if number else 0.0
        )
        landmarks = np.full(len(points), -1, dtype=np.intp)
        known = numbers[located.landmarks]
        landmarks[located.features] = known
        self._descriptors[known] = points.descriptors[located.features]
        new = np.flatnonzero(landmarks < 0)
        landmarks[new] = self._create(points, new, located.state, number)
        self._last[landmarks], self._times[landmarks] = number, self._times[landmarks] + 1
        self.keyframes.append(ViewKeyframe(points, landmarks))
        self._places.add(points.descriptors)

    def _create(self, points: PicturePoints, features: NDArray[np.intp], state: Array, number: int) -> NDArray[np.intp]:
        """Return the numbers of new landmarks of some features of a keyframe."""
        numbers = self._count + np.arange(len(features))
        self._count += len(features)
        while self._count > len(self._anchors):
            self._grow()
        rays, noise = points.rays[features], points.noise[features]
        measured = rays[:, 2] > 0.0
        origins, directions = rays_of(rays[:, :2], state, self._camera.robot_from_camera)
        self._rays.origins[numbers], self._rays.directions[numbers] = origins, directions
        self._rays.inverses[numbers] = np.where(measured, rays[:, 2], UNKNOWN[0])
        self._rays.variances[numbers] = np.where(measured, noise[:, 2], UNKNOWN[1]) ** 2
        self._rays.noise[numbers] = noise[:, 0]
        self._anchors[numbers], self._descriptors[numbers] = number, points.descriptors[features]
        return numbers

    def _grow(self) -> None:
        """Double the space for landmarks."""
        self._anchors, self._last, self._times = (
            np.concatenate([part, np.zeros_like(part)]) for part in (self._anchors, self._last, self._times)
        )
        self._descriptors = np.concatenate([self._descriptors, np.zeros_like(self._descriptors)])
        rays = self._rays
        parts = rays.origins, rays.directions, rays.inverses, rays.variances, rays.noise
        self._rays = LandmarkRays(*(np.concatenate([part, np.zeros_like(part)]) for part in parts))

    def _refine(self, points: PicturePoints, located: Located, numbers: NDArray[np.intp]) -> None:
        """Update the depths of the landmarks that a picture shows, given its pose: a Kalman filter of each alone."""
        known = numbers[located.landmarks]
        rays = self.rays(known, len(self.keyframes) - 1)
        z, H, J = seen_from(rays, located.state, self._camera.robot_from_camera)
        error = points.rays[located.features] - z
        S = H @ located.covariance @ H.transpose(0, 2, 1)
        noise = points.noise[located.features] ** 2
        noise[:, :2] += rays.noise[:, None] ** 2
        S[:, (0, 1, 2), (0, 1, 2)] += noise
        gained = np.linalg.solve(S, J[:, :, None])[:, :, 0]
        information = 1.0 / rays.variances + np.einsum("ki,ki->k", gained, J)
        changed = rays.inverses + np.einsum("ki,ki->k", gained, error) / information
        self._rays.inverses[known] = np.clip(changed, 1e-3, NEAREST)
        self._rays.variances[known] = 1.0 / information + GROWTH * rays.inverses**2

    def local(self) -> NDArray[np.intp]:
        """Return the landmarks that the next pictures may show."""
        newest = len(self.keyframes) - 1
        first = max(newest - LOCAL, self._begin or 0, 0)
        own = self.keyframes[-1].landmarks
        seen = np.unique(np.concatenate([each.landmarks for each in self.keyframes[first:]]))
        old = seen[(self._times[seen] > 1) & (self._last[seen] < newest)]
        old = old[np.argsort(-self._last[old], kind="stable")]
        return np.concatenate([own, old])[:MAX_LOCAL]

    def descriptors(self, landmarks: NDArray[np.intp]) -> NDArray[np.uint64]:
        """Return the newest descriptor of each landmark."""
        return self._descriptors[landmarks]

    def work(self) -> None:
        """Look for a loop of a keyframe, and improve the graph."""
        number = len(self.keyframes) - 1 - DELAY
        if self._begin is not None:
            self._find(number, self._begin)
        elif number > 0:
            self._try_loop(number)
        if self.loops.moving:
            self._solve()

    def finish(self) -> None:
        """Do all pending work."""
        for _ in range(20):
            if self.loops.moving:
                self._solve()

    def _try_loop(self, number: int) -> None:
        """Compare a keyframe with the old one near it that looks most like it."""
        step = step_between(self.graph.poses[number], self.graph.poses[:number])
        distance, turn = np.hypot(*step.T[:2]), np.abs(step[:, 2])
        drift = 2.0 * np.sqrt(np.trace(self._covariance[:2, :2]))
        turned = TURN + 2.0 * np.sqrt(self._covariance[2, 2])
        returned = self._ways[number] - self._ways[:number] > MIN_WAY + DETOUR * (distance + 0.5 * turn)
        near = np.flatnonzero((distance < REACH + drift) & (turn < turned) & returned)
        if not len(near):
            return
        old = int(near[np.argmax(self._places.likeness(number, near))])
        located = self._verified(old, number)
        if located is None:
            return
        covariance = self.graph.step_covariances([old], number)[0]
        own = located.covariance[:3, :3] + LOOP_FLOOR
        difference = located.state[:3] - step_between(self.graph.poses[old], self.graph.poses[number])
        difference[2] = wrap_angles(difference[2])
        if difference @ inverse(covariance + own) @ difference < GATE:
            self.loops.consider(Loop(old, number, located.state[:3], inverse(own), is_certain(covariance, own)))

    def _verified(self, old: int, number: int) -> Located | None:
        """Return the pose of a keyframe in the frame of an old one; None if they do not show the same landmarks."""
        around = self.keyframes[max(0, old - AROUND) : old + AROUND + 1]
        landmarks = np.unique(np.concatenate([each.landmarks for each in around]))
        return self.recognised(self.keyframes[number].points, self.rays(landmarks, old), self._descriptors[landmarks])

    def recognised(self, points: PicturePoints, rays: LandmarkRays, descriptors: NDArray[np.uint64]) -> Located | None:
        """Return the pose from which a picture shows some landmarks; None if it does not show enough of them."""
        found = locate_anywhere(points, rays, descriptors, robot_from_camera=self._camera.robot_from_camera)
        if found is None:
            return None
        guess = np.array([*found, 0.0, 0.0])
        located = self.located(points, rays, descriptors, guess, (guess, LOOSE))
        enough = max(MIN_INLIERS, MIN_SHARE * min(len(located.visible), len(points)))
        return located if len(located.landmarks) >= enough else None

    def located(
        self,
        points: PicturePoints,
        rays: LandmarkRays,
        descriptors: NDArray[np.uint64],
        guess: Array,
        prior: tuple[Array, Array],
    ) -> Located:
        """Return the pose of a picture, given a prior of the pose (5,) and its covariance without leaning (3, 3)."""
        covariance = np.diag([0.0, 0.0, 0.0, *LEAN**2])
        covariance[:3, :3] = prior[1]
        return locate(
            points,
            rays,
            descriptors,
            guess,
            (prior[0], covariance),
            robot_from_camera=self._camera.robot_from_camera,
            extent=self._camera.extent,
        )

    def _find(self, number: int, begin: int) -> None:
        """Compare a keyframe of a lost robot with the old ones; join the map if only one place fits."""
        if number < begin:
            return
        likeness = self._places.likeness(number, np.arange(begin))
        tried: list[tuple[int, int, Located]] = []
        for _ in range(TRIED):
            old = int(np.argmax(likeness))
            if likeness[old] <= 0.0:
                break
            near = np.hypot(*(self.graph.poses[:begin, :2] - self.graph.poses[old, :2]).T) < REACH / 2.0
            likeness[near] = 0.0
            located = self._verified(old, number)
            if located is not None and len(located.landmarks) > SURE_SHARE * len(self.keyframes[number].points):
                tried.append((len(located.landmarks), old, located))
        if not tried:
            return
        tried.sort(key=lambda each: -each[0])
        inliers, old, located = tried[0]
        places = [compose(self.graph.poses[each[1]], each[2].state[:3]) for each in tried]
        for other, place in zip(tried[1:], places[1:], strict=True):
            if other[0] > UNIQUE * inliers and np.hypot(*(place - places[0])[:2]) > 1.0:
                return
        # A second keyframe must agree on where this part of the map begins.
        start = compose(places[0], step_between(self.graph.poses[number], self.graph.poses[begin]))
        before, self._start = self._start, start
        if before is None or not (np.abs(step_between(before, start)) < AGREEING).all():
            return
        since = composed(places[0], step_between(self.graph.poses[number], self.graph.poses[begin:]))
        self.graph.poses = np.concatenate([self.graph.poses[:begin], since])
        self.loops.close(old, number, located.state[:3], inverse(located.covariance[:3, :3] + LOOP_FLOOR))
        self._begin = None
        self._solve()

    def _solve(self) -> None:
        """Iterate the graph; when it has converged, remove loops that do not fit."""
        before = self.graph.poses
        self.graph.solve(rounds=1)
        self.loops.settle(before)
        newest = len(self.graph.poses) - 1
        by_first = carried(self.graph.poses[newest], self.graph.poses[0])
        joint = self.graph.joint_covariance(newest)
        self._systematic = joint[3:, 3:]
        self._slopes = np.asarray(np.linalg.solve(joint[3:, 3:], joint[3:, :3]).T)
        self._own = joint[:3, :3] - self._slopes @ joint[3:, :3] + by_first @ self._prior_covariance @ by_first.T
