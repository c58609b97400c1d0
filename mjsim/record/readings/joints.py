"""Readings of the encoders of arms."""

from collections.abc import Mapping, Sequence

import numpy as np

from mjsim.interface import JointState
from mjsim.record import json_schema as schema
from mjsim.record.numbers import Message, flat
from mjsim.record.readings.codec import Codec


def _messages(readings: Mapping[str, JointState]) -> list[Message]:
    return [
        {
            "name": name,
            "stamp": float(state.stamp),
            "positions": flat(state.positions),
            "velocities": flat(state.velocities),
            "torques": flat(state.torques),
        }
        for name, state in readings.items()
    ]


def _readings(messages: Sequence[Message]) -> dict[str, JointState]:
    return {
        item["name"]: JointState(
            item["stamp"], *(np.array(item[key], dtype=float) for key in ("positions", "velocities", "torques"))
        )
        for item in messages
    }


JOINTS = Codec(
    field="joints",
    schema=schema.readings(
        "Encoders of arms",
        {
            "positions": schema.numbers("[rad], or [m] of joints that slide"),
            "velocities": schema.numbers("[rad/s], or [m/s]"),
            "torques": schema.numbers("Of the motors at the joints [N m], or [N]"),
        },
    ),
    encode=_messages,
    decode=_readings,
    sparse=True,
)
