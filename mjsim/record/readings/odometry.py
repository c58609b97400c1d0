"""Odometry: the motion measured by the wheels."""

from mjsim.interface import Odometry
from mjsim.record import json_schema as schema
from mjsim.record.numbers import Message, flat, numbers
from mjsim.record.readings.codec import Codec


def _message(odometry: Odometry) -> Message:
    stamp = {} if odometry.stamp is None else {"stamp": float(odometry.stamp)}
    return {
        "forward": float(odometry.forward),
        "left": float(odometry.left),
        "turn": float(odometry.turn),
        "covariance": flat(odometry.covariance),
        **stamp,
    }


def _odometry(message: Message) -> Odometry:
    covariance = numbers(message["covariance"], 3, 3)
    return Odometry(message["forward"], message["left"], message["turn"], covariance, message.get("stamp"))


ODOMETRY = Codec(
    field="odometry",
    schema=schema.keyed(
        {
            "forward": schema.number("[m]"),
            "left": schema.number("[m]"),
            "turn": schema.number("[rad]"),
            "covariance": schema.numbers("3 x 3", count=9),
            "stamp": schema.number("When the motion ended, if not at the time of the tick [s]"),
        },
        "Motion since the last tick as the wheels tell it",
        optional={"stamp"},
    ),
    encode=_message,
    decode=_odometry,
)
