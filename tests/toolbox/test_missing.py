"""What scripts of other toolboxes are told, without Octave."""

import pytest

from mjsim.toolbox.missing import explained


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("rigidBodyTree", "; arms are made by robot and link"),
        ("DHFactor", "; arms are made by robot and link"),
        ("inverseKinematics", "; arms are made by robot and link"),
        ("binaryOccupancyMap", "; maps and scans belong to a world"),
        ("controllerPurePursuit", "; drivers, planners and filters are modules"),
        ("bicycleKinematics", "; drivers, planners and filters are modules"),
        ("SE3", "; poses are 4 x 4 matrices"),
        ("eul2quat", "; poses are 4 x 4 matrices"),
        ("array2table", "; Octave has no tables"),
        ("plot_homline", "; draw with plot"),
        ("fkin", "; did you mean 'fkine'?"),
        ("rnad_of_mine", " ("),
    ],
)
def test_an_undefined_name_is_told_with_what_serves_instead(name, told):
    found = explained(f"'{name}' undefined near line 3, column 5 (a.m:3)")
    assert found.startswith(f"'{name}' undefined{told}")
    assert found.endswith(" (a.m:3)")


def test_packages_of_octave_are_named_in_a_short_line():
    plea = "belongs to the image package from Octave Forge which seems to not be installed in your system. Please read"
    assert explained(f"'fspecial' undefined The 'fspecial' function {plea} <x> to learn. (a.m:1)") == (
        "'fspecial' undefined; install octave-image and write pkg load image (a.m:1)"
    )
    assert explained("index (5,_): out of bound 4 (a.m:2)") == "index (5,_): out of bound 4 (a.m:2)"
