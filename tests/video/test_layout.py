"""The parts of a composed picture fill it, with equal gaps and without overlap, for worlds of all shapes."""

import itertools
from dataclasses import astuple

import numpy as np
import pytest

from mjsim.video.picture_layout import GAP, HEAD, HEIGHT, MARGIN, WIDTH, arrange

RIGHT, BOTTOM = WIDTH - MARGIN, HEIGHT - MARGIN


@pytest.mark.parametrize("camera", [None, 4 / 3, 16 / 9, 1.0, 5.0])
@pytest.mark.parametrize("shape", [0.1, 0.5, 0.74, 0.76, 1.0, 2.39, 2.41, 4.0, 20.0])
def test_parts_fill_the_page_below_its_head_and_leave_gaps_between(shape, camera):
    layout = arrange(np.array([[1.0, 2.0], [1.0 + 3.0 * shape, 5.0]]), camera=camera)
    assert (layout.onboard is None) == (camera is None)
    panes = [pane for pane in (layout.plan, layout.close_up, layout.chart, layout.onboard) if pane is not None]
    covered = np.zeros((HEIGHT, WIDTH), int)
    for x, y, width, height in map(astuple, panes):
        assert min(width, height) >= 80
        # With the gap around it each meets its neighbours and the margins exactly.
        covered[y : y + height, x : x + width] += 1
    assert covered.max() == 1
    rows, columns = np.nonzero(covered)
    assert (columns.min(), columns.max(), rows.min(), rows.max()) == (MARGIN, RIGHT - 1, HEAD, BOTTOM - 1)
    for one, other in itertools.combinations(panes, 2):
        across = max(one.x, other.x) - min(one.x + one.width, other.x + other.width)
        down = max(one.y, other.y) - min(one.y + one.height, other.y + other.height)
        if across < 0 or down < 0:
            assert max(across, down) >= GAP
    for x, y, width, height in map(astuple, panes):
        for beside in (covered[y : y + height, x + width :].T, covered[y + height :, x : x + width]):
            if len(beside) > MARGIN:
                assert not beside[:GAP].any()
                assert beside[GAP].any()
    if camera is not None and layout.onboard.height < 400:
        ratio = layout.onboard.width / layout.onboard.height
        assert ratio == pytest.approx(camera, rel=0.02) or shape > 2.4 or layout.close_up.height < 500


@pytest.mark.parametrize(("shape", "height"), [(2.5, 320), (5.0, 270), (8.0, 176), (50.0, 140)])
def test_the_plan_of_a_wide_world_is_as_high_as_it_needs(shape, height):
    layout = arrange(np.array([[0.0, 0.0], [shape, 1.0]]), camera=None)
    assert layout.plan.width == RIGHT - MARGIN
    assert layout.plan.height == pytest.approx(min(max((RIGHT - MARGIN) / shape + 20, 140), 320), abs=0.5)
    assert layout.plan.height == pytest.approx(height, abs=1)


@pytest.mark.parametrize(("shape", "width"), [(0.7, 459), (0.5, 348), (0.1, 200)])
def test_the_plan_of_a_tall_world_is_as_wide_as_it_needs(shape, width):
    layout = arrange(np.array([[0.0, 0.0], [shape, 1.0]]), camera=1.0)
    assert layout.plan.height == BOTTOM - HEAD
    assert layout.plan.width == pytest.approx(width, abs=1)
