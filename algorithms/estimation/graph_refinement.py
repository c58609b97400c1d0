"""Final solution of the whole graph of a run, with noise and systematic errors estimated from the run.

While a robot drives, odometry and sightings are weighted according to their data sheets. The complete run reveals the
systematic errors of odometry, the actual noise of sightings, and legs in which the robot was displaced. They are
estimated from the solved graph, which is then solved again, for several rounds.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mjsim.geometry import Array, wrap_angles
from mjsim.interface import Sighting

from .displaced_legs import DISPLACED, Factors, displacement_odds
from .ekf_models import innovation, range_bearing
from .graph_factors import prior_factor, sighting_factor, turned_covariance
from .pose_graph import composed, step_between, step_errors

ROUNDS = 4
"""Number of rounds; errors and noise change little after that."""
CAUCHY = 2.0
"""Scale of Cauchy's loss in standard deviations: larger residuals of sightings lose influence, so that wrong ones are
ignored."""
HUBER = 2.0
"""Scale of Huber's loss of legs for the systematic errors, in standard deviations."""
FINEST, COARSEST = 0.25, 4.0
"""Limits of the actual noise of sightings relative to their covariance. The graph follows sightings a little, so
residuals are smaller than their noise."""
NORMAL = 1.4826
"""Standard deviation of a normal distribution divided by its median absolute deviation."""


@dataclass(frozen=True, slots=True, eq=False)
class Leg:
    """Odometry between two successive poses of a graph."""

    step: Array
    """Pose of the second in the frame of the first, shape (3,) [m, m, rad]."""
    covariance: Array
    """Covariance of the step, in the axes of the first, shape (3, 3)."""
    slopes: Array
    """Derivative of the step by the systematic errors of odometry, shape (3, 4)."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MeasuredGraph:
    """All measurements of a robot, and the poses and landmarks of the graph."""

    poses: Array
    """World frame, shape (n, 3) [m, m, rad]."""
    landmarks: Mapping[str, Array]
    """World frame, shape (2,) each [m]."""
    first_covariance: Array
    """Covariance of the first pose, in the world's axes, shape (3, 3)."""
    legs: Sequence[Leg]
    """Odometry between successive poses, n - 1 of them."""
    sightings: Sequence[tuple[int, Sighting]]
    """Sightings of named landmarks, each with the index of its pose."""
    systematic_variances: Array
    """Variances of the systematic errors of odometry, shape (4,)."""


@dataclass(frozen=True, slots=True, eq=False)
class Displacement:
    """A time in which a robot was moved without odometry measuring it, until it was relocalized."""

    end: int
    """Tick at which it was found."""
    pose: int
    """Last pose of the graph before that."""
    step: Array
    """Step from there to that tick by odometry alone, shape (3,) [m, m, rad]."""
    slopes: Array
    """Derivative of the step by the systematic errors of odometry, shape (3, 4)."""
    sightings: Sequence[tuple[int, Sighting]]
    """Sightings of the map since they began to fail, each with its tick."""


def sound_sightings(
    sightings: Sequence[tuple[int, Sighting]], begin: int, failing: set[str | None]
) -> list[tuple[int, Sighting]]:
    """Return the sightings of a graph without those of failing landmarks from a pose on, if they have others."""
    doubtful = failing & {sighting.name for number, sighting in sightings if number < begin}
    return [(number, seen) for number, seen in sightings if number < begin or seen.name not in doubtful]


def moved_path(path: Array, expected: Array, displaced: Displacement, landmarks: Mapping[str, Array]) -> Array:
    """Return a path with displacements at the time that sightings indicate, not when the robot was relocalized.

    By odometry, the ticks before it was found follow from the pose before, or precede the pose where it was found. The
    time of the change is the most probable one, with the loss of sightings that `refined_poses` has.

    Args:
        path: Pose of each tick, shape (n, 3).
        expected: Pose at `displaced.end` without a displacement, shape (3,).
        displaced: What happened.
        landmarks: World frame, shape (2,) each [m].
    """
    first = displaced.sightings[0][0]
    since = composed(path[displaced.end], step_between(expected, path[first : displaced.end]))
    gained, best, change = 0.0, 0.0, displaced.end
    for tick, sighting in reversed(displaced.sightings):
        place = landmarks[sighting.name or ""]
        gained += _loss(path[tick], place, sighting) - _loss(since[tick - first], place, sighting)
        if gained > best:
            best, change = gained, tick
    return np.concatenate([path[:change], since[change - first :], path[displaced.end :]])


