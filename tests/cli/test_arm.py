"""`mjsim arm` as a person types it."""

import cv2
import pytest

from mjsim.cli import main


def typed(capsys, *arguments):
    with pytest.raises(SystemExit) as ended:
        main(["arm", *arguments])
    out, err = capsys.readouterr()
    return ended.value.code, out, err


def test_the_table_of_a_preset_has_its_numbers_and_the_place_of_the_tool(capsys):
    code, out, _ = typed(capsys, "puma560", "--joints", "0,0,0,0,0,0")
    assert code == 0
    lines = out.splitlines()
    assert lines[0] == "puma560: 6 joints, standard convention"
    assert lines[4].split() == [
        "2",
        "turns",
        "0",
        "0",
        "0.4318",
        "0",
        "-45",
        "..",
        "225",
        "86.5",
        "186.4",
        "17.4",
        "107.815",
    ]
    assert lines[-1].endswith("tool at 0.4521, -0.1500, 1.1036 m; roll, pitch, yaw 0.00, 0.00, 0.00 deg")


@pytest.mark.slow  # the first picture loads matplotlib
def test_a_picture_is_written_and_not_over_another(capsys, tmp_path):
    place = tmp_path / "arm.png"
    code, out, _ = typed(capsys, "motoman_up6", "--plot", str(place))
    assert (code, out.splitlines()[-1]) == (0, str(place))
    assert cv2.imread(str(place)).std() > 10
    code, _, err = typed(capsys, "motoman_up6", "--plot", str(place))
    assert (code, len(err.splitlines())) == (2, 1)


WRONG = {
    "'pumma560' is neither an arm preset nor a file (.yaml, .xml, .urdf, .xacro); did you mean 'puma560'?": [
        "pumma560"
    ],
    "--joints is '1,2'; give 6 numbers separated by commas": ["puma560", "--joints", "1,2"],
    "--joints is 'a'; give 6 numbers separated by commas": ["puma560", "--joints", "a"],
    "'arm.gif' is not a picture; its name must end in .png, .svg or .pdf": ["puma560", "--plot", "arm.gif"],
    "no file 'none.yaml'; name a YAML file with `dh`, MJCF or URDF": ["none.yaml"],
}


@pytest.mark.parametrize(("sentence", "arguments"), WRONG.items())
def test_a_mistake_is_one_line_and_code_2(sentence, arguments, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, _, err = typed(capsys, *arguments)
    assert (code, err) == (2, sentence + "\n")
