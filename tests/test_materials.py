"""The shipped materials: small pictures that repeat without a seam and are nowhere flat."""

from pathlib import Path

import cv2
import numpy as np
import pytest

ROOT = Path(__file__).parents[1]
MATERIALS = sorted((ROOT / "assets" / "materials").glob("*.jpg"))
NAMES = {
    *("plaster", "plaster_white", "wallpaper", "wood", "oak", "tiles", "carpet", "brick", "concrete", "metal"),
    *("boards", "terrazzo", "fabric", "ceiling_panels", "whiteboard", "cork", "paper"),
}


def gray_of(path: Path) -> np.ndarray:
    picture = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
    assert picture is not None
    return picture.astype(float)


def test_each_material_has_its_picture():
    assert {path.stem for path in MATERIALS} == NAMES


@pytest.mark.parametrize("path", MATERIALS, ids=lambda path: path.stem)
def test_a_material_is_a_small_square(path):
    gray = gray_of(path)
    assert gray.shape in {(512, 512), (768, 768)}
    assert path.stat().st_size < 60_000


@pytest.mark.parametrize("path", MATERIALS, ids=lambda path: path.stem)
def test_a_material_has_no_seam(path):
    """Steps across the seam are like those between other rows: some materials have a joint of their own there."""
    gray = gray_of(path)
    for picture in (gray, gray.T):
        steps = np.abs(np.diff(picture, axis=0, append=picture[:1])).mean(axis=1)
        assert steps[-1] <= 1.1 * np.partition(steps[:-1], -4)[-4]


@pytest.mark.parametrize("path", MATERIALS, ids=lambda path: path.stem)
def test_a_material_is_uneven_near_and_far(path):
    gray = gray_of(path)
    for halvings in (0, 1, 2, 3):
        seen = cv2.resize(gray, None, fx=0.5**halvings, fy=0.5**halvings, interpolation=cv2.INTER_AREA)
        slope = np.hypot(*np.gradient(seen))
        assert (slope < 0.25).mean() < 0.1, f"at 1/{2**halvings} of its size"
