"""Cooperative SLAM: two robots exchange their maps by radio, and each merges both.

Each robot runs EKF-SLAM on its own sightings only and sends the resulting map, which summarizes them all in one
message. It keeps received maps separate from its own and merges them anew at every tick for its estimate; merged maps
are never sent. So each sighting counts once, even if reports are repeated, late or lost. Passing on received
information would need covariance intersection (Julier, Uhlmann 1997), which is conservative and loses much of it.
"""

import functools
from collections.abc import Hashable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.random import Generator

from mjsim.geometry import Array, Pose, align_rigid, wrap_angle
from mjsim.interface import BeaconInfo, Command, Estimate, Observation, RobotInfo

from .ekf_slam.ekf_slam import EkfSlam
from .waypoints import Waypoints

EXACT = 1e-10
"""Variance of the constraint that a landmark is at the same place on both maps [m^2]; above 0 because of rounding."""
ANYWHERE = np.diag([100.0, 100.0, 1.0])
"""Prior covariance of another robot's frame about the best fit: far larger than that of maps of a building."""


@dataclass(frozen=True, slots=True, eq=False)
class Map:
    """A Gaussian over a pose and landmarks, or over landmarks alone."""

    names: tuple[Hashable, ...]
    """Names of n landmarks."""
    mean: Array
    """Shape (3 + 2 n,) or (2 n,) [m, rad]."""
    covariance: Array
    """Square, of the same size."""

    def places(self) -> dict[Hashable, Array]:
        """Return the landmarks by name, shape (2,) each [m]."""
        return dict(zip(self.names, self.mean[len(self.mean) - 2 * len(self.names) :].reshape(-1, 2), strict=True))


@dataclass(frozen=True, slots=True, eq=False)
class TeamEstimate(Estimate):
    """An estimate, with a report for other robots."""

    report: Any = None
    """A message for `Command.messages`; None if no report is due at this tick."""


class CooperativeSlam:
    """Estimates pose and beacons from the robot's own sightings and the reports of other robots.

    References:
        Thrun, Liu, Multi-Robot SLAM with Sparse Extended Information Filters, ISRR 2003 (Springer 2005): maps of
        disjoint sightings are fused by adding their information, in an unknown frame after aligning it. Howard,
        Multi-robot Simultaneous Localization and Mapping using Particle Filters, IJRR 25(12), 2006: robots with
        initially unknown relative poses.
    """

    def __init__(
        self,
        *,
        frame: Literal["common", "unknown"] = "common",
        period: float = 1.0,
        jacobians: Literal["standard", "first-estimates", "invariant"] = "invariant",
    ) -> None:
        """Set the rules.

        Args:
            frame: Whether all robots' priors are given in one common frame; otherwise the transform between their
                frames is estimated from beacons on both maps, at least two.
            period: Time between reports [s].
            jacobians: As for `EkfSlam`.
        """
        if frame not in ("common", "unknown"):
            raise ValueError(f"frame is {frame!r}; it must be 'common' or 'unknown'")
        self._common, self._period = frame == "common", period
        self._slam = EkfSlam(jacobians=jacobians, joint_covariance=True)

    def start(self, robot: RobotInfo, catalogue: Mapping[str, BeaconInfo], rng: Generator) -> None:
        """Start with an empty map and no reports."""
        self._slam.start(robot, catalogue, rng)
        self._received: dict[str, Map] = {}
        self._next = 0.0

    def update(self, seen: Observation) -> TeamEstimate:
        """Return the belief after this tick's observation, with a report when one is due."""
        for message in seen.messages:
            if isinstance(message.content, dict) and "places" in message.content:
                self._received[message.sender] = map_from(message.content)
        own = self._slam.update(seen)
        merged = functools.reduce(functools.partial(merge, common=self._common), self._received.values(), map_of(own))
        due = bool(own.landmarks) and seen.time >= self._next
        if due:
            self._next = seen.time + self._period
        return belief_of(merged, own, report=report_of(own) if due else None)


class ReportingWaypoints(Waypoints):
    """Drives as `Waypoints` does, and sends what the estimator reports."""

    def command(self, seen: Observation, belief: Estimate) -> Command:
        """Return the twist along the path, with the report of this tick if there is one."""
        command = super().command(seen, belief)
        report = belief.report if isinstance(belief, TeamEstimate) else None
        return command if report is None else replace(command, messages=(report,))