def _loss(pose: Array, place: Array, sighting: Sighting) -> float:
    """Return Cauchy's loss of a sighting."""
    expected, _, _ = range_bearing(pose, place[None])
    nu = innovation(np.array([[sighting.range, sighting.bearing]]), expected)[0]
    squared = float(nu @ np.linalg.solve(sighting.covariance, nu))
    return 0.5 * CAUCHY**2 * math.log1p(squared / CAUCHY**2)


def refined_poses(gtsam: Any, drive: MeasuredGraph) -> tuple[Array, Array]:
    """Return the poses that fit all measurements best, and the systematic errors of odometry.

    Args:
        gtsam: The module.
        drive: Drive with the initial poses.

    Returns:
        poses: World frame, shape (n, 3) [m, m, rad].
        errors: Errors as in `OdometryErrors`, shape (4,).

    References:
        Zhang, Parameter Estimation Techniques, Image and Vision Computing 15(1), 1997, table 1: Cauchy's loss.
    """
    values, errors = _values(gtsam, drive), np.zeros(len(drive.systematic_variances))
    while True:
        for _ in range(ROUNDS):
            errors = systematic_errors(drive, drive.poses, errors)
            scales = sighting_scales(drive, drive.poses, drive.landmarks)
            values = gtsam.LevenbergMarquardtOptimizer(_graph(gtsam, drive, errors, scales), values).optimize()
            poses = np.array([_pose(values.atPose2(gtsam.symbol("x", row))) for row in range(len(drive.poses))])
            landmarks = {name: np.asarray(values.atPoint2(key)) for name, key in _keys(gtsam, drive).items()}
            drive = replace(drive, poses=poses, landmarks=landmarks)
        odds = leg_odds(drive, errors, scales)
        displaced = int(np.argmax(odds))
        if odds[displaced] <= 0.0:
            return drive.poses, errors
        legs = list(drive.legs)
        legs[displaced] = replace(legs[displaced], covariance=legs[displaced].covariance + DISPLACED)
        drive = replace(drive, legs=legs)


def leg_odds(drive: MeasuredGraph, errors: Array, scales: Array) -> Array:
    """Return for each leg, and 0, the logarithm of the odds that the robot was displaced in it, by solved poses.

    Args:
        drive: Drive with the poses and landmarks that fit best.
        errors: Systematic errors of odometry, shape (4,).
        scales: Ratios of the actual noise of ranges and bearings to their standard deviations, shape (2,).
    """
    if not drive.legs or not drive.sightings:
        return np.zeros(1)
    poses, number = drive.poses, len(drive.poses)
    steps = np.array([leg.step + leg.slopes @ errors for leg in drive.legs])
    off, A, B = step_errors(poses[:-1], poses[1:], steps)
    trust = np.linalg.inv(np.array([leg.covariance for leg in drive.legs]))
    legs = Factors(off, np.concatenate([A, B], axis=2), trust, 3 * np.arange(number - 1)[:, None] + np.arange(6))
    columns = {name: 3 * number + 2 * index for index, name in enumerate(drive.landmarks)}
    looks = []
    for row, sighting in drive.sightings:
        name = sighting.name or ""
        expected, H_pose, H_landmark = range_bearing(poses[row], drive.landmarks[name][None])
        nu = innovation(np.array([[sighting.range, sighting.bearing]]), expected)[0]
        information = np.linalg.inv(sighting.covariance * np.outer(scales, scales))
        weight = 1.0 / (1.0 + nu @ information @ nu / CAUCHY**2)
        own = [*range(3 * row, 3 * row + 3), columns[name], columns[name] + 1]
        looks.append((-nu, np.concatenate([H_pose[0], H_landmark[0]], axis=1), weight * information, own))
    sightings = Factors(*(np.array(each) for each in zip(*looks, strict=True)))
    first = np.asarray(np.linalg.inv(drive.first_covariance), dtype=float)
    size = 3 * number + 2 * len(columns)
    return np.append(displacement_odds(poses, first, legs, sightings, size), 0.0)


