"""Lenses as described in a world file, and their distortion."""

from typing import Annotated, Self

import numpy as np
from pydantic import Field, model_validator

from mjsim.geometry import Array
from mjsim.world.ground import Model, fault

Coefficient = Annotated[float, Field(ge=-100, le=100)]
MAX_ITERATIONS, EXACT = 50, 1e-12
"""Iterations of Newton's method."""


class Lens(Model):
    """Lens distortion: exactly one of the models, with parameters in OpenCV's order."""

    brown: Annotated[tuple[Coefficient, ...], Field(strict=False, min_length=4, max_length=5)] | None = None
    """Brown's model: k1, k2, p1, p2 and optionally k3."""
    fisheye: Annotated[tuple[Coefficient, ...], Field(strict=False, min_length=4, max_length=4)] | None = None
    """Kannala and Brandt's model: k1, k2, k3, k4; [0, 0, 0, 0] is equidistant."""

    @model_validator(mode="after")
    def _one_of_both(self) -> Self:
        if (self.brown is None) == (self.fisheye is None):
            raise fault("a lens is of one model; write brown: [k1, k2, p1, p2, k3] or fisheye: [k1, k2, k3, k4]")
        return self

    def bend(self, points: Array) -> Array:
        """Return the distorted image of pinhole points x/z, y/z, in focal lengths, shapes (n, 2).

        References:
            Brown, Close-range camera calibration, Photogrammetric Engineering 37(8), 1971; Kannala, Brandt, A generic
            camera model and calibration method, IEEE PAMI 28(8), 2006; both as OpenCV writes them.
        """
        if self.fisheye is not None:
            radii = np.hypot(points[:, 0], points[:, 1])
            scale = np.ones(len(points))
            np.divide(_angle_bent(np.arctan(radii), self.fisheye)[0], radii, out=scale, where=radii > 0.0)
            return points * scale[:, None]
        k1, k2, p1, p2, k3 = self._brown()
        x, y = points.T
        r2 = x * x + y * y
        radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
        bent_x = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
        bent_y = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
        return np.stack([bent_x, bent_y], axis=-1)

    def straighten(self, bent: Array) -> Array:
        """Return the inverse of `bend`, shape (n, 2); NaN where the lens folds or does not see."""
        return self._angles_straight(bent) if self.fisheye is not None else self._brown_straight(bent)

    def _brown(self) -> tuple[float, float, float, float, float]:
        k1, k2, p1, p2, k3 = (*(self.brown or ()), 0.0)[:5]
        return k1, k2, p1, p2, k3

    def _angles_straight(self, bent: Array) -> Array:
        radii = np.hypot(bent[:, 0], bent[:, 1])
        angles = radii.copy()
        for _ in range(MAX_ITERATIONS):
            value, slope = _angle_bent(angles, self.fisheye or ())
            step = (value - radii) / np.where(slope > 0.0, slope, np.nan)
            angles = angles - step
            if np.nanmax(np.abs(step), initial=0.0) < EXACT:
                break
        angles[~((angles >= 0.0) & (angles < np.pi / 2))] = np.nan
        scale = np.ones(len(bent))
        np.divide(np.tan(angles), radii, out=scale, where=radii > 0.0)
        return bent * scale[:, None]

    def _brown_straight(self, bent: Array) -> Array:
        k1, k2, p1, p2, k3 = self._brown()
        points = bent.copy()
        with np.errstate(over="ignore", invalid="ignore"):
            for _ in range(MAX_ITERATIONS):
                x, y = points.T
                r2 = x * x + y * y
                radial, slope = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3)), 2 * (k1 + r2 * (2 * k2 + 3 * r2 * k3))
                a = radial + slope * x * x + 2 * p1 * y + 6 * p2 * x
                b = slope * x * y + 2 * p1 * x + 2 * p2 * y
                d = radial + slope * y * y + 6 * p1 * y + 2 * p2 * x
                determinant = a * d - b * b
                error = self.bend(points) - bent
                # A point where the picture folds over corresponds to no ray of light.
                turned = (determinant <= 0.0) | (a <= 0.0)
                step = np.stack([d * error[:, 0] - b * error[:, 1], a * error[:, 1] - b * error[:, 0]], axis=-1)
                step /= np.where(turned, np.nan, determinant)[:, None]
                points = points - step
                if np.nanmax(np.abs(step), initial=0.0) < EXACT:
                    break
        return points


def _angle_bent(angles: Array, k: tuple[float, ...]) -> tuple[Array, Array]:
    """Return the image radius of an angle from the axis, and its slope, shapes (n,)."""
    squared = angles * angles
    value, slope = np.ones_like(angles), np.ones_like(angles)
    for power, factor in enumerate(k, start=1):
        value = value + factor * squared**power
        slope = slope + (2 * power + 1) * factor * squared**power
    return angles * value, slope
