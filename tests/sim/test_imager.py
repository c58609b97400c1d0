"""Pictures in linear light: photon transfer, exposure, optics and processing, each held to its formula."""

import math

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from mjsim.sim.imaging.imager import Imager, PlainImager, imager_of, specks, vignette
from mjsim.sim.imaging.light_response import light_for
from mjsim.sim.imaging.pixel_noise import PixelNoise
from mjsim.world import Camera

WIDE, TALL = 96, 72


def camera(**keys: object) -> Camera:
    return Camera.model_validate({"camera": "c", "width": WIDE, "height": TALL, "noise": 0, **keys})


def made(number: int = 0, **keys: object) -> Imager:
    found = imager_of(camera(**keys), np.random.default_rng(number), np.random.default_rng(number + 1))
    assert isinstance(found, Imager)
    return found


def flat(level: int) -> NDArray[np.uint8]:
    return np.full((TALL, WIDE, 3), level, dtype=np.uint8)


def srgb(light: NDArray[np.float64]) -> NDArray[np.float64]:
    """Encode linear light: the forward formula of the standard, which mjsim never uses."""
    return 255 * np.where(light <= 0.0031308, 12.92 * light, 1.055 * np.maximum(light, 1e-9) ** (1 / 2.4) - 0.055)


def poisson_levels(level: int, *, full_well: float, read: float, gain: float = 1.0) -> NDArray[np.float64]:
    """Return pixel values by counted photons and electrons of the read-out."""
    rng = np.random.default_rng(7)
    light = np.interp(level, srgb(np.linspace(0, 1, 20001)), np.linspace(0, 1, 20001))
    counted = rng.poisson(light * full_well / gain, 40_000) + rng.normal(0.0, read, 40_000)
    return np.clip(np.rint(srgb(np.clip(counted * gain / full_well, 0.0, 1.0))), 0, 255)


@pytest.mark.parametrize("level", [0, 4, 16, 60, 118, 230, 255])
@pytest.mark.parametrize(("full_well", "read"), [(5800.0, 3.9), (900.0, 12.0), (30_000.0, 0.0)])
def test_pixel_values_are_distributed_like_counted_photons(level, full_well, read):
    picture = made(noise={"full_well": full_well, "read": read}).picture(flat(level), 0.0)
    expected = poisson_levels(level, full_well=full_well, read=read)
    # The standard error of 20,000 values' deviation is 0.5 %, and at black, read-out noise is made a little skew.
    assert picture.std() == pytest.approx(expected.std(), rel=0.04 if level else 0.1, abs=0.06)
    assert picture.mean() == pytest.approx(expected.mean(), abs=0.06 + 5 * expected.std() / math.sqrt(picture.size))


@pytest.mark.parametrize(("level", "deviation"), [(16, 2.8), (230, 1.5)])
def test_the_usual_photons_are_those_of_a_real_camera(level, deviation):
    assert made(noise={}).picture(flat(level), 0.0).std() == pytest.approx(deviation, rel=0.04)


def test_a_gain_costs_photons():
    exposure = {"seconds": 0.01 / 16, "gain": 16}
    picture = made(noise={}, exposure=exposure).picture(flat(118), 0.0)
    expected = poisson_levels(118, full_well=5800.0, read=3.9, gain=16.0)
    assert picture.mean() == pytest.approx(expected.mean(), abs=0.5)
    assert picture.std() == pytest.approx(expected.std(), rel=0.04)


def test_variance_in_linear_light_is_photons_plus_read_out():
    """The photon transfer curve of a linear camera: its slope is the inverse of the full well."""
    device = made(noise={"full_well": 2000, "read": 20}, response="linear")
    levels = np.array([40, 90, 140, 190, 225])
    light = light_for(levels.astype(float), "srgb")
    variances = [device.picture(flat(int(level)), 0.0).astype(float).var() for level in levels]
    slope, offset = np.polyfit(light, (np.array(variances) - 1 / 12) / 255**2, 1)
    assert 1 / slope == pytest.approx(2000, rel=0.06)
    assert math.sqrt(offset) * 2000 == pytest.approx(20, abs=4)


def test_noise_is_white_in_a_picture_and_between_pictures():
    device = made(noise={})
    first, second = (device.picture(flat(118), 0.1 * n).astype(float) - 118 for n in range(2))
    spectrum = np.fft.fft2(first[..., 1])
    correlation = np.fft.ifft2(np.abs(spectrum) ** 2).real / first[..., 1].var() / first[..., 1].size
    correlation[0, 0] = 0.0
    # The largest of 6912 normal values of deviation 1 / sqrt(6912) is 4.0 of them; 6 never happen by chance.
    limit = 6 / math.sqrt(WIDE * TALL)
    assert np.abs(correlation).max() < limit
    across = np.fft.ifft2(np.conj(spectrum) * np.fft.fft2(second[..., 1])).real
    assert np.abs(across).max() / first[..., 1].size / first[..., 1].var() < limit
    assert abs(np.corrcoef(first[..., 0].ravel(), first[..., 2].ravel())[0, 1]) < limit


