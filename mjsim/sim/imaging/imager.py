"""The pipeline from the light of a scene to the picture of a camera, with exposure, gain and white balance."""

import math
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.interface import Picture
from mjsim.sim.imaging.light_response import ROOT_LEVELS, ROOT_OF_WHITE, coded, light_for, srgb_light, with_electrons
from mjsim.sim.imaging.pixel_noise import PixelNoise
from mjsim.world import Camera, Exposure, Photons

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
    """Exposure settings of a picture."""

    factors: Array
    """Factors of red, green and blue light, with the gain, shape (3,)."""
    gain: float
    """Gain of the read-out, at least 1."""


class AutoExposure:
    """Sets a camera by the brightness of its pictures, with a delay of first order."""

    def __init__(self, camera: Camera) -> None:
        """Start with the settings that suit the first picture; `camera` is from the world file."""
        self.memory: Memory = None
        self._metered = camera.exposure == "auto" or (
            isinstance(camera.exposure, Exposure) and camera.exposure.seconds is None
        )
        self._exposure = camera.exposure if isinstance(camera.exposure, Exposure) else None
        self._balance = camera.white_balance
        self._grey = math.sqrt(float(light_for(np.array(MIDDLE_GREY), camera.response)))

    @property
    def metered(self) -> bool:
        """Whether the settings depend on the pictures."""
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


LUMINANCE_WEIGHTS = (0.2126, 0.7152, 0.0722)
"""Shares of red, green and blue in the luminance of linear light (ITU-R BT.709)."""
SPECK_COUNT, MIN_SPECK_RADIUS, MAX_SPECK_RADIUS = 40, 0.006, 0.05
"""Number of specks on a dirty lens, and their radii in widths of the picture; out of focus they are soft."""
SHARPENING_SIDE = 3
"""Side of the blur that an unsharp mask subtracts, binomial [px]."""
SAME_GAIN = 0.01
"""Relative change of the gain below which its tables are kept."""


class PlainImager:
    """A camera that keeps rendered pixel values: blur, brightness and noise act on them."""

    def __init__(self, camera: Camera, pixels: Generator) -> None:
        """Initialise.

        Args:
            camera: Camera of the world file, with a constant noise.
            pixels: Random stream of the noise.
        """
        self._camera = camera
        self._shape = camera.height, camera.width, 3
        self._noise = PixelNoise(camera.noise, pixels) if isinstance(camera.noise, float) and camera.noise else None
        self.memory: Memory = None
        self.remembers = False

    def light(self, picture: Picture) -> Picture:
        """Return the quantity that is averaged over the exposure: the pixel values."""
        return picture

    def picture(self, seen: Picture | NDArray[np.float32], stamp: float) -> Picture:
        """Return the picture of the camera; `seen` may be modified."""
        image = seen if seen.dtype == np.uint8 else np.rint(seen)
        image = np.asarray(image, dtype=np.uint8)
        if self._camera.blur:
            cv2.GaussianBlur(image, (0, 0), self._camera.blur, dst=image)
        self._brighten(image)
        if self._noise is not None:
            self._noise.add_to(image)
        return image

    def pass_over(self) -> None:
        """Draw the random numbers of a picture that was not requested."""
        if self._noise is not None:
            self._noise.draw(self._shape)

    def _brighten(self, image: Picture) -> None:
        gain = self._camera.exposure
        if gain == "auto":
            gain = min(max(MIDDLE_GREY / max(float(image.mean()), 1.0), 1.0 / MAX_GAIN), MAX_GAIN)
        if isinstance(gain, float) and gain != 1.0:
            cv2.convertScaleAbs(image, dst=image, alpha=gain)


