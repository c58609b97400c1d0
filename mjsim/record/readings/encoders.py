"""Counts of wheel encoders."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from mjsim.interface import Observation, RobotInfo
from mjsim.record.readings.codec import Box
from mjsim.record.readings.derived import derived
from mjsim.world import World, sensors


def _boxes(encoders: sensors.Encoders, info: RobotInfo, world: World) -> Mapping[str, Box]:
    half = 1 << (encoders.bits - 1)

    def read(seen: Observation) -> ArrayLike | None:
        ticks = seen.encoders.get(encoders.encoders)
        return None if ticks is None else ticks.counts

    return {"": Box(read=read, low=-half, high=half - 1, shape=(len(info.wheels),), dtype=np.int64)}


ENCODERS = replace(derived("encoders"), boxes=_boxes)
