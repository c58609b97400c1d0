"""How well pictures can be recognised: what is wrong with plain, striped, long and repeated ones; which are alike."""

import math

import cv2
import numpy as np
import pytest

from mjsim.algorithms.beacon_vision.picture_quality import picture_qualities


def colored(gray):
    return np.repeat(np.asarray(gray, dtype=np.uint8)[..., None], 3, axis=2)


def clouds(seed=0, size=(96, 96), blur=2.0):
    noise = cv2.GaussianBlur(np.random.default_rng(seed).normal(0, 1, size), (0, 0), blur)
    return np.clip(128 + 60 * noise / noise.std(), 0, 255)


PLAIN = np.full((64, 64), 120.0)
STRIPES = np.tile(127 + 100 * np.sin(np.arange(96) / 3.0), (96, 1))


@pytest.mark.parametrize(
    ("gray", "fault"),
    [
        (PLAIN, "is of one colour or nearly so"),
        (PLAIN + 0.4 * (np.indices((64, 64)).sum(axis=0) % 2), "is of one colour or nearly so"),
        (STRIPES, "changes in one direction only, like stripes"),
        (clouds(size=(8, 400)), "is 50 times as long as it is wide"),
        (np.tile(clouds(size=(24, 24), blur=1.5), (4, 4)), "repeats itself"),
    ],
)
def test_what_is_wrong_with_a_picture_is_told(gray, fault):
    (found,) = picture_qualities({"one": colored(gray)}).values()
    assert found.fault.startswith(fault)
    assert found.like is None


def test_a_picture_with_shapes_all_over_is_found_small_and_a_copy_is_told():
    found = picture_qualities({"a": colored(clouds(1)), "b": colored(clouds(1) * 0.9 + 5)})
    assert found["a"].fault is None
    assert found["a"].like is None
    name, share = found["b"].like
    assert name == "a"
    assert 0.9 < share <= 1.0
    assert found["b"].least_side == found["a"].least_side
    assert math.isfinite(found["a"].least_side)