def systematic_errors(drive: MeasuredGraph, poses: Array, known: Array) -> Array:
    """Return the systematic errors of odometry relative to the poses, shape (4,), by weighted least squares.

    Args:
        drive: Drive with its legs.
        poses: Poses of the graph, shape (n, 3).
        known: The errors so far, used to identify outliers among the legs, shape (4,).
    """
    if not drive.legs:
        return known
    D = np.array([leg.slopes for leg in drive.legs])
    residuals = step_between(poses[:-1], poses[1:]) - np.array([leg.step for leg in drive.legs])
    residuals[:, 2] = wrap_angles(residuals[:, 2])
    information = np.linalg.inv(np.array([leg.covariance for leg in drive.legs]))
    left = residuals - D @ known
    far = np.sqrt(np.einsum("ni,nij,nj->n", left, information, left))
    weighted = D.transpose(0, 2, 1) @ (information * np.minimum(1.0, HUBER / np.maximum(far, HUBER))[:, None, None])
    A = (weighted @ D).sum(axis=0) + np.diag(1.0 / np.maximum(drive.systematic_variances, 1e-12))
    return np.asarray(np.linalg.solve(A, (weighted @ residuals[:, :, None]).sum(axis=0)[:, 0]))


def sighting_scales(drive: MeasuredGraph, poses: Array, landmarks: Mapping[str, Array]) -> Array:
    """Return the ratios of the actual noise of ranges and bearings to their standard deviations, shape (2,)."""
    if not drive.sightings:
        return np.ones(2)
    normalised = []
    for row, sighting in drive.sightings:
        expected, _, _ = range_bearing(poses[row], landmarks[sighting.name or ""][None])
        residual = np.array([sighting.range, sighting.bearing]) - expected[0]
        residual[1] = wrap_angles(residual[1:])[0]
        normalised.append(residual / np.sqrt(np.diag(sighting.covariance)))
    return np.asarray(np.clip(NORMAL * np.median(np.abs(normalised), axis=0), FINEST, COARSEST))


def _graph(gtsam: Any, drive: MeasuredGraph, errors: Array, scales: Array) -> Any:
    """Return the factors of a drive: the first pose, legs corrected for systematic errors, robust sightings."""
    graph, noise, symbol = gtsam.NonlinearFactorGraph(), gtsam.noiseModel, gtsam.symbol
    graph.add(prior_factor(gtsam, symbol("x", 0), drive.poses[0], drive.first_covariance))
    for row, leg in enumerate(drive.legs):
        step = leg.step + leg.slopes @ errors
        own = noise.Gaussian.Covariance(turned_covariance(leg.covariance, -step[2]))
        graph.add(gtsam.BetweenFactorPose2(symbol("x", row), symbol("x", row + 1), gtsam.Pose2(*step), own))
    keys = _keys(gtsam, drive)
    for row, sighting in drive.sightings:
        covariance, loss = sighting.covariance * np.outer(scales, scales), noise.mEstimator.Cauchy.Create(CAUCHY)
        graph.add(sighting_factor(gtsam, (symbol("x", row), keys[sighting.name or ""]), sighting, covariance, loss))
    return graph


def _values(gtsam: Any, drive: MeasuredGraph) -> Any:
    """Return poses and landmarks as gtsam values."""
    values = gtsam.Values()
    for row, pose in enumerate(drive.poses):
        values.insert(gtsam.symbol("x", row), gtsam.Pose2(*pose))
    for name, key in _keys(gtsam, drive).items():
        values.insert(key, drive.landmarks[name])
    return values


def _keys(gtsam: Any, drive: MeasuredGraph) -> dict[str, int]:
    return {name: gtsam.symbol("l", number) for number, name in enumerate(drive.landmarks)}


def _pose(pose: Any) -> tuple[float, float, float]:
    return pose.x(), pose.y(), pose.theta()