@pytest.mark.parametrize("keys", [{"noise": {}}, {"noise": 3.0}, {"noise": {}, "monochrome": True}])
def test_a_picture_passed_over_takes_the_random_numbers_of_one_that_is_taken(keys):
    one, two = (imager_of(camera(**keys), np.random.default_rng(5), np.random.default_rng(6)) for _ in range(2))
    one.picture(flat(90), 0.0)
    two.pass_over()
    np.testing.assert_array_equal(one.picture(flat(90), 1.0), two.picture(flat(90), 1.0))
    other = imager_of(camera(**keys), np.random.default_rng(8), np.random.default_rng(6))
    assert (other.picture(flat(90), 0.0) != one.picture(flat(90), 2.0)).mean() > 0.3


@pytest.mark.parametrize("shape", [(48, 64, 3), (17, 19, 3)])
def test_constant_noise_is_a_table_of_two_random_bytes_as_ever(shape):
    noise, stream = PixelNoise(5.0, np.random.default_rng(3)), np.random.default_rng(3)
    from scipy.special import ndtri

    errors = np.rint(5.0 * ndtri((np.arange(1 << 16) + 0.5) / (1 << 16))).astype(int)
    for _ in range(3):
        image = np.full(shape, 128, dtype=np.uint8)
        noise.add_to(image)
        drawn = np.frombuffer(stream.bytes(2 * image.size), dtype=np.uint16).reshape(shape)
        np.testing.assert_array_equal(image, np.clip(128 + errors[drawn], 0, 255))


def test_without_errors_each_pixel_value_comes_back():
    levels = np.arange(256, dtype=np.uint8).reshape(16, 16)
    picture = np.repeat(levels[..., None], 3, axis=2)
    device = imager_of(camera(width=16, height=16, exposure={"seconds": 0.01}), *[np.random.default_rng(0)] * 2)
    np.testing.assert_array_equal(device.picture(picture, 0.0), picture)


def test_twice_the_exposure_time_is_twice_the_light():
    level = 100
    twice = made(exposure={"seconds": 0.02}).picture(flat(level), 0.0)
    light = np.interp(level, srgb(np.linspace(0, 1, 20001)), np.linspace(0, 1, 20001))
    assert np.all(np.abs(twice - srgb(np.array(2 * light))) <= 1)


def test_automatic_exposure_reaches_middle_grey_with_its_time_constant():
    device = made(exposure={"time_constant": 0.5, "longest": 0.1})
    device.picture(flat(180), 0.0)
    light = [light_for(np.array(float(device.picture(flat(60), t)[0, 0, 0])), "srgb") for t in np.arange(0.1, 5, 0.1)]
    distance = np.log(light_for(np.array(118.0), "srgb") / np.array(light))
    # The logarithm of the exposure follows as first-order lag: it starts where the bright picture left it.
    start = math.log(float(light_for(np.array(180.0), "srgb") / light_for(np.array(60.0), "srgb")))
    np.testing.assert_allclose(distance[:15], start * np.exp(-np.arange(0.1, 1.55, 0.1) / 0.5), atol=0.08)
    assert abs(distance[-1]) < 0.03


def test_in_the_dark_the_longest_exposure_is_followed_by_gain_and_noise():
    bright, dark = (
        made(noise={}, exposure={"longest": 0.02, "full_light": 0.01, "gain": 64}).picture(flat(level), 0.0)
        for level in (118, 12)
    )
    assert dark.mean() == pytest.approx(bright.mean(), abs=3)
    assert dark.std() > 3 * bright.std()


def test_automatic_white_balance_takes_a_tint_away_and_given_factors_add_one():
    tinted = flat(120)
    tinted[..., 0], tinted[..., 2] = 140, 100
    means = made(white_balance="auto").picture(tinted, 0.0).mean(axis=(0, 1))
    assert np.ptp(means) <= 1
    red, green, blue = made(white_balance=[1.5, 1, 0.5]).picture(flat(120), 0.0)[0, 0]
    light = light_for(np.array([red, green, blue], dtype=float), "srgb")
    np.testing.assert_allclose(light / light[1], [1.5, 1.0, 0.5], rtol=0.02)


