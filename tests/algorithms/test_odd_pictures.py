"""Pictures that cannot be recognised: nothing fails, and what is ambiguous is not reported."""

from collections.abc import Mapping

import cv2
import numpy as np
import pytest

from mjsim.algorithms.beacon_vision.beacon_vision import PictureBeacons
from mjsim.algorithms.beacon_vision.picture_likeness import correlation_by_shift, repeats
from mjsim.algorithms.beacon_vision.planar_pose import (
    fit_pose,
    image_from_plane,
    rotation_between,
    rotation_of,
)
from mjsim.algorithms.estimation.inverses import inverse_of
from mjsim.bench.odd_pictures import colored, drawing, odd_pictures, one_way, plain, repeated
from mjsim.geometry import Array
from mjsim.interface import Picture
from mjsim.models import bounded, read_picture
from mjsim.sim.imaging.lens import intrinsics_of
from mjsim.world import Camera

ODD = odd_pictures()
WIDTH = 0.6
INTRINSICS = intrinsics_of(Camera(camera="front", width=320, height=240))
FRONT = np.eye(3)


def wall_with(*hung: tuple[Picture, Array, Array]) -> Picture:
    """Return an image of a gray wall with pictures: each with camera_from_picture and its centre [m]."""
    image = np.full((240, 320, 3), 200, dtype=np.uint8)
    for picture, rotation, position in hung:
        small = bounded(picture, 200)
        k, (h, w) = WIDTH / small.shape[1], small.shape[:2]
        plane_from_pixel = np.array([[k, 0.0, -k * (w - 1) / 2], [0.0, k, -k * (h - 1) / 2], [0.0, 0.0, 1.0]])
        mapping = image_from_plane(rotation, position, INTRINSICS) @ plane_from_pixel
        cv2.warpPerspective(
            small, mapping, (320, 240), dst=image, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_TRANSPARENT
        )
    return image


def names_in(catalogue: Mapping[str, Picture], image: Picture) -> set[str]:
    finder = PictureBeacons({name: (picture, WIDTH) for name, picture in catalogue.items()})
    return {found.name for found in finder.detect(image, INTRINSICS)}


GOOD = colored(drawing(7))
OTHER = colored(drawing(8))
AHEAD = np.array([0.0, 0.0, 1.3])


@pytest.mark.parametrize("name", sorted(ODD))
def test_a_catalogue_may_hold_any_picture_and_every_pose_is_right(name: str):
    picture = read_picture(ODD[name])
    turn = rotation_of(np.array([0.0, 0.3, 0.0]))
    finder = PictureBeacons({"odd": (picture, WIDTH), "other": (OTHER, WIDTH)})
    for found in finder.detect(wall_with((picture, turn, AHEAD)), INTRINSICS):
        assert found.name == "odd"
        # A twentieth of a picture's width: what is wrong is off by a shift or a size.
        np.testing.assert_allclose(found.position, AHEAD, atol=0.03)
        assert np.linalg.eigvalsh(found.covariance).min() > 0.0


@pytest.mark.parametrize("name", [*plain(), *one_way()])
def test_a_plain_or_striped_picture_is_never_found(name: str):
    picture = read_picture(ODD[f"{name}.png"])
    if name not in ("cross", "rings", "stripes-slanted"):
        assert names_in({"odd": picture}, wall_with((picture, FRONT, AHEAD))) == set()


def test_a_good_picture_is_found_beside_bad_ones():
    bad = {name: read_picture(data) for name, data in ODD.items() if name.endswith(("x1.png", "white.png", "pes.png"))}
    assert names_in({**bad, "good": GOOD}, wall_with((GOOD, FRONT, AHEAD))) == {"good"}


SPOTTED = GOOD.copy()
cv2.circle(SPOTTED, (60, 80), 8, (255, 0, 0), -1)
LIKE = {
    "equal": GOOD.copy(),
    "of another size": cv2.resize(GOOD, (180, 240), interpolation=cv2.INTER_AREA),
    "upside down": GOOD[::-1, ::-1].copy(),
    "brighter": np.clip(GOOD * 0.6 + 70, 0, 255).astype(np.uint8),
    "with a spot": SPOTTED,
}


@pytest.mark.parametrize("how", LIKE)
@pytest.mark.parametrize("distance", [1.5, 2.5])
def test_of_two_pictures_alike_neither_is_reported_and_a_third_is(how: str, distance: float):
    catalogue = {"one": GOOD, "two": LIKE[how], "three": OTHER}
    side = np.array([-0.4, 0.0, distance])
    image = wall_with((GOOD, FRONT, side), (OTHER, FRONT, side * [-1, 1, 1]))
    assert names_in({name: catalogue[name] for name in ("one", "three")}, image) == {"one", "three"}
    assert names_in(catalogue, image) == {"three"}


