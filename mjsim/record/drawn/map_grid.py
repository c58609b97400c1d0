"""The map as a grid of cells, which Foxglove draws below everything else."""

import numpy as np
from foxglove.messages import Grid, PackedElementField, PackedElementFieldNumericType, Quaternion, Vector2, Vector3
from foxglove.messages import Pose as FoxglovePose

from mjsim.errors import UsageError
from mjsim.record.drawn.scene_messages import stamp
from mjsim.world import World, grid_of

MAX_CELLS = 1_000_000
"""Maximum number of cells; larger worlds have cells larger than 0.05 m."""
OCCUPIED, FREE, UNKNOWN = 100, 0, -1
"""As in `nav_msgs/OccupancyGrid`."""
COLORS = {OCCUPIED: (40, 40, 40, 255), FREE: (254, 254, 254, 255), UNKNOWN: (205, 205, 205, 0)}
"""Red, green, blue and alpha."""
UINT8, INT8 = PackedElementFieldNumericType.Uint8, PackedElementFieldNumericType.Int8
FIELDS = {"red": UINT8, "green": UINT8, "blue": UINT8, "alpha": UINT8, "occupancy": INT8}
"""Fields of a cell, one byte each."""


def grid_message(world: World) -> Grid | None:
    """Return which cells are occupied, free and unknown at the height of robots, at the start of a run.

    None if nothing is solid. The first cell has the smallest x and y; x varies fastest.
    """
    try:
        grid = grid_of(world, most_cells=MAX_CELLS)
    except UsageError:
        return None
    # A row of bytes for unknown, free and occupied; the last one is signed.
    rows = np.array([(*COLORS[each], each & 0xFF) for each in (UNKNOWN, FREE, OCCUPIED)], dtype=np.uint8)
    cells = rows.take(np.where(grid.occupied, 2, grid.free.view(np.uint8)), axis=0)
    _, columns, stride = cells.shape
    corner = grid.world_from_grid
    return Grid(
        timestamp=stamp(0.0),
        frame_id="world",
        pose=FoxglovePose(position=Vector3(x=corner.x, y=corner.y), orientation=Quaternion(w=1.0)),
        column_count=columns,
        cell_size=Vector2(x=grid.resolution, y=grid.resolution),
        row_stride=columns * stride,
        cell_stride=stride,
        fields=[
            PackedElementField(name=name, offset=offset, type=kind)
            for offset, (name, kind) in enumerate(FIELDS.items())
        ],
        data=cells.tobytes(),
    )
