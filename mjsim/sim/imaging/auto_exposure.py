"""Exposure, gain and white balance of a camera, fixed or automatic."""

import math
from dataclasses import dataclass

import numpy as np

from mjsim.geometry import Array
from mjsim.sim.imaging.light_response import ROOT_OF_WHITE, light_for
from mjsim.world import Camera, Exposure

Memory = tuple[float, ...] | None
"""Stamp of the last picture [s], logarithms of its exposure and of its white balance; None before the first."""
MIDDLE_GREY, MAX_GAIN = 118.0, 8.0
"""Target of automatic exposure for the mean of a picture, on a 0 to 255 scale, and its largest factor."""
AUTOMATIC_GAIN = 16.0
"""Largest gain of the read-out of automatic exposure, unless given."""
MAX_WHITE_BALANCE = 2.0
"""Largest factor of automatic white balance, and the inverse of its smallest."""


@dataclass(frozen=True, slots=True, eq=False)
class CameraSettings:
    """With what a picture is taken."""

    factors: Array
    """Factors of red, green and blue light, with the gain, shape (3,)."""
    gain: float
    """Gain of the read-out, at least 1."""


class AutoExposure:
    """Sets a camera by the brightness of its pictures, with a delay of first order."""

    def __init__(self, camera: Camera) -> None:
        """Start with what suits the first picture; `camera` is from the world file."""
        self.memory: Memory = None
        self._metered = camera.exposure == "auto" or (
            isinstance(camera.exposure, Exposure) and camera.exposure.seconds is None
        )
        self._exposure = camera.exposure if isinstance(camera.exposure, Exposure) else None
        self._balance = camera.white_balance
        self._grey = math.sqrt(float(light_for(np.array(MIDDLE_GREY), camera.response)))

    @property
    def metered(self) -> bool:
        """Whether it looks at the pictures."""
        return self._metered or self._balance == "auto"

    @property
    def remembers(self) -> bool:
        """Whether the settings of a picture depend on pictures before it."""
        return self.metered and self._exposure is not None and self._exposure.time_constant > 0.0

    def settings(self, roots: Array, stamp: float) -> CameraSettings:
        """Return the settings for the picture at a stamp.

        Args:
            roots: Means of the roots of its light, shape (3,), equal for grey.
            stamp: The simulated time [s].
        """
        wanted = self._wanted(np.maximum(roots, 1.0) / ROOT_OF_WHITE)
        if self.remembers and self._exposure is not None:
            wanted = self._delayed(wanted, stamp, self._exposure.time_constant)
        light, balance = math.exp(wanted[0]), np.exp(wanted[1:])
        return CameraSettings(factors=light * balance, gain=self._gain(light))

    def _wanted(self, roots: Array) -> Array:
        """Return logarithms of the exposure and of the balance that suit a picture, shape (4,)."""
        balance = np.zeros(3)
        if self._balance == "auto":
            limit = math.log(MAX_WHITE_BALANCE)
            balance = np.clip(2.0 * np.log(roots[1] / roots), -limit, limit)
        elif isinstance(self._balance, tuple):
            balance = np.log(self._balance)
        return np.concatenate([[self._wanted_light(float(roots.mean()))], balance])

    def _wanted_light(self, root: float) -> float:
        exposure = self._exposure
        if exposure is not None and exposure.seconds is not None:
            return math.log(exposure.seconds / exposure.full_light * (exposure.gain or 1.0))
        if not self._metered:
            return 0.0
        most = 2.4 * math.log(MAX_GAIN)
        least = -most
        if exposure is not None:
            most = math.log(exposure.longest / exposure.full_light * (exposure.gain or AUTOMATIC_GAIN))
        return min(max(2.0 * math.log(self._grey / root), least), most)

    def _gain(self, light: float) -> float:
        exposure = self._exposure
        if exposure is None:
            return 1.0
        if exposure.seconds is not None:
            return exposure.gain or 1.0
        return max(light * exposure.full_light / exposure.longest, 1.0)

    def _delayed(self, wanted: Array, stamp: float, time_constant: float) -> Array:
        if self.memory is not None:
            before, reached = self.memory[0], np.array(self.memory[1:])
            wanted = wanted + (reached - wanted) * math.exp(-max(stamp - before, 0.0) / time_constant)
        self.memory = (stamp, *wanted.tolist())
        return wanted
