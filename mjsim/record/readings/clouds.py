"""Clouds of points of 3-D lidars."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from foxglove.channels import PointCloudChannel
from foxglove.messages import PackedElementField, PackedElementFieldNumericType, Quaternion, Vector3
from foxglove.messages import PointCloud as FoxgloveCloud
from foxglove.messages import Pose as FoxglovePose

from mjsim.interface import CLOUD_FIELDS, PointCloud
from mjsim.record.drawn import stamp
from mjsim.record.readings.codec import DrawnTopic, Given, SensorTable, by_name
from mjsim.record.readings.derived import derived

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


def _tables(given: Given) -> Iterator[SensorTable]:
    """Yield for each lidar a table with a row per point; `time` and `stamp` are those of its cloud."""
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


CLOUDS = replace(
    derived("clouds"),
    drawings=(
        DrawnTopic(
            topic=lambda robot, lidar: f"/{robot}/{lidar}/points",
            channel=PointCloudChannel,
            message=_cloud_message,
        ),
    ),
    tables=_tables,
)
