"""Readings of inertial sensors."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from math import isfinite

import numpy as np

from mjsim.geometry import Array
from mjsim.interface import ImuReading, Observation, RobotInfo
from mjsim.record import json_schema as schema
from mjsim.record.numbers import Message, stamp_json
from mjsim.record.readings.codec import Box, ReadingTopic, Topic
from mjsim.record.readings.derived import derived
from mjsim.record.tick import Tick
from mjsim.world import Imu, World

UNKNOWN, NONE = [0.0] * 9, [-1.0, *[0.0] * 8]
"""Covariances in `sensor_msgs/Imu`: unknown, and not measured."""
NOTHING = {"x": 0.0, "y": 0.0, "z": 0.0}


def _xyz(values: Array) -> dict[str, float] | None:
    """Return the numbers along the axes; None if they were not measured."""
    x, y, z = values.tolist()
    return {"x": x, "y": y, "z": z} if isfinite(x) and isfinite(y) and isfinite(z) else None


def _topic_message(tick: Tick, robot: str) -> Message | None:
    """Return the readings of a tick for plots."""
    seen = tick.seen.get(robot)
    if seen is None or not seen.imu:
        return None
    readings = [
        {
            "name": each.name,
            "stamp": each.stamp,
            **({} if (felt := _xyz(each.acceleration)) is None else {"acceleration": felt}),
            **({} if (turned := _xyz(each.turn)) is None else {"turn": turned}),
        }
        for each in seen.imu
    ]
    return {"time": tick.time, "readings": readings}


def _stream_messages(robot: str, readings: Sequence[ImuReading]) -> Iterator[tuple[str, Message]]:
    """Yield topic and message of each reading, with the fields of `sensor_msgs/Imu`."""
    for each in readings:
        turned, felt = _xyz(each.turn), _xyz(each.acceleration)
        yield (
            f"/{robot}/{each.name}/imu",
            {
                "time": each.stamp,
                "header": {"stamp": stamp_json(each.stamp), "frame_id": f"{robot}/{each.name}"},
                "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0},
                "orientation_covariance": NONE,
                "angular_velocity": turned or NOTHING,
                "angular_velocity_covariance": UNKNOWN if turned else NONE,
                "linear_acceleration": felt or NOTHING,
                "linear_acceleration_covariance": UNKNOWN if felt else NONE,
            },
        )


def _boxes(imu: Imu, info: RobotInfo, world: World) -> Mapping[str, Box]:
    # If the rate is not a multiple of the tick rate, the number of readings per tick varies by one.
    count = math.ceil(imu.rate_hz * info.dt - 1e-9)
    limit = np.repeat([imu.range.acceleration, imu.range.turn], 3)

    def read(seen: Observation) -> Array:
        rows = [(*reading.acceleration, *reading.turn) for reading in seen.imu if reading.name == imu.imu]
        return np.array([*np.zeros((count - len(rows), 6)), *rows])

    return {"": Box(read=read, low=-limit, high=limit, shape=(count, 6))}


IMU = replace(
    derived("imu"),
    topic=Topic(
        name="imu",
        schema=schema.topic(
            "mjsim.Imu",
            "Readings of inertial sensors since the last tick.",
            {
                "readings": schema.listed(
                    schema.keyed(
                        {
                            "name": schema.text("Of the sensor"),
                            "stamp": schema.number("[s]"),
                            "acceleration": schema.xyz(
                                "Specific force in the sensor's frame [m/s^2]; omitted if not measured"
                            ),
                            "turn": schema.xyz(
                                "Angular velocity in the sensor's frame [rad/s]; omitted if not measured"
                            ),
                        },
                        optional=("acceleration", "turn"),
                    ),
                    "In time, one sensor after the other",
                )
            },
        ),
        message=_topic_message,
    ),
    stream=ReadingTopic(
        name="imu",
        schema=schema.topic(
            "sensor_msgs/Imu",
            "A reading of an inertial sensor, with the fields of ROS.",
            {
                "header": schema.keyed({"stamp": schema.STAMP, "frame_id": schema.text("Of the sensor")}),
                "orientation": schema.keyed(
                    {axis: {"type": "number"} for axis in "xyzw"}, "Not measured, as its covariance says"
                ),
                "orientation_covariance": schema.numbers("-1 first: not measured", count=9),
                "angular_velocity": schema.xyz("In the sensor's frame [rad/s]"),
                "angular_velocity_covariance": schema.numbers("Zeros: unknown; -1 first: not measured", count=9),
                "linear_acceleration": schema.xyz("Specific force in the sensor's frame [m/s^2]"),
                "linear_acceleration_covariance": schema.numbers("Zeros: unknown; -1 first: not measured", count=9),
            },
        ),
        messages=_stream_messages,
    ),
    boxes=_boxes,
)
