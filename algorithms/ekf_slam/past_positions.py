"""Positions where the robot has been, kept in the state of a filter: they show how corrections move its map as a whole.

A filter does not keep past poses. When it learns late how everything mapped after a minute without sightings is
rotated, robot and landmarks move, and it is unknown which of them was wrong. Marks along the path move with them.
"""

import math
from operator import methodcaller
from typing import NamedTuple

import numpy as np

from mjsim.geometry import Array, Pose
from mjsim.interface import Estimate

from ..estimation.held_frame import HeldFrame
from .ekf_filter import EkfSlamFilter
from .rival_filters import RivalFilters

SPACING = 0.3
"""Distance between two marks [m]; doubled whenever there are too many."""
MAX_MARKS = 32
"""Every other mark is dropped when there are more."""


class Mark(NamedTuple):
    """The name of a mark in a filter."""

    number: int


class PastPositions:
    """Marks the path in a filter, and reports its estimates in a frame that agrees with those before.

    References:
        Roumeliotis, Burdick, Stochastic Cloning, ICRA 2002: past poses in the state, never seen again.
    """

    def __init__(self, slam: RivalFilters) -> None:
        """Begin where the robot starts."""
        self._frame = HeldFrame(slam.leading.pose, release=False)
        self._marks = [Mark(0)]
        self._distance, self._spacing, self._next = 0.0, SPACING, 1
        slam.change(lambda each: each.mark(self._marks[0]))

    def move(self, distance: float) -> None:
        """Add the distance that the robot has driven in a tick [m]."""
        self._distance += distance

    def hold(self, slam: EkfSlamFilter) -> None:
        """Keep the frame after a correction."""
        self._frame.hold(slam.positions(self._marks), math.sqrt(slam.covariance[2, 2]))

    def mark(self, slam: RivalFilters, pose: Array) -> None:
        """Mark the position of the robot, whose pose is reported, if it is far enough from the last one."""
        if self._distance < self._spacing:
            return
        self._distance = 0.0
        self._marks.append(Mark(self._next))
        self._next += 1
        slam.change(lambda each: each.mark(self._marks[-1]))
        self._frame.report(pose)
        if len(self._marks) > MAX_MARKS:
            for mark in self._marks[1::2]:
                slam.change(methodcaller("remove", mark))
            del self._marks[1::2]
            self._frame.thin()
            self._spacing *= 2.0

    def reported(self, solved: Estimate) -> Estimate:
        """Return an estimate of the filter in the held frame; unchanged if the frame is that of the start."""
        frame, pose, joint = self._frame, solved.pose.as_array(), solved.joint_covariance
        if not frame.is_shifted:
            return solved
        means = np.array([mean for mean, _ in solved.landmarks.values()]).reshape(-1, 2)
        covariances = np.array([covariance for _, covariance in solved.landmarks.values()]).reshape(-1, 2, 2)
        held = zip(solved.landmarks, *frame.places(means, covariances), strict=True)
        return Estimate(
            pose=Pose.from_array(frame.pose(pose)),
            covariance=frame.pose_covariance(pose, solved.covariance),
            landmarks={name: (place, covariance) for name, place, covariance in held},
            innovations=solved.innovations,
            joint_covariance=None if joint is None else frame.joint_covariance(pose, means, joint),
        )
