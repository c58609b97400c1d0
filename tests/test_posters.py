"""The posters: drawn by a script of ours, the same each time, apart from one another and small."""

import runpy
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

ROOT = Path(__file__).parent.parent
POSTERS = sorted((ROOT / "assets" / "posters").glob("*.jpg"))


@pytest.fixture(scope="module")
def draw_poster(request: pytest.FixtureRequest) -> Callable[[str], NDArray[np.uint8]]:
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(ROOT / "scripts" / "make"))
        return runpy.run_path(str(ROOT / "scripts" / "make" / "posters.py"))["draw_poster"]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["lion", "moon", "windmill", "bell"])
def test_the_script_draws_the_posters_that_are_shipped(name: str, draw_poster: Callable[[str], NDArray[np.uint8]]):
    drawn = draw_poster(name)
    np.testing.assert_array_equal(drawn, draw_poster(name))
    shipped = cv2.cvtColor(cv2.imread(str(ROOT / "assets" / "posters" / f"{name}.jpg")), cv2.COLOR_BGR2RGB)
    assert shipped.shape == drawn.shape
    # JPEG of quality 88 halves the resolution of colour, so single pixels at edges differ, the mean hardly.
    assert np.abs(shipped.astype(float) - drawn).mean() < 8.0


def test_posters_are_40_in_less_than_4_megabytes():
    assert len(POSTERS) == 40
    assert sum(path.stat().st_size for path in POSTERS) < 4e6


def test_no_two_posters_look_alike_however_they_are_turned():
    small = {}
    for path in POSTERS:
        gray = cv2.resize(cv2.imread(str(path), cv2.IMREAD_GRAYSCALE), (24, 24), interpolation=cv2.INTER_AREA)
        centred = gray - gray.mean()
        small[path.stem] = centred / np.linalg.norm(centred)
    for name, picture in small.items():
        for other, second in small.items():
            for quarter in range(4):
                if name != other or quarter:
                    likeness = float(np.sum(picture * np.rot90(second, quarter)))
                    assert likeness < 0.9, f"{name} and {other} turned by {90 * quarter} degrees"
