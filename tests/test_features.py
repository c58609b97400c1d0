"""What `scripts/measure/features.py` counts in a picture."""

import runpy
from pathlib import Path

import numpy as np
import pytest

SCRIPT = Path(__file__).parents[1] / "scripts" / "measure" / "features.py"


@pytest.fixture(scope="module")
def measure():
    return runpy.run_path(str(SCRIPT))["measure"]


def squares(rows: int, columns: int):
    """Return a grey picture of 480 by 640 with a bright square in the middle of each of the first cells of 8 by 6."""
    picture = np.full((480, 640, 3), 90, dtype=np.uint8)
    for row in range(rows):
        for column in range(columns):
            picture[80 * row + 35 : 80 * row + 45, 80 * column + 35 : 80 * column + 45] = 200
    return picture


def test_a_flat_picture_holds_nothing_and_noise_hides_that_it_is_flat(measure):
    seen = measure(squares(0, 0), 2.0, np.random.default_rng(0))
    assert (seen.features, seen.cells, seen.flat) == (0, 0.0, 1.0)
    assert seen.flat_noisy < 0.1


@pytest.mark.parametrize(("rows", "columns"), [(6, 8), (3, 8), (6, 2)])
def test_cells_with_a_feature_are_those_with_a_square(measure, rows, columns):
    seen = measure(squares(rows, columns), 0.0, np.random.default_rng(0))
    assert seen.cells == pytest.approx(rows * columns / 48)
    assert seen.features >= rows * columns
    # Central differences see an edge from both sides: a frame of two pixels around each square, without its corners.
    assert seen.flat == pytest.approx(1.0 - rows * columns * (10 * 2 * 4 - 4) / (480 * 640), abs=1e-6)
