"""What is asked of the figures of one call."""

import statistics
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

ASKED_HEAD = f"{'asked, median of the runs':<58}{'value':>8}  {'asked':<14}"


@dataclass(frozen=True)
class Asked:
    """What figures of one call must show together."""

    text: str
    of: tuple[str, ...]
    """Names of the figures that it is made of."""
    value: Callable[..., float]
    """Makes it of one value of each."""
    sense: Literal["at least", "at most"]
    limit: float

    def holds(self, value: float) -> bool:
        """Say whether a value is as asked."""
        return value >= self.limit if self.sense == "at least" else value <= self.limit


def verdict(asked: Asked, values: Mapping[str, Sequence[float]]) -> str:
    """Return a line of a table: what is asked, what it is, and whether it holds.

    Ratios are taken run by run, as the machine changes from run to run; the median counts.

    Args:
        asked: What is asked.
        values: Of each figure, one a run.
    """
    value = statistics.median(asked.value(*row) for row in zip(*(values[name] for name in asked.of), strict=True))
    mark = "holds" if asked.holds(value) else "FAILS"
    return f"{asked.text:<58}{value:>8.3g}  {f'{asked.sense} {asked.limit:g}':<14}{mark}"


def _as_often(ours: float, theirs: float) -> float:
    return ours / theirs


def _as_dear(ours: float, floor: float) -> float:
    return floor / ours


def _outside(tick: float, *parts: float) -> float:
    return 100.0 * (1.0 - sum(parts) / tick)


PARTS = ("tick-gallery", "tick-physics", "tick-rendering", "tick-modules", "tick-encoding")
ASKED = (
    Asked("a gallery picture, times the floor's cost", ("sense-640x480", "pictures-floor"), _as_dear, "at most", 1.8),
    Asked("pictures 320x240, times mujoco.Renderer's", ("sense-320x240", "stock-320x240"), _as_often, "at least", 20.0),
    Asked("pictures 640x480, times mujoco.Renderer's", ("sense-640x480", "stock-640x480"), _as_often, "at least", 10.0),
    Asked("2000-wall office, times drawn geom by geom", ("office", "office-geoms"), _as_often, "at least", 8.0),
    Asked("a baked gallery picture, times a plain one", ("baked",), float, "at most", 1.35),
    Asked("the same with textures on all walls", ("baked-textured",), float, "at most", 1.25),
    Asked("a furnished office, times the textured gallery", ("furnished",), float, "at most", 1.5),
    Asked("baked with four samples, times plain high quality", ("baked-high",), float, "at most", 0.25),
    Asked("the gallery's whole demo, times real time", ("gallery",), float, "at least", 3.0),
    Asked("tick outside physics, pictures, modules, encoding [%]", PARTS, _outside, "at most", 15.0),
)  # fmt: skip
ASKED_OF_PEERS = (
    Asked("pictures 640x480, times PyBullet's", ("sense-640x480", "pybullet-640x480"), _as_often, "at least", 4.0),
    Asked("pictures 320x240, times PyBullet's", ("sense-320x240", "pybullet-320x240"), _as_often, "at least", 4.0),
    Asked("loop with a lidar, times ir-sim's", ("loop-lidar-25", "irsim-lidar"), _as_often, "at least", 3.0),
)
