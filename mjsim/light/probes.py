"""Probes: light at the points of a grid, for robots, people and doors."""

from dataclasses import dataclass

import numpy as np

from mjsim.geometry import Array
from mjsim.light.baked import LightProbes
from mjsim.light.emitters import inside_of
from mjsim.light.light_geometry import Atlas
from mjsim.light.light_rays import Light, Numbers, Points
from mjsim.world import World

PROBE_HEIGHTS = (0.15, 0.65, 1.15, 1.65)
"""Heights of the probes [m]."""
MIN_SPACING, MAX_POINTS = 0.5, 8000
"""Minimum distance of neighbours [m], and the approximate limit of probes above which it is larger."""
MAX_BURIED_SHARE = 0.25
"""Share of rays that hit surfaces from behind above which a probe lies in a solid."""
SIDES = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=float)
"""Normals of the sides of a probe."""
FIRST_NUMBER = 1 << 40
"""First number of the points of probes, above those of texels."""


@dataclass(frozen=True, slots=True, eq=False)
class ProbeGrid:
    """The points of the probes."""

    origin: Array
    """World frame, shape (3,) [m]."""
    spacing: Array
    """Distance of neighbours along x, y and z, shape (3,) [m]."""
    count: tuple[int, int, int]
    """Points along x, y and z."""
    points: Points
    """The sides of all probes, six each."""

    def outside_solids(self, values: Light, behind: Light) -> Light:
        """Return values of probes; those in solids get the value of the nearest one outside.

        Args:
            values: Values of each probe, shape (n, ...).
            behind: Share of its rays that hit surfaces from behind, shape (n,).
        """
        from scipy.ndimage import distance_transform_edt

        buried = (behind > MAX_BURIED_SHARE).reshape(self.count)
        if not buried.any() or buried.all():
            return values
        near = distance_transform_edt(buried, sampling=self.spacing, return_distances=False, return_indices=True)
        filled: Light = values[np.ravel_multi_index(tuple(near), self.count).ravel()]
        return filled

    def probes(self, light: Light) -> LightProbes:
        """Return the probes with their light, shape (n, groups, 3)."""
        table = np.moveaxis(light.astype(np.float16), 1, 0)
        return LightProbes(self.origin, self.spacing, table.reshape(len(table), *self.count, 3))


def grid_of(world: World, shape: Atlas) -> ProbeGrid:
    """Return probes over all rooms of a world."""
    texels = shape.texels.points
    floor = texels[inside_of(world)(texels[:, :2])]
    low, high = (
        (floor if len(floor) else texels)[:, :2].min(axis=0),
        (floor if len(floor) else texels)[:, :2].max(axis=0),
    )
    spacing = max(MIN_SPACING, float(np.sqrt((high - low).prod() * len(PROBE_HEIGHTS) / MAX_POINTS)))
    columns, rows = (np.ceil((high - low) / spacing).astype(int) + 1).tolist()
    origin = np.array([*low, PROBE_HEIGHTS[0]])
    step = np.array([spacing, spacing, PROBE_HEIGHTS[1] - PROBE_HEIGHTS[0]])
    count = (columns, rows, len(PROBE_HEIGHTS))
    at: Array = origin + step * np.stack(np.meshgrid(*map(np.arange, count), indexing="ij"), axis=-1).reshape(-1, 3)
    numbers: Numbers = np.arange(FIRST_NUMBER, FIRST_NUMBER + 6 * len(at), dtype=np.int64)
    return ProbeGrid(origin, step, count, Points(numbers, at.repeat(6, axis=0), np.tile(SIDES, (len(at), 1))))
