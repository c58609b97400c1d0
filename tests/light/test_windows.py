"""What a window shows in baked light."""

import numpy as np
import pytest

from mjsim.compile import compile_world, compiled
from mjsim.light import GENERAL, bake
from mjsim.world import parse_world

ROOM = """mjsim: 1
style: office
walls:
  - {points: [[0, 0], [3, 0], [3, 2], [0, 2]], closed: true, thickness: 0.2,
     openings: [{at: 1, width: 1, sill: 0.9, head: 2}]}
ceiling: {}
"""


@pytest.mark.slow
def test_the_view_in_a_window_has_the_light_of_the_day():
    world = parse_world(ROOM)
    model = compiled(compile_world(world))
    baked = bake(world, model, processes=1, texel=0.2)
    light = next(group for group in baked.groups if group.name == GENERAL)
    height, width = light.texels.shape[:2]
    # The pane shines in the middle of the wall, y = 0; the view is the sheet beyond it that fills the opening.
    for surface in baked.surfaces:
        for corners in surface.triangles:
            points, inwards = surface.points[corners], surface.normals[corners, 1].mean() > 0.9
            if inwards and points[:, 1].max() < 0.0 and np.ptp(points, axis=0)[[0, 2]].min() > 0.9:
                column, row = (surface.lightcoords[corners].mean(axis=0) * [width, height]).astype(int)
                assert light.texels[row, column].min() == pytest.approx(2.0 * light.gain, rel=0.01)
                return
    raise AssertionError("the window has no view")
