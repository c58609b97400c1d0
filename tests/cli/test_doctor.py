import re
import tomllib
from importlib import metadata
from pathlib import Path

import cv2
import pytest

from mjsim.doctor import EXTRAS, diagnose, limits_held, missing_of_extras, report_lines
from mjsim.guarded import guarded
from mjsim.modules import octave_found
from tests.modules.octave_room import needs_octave


def put_program(folder, text):
    """Put a program called octave-cli into a folder that alone is searched."""
    program = folder / "octave-cli"
    program.write_text(f"#!/bin/sh\n{text}\n")
    program.chmod(0o755)
    return program


@pytest.fixture
def search(tmp_path, monkeypatch):
    """The only folder in which programs are looked for."""
    monkeypatch.setenv("PATH", str(tmp_path))
    return tmp_path


@needs_octave
def test_octave_is_told_with_its_version_and_place():
    version, program = octave_found().split(", ")
    assert version[0].isdigit()
    assert program.endswith(("/octave", "/octave-cli"))


def test_without_octave_one_line_says_what_to_type(search):
    assert octave_found() == (
        "not found; modules in .m files need it; type: sudo apt-get install --no-install-recommends octave"
    )


def test_what_is_called_octave_and_is_not_is_said_to_be_broken(search):
    program = put_program(search, "exit 127")
    assert octave_found().startswith(f"{program} is not GNU Octave, or is broken (exit code 127); type: sudo apt-get")
    program.write_bytes(b"\x7fELF")
    assert octave_found().startswith(f"{program} does not start: Exec format error; type: sudo apt-get")


@pytest.mark.slow
def test_the_doctor_draws_a_room_and_names_what_it_tried(tmp_path):
    diagnosis = diagnose(tmp_path / "new" / "room.png")
    assert diagnosis.backends[diagnosis.backend] == f"works: {diagnosis.renderer}"
    assert diagnosis.fault is None
    assert diagnosis.pictures_per_second > 5  # a 640 x 480 room on one slow core
    picture = cv2.imread(str(diagnosis.picture))
    assert picture.shape == (480, 640, 3)
    hue = cv2.cvtColor(picture, cv2.COLOR_BGR2HSV)[..., 0][cv2.cvtColor(picture, cv2.COLOR_BGR2HSV)[..., 1] > 150]
    for wanted in (0, 23, 107):  # the red box, the yellow cylinder and the blue box, in OpenCV's half degrees
        assert (abs(hue.astype(int) - wanted) < 4).mean() > 0.02
    lines = report_lines(diagnosis)
    assert lines[0] == f"backend   {diagnosis.backend}"
    assert any(diagnosis.versions["mujoco"] in line for line in lines)
    assert f"octave    {diagnosis.octave}" in lines
    assert any(line.startswith("  dxf  ") and line.endswith(EXTRAS["dxf"]) for line in lines)
    assert f"limits    {limits_held(guarded('mjsim.guarded:missing_limits', about='here'))}" in lines


def test_limits_that_a_system_lacks_are_named():
    assert "without" not in limits_held([])
    assert limits_held(["memory", "other files"]).startswith(
        "untrusted files are read without limits on memory, other files;"
    )


def test_every_extra_of_the_package_is_known_with_what_it_lacks(monkeypatch):
    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = {name: each for name, each in project["optional-dependencies"].items() if each and name != "all"}
    assert set(EXTRAS) == set(extras)
    (everything,) = project["optional-dependencies"]["all"]
    assert set(re.findall(r"\w+", everything)[1:]) == set(extras) - {"docs", "peers"}

    def nothing(name):
        raise metadata.PackageNotFoundError(name)

    monkeypatch.setattr("importlib.metadata.version", nothing)
    assert missing_of_extras() == {name: [re.split(r"[^\w.-]", each)[0] for each in extras[name]] for name in EXTRAS}
