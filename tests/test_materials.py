"""The shipped materials: small pictures that repeat without a seam and are nowhere flat."""

import re
from pathlib import Path

import cv2
import numpy as np
import pytest

from mjsim.compile import compile_world
from mjsim.world import parse_world

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


def test_the_page_has_every_material_and_its_world_shows_them():
    page = (ROOT / "docs" / "materials.md").read_text(encoding="utf-8")
    assert set(re.findall(r"^\| `(\w+)` \| [\d.]+ \|", page, re.MULTILINE)) == NAMES
    (text,) = re.findall(r"```yaml\n(.*?)```", page, re.DOTALL)
    model = compile_world(parse_world(text)).compile()
    textures = {model.texture(index).name for index in range(model.ntex)}
    assert {"ceiling", "floor", "wall/texture1", "wall/texture2", "obstacle/texture1", "obstacle/texture2"} <= textures
