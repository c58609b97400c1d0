"""Cameras as described in a world file: optics, exposure, noise, processing, and depth."""

import math
from itertools import pairwise
from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import AfterValidator, ConfigDict, Field, model_validator

from mjsim.sentences import Sentence
from mjsim.world.ground import Degrees, Deviation, Length, Model, Name, Point3, Rate, Shaped, Slider, fault
from mjsim.world.items.sensing.lenses import Lens
from mjsim.world.items.sensing.sensor_model import Bought, Bounds, Latency, Pitch

Seconds = Annotated[float, Field(gt=0, le=1)]
Factor = Annotated[float, Field(gt=0, le=8)]
Share = Annotated[float, Field(ge=0, le=0.95)]


class Photons(Model):
    """Noise of a picture from its physics: photons arrive at random, and reading out adds electrons."""

    full_well: Annotated[float, Field(ge=100, le=1_000_000), Slider(500.0, 50_000.0)] = 5800.0
    """Electrons in a pixel that is just white at gain 1 [e-]."""
    read: Annotated[float, Field(ge=0, le=1000), Slider(0.0, 50.0)] = 3.9
    """Standard deviation of the read-out [e-]."""


class Exposure(Model):
    """Exposure as a camera sets it, in linear light: by a time, or automatically."""

    seconds: Seconds | None = None
    """Exposure time, which also causes motion blur [s]; default: automatic, the mean of pictures is medium grey."""
    gain: Annotated[float, Field(ge=1, le=256)] | None = None
    """Gain of the read-out, or its upper limit of automatic exposure; default: 1, automatic 16."""
    full_light: Seconds = 0.01
    """Exposure time after which white in full light is just white at gain 1 [s]."""
    time_constant: Annotated[float, Field(ge=0, le=60)] = 0.0
    """Time constant of automatic exposure and white balance [s]."""
    longest: Seconds = 0.03
    """Longest automatic exposure time; beyond it, gain increases [s]."""

    @model_validator(mode="after")
    def _fixed_or_automatic(self) -> Self:
        if self.seconds is not None and (given := self.model_fields_set & {"time_constant", "longest"}):
            raise fault("a fixed exposure has 'seconds' and 'gain' only; leave out this key", min(given))
        return self


class Stereo(Model):
    """Depth as a stereo camera measures it: by matching windows of its picture with those of a second camera."""

    baseline: Length = 0.05
    """Distance of the second camera, to the right [m]."""
    subpixel: Annotated[float, Field(gt=0, le=2)] = 0.08
    """Standard deviation of a disparity [px]."""
    step: Annotated[float, Field(ge=0, le=1)] = 0.03125
    """Disparities are multiples of this [px]."""
    window: Annotated[int, Field(ge=1, le=63)] = 7
    """Side of the window, odd; errors closer together are correlated [px]."""
    steepest_deg: Annotated[float, Field(gt=0, le=90)] = 80.0
    """Largest angle between the line of sight and the normal of a surface."""
    texture: Annotated[float, Field(ge=0, le=128)] = 1.5
    """Minimum standard deviation of pixel values in a window, on a 0 to 255 scale; plainer surfaces have no depth."""
    projector: Annotated[float, Field(ge=0, le=1000)] = 0.0
    """Standard deviation that its projected pattern adds at 1 m; it falls with the square of the distance."""

    @model_validator(mode="after")
    def _window_has_a_middle(self) -> Self:
        if self.window % 2 == 0:
            raise fault(
                Sentence("window is {window} px; it must be odd, such as {next}", self.window, self.window + 1),
                "window",
            )
        return self


class Depth(Model):
    """Depth measurement of a camera."""

    range: Bounds = (0.0, 100.0)
    """[minimum, maximum] range [m]."""
    noise: Deviation = 0.0
    """Standard deviation at 1 m [m]; it grows with the square of the distance, as in stereo."""
    stereo: Stereo | None = None
    """Errors of a real stereo camera instead of `noise`; default: none."""

    @model_validator(mode="after")
    def _noise_once(self) -> Self:
        if self.stereo is not None and self.noise:
            raise fault("the noise of stereo is its 'subpixel'; leave out 'noise'", "noise")
        return self


def _rising(response: tuple[float, ...]) -> tuple[float, ...]:
    if any(high <= low for low, high in pairwise(response)):
        raise ValueError("a response must increase from each value to the next")
    return response


Response = Annotated[
    Literal["srgb", "linear"]
    | Annotated[
        tuple[Annotated[float, Field(ge=0, le=255)], ...],
        Field(strict=False, min_length=2, max_length=1024),
        AfterValidator(_rising),
    ],
    Shaped(("word", "list")),
]
"""Pixel value by light: a name, or the values at equal steps of light from darkness to white."""
IN_LIGHT = ("white_balance", "vignetting", "response", "sharpening", "jpeg", "dirt", "monochrome")
"""Keys that act on linear light or after it; a camera without them and without photons keeps rendered pixel values."""


