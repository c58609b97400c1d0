"""Trajectories in text with names of columns: units and orders as they are written, against values written by hand."""

import math

import numpy as np
import pytest

from mjsim.errors import UsageError
from mjsim.logs.named_poses import named_rows

TIMES, X, Y = np.arange(6.0), np.linspace(0.0, 5.0, 6), np.linspace(1.0, 2.0, 6)
HEADING = np.full(6, math.atan2(0.2, 1.0))
HALF = HEADING / 2


def written(tmp_path, columns):
    path = tmp_path / "t.csv"
    rows = zip(*columns.values(), strict=True)
    path.write_text("\n".join([",".join(columns), *(",".join(f"{float(value):.9f}" for value in row) for row in rows)]))
    return path


@pytest.mark.parametrize(
    "columns",
    [
        {"time": TIMES, "x": X, "y": Y, "heading": HEADING},
        {"y": Y, "time": TIMES, "heading_deg": np.degrees(HEADING), "x": X},
        {"time": TIMES, "x": X, "y": Y, "qx": 0 * X, "qy": 0 * X, "qz": np.sin(HALF), "qw": np.cos(HALF)},
        {"qw": np.cos(HALF), "qz": np.sin(HALF), "qx": 0 * X, "qy": 0 * X, "time": TIMES, "x": X, "y": Y},
    ],
    ids=["radians", "degrees", "quaternion", "its parts in another order"],
)
def test_poses_are_read_by_the_names_of_their_columns(columns, tmp_path):
    notes = {}
    rows = named_rows(written(tmp_path, columns), notes)
    np.testing.assert_allclose(rows, np.column_stack([TIMES, X, Y, HEADING]), atol=1e-6)
    assert "columns of the trajectory" in notes


def test_a_role_without_a_column_is_named(tmp_path):
    with pytest.raises(UsageError, match="heading"):
        named_rows(written(tmp_path, {"time": TIMES, "x": X, "y": Y}), {})
