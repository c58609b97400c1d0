"""The codecs of all kinds of readings, in the order of an observation."""

from mjsim.interface import Observation, form_fields
from mjsim.record.readings.cameras import CAMERAS
from mjsim.record.readings.clouds import CLOUDS
from mjsim.record.readings.codec import Codec
from mjsim.record.readings.derived import ORDER, derived
from mjsim.record.readings.encoders import ENCODERS
from mjsim.record.readings.imu import IMU
from mjsim.record.readings.ranges import RANGES
from mjsim.record.readings.scans import SCANS
from mjsim.record.readings.sightings import SIGHTINGS

_OWN = {codec.field: codec for codec in (SIGHTINGS, CAMERAS, SCANS, IMU, ENCODERS, RANGES, CLOUDS)}
"""Codecs with more than the declarations give: formats of other programs, tables and arrays."""
_FIELDS = dict.fromkeys((*ORDER, *(part.name for part, _ in form_fields(Observation))))
CODECS: tuple[Codec, ...] = tuple(_OWN.get(field) or derived(field) for field in _FIELDS)
"""Codecs in the order of the keys in a message of `/R/observation`."""


def codec_of(kind: str) -> Codec:
    """Return the codec of a kind of sensor."""
    return next(codec for codec in CODECS if codec.sensor == kind)