def merge(own: Map, other: Map, *, common: bool) -> Map:
    """Fuse a map with a pose and another map of disjoint sightings, in the frame of the first.

    A landmark on both maps is the same one: own = T(other), where T, the other's frame, is the identity or unknown. The
    state (own, T, other) is conditioned on this as by a measurement without error, iterated since T is nonlinear.

    Args:
        own: Pose and n landmarks.
        other: m landmarks.
        common: Whether T is the identity; if not, and fewer than two landmarks are shared, the first map is returned.

    References:
        Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking and Navigation (2001), section 10.5.2:
        the iterated update.
    """
    mine, theirs = own.places(), other.places()
    shared = [name for name in theirs if name in mine]
    if not common and len(shared) < 2:
        return own
    size, start = len(own.mean), len(own.mean) + 3
    mean = np.concatenate([own.mean, np.zeros(3), other.mean])
    P = np.zeros((len(mean), len(mean)))
    P[:size, :size], P[start:, start:] = own.covariance, other.covariance
    if not common:
        fit = align_rigid(np.array([theirs[name] for name in shared]), np.array([mine[name] for name in shared]))
        mean[size:start] = fit.as_array()
        P[size:start, size:start] = ANYWHERE
    rows_mine = [3 + 2 * own.names.index(name) + i for name in shared for i in (0, 1)]
    rows_theirs = [start + 2 * other.names.index(name) + i for name in shared for i in (0, 1)]
    state = mean
    for _ in range(3 if shared else 0):
        placed, J = _placed(state, size, rows_theirs)
        H = -J
        H[np.arange(len(rows_mine)), rows_mine] += 1.0
        K = np.linalg.solve(H @ P @ H.T + EXACT * np.eye(len(H)), H @ P).T
        state = mean - K @ (state[rows_mine] - placed + H @ (mean - state))
    if shared:
        P = P - K @ H @ P
    new = [name for name in other.names if name not in mine]
    rows_new = [start + 2 * other.names.index(name) + i for name in new for i in (0, 1)]
    placed, J = _placed(state, size, rows_new)
    A = np.vstack([np.eye(size, len(mean)), J])
    joint = A @ P @ A.T
    return Map((*own.names, *new), np.concatenate([state[:size], placed]), 0.5 * (joint + joint.T))


def _placed(state: Array, at: int, rows: list[int]) -> tuple[Array, Array]:
    """Return landmarks moved by the frame T at a row of the state, shape (2 k,), and the derivative by the state."""
    x, y, heading = state[at : at + 3]
    rotation = Pose(x, y, heading).matrix()[:2, :2]
    turned = state[rows].reshape(-1, 2) @ rotation.T
    J = np.zeros((len(rows), len(state)))
    for k, (dx, dy) in enumerate(turned.tolist()):
        J[2 * k : 2 * k + 2, at : at + 3] = [[1.0, 0.0, -dy], [0.0, 1.0, dx]]
        J[2 * k : 2 * k + 2, rows[2 * k] : rows[2 * k] + 2] = rotation
    return (turned + state[at : at + 2]).ravel(), J


def map_of(belief: Estimate) -> Map:
    """Return pose and landmarks of a belief with a joint covariance."""
    assert belief.joint_covariance is not None
    places = [mean for mean, _ in belief.landmarks.values()]
    return Map(tuple(belief.landmarks), np.concatenate([belief.pose.as_array(), *places]), belief.joint_covariance)


def belief_of(merged: Map, own: Estimate, *, report: Any) -> TeamEstimate:
    """Return a merged map as an estimate, with the innovations of this robot's filter at this tick."""
    P = merged.covariance
    places = merged.mean[3:].reshape(-1, 2)
    landmarks = {
        name: (place, P[3 + 2 * k : 5 + 2 * k, 3 + 2 * k : 5 + 2 * k])
        for k, (name, place) in enumerate(zip(merged.names, places, strict=True))
    }
    pose = Pose(float(merged.mean[0]), float(merged.mean[1]), wrap_angle(float(merged.mean[2])))
    return TeamEstimate(pose, P[:3, :3], landmarks, own.innovations, P, report)


def report_of(own: Estimate) -> dict[str, Any]:
    """Return the message with a robot's own map: names, positions, and the lower triangle of their covariance."""
    assert own.joint_covariance is not None
    covariance = own.joint_covariance[3:, 3:]
    return {
        "names": list(own.landmarks),
        "places": [mean.tolist() for mean, _ in own.landmarks.values()],
        "covariance": covariance[np.tril_indices(len(covariance))].tolist(),
    }


def map_from(report: Mapping[str, Any]) -> Map:
    """Return the map in a message."""
    size = 2 * len(report["names"])
    half = np.zeros((size, size))
    half[np.tril_indices(size)] = report["covariance"]
    whole = half + half.T - np.diag(np.diag(half))
    return Map(tuple(report["names"]), np.array(report["places"], dtype=float).ravel(), whole)