class Imager:
    """Exposure, photons, read-out, response and processing of a camera.

    Everything works on the square root of light as whole numbers: there the noise of photons and read-out is equal for
    all levels, so that it is added without computing the deviation of each pixel.

    References:
        Anscombe, The transformation of Poisson, binomial and negative-binomial data, Biometrika 35, 1948; with read-out
        noise: Murtagh, Starck, Bijaoui, Image restoration with noise suppression, Astron. Astrophys. Suppl. 112, 1995.
    """

    def __init__(self, camera: Camera, pixels: Generator, dirt: Generator) -> None:
        """Precompute the tables of the camera.

        Args:
            camera: Camera of the world file.
            pixels: Random stream of the noise.
            dirt: Random stream of the specks on the lens.
        """
        self._camera = camera
        self._auto = AutoExposure(camera)
        values = np.minimum(np.arange(256) * (camera.exposure if isinstance(camera.exposure, float) else 1.0), 255.0)
        light = srgb_light(values / 255.0)
        self._light = light.astype(np.float32)
        self._root = np.rint(np.sqrt(light) * ROOT_OF_WHITE).astype(np.int16)
        shape = (camera.height, camera.width) if camera.monochrome else (camera.height, camera.width, 3)
        self._roots = np.empty(shape, dtype=np.int16)
        self._fall_off = _fall_off(camera, dirt)
        self._photons = camera.noise if isinstance(camera.noise, Photons) else None
        constant = camera.noise if isinstance(camera.noise, float) else 0.0
        self._noise = PixelNoise(constant, pixels) if camera.noise else None
        self._tabulate(1.0)

    @property
    def memory(self) -> Memory:
        """State of automatic exposure between pictures."""
        return self._auto.memory

    @memory.setter
    def memory(self, memory: Memory) -> None:
        self._auto.memory = memory

    @property
    def remembers(self) -> bool:
        """Whether a picture depends on pictures before it."""
        return self._auto.remembers

    def light(self, picture: NDArray[Any]) -> NDArray[np.float32]:
        """Return the linear light of a rendered picture, 1 for white, of the same shape."""
        return np.asarray(cv2.LUT(picture, self._light), dtype=np.float32)

    def picture(self, seen: Picture | NDArray[np.float32], stamp: float) -> Picture:
        """Return the picture of the camera.

        Args:
            seen: A rendered picture, or the mean light of several, shape (height, width, 3).
            stamp: The simulated time [s].
        """
        self._take_roots(seen)
        roots = self._roots
        if self._fall_off is not None:
            cv2.multiply(roots, self._fall_off, dst=roots, scale=1.0 / ROOT_LEVELS)
        self._expose(stamp)
        words = roots.view(np.uint16).reshape(len(roots), -1)
        if self._noise is not None and self._photons is not None:
            cv2.LUT(words, self._electrons, dst=words)
            self._noise.add_to(roots)
        image = np.asarray(cv2.LUT(words, self._coded), dtype=np.uint8).reshape(roots.shape)
        if self._noise is not None and self._photons is None:
            self._noise.add_to(image)
        return self._processed(image)

    def pass_over(self) -> None:
        """Draw the random numbers of a picture that was not requested."""
        if self._noise is not None:
            self._noise.draw(self._roots.shape)

    def _take_roots(self, seen: Picture | NDArray[np.float32]) -> None:
        """Set the roots of the light after the lens."""
        camera = self._camera
        if seen.dtype == np.uint8 and not (camera.monochrome or camera.blur):
            cv2.LUT(seen, self._root, dst=self._roots)
            return
        light: Any = self.light(seen) if seen.dtype == np.uint8 else seen
        if camera.monochrome:
            light = cv2.transform(light, np.array([LUMINANCE_WEIGHTS], dtype=np.float32))
        if camera.blur:
            light = cv2.GaussianBlur(light, (0, 0), camera.blur)
        root = cv2.sqrt(light).reshape(self._roots.shape)
        np.rint(np.multiply(root, ROOT_OF_WHITE, out=root), out=root)
        np.copyto(self._roots, root, casting="unsafe")

    def _expose(self, stamp: float) -> None:
        """Multiply the light by the factors of exposure time, gain and white balance."""
        means = np.array(cv2.mean(self._roots)[:3]) if self._auto.metered else np.ones(3)
        if self._camera.monochrome:
            means[:] = means[0]
        settings = self._auto.settings(means, stamp)
        if abs(settings.gain - self._gain) > SAME_GAIN * self._gain:
            self._tabulate(settings.gain)
        factors = np.sqrt(settings.factors)
        if not np.allclose(factors, 1.0, rtol=1e-6):
            # A diagonal matrix takes less than half the time of multiplying by factors.
            matrix = np.diag(factors[: self._roots[0, 0].size]).astype(np.float32)
            cv2.transform(self._roots, matrix, dst=self._roots)

    def _tabulate(self, gain: float) -> None:
        """Make the tables of noise and response for a gain."""
        self._gain, read, shot = gain, 0.0, 0.0
        if self._noise is not None and self._photons is not None:
            electron = ROOT_OF_WHITE**2 * gain / self._photons.full_well
            read, shot = self._photons.read**2 * electron, electron / 4
            self._electrons = with_electrons(read)
            self._noise.widen(math.sqrt(shot))
        self._coded = coded(self._camera.response, read + shot)

    def _processed(self, image: Picture) -> Picture:
        """Return a picture after sharpening and compression, in colour."""
        camera = self._camera
        if camera.sharpening:
            blurred = cv2.GaussianBlur(image, (SHARPENING_SIDE, SHARPENING_SIDE), 0)
            cv2.addWeighted(image, 1.0 + camera.sharpening, blurred, -camera.sharpening, 0.0, dst=image)
        if camera.jpeg is not None:
            image = _compressed(image, camera.jpeg)
        return np.asarray(cv2.cvtColor(image, cv2.COLOR_GRAY2RGB) if camera.monochrome else image, dtype=np.uint8)