def test_pictures_that_share_a_part_are_told_apart():
    half = GOOD.copy()
    half[160:] = OTHER[160:]
    for name, picture in {"one": GOOD, "half": half}.items():
        assert names_in({"one": GOOD, "half": half}, wall_with((picture, FRONT, AHEAD))) == {name}


def test_a_picture_that_is_cut_out_of_another_is_not_seen_in_it():
    cut = GOOD[:230, :200].copy()
    assert names_in({"whole": GOOD, "cut": cut}, wall_with((GOOD, FRONT, AHEAD))) == {"whole"}
    assert names_in({"whole": GOOD, "cut": cut}, wall_with((cut, FRONT, AHEAD))) == {"cut"}


def test_a_repeated_pattern_is_reported_only_as_a_whole():
    bricks = read_picture(ODD["bricks.png"])
    image, near = wall_with((bricks, FRONT, AHEAD)), wall_with((GOOD, FRONT, AHEAD))
    assert names_in({"bricks": bricks}, image) == {"bricks"}
    for cut in (image, near):
        cut[:, :118] = 90
    assert names_in({"bricks": bricks}, image) == set()
    assert names_in({"good": GOOD}, near) == {"good"}


@pytest.mark.parametrize("name", [*repeated()])
def test_what_repeats_itself_is_known_from_the_picture(name: str):
    assert repeats(cv2.cvtColor(read_picture(ODD[f"{name}.png"]), cv2.COLOR_RGB2GRAY)) == (name != "noise")
    assert not repeats(drawing(len(name)))


def test_a_picture_is_correlated_with_itself_where_it_overlaps():
    small = np.random.default_rng(0).uniform(0.0, 255.0, (24, 40))
    found = correlation_by_shift(small)
    for down, right in [(0, 0), (3, 0), (-2, 5), (4, -6), (-5, -3)]:
        own = small[max(down, 0) : 24 + min(down, 0), max(right, 0) : 40 + min(right, 0)]
        other = small[max(-down, 0) : 24 + min(-down, 0), max(-right, 0) : 40 + min(-right, 0)]
        assert found[23 + down, 39 + right] == pytest.approx(np.corrcoef(own.ravel(), other.ravel())[0, 1], abs=1e-9)
    assert found[0, 0] == 0.0  # one pixel in common


def test_corners_that_determine_no_pose_give_none():
    line = np.array([[100.0, 100.0], [200.0, 150.0], [300.0, 200.0], [400.0, 250.0]])
    square = np.array([[300.0, 200.0], [400.0, 200.0], [400.0, 300.0], [300.0, 300.0]])
    for corners, covariance in (
        (line, np.eye(8)),
        (np.full((4, 2), 250.0), np.eye(8)),
        (square * np.nan, np.eye(8)),
        (square, np.zeros((8, 8))),
        (square, np.full((8, 8), np.nan)),
    ):
        assert fit_pose(corners, covariance, (0.6, 0.6), INTRINSICS) is None
    behind = (np.eye(3), np.array([0.0, 0.0, -2.0]))
    assert fit_pose(square, np.eye(8), (0.6, 0.6), INTRINSICS, guess=behind) is None
    assert fit_pose(square, np.eye(8), (0.6, 0.6), INTRINSICS) is not None


def test_a_pose_seen_edge_on_has_no_mirrored_one():
    edge = rotation_between(np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0]))
    square = np.array([[300.0, 200.0], [400.0, 200.0], [400.0, 300.0], [300.0, 300.0]])
    fit = fit_pose(square, np.eye(8), (0.6, 0.6), INTRINSICS, guess=(edge, AHEAD))
    assert fit is None or np.isfinite(fit.covariance).all()


def test_only_what_can_be_inverted_is_inverted():
    rng = np.random.default_rng(0)
    good = rng.normal(size=(5, 5))
    inverse = inverse_of(good)
    assert inverse is not None
    np.testing.assert_allclose(inverse @ good, np.eye(5), atol=1e-9)
    nearly = good.copy()
    nearly[0] = nearly[1] * (1.0 + 1e-14)
    for bad in (np.zeros((3, 3)), np.full((2, 2), np.inf), np.full((2, 2), np.nan), nearly):
        with np.errstate(invalid="ignore"):
            assert inverse_of(bad) is None
