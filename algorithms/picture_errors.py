"""Errors of camera sightings beyond their own covariance: errors shared within an image, or repeated across images.

The covariance of a picture's position is consistent for a single sighting. For a filter that assumes independent
sightings, two more effects matter:

- A robot pitches and rolls as its speed changes. Everything in one image shifts together, by the angle times the height
  of the camera: a tenth of a degree is 2 mm at 1 m, several times the error of a single picture.
- Consecutive images show a picture from nearly the same place, and part of its error stays the same. A hundred
  sightings from there contain no more information than a few.
"""

import math
from collections.abc import Sequence

import numpy as np

from mjsim.geometry import Array
from mjsim.interface import Odometry, RobotInfo, Sighting

NEAREST = 1e-3
"""Minimum distance counted between two images [m], so that sightings at rest have a little information."""
LEAN = 5.0
"""Additional pitch for an acceleration of 1 m/s^2; a robot that starts at full power pitches by some 0.7 degrees on
tyres and caster, just when its first landmarks enter the map."""
SMOOTH = 0.2
"""Time over which acceleration is computed: odometry is too noisy within one tick [s]."""


class PictureErrors:
    """The covariance of simultaneous sightings, for filters that assume independence between ticks.

    If the part q of a picture's variance s^2 repeats over a distance L, the mean of n sightings there has the variance
    (1 - q) s^2 / n + q s^2. Independent sightings with the variance s^2 (1 + q n) have nearly the same mean, and n is L
    divided by the distance between two sightings. So only the product q L must be known.

    References:
        Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking and Navigation (2001), section 8.1:
        measurement noise that is not white needs more than its variance.
    """

    def __init__(self, robot: RobotInfo, *, nod: float, repeat: float) -> None:
        """Initialise.

        Args:
            robot: The height of its highest camera gives the shift by pitch; without a camera it is assumed level.
            nod: Standard deviation of pitch and roll at constant speed [rad].
            repeat: Repeated part of the variance (0 to 1) times the distance over which it repeats [m].
        """
        cameras = [sensor for sensor in robot.sensors.values() if sensor.intrinsics is not None]
        self._usual = nod * max((float(camera.robot_from_sensor[2, 3]) for camera in cameras), default=0.0)
        self._shift, self._speed, self._dt = self._usual, 0.0, robot.dt
        self._repeat, self._distance, self._since = repeat, math.inf, math.inf

    def move(self, step: Odometry, sightings: Sequence[Sighting]) -> None:
        """Add the motion of a tick: the acceleration determines the pitch, the distance the independence of sightings.

        A turn of one radian counts as one metre.
        """
        speed = step.forward / self._dt
        self._speed += min(self._dt / SMOOTH, 1.0) * (speed - self._speed)
        self._shift = self._usual * math.hypot(1.0, LEAN * (speed - self._speed) / SMOOTH)
        self._distance += math.hypot(step.forward, step.left) + abs(step.turn)
        if any(sighting.corners is not None for sighting in sightings):
            self._since, self._distance = max(self._distance, NEAREST), 0.0

    def covariance(self, sightings: Sequence[Sighting], *, scale: float) -> Array:
        """Return the joint covariance of (range, bearing) of k simultaneous sightings, shape (2 k, 2 k) [m, rad].

        A place at range r and bearing b that shifts by (ahead, left) is seen at r + cos b * ahead + sin b * left and
        b + (cos b * left - sin b * ahead) / r.

        Args:
            sightings: Those not from pictures keep their own covariance.
            scale: Factor on the standard deviation of each.
        """
        # Written in place: scipy's block_diag took 0.2 ms.
        own, by_shift = np.zeros((2 * len(sightings), 2 * len(sightings))), np.zeros((2 * len(sightings), 2))
        for row, sighting in enumerate(sightings):
            at = slice(2 * row, 2 * row + 2)
            in_picture = sighting.corners is not None
            factor = scale**2 * (1.0 + self._repeat / self._since if in_picture else 1.0)
            own[at, at] = np.asarray(sighting.covariance) * factor
            if in_picture:
                c, s = math.cos(sighting.bearing), math.sin(sighting.bearing)
                by_shift[at] = (c, s), (-s / sighting.range, c / sighting.range)
        return np.asarray(own + self._shift**2 * by_shift @ by_shift.T)


def each_of(together: Array) -> Array:
    """Return the individual covariances of k sightings, shape (k, 2, 2), from the joint one, shape (2 k, 2 k)."""
    count = len(together) // 2
    each = np.arange(count)
    return together.reshape(count, 2, count, 2)[each, :, each]