class Camera(Bought):
    """A camera on the robot; without yaw and pitch it looks along the robot's x axis."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"camera": "front", "at": [0.1, 0, 0.5]}]})
    kind: ClassVar[str] = "camera"
    reading: ClassVar[str] = "cameras"
    noise_keys: ClassVar[tuple[str, ...]] = ("noise", "depth")
    camera: Name
    """Its name."""
    at: Point3 = (0.0, 0.0, 0.3)
    """Position [x, y, z] in the robot frame [m]."""
    yaw_deg: Degrees = 0.0
    """Yaw to the left."""
    pitch_deg: Pitch = 0.0
    """Pitch, positive up."""
    width: Annotated[int, Field(ge=16, le=4096)] = 640
    """[px]"""
    height: Annotated[int, Field(ge=16, le=4096)] = 480
    """[px]"""
    fov_deg: Annotated[float, Field(ge=5, le=150)] = 60.0
    """Horizontal field of view."""
    rate_hz: Rate = 12.5
    """Pictures per second; must divide the tick rate."""
    quality: Literal["normal", "high"] = "normal"
    """Rendering quality; high adds shadows, reflections and multisampling."""
    noise: Annotated[Annotated[float, Field(ge=0, le=100)] | Photons, Shaped(("number", "keys")), Slider(0.0, 40.0)] = (
        Photons()
    )
    """Standard deviation of pixel values on a 0 to 255 scale, or the electrons that cause it; default: those of a usual
    camera, which `mjsim check` and `mjsim run` report."""
    latency: Latency = 0
    """Delay of a picture, in ticks."""
    lens: Lens | None = None
    """Lens distortion; default: none. The field of view is that after distortion."""
    depth: Annotated[bool | Depth, Shaped(("truth", "keys"))] = False
    """Whether it also measures the depth of each pixel: true, or the parameters."""
    segmentation: bool = False
    """Whether it also gives the object at each pixel."""
    exposure: Annotated[
        Annotated[float, Field(gt=0, le=100)] | Literal["auto"] | Exposure, Shaped(("number", "word", "keys"))
    ] = 1.0
    """Brightness of pictures, relative to the light; auto sets the mean of each picture to medium grey."""
    blur: Annotated[float, Field(ge=0, le=20)] = 0.0
    """Standard deviation of the blur of the lens [px]."""
    shutter: Annotated[float, Field(ge=0, le=1)] = 0.0
    """Exposure time [s], which causes motion blur."""
    rolling_shutter: Annotated[float, Field(ge=0, le=1)] = 0.0
    """Readout time from the first row to the last [s]; the stamp is that of the middle row."""
    white_balance: Annotated[
        Annotated[tuple[Factor, ...], Field(strict=False, min_length=3, max_length=3)] | Literal["auto"],
        Shaped(("list", "word")),
    ] = (1.0, 1.0, 1.0)
    """Factors of red, green and blue light; auto makes their means equal."""
    vignetting: Share = 0.0
    """Share of the light that does not reach the corners."""
    dirt: Share = 0.0
    """Share of the light that specks on the lens absorb, on average."""
    monochrome: bool = False
    """Whether pictures are grey."""
    response: Response = "srgb"
    """Pixel values by light: srgb, linear, or the values at equal steps of light from darkness to white."""
    sharpening: Annotated[float, Field(ge=0, le=5)] = 0.0
    """Strength of the unsharp mask after the response."""
    jpeg: Annotated[int, Field(ge=1, le=100)] | None = None
    """Quality of the JPEG compression of its pictures; default: none."""

    @property
    def focal(self) -> float:
        """Focal length [px]; with a lens, points at half the field of view are still at the edge.

        References:
            The pinhole camera, f = (width / 2) / tan(fov / 2).
        """
        edge = np.array([[math.tan(math.radians(self.fov_deg) / 2), 0.0]])
        return self.width / 2 / float((edge if self.lens is None else self.lens.bend(edge))[0, 0])

    @property
    def exposed(self) -> float:
        """Exposure time, if it is fixed [s]."""
        return (isinstance(self.exposure, Exposure) and self.exposure.seconds) or self.shutter

    @property
    def in_light(self) -> bool:
        """Whether its pictures are computed in linear light."""
        plain = all(getattr(self, key) == type(self).model_fields[key].default for key in IN_LIGHT)
        return not plain or isinstance(self.noise, Photons) or isinstance(self.exposure, Exposure)

    def without_errors(self, **changes: object) -> Self:
        """Return a camera whose pictures show exactly what is in view, with the same geometry, and other changes."""
        errors = (*IN_LIGHT, "blur", "shutter", "rolling_shutter")
        exact = {key: type(self).model_fields[key].default for key in errors}
        calm = 1.0 if isinstance(self.exposure, Exposure) else self.exposure
        return self.model_copy(update={**exact, "noise": 0.0, "exposure": calm, **changes})

    @model_validator(mode="after")
    def _lens_reaches_its_edge(self) -> Self:
        if self.lens is not None:
            edge = np.array([[math.tan(math.radians(self.fov_deg) / 2), 0.0]])
            if not np.allclose(self.lens.straighten(self.lens.bend(edge)), edge, atol=1e-6):
                message = Sentence(
                    "fov_deg is {fov_deg:g}; the lens model is not invertible up to there, reduce one of them",
                    self.fov_deg,
                )
                raise fault(message, "lens")
        return self

    @model_validator(mode="after")
    def _one_exposure_time(self) -> Self:
        if self.shutter and isinstance(self.exposure, Exposure) and self.exposure.seconds is not None:
            raise fault("the exposure time is exposure.seconds already; leave out 'shutter'", "shutter")
        return self

    @model_validator(mode="after")
    def _stereo_is_rectified(self) -> Self:
        if self.lens is not None and isinstance(self.depth, Depth) and self.depth.stereo is not None:
            raise fault("stereo matches pictures without distortion; leave out 'lens'", "lens")
        return self