def imager_of(camera: Camera, pixels: Generator, dirt: Generator) -> Imager | PlainImager:
    """Return the imager of a camera: in linear light only where a key needs it."""
    return Imager(camera, pixels, dirt) if camera.in_light else PlainImager(camera, pixels)


def _compressed(image: Picture, quality: int) -> Picture:
    grey = image.ndim == 2
    data = cv2.imencode(
        ".jpg", image if grey else cv2.cvtColor(image, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, quality]
    )[1]
    return np.asarray(cv2.imdecode(data, cv2.IMREAD_GRAYSCALE if grey else cv2.IMREAD_COLOR_RGB), dtype=np.uint8)


def _fall_off(camera: Camera, dirt: Generator) -> NDArray[np.int16] | None:
    """Return the root of the share of light that reaches each pixel, in integer units; None if all light does."""
    if not camera.vignetting and not camera.dirt:
        return None
    share = vignette(camera) * (1.0 - specks(camera, dirt))
    root = np.minimum(np.rint(np.sqrt(share) * ROOT_LEVELS), ROOT_LEVELS - 1).astype(np.int16)
    return root if camera.monochrome else np.repeat(root[..., None], 3, axis=2)


def vignette(camera: Camera) -> Array:
    """Return the share of light that the lens lets through, 1 in the middle, shape (height, width).

    It falls as cos^4 of the angle from the axis, scaled so that corners lose the fraction `vignetting`.
    """
    y, x = np.mgrid[: camera.height, : camera.width]
    middle_x, middle_y = (camera.width - 1) / 2, (camera.height - 1) / 2
    squares = ((x - middle_x) ** 2 + (y - middle_y) ** 2) / (middle_x**2 + middle_y**2)
    tangent = 1.0 / math.sqrt(1.0 - camera.vignetting) - 1.0
    return np.asarray((1.0 + tangent * squares) ** -2.0, dtype=float)


def specks(camera: Camera, dirt: Generator) -> Array:
    """Return the share of light that soft specks on the lens absorb, on average that of the camera, (height, width)."""
    loss = np.zeros((camera.height, camera.width))
    if not camera.dirt:
        return loss
    y, x = np.mgrid[: camera.height, : camera.width]
    places = dirt.uniform(0.0, 1.0, (SPECK_COUNT, 2)) * [camera.width, camera.height]
    radii = (
        camera.width * MIN_SPECK_RADIUS * (MAX_SPECK_RADIUS / MIN_SPECK_RADIUS) ** dirt.uniform(0.0, 1.0, SPECK_COUNT)
    )
    for (u, v), radius, depth in zip(places, radii, dirt.uniform(0.2, 1.0, SPECK_COUNT), strict=True):
        loss += depth * np.exp(-((((x - u) ** 2 + (y - v) ** 2) / radius**2) ** 2))
    return np.asarray(np.minimum(loss * camera.dirt / loss.mean(), 0.95), dtype=float)
