"""Plots as PNG, PDF and SVG."""

import re
import shutil

import pytest
from matplotlib.figure import Figure

import mjsim
from mjsim.cli import main
from mjsim.report import write_comparison, write_report
from mjsim.report.drawings import FORMATS, _say_boxes, drawing_as, drawing_files, parse_formats, plot_text, png_of

ROOM = """
mjsim: 1
name: room
walls: [{points: [[0, 0], [4, 0], [4, 3], [0, 3]], closed: true}]
robots: [{name: scout, preset: pioneer3dx, at: [1, 1.5]}]
run:
  seconds: 1
  drivers:
    scout:
      estimator: {use: "mjsim.algorithms.ekf_slam:EkfSlam"}
      navigator: {use: "mjsim.algorithms.waypoints:Waypoints", points: [[3, 1.5]]}
"""


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    path = tmp_path_factory.mktemp("run") / "run.mcap"
    with mjsim.Simulation(mjsim.parse_world(ROOM)) as sim:
        return mjsim.run(sim, record=path), path


def figure() -> Figure:
    drawing = Figure()
    drawing.subplots().plot([0, 1], label="error [m]")
    drawing.legend()
    return drawing


@pytest.mark.slow
def test_each_format_is_what_its_name_says_and_the_same_bytes_each_time():
    for form, begin in zip(FORMATS, (b"\x89PNG", b"%PDF-", b"<?xml"), strict=True):
        data = drawing_as(figure(), form)
        assert data.startswith(begin)
        assert drawing_as(figure(), form) == data
    assert b"/Type3" not in drawing_as(figure(), "pdf")


def test_a_picture_that_is_there_is_not_drawn_again():
    files = drawing_files({"path": figure()}, ("png", "svg"), pictures={"path": b"there"})
    assert list(files) == ["path.png", "path.svg"]
    assert files["path.png"] == b"there"


def test_formats_are_a_list_of_words_and_a_misspelt_one_is_told():
    assert parse_formats("pdf, SVG,pdf") == ("pdf", "svg")
    for wrong, right in (("pdff", "; did you mean 'pdf'?"), ("", "; there are pdf, png, svg")):
        with pytest.raises(mjsim.UsageError, match=re.escape(f"no format '{wrong}' for plots{right}")):
            parse_formats(wrong)


@pytest.mark.slow
def test_a_report_of_vector_plots_alone_has_each_in_each_format_no_png_and_a_page_with_them_all(recording, tmp_path):
    with pytest.raises(SystemExit) as ended:
        main(["report", str(recording[1]), "-o", str(tmp_path), "--formats", "pdf,svg"])
    assert ended.value.code == 0
    stems = {path.stem for path in tmp_path.glob("scout_*")}
    files = {f"{stem}.{form}" for stem in stems for form in ("pdf", "svg")}
    assert {path.name for path in tmp_path.glob("scout_*")} == files
    assert (tmp_path / "report.html").read_text().count("data:image/png") == len(stems) > 2


@pytest.mark.slow
def test_a_comparison_of_vector_plots_alone_has_no_files_of_png(recording, tmp_path):
    odd = shutil.copy(recording[1], tmp_path / r"cost $\frac{a$.mcap")
    write_comparison(mjsim.compare([recording[1], odd]), tmp_path / "comparison", formats=["pdf"])
    assert {path.suffix for path in (tmp_path / "comparison").iterdir()} >= {".pdf"}
    assert not list((tmp_path / "comparison").glob("*.png"))


@pytest.mark.slow
def test_a_report_over_another_leaves_no_plot_of_a_robot_that_is_gone(recording, tmp_path):
    two = ROOM.replace("robots: [", "robots: [{name: gone, preset: pioneer3dx, at: [3, 1]}, ")
    with mjsim.Simulation(mjsim.parse_world(two)) as sim:
        write_report(mjsim.run(sim), tmp_path)
    assert list(tmp_path.glob("gone_*.png"))
    (tmp_path / "gone_photo.png").write_bytes(b"a person's own")
    assert main_ended("report", str(recording[1]), "-o", str(tmp_path)) == 2
    assert main_ended("report", str(recording[1]), "-o", str(tmp_path), "--overwrite") == 0
    assert [path.name for path in tmp_path.glob("gone_*")] == ["gone_photo.png"]
    assert "gone" not in (tmp_path / "report.html").read_text()


def main_ended(*words: str) -> int:
    with pytest.raises(SystemExit) as ended:
        main(list(words))
    return int(ended.value.code or 0)


def test_a_wrong_format_is_an_error_before_anything_is_read(tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["report", "none.mcap", "-o", str(tmp_path), "--formats", "jpg"])
    assert ended.value.code == 2
    assert capsys.readouterr().err == "no format 'jpg' for plots; did you mean 'png'?\n"


@pytest.mark.parametrize("name", [r"cost $\frac{a$", "$x$", "_x", "5 $"])
def test_a_name_of_a_file_is_drawn_as_it_is_and_stands_in_the_legend(name):
    drawing = Figure(figsize=(2, 1))
    axes = drawing.subplots()
    axes.plot([0, 1], label=plot_text(name))
    assert [text.get_text() for text in axes.legend().get_texts()] == [plot_text(name)]
    assert png_of(drawing)


def test_letters_that_the_font_lacks_are_boxes_and_that_is_said_once(capsys):
    figure = Figure()
    figure.suptitle("机器人")
    _say_boxes.cache_clear()
    assert png_of(figure)[:4] == png_of(figure)[:4] == b"\x89PNG"
    assert capsys.readouterr().err.count("plots show boxes for letters") == 1
