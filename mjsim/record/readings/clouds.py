"""Clouds of points of 3-D lidars."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from foxglove.channels import PointCloudChannel
from foxglove.messages import PackedElementField, PackedElementFieldNumericType, Quaternion, Vector3
from foxglove.messages import PointCloud as FoxgloveCloud
from foxglove.messages import Pose as FoxglovePose

from mjsim.interface import CLOUD_FIELDS, PointCloud
from mjsim.record import json_schema as schema
from mjsim.record.numbers import Message, packed, unpacked
from mjsim.record.readings.codec import Codec, DrawnTopic, SensorTable, by_name
from mjsim.record.scene import stamp

KINDS = {"<f4": PackedElementFieldNumericType.Float32, "<u2": PackedElementFieldNumericType.Uint16}


def _cloud_message(cloud: PointCloud, frame_id: str) -> FoxgloveCloud:
    rows = cloud.rows()
    return FoxgloveCloud(
        timestamp=stamp(cloud.stamp),
        frame_id=frame_id,
        pose=FoxglovePose(position=Vector3(), orientation=Quaternion(w=1.0)),
        point_stride=rows.itemsize,
        fields=[
            PackedElementField(name=name, offset=offset, type=KINDS[CLOUD_FIELDS[name]])
            for name, (_, offset, *_) in (rows.dtype.fields or {}).items()
        ],
        data=rows.tobytes(),
    )


def _messages(clouds: Mapping[str, PointCloud]) -> list[Message]:
    return [
        {
            "name": name,
            "stamp": float(cloud.stamp),
            "points": packed(cloud.points, "<f4"),
            "times": packed(cloud.times, "<f4"),
            "intensities": packed(cloud.intensities, "<f4"),
            "rings": packed(cloud.rings, "<u2"),
        }
        for name, cloud in clouds.items()
    ]


def _clouds(messages: Sequence[Message]) -> dict[str, PointCloud]:
    return {item["name"]: _cloud(item) for item in messages}


def _cloud(message: Message) -> PointCloud:
    cloud = PointCloud(
        stamp=message["stamp"],
        points=unpacked(message["points"], -1, 3, kind="<f4"),
        times=unpacked(message["times"], kind="<f4"),
        intensities=unpacked(message["intensities"], kind="<f4"),
        rings=unpacked(message["rings"], kind="<u2"),
    )
    counts = {len(part) for part in (cloud.points, cloud.times, cloud.intensities, cloud.rings)}
    if len(counts) > 1:
        raise ValueError(f"a cloud of {len(cloud.points)} points with other counts of times, intensities or rings")
    return cloud


def _tables(given: Sequence[tuple[float, Mapping[str, PointCloud]]]) -> Iterator[SensorTable]:
    """Yield of each lidar a table of all points, one below the other; `time` and `stamp` are those of their clouds."""
    for name, times, clouds in by_name(given):
        counts = [len(cloud.points) for cloud in clouds]
        whens = {when: np.repeat(column, counts) for when, column in times.items()}
        rows = np.concatenate([cloud.rows() for cloud in clouds])
        arrays: dict[str, Any] = {
            **whens,
            "points": np.stack([rows[axis] for axis in "xyz"], axis=-1),
            "offsets": rows["time"],
            "intensities": rows["intensity"],
            "rings": rows["ring"],
        }
        columns = {**whens, **{name: rows[name] for name in ("x", "y", "z", "intensity", "ring")}}
        columns["offset"] = rows["time"]
        yield SensorTable(
            name=f"cloud_{name}", columns={key: each.tolist() for key, each in columns.items()}, arrays=arrays
        )


CLOUDS = Codec(
    field="clouds",
    schema=schema.readings(
        "Of 3-D lidars, where due",
        {
            "points": schema.packed("x, y and z of each in the sensor's frame at its time [m]", "singles"),
            "times": schema.packed("when each was measured, after the stamp [s]", "singles"),
            "intensities": schema.packed("strength of each return", "singles"),
            "rings": schema.packed("which beam of the stack, the lowest is 0", "16-bit whole numbers"),
        },
    ),
    encode=_messages,
    decode=_clouds,
    optional=True,
    sparse=True,
    sensor="lidar3d",
    drawings=(
        DrawnTopic(
            topic=lambda robot, lidar: f"/{robot}/{lidar}/points",
            channel=PointCloudChannel,
            message=_cloud_message,
        ),
    ),
    tables=_tables,
)
