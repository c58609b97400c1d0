"""Proximity and contact of every robot: the ring of proximity rays, and the bumper."""

from mjsim.record import json_schema as schema
from mjsim.record.numbers import distances, flat, numbers
from mjsim.record.readings.codec import Codec

PROXIMITY = Codec(
    field="proximity",
    schema=schema.distances("Ring of ranges, first ahead, then counter-clockwise [m]"),
    encode=distances,
    decode=numbers,
)
BUMP = Codec(
    field="bump",
    schema=schema.numbers("Bearings of contacts, left positive [rad]"),
    encode=flat,
    decode=tuple,
)
