"""The codecs of all kinds of readings, in the order of an observation."""

from mjsim.record.readings.cameras import CAMERAS
from mjsim.record.readings.clouds import CLOUDS
from mjsim.record.readings.codec import Codec
from mjsim.record.readings.encoders import ENCODERS
from mjsim.record.readings.imu import IMU
from mjsim.record.readings.joints import JOINTS
from mjsim.record.readings.odometry import ODOMETRY
from mjsim.record.readings.radio import MESSAGES
from mjsim.record.readings.ranges import RANGES
from mjsim.record.readings.scans import SCANS
from mjsim.record.readings.sightings import SIGHTINGS
from mjsim.record.readings.touch import BUMP, PROXIMITY

CODECS: tuple[Codec, ...] = (
    ODOMETRY,
    SIGHTINGS,
    PROXIMITY,
    BUMP,
    CAMERAS,
    SCANS,
    IMU,
    MESSAGES,
    ENCODERS,
    RANGES,
    JOINTS,
    CLOUDS,
)
"""In the order of the keys in a message of `/R/observation`."""


def codec_of(kind: str) -> Codec:
    """Return the codec of a kind of sensor."""
    return next(codec for codec in CODECS if codec.sensor == kind)
