"""Cameras in a world file: values of several shapes, what excludes each other, the usual noise, real devices."""

import math

import pytest

from mjsim.errors import WorldError
from mjsim.world import Camera, Photons, format_world, parse_world, world_notes

ROBOT = "mjsim: 1\nrobots: [{name: r, at: [0, 0], odometry: {noise: {}}, sensors: [{camera: c, %s}]}]\n"
WRONG = {
    "noise: [1]": "noise is [1]; it must be a number or keys with values",
    "noise: -1": "noise is -1; it must be at least 0",
    "noise: true": "noise is true; it must be a number",
    "noise: {full_well: 1}": "full_well is 1 e-; it must be at least 100",
    "noise: {reed: 1}": "unknown key 'reed'; did you mean 'read'?",
    "exposure: off": "exposure is 'off'; it must be 'auto', a number or keys with values",
    "white_balance: sunny": "white_balance is 'sunny'; it must be 'auto' or a list of 3 numbers",
    "exposure: {seconds: 2}": "seconds is 2; it must be at most 1",
    "exposure: {seconds: 0.1, longest: 0.1}": "a fixed exposure has 'seconds' and 'gain' only; leave out this key",
    "exposure: {seconds: 0.1}, shutter: 0.1": "the exposure time is exposure.seconds already; leave out 'shutter'",
    "response: [3, 2]": "a response must increase from each value to the next",
    "response: cubic": "response is 'cubic'; it must be 'srgb', 'linear' or a list",
    "white_balance: [1, 2]": "white_balance is [1, 2]; it must have at least 3 items",
    "depth: 3": "depth is 3; it must be true or false or keys with values",
    "depth: {stereo: {window: 4}}": "window is 4 px; it must be odd, such as 5",
    "depth: {stereo: {}, noise: 1}": "the noise of stereo is its 'subpixel'; leave out 'noise'",
    "depth: {stereo: {}}, lens: {brown: [0, 0, 0, 0]}": "stereo matches pictures without distortion; leave out 'lens'",
}


def camera(keys: str) -> Camera:
    found = parse_world(ROBOT % keys).robots[0].sensors[0]
    assert isinstance(found, Camera)
    return found


@pytest.mark.parametrize("keys", WRONG)
def test_a_wrong_key_of_a_camera_is_one_error(keys):
    with pytest.raises(WorldError) as caught:
        parse_world(ROBOT % keys)
    (line,) = str(caught.value).splitlines()
    assert line.split(": ", 1)[1] == WRONG[keys]


@pytest.mark.parametrize("keys", ["noise: {read: 2}", "exposure: {seconds: 0.02, gain: 2}", "response: [0, 99, 255]"])
def test_keys_of_light_are_written_and_read_back(keys):
    world = parse_world(ROBOT % keys)
    assert parse_world(format_world(world)) == world
    assert world.robots[0].sensors[0].in_light


def test_a_camera_with_constant_noise_alone_keeps_rendered_values():
    assert not camera("noise: 2, blur: 1, exposure: auto, shutter: 0.01").in_light
    assert camera("exposure: {seconds: 0.02}").exposed == 0.02
    calm = camera("jpeg: 20, dirt: 0.1, noise: 3, exposure: {seconds: 0.5}").without_errors(depth=True)
    assert (calm.in_light, calm.exposed, calm.depth) == (False, 0.0, True)


def test_a_bare_camera_has_the_usual_noise_and_a_note_says_so():
    (note,) = world_notes(parse_world(ROBOT % "width: 64"))
    assert str(note) == (
        "world.yaml:2:74: camera 'r/c' has no key noise, so it has the default, full well 5800 and read-out 3.9"
        " electrons; for none, write noise: 0"
    )
    assert camera("width: 64").noise == Photons()
    for given in ("noise: 0", "noise: {}", "preset: phone"):
        assert not world_notes(parse_world(ROBOT % given))


def test_the_electrons_of_the_industrial_camera_give_the_ratios_of_its_data_sheet():
    """Photons alone make the noise at saturation; the dynamic range is the full well over the read-out noise."""
    noise = camera("preset: mvbluefox3-2016").noise
    assert 10 * math.log10(noise.full_well) == pytest.approx(40.2, abs=0.02)
    assert 20 * math.log10(noise.full_well / noise.read) == pytest.approx(71.4, abs=0.1)


def test_the_depth_of_the_d435_errs_as_its_makers_say():
    preset = camera("preset: realsense-d435")
    stereo = preset.depth.stereo
    assert stereo.subpixel / (preset.focal * stereo.baseline) == pytest.approx(0.0047, abs=1e-4)
