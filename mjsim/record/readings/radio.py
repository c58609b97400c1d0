"""Messages received by radio."""

from collections.abc import Sequence

from mjsim.interface import Message as RadioMessage
from mjsim.record import json_schema as schema
from mjsim.record.numbers import Message
from mjsim.record.readings.codec import Codec


def _messages(messages: Sequence[RadioMessage]) -> list[Message]:
    return [{"sender": each.sender, "stamp": float(each.stamp), "text": each.text} for each in messages]


def _radio_messages(messages: Sequence[Message]) -> tuple[RadioMessage, ...]:
    return tuple(RadioMessage(item["sender"], item["stamp"], item["text"]) for item in messages)


MESSAGES = Codec(
    field="messages",
    schema=schema.listed(
        schema.keyed(
            {"sender": schema.text("Robot"), "stamp": schema.number("[s]"), "text": schema.text("Content as JSON")}
        ),
        "What the radio brought",
    ),
    encode=_messages,
    decode=_radio_messages,
    optional=True,
)