def test_vignetting_follows_the_fourth_power_of_a_cosine_to_the_corners():
    share = vignette(camera(vignetting=0.4))
    assert share[0, 0] == pytest.approx(0.6)
    radius = np.hypot(*np.meshgrid(np.arange(WIDE) - (WIDE - 1) / 2, np.arange(TALL) - (TALL - 1) / 2))
    distance = radius.max() / math.tan(math.acos(0.6**0.25))
    np.testing.assert_allclose(share, np.cos(np.arctan(radius / distance)) ** 4, rtol=1e-9)
    seen = made(vignetting=0.4).picture(flat(200), 0.0)
    ratio = light_for(seen[..., 1].astype(float), "srgb") / light_for(np.array(200.0), "srgb")
    np.testing.assert_allclose(ratio, share, atol=0.008)


def test_dirt_takes_its_share_and_stays_where_it_is():
    assert specks(camera(dirt=0.05), np.random.default_rng(3)).mean() == pytest.approx(0.05, rel=0.05)
    device = made(dirt=0.05)
    one, two = device.picture(flat(200), 0.0), device.picture(flat(200), 1.0)
    np.testing.assert_array_equal(one, two)
    assert one.min() < 190 < one.max()


def test_a_given_response_maps_light_as_its_values_say():
    curve = [0, 100, 180, 230, 255]
    picture = made(response=curve).picture(flat(150), 0.0)
    light = float(light_for(np.array(150.0), "srgb"))
    assert abs(float(picture[0, 0, 0]) - np.interp(light, np.linspace(0, 1, 5), curve)) <= 0.51


@pytest.mark.parametrize(
    ("color", "luminance"),
    [((255, 0, 0), 0.2126), ((0, 255, 0), 0.7152), ((0, 0, 255), 0.0722), ((255, 255, 255), 1.0)],
)
def test_grey_pictures_show_luminance_of_linear_light(color, luminance):
    picture = made(monochrome=True).picture(np.full((TALL, WIDE, 3), color, dtype=np.uint8), 0.0)
    assert picture.shape == (TALL, WIDE, 3)
    assert abs(float(picture[0, 0, 1]) - float(srgb(np.array(luminance)))) <= 1


def test_sharpening_makes_edges_steeper_and_leaves_planes():
    step = flat(100)
    step[:, WIDE // 2 :] = 150
    row = made(sharpening=1.0).picture(step, 0.0)[TALL // 2, :, 0].astype(int)
    # The unsharp mask of the binomial blur: a quarter of the step overshoots at each side.
    assert row[WIDE // 2 - 1] == pytest.approx(100 - 50 / 4, abs=1)
    assert row[WIDE // 2] == pytest.approx(150 + 50 / 4, abs=1)
    assert set(row[: WIDE // 2 - 2]) == {100}


def test_compression_is_that_of_a_jpeg_file_of_its_quality():
    picture = np.random.default_rng(0).integers(0, 256, (TALL, WIDE, 3), dtype=np.uint8)
    data = cv2.imencode(".jpg", picture[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 60])[1]
    np.testing.assert_array_equal(made(jpeg=60).picture(picture, 0.0), cv2.imdecode(data, 1)[..., ::-1])


def test_light_of_several_instants_is_averaged_not_pixel_values():
    device = made(noise={"full_well": 1_000_000, "read": 0})
    light = (device.light(flat(0)) + device.light(flat(255))) / 2
    assert abs(device.picture(light, 0.0).mean() - float(srgb(np.array(0.5)))) < 1
    plain = imager_of(camera(), *[np.random.default_rng(0)] * 2)
    assert isinstance(plain, PlainImager)
    values = (plain.light(flat(0)).astype(np.float32) + plain.light(flat(255))) / 2
    assert plain.picture(values, 0.0)[0, 0, 0] == 128


def test_blur_of_the_lens_acts_on_light():
    step = flat(0)
    step[:, WIDE // 2 :] = 255
    row = made(exposure={"seconds": 0.01}, blur=3.0).picture(step, 0.0)[TALL // 2, :, 0].astype(float)
    assert light_for(row, "srgb")[WIDE // 2 - 1 : WIDE // 2 + 1].mean() == pytest.approx(0.5, abs=0.01)


def test_noise_wider_than_16_bits_is_clipped_and_keeps_its_signs():
    small, wide = np.zeros((2, 64, 64), dtype=np.int16)
    PixelNoise(100.0, np.random.default_rng(1)).add_to(small)
    PixelNoise(13_000.0, np.random.default_rng(1)).add_to(wide)
    np.testing.assert_array_equal(np.sign(wide)[small != 0], np.sign(small)[small != 0])
    assert wide.max() == 32767
