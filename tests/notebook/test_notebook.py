"""What notebooks show: a small plan and a few numbers, progress in one line, and errors without frames of mjsim."""

import re
import sys
from xml.etree.ElementTree import fromstring

import matplotlib
import numpy as np
import pandas as pd
import pytest
from IPython.core.interactiveshell import InteractiveShell
from IPython.utils.capture import capture_output
from matplotlib.axes import Axes

import mjsim
from mjsim.record import export_csv
from mjsim.sweep import Sweep
from mjsim.traces import short_trace
from tests.children import completed

matplotlib.use("agg")
ROOM = """
mjsim: 1
name: room
walls: [{points: [[0, 0], [4, 0], [4, 3], [0, 3]], closed: true}]
beacons: [{name: post, at: [3.9, 1.5], heading_deg: 180}]
robots:
  - {name: scout, at: [1, 1], odometry: {noise: {distance: 0.05, turn: 0.05}},
     sensors: [{beacons: ring, range: [0.1, 8], fov_deg: 360, rate_hz: 5, noise: {range: 0.05, bearing_deg: 1}}]}
run: {seconds: 1, rate_hz: 25}
"""
FEW_KB = 4000


class Failing:
    """Raises after some updates."""

    def start(self, robot, catalogue, rng):
        self.left = 3

    def update(self, seen):
        self.left -= 1
        return mjsim.Estimate(mjsim.Pose(1 / self.left, 0, 0), np.eye(3))


class Driving:
    def start(self, robot, map, rng):
        """Do nothing."""

    def command(self, seen, belief):
        return mjsim.Command(0.3, 0.0, 0.2)


@pytest.fixture(scope="module")
def world():
    return mjsim.parse_world(ROOM)


@pytest.fixture(scope="module")
def recording(world):
    from mjsim.algorithms.textbook import TextbookEkfSlam

    return mjsim.run(world, drivers={"scout": mjsim.Driver(estimator=TextbookEkfSlam(), navigator=Driving())})


def parts(value):
    """Return the picture and the rest of what a notebook shows of a value; both are well-formed."""
    html = value._repr_html_()
    fromstring(f"<all>{html}</all>")
    svg = "".join(re.findall("<svg.*</svg>", html))
    return svg, html.replace(svg, "") if svg else html


def texts(html):
    return [*map(str.strip, fromstring(f"<all>{html}</all>").itertext())]


def test_a_world_is_its_plan_and_what_it_holds(world):
    svg, rest = parts(world)
    assert svg.count("<polygon") > 3
    assert len(rest) < FEW_KB
    assert {"World room", "4.1 x 3.1 m", "beacons", "scout"} <= set(texts(rest))
    assert repr(world) == str(world) == "<World 'room': 1 wall, 1 beacon, 1 robot>"


def test_a_recording_and_a_track_show_paths_and_errors(recording):
    track = recording.robots["scout"]
    wrong = np.hypot(*(track.estimate - track.truth)[:, :2].T)
    for value, title in ((recording, "scout: position error, rmse"), (track, "position error, rmse")):
        svg, rest = parts(value)
        assert svg.count("<polyline") >= 3
        shown = texts(rest)
        assert shown[shown.index(title) + 1] == f"{np.sqrt(np.mean(wrong**2)):.3f} m"
        assert len(rest) < FEW_KB
    assert repr(recording) == "<Recording of 'room': 25 ticks in 0.96 s, seed 1; scout>"
    assert len(repr(recording.robots)) < 200


def test_a_simulation_shows_where_its_robot_is(world):
    with mjsim.Simulation(world) as sim:
        before = parts(sim)[0]
        sim.apply("scout", mjsim.Command(0.5, 0.0, 0.0))
        for _ in range(25):
            sim.step()
        svg, rest = parts(sim)
    assert svg != before
    assert f"x {sim.truth('scout').x:.3f} m" in rest
    assert {"1 s", "Simulation of room"} <= set(texts(rest))


def test_statistics_and_comparisons_show_tables(recording):
    figures, comparison = mjsim.statistics(recording), mjsim.compare({"one": [recording]})
    for value in (figures, comparison):
        svg, rest = parts(value)
        assert not svg
        assert "position error, rmse [m]" in rest
        assert f"{figures['scout']['position_error_m']['rmse']:.3f}" in rest
        assert len(rest) < FEW_KB
    assert repr(comparison) == "<Comparison of one: 0 significant differences>"


def test_a_sweep_is_shown_with_its_folder_and_no_more_than_a_few_lines(tmp_path):
    figures = {"position_error_m.rmse": {"mean": 0.25, "low": None, "high": None}}
    case = {
        "settings": {},
        "runs": 2,
        "failed": 0,
        "robots": dict.fromkeys(map(str, range(90)), figures),
        "no_nees": {},
    }
    sweep = Sweep(folder=tmp_path, rows=[{}] * 180, summary={"cases": [case]}, failed={})
    _, rest = parts(sweep)
    assert "0.25" in rest
    assert len(rest) < FEW_KB
    assert repr(sweep) == f"<Sweep in '{tmp_path}': 180 rows, 0 failed runs>"


def test_worlds_with_many_things_show_no_more_than_a_plan_and_a_few_rows():
    robots = "".join(f"  - {{name: r{i}, at: [{i}, 0]}}\n" for i in range(32))
    svg, rest = parts(mjsim.parse_world(f"robots:\n{robots}"))
    assert svg
    assert len(rest) < FEW_KB


def test_a_frame_is_the_table_of_the_export(recording, tmp_path):
    paths = export_csv(recording, tmp_path)
    assert len(paths) > 4
    for path in paths:
        exported = pd.read_csv(path)
        pd.testing.assert_frame_equal(recording.frame(path.stem), exported, check_dtype=False)
    pd.testing.assert_frame_equal(recording.frame(), recording.frame("scout_track"))
    with pytest.raises(mjsim.UsageError, match=r"no table 'scout_trak' .* did you mean 'scout_track'"):
        recording.frame("scout_trak")


def test_without_pandas_a_frame_says_what_to_type(recording, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(mjsim.UsageError, match=r"needs pandas, which is not installed; type: .* install .*pandas$"):
        recording.frame()


def test_a_plot_is_axes_of_pyplot_with_the_data(recording):
    from matplotlib import pyplot

    axes = recording.plot()
    assert isinstance(axes, Axes)
    assert pyplot.gcf() is axes.figure
    truth = next(line for line in axes.lines if line.get_label() == "truth")
    np.testing.assert_array_equal(truth.get_xydata(), recording.robots["scout"].truth[:, :2])
    pyplot.close("all")


def test_a_plot_of_several_panels_is_an_array_of_axes_and_a_wrong_name_is_told(recording):
    from matplotlib import pyplot

    assert [axes.get_ylabel() for axes in recording.plot("bounds")] == [
        "x error [m]",
        "y error [m]",
        "heading error [deg]",
    ]
    pyplot.close("all")
    with pytest.raises(mjsim.UsageError, match="no plot 'nes' of a recording; did you mean 'nees'"):
        recording.plot("nes")
    with pytest.raises(mjsim.UsageError, match="no robot 'joe' in "):
        recording.plot(robot="joe")


def test_a_fault_of_a_module_shows_the_frames_of_the_user_alone(world):
    with pytest.raises(mjsim.ModuleFault) as caught:
        mjsim.run(world, drivers={"scout": mjsim.Driver(estimator=Failing())})
    lines = short_trace(caught.value)
    assert lines[-1].startswith("mjsim.errors.ModuleFault: estimator Failing of robot 'scout' at 0.08 s raised ZeroDiv")
    named = re.findall(r'File ".*", line \d+, in (\w+)', "\n".join(lines))
    assert named == ["test_a_fault_of_a_module_shows_the_frames_of_the_user_alone", "update"]
    assert "1 / self.left" in "\n".join(lines)


CELL = """
import mjsim
from IPython.display import display
from tests.notebook.test_notebook import ROOM, Failing
display(mjsim.run(mjsim.parse_world(ROOM)))
"""


@pytest.fixture
def shell():
    InteractiveShell.clear_instance()
    yield InteractiveShell.instance()
    InteractiveShell.clear_instance()


def test_a_notebook_shows_one_line_of_progress_that_it_updates_and_the_recording(shell):
    with capture_output() as shown:
        assert shell.run_cell(CELL).success
    first, *_, last = [output.data for output in shown.outputs]
    assert first == {"text/plain": "run room ..."}
    updates = [output for output in shown.outputs if output.update]
    assert updates[-1].data["text/plain"].startswith("run room: 1 of 1 s (")
    assert "<svg" in last["text/html"]
    assert len(last["text/plain"]) < 100
    assert shown.stderr == ""


def test_a_notebook_shows_a_fault_without_frames_of_mjsim(shell):
    cell = CELL.replace("(ROOM))", "(ROOM), drivers={'scout': mjsim.Driver(estimator=Failing())})")
    with capture_output() as shown:
        assert not shell.run_cell(cell).success
    assert "ModuleFault: estimator Failing of robot 'scout'" in shown.stdout
    assert "mjsim/run" not in shown.stdout
    assert "boundary" not in shown.stdout
    assert "in update" in shown.stdout


@pytest.mark.slow  # It starts Python.
def test_a_script_that_a_fault_ends_prints_the_frames_of_the_user_alone(tmp_path):
    (tmp_path / "try.py").write_text(
        "import sys\n"
        f"sys.path.insert(0, {str(sys.path[0])!r})\n"
        + CELL.replace("(ROOM))", "(ROOM), drivers={'scout': mjsim.Driver(estimator=Failing())})")
    )
    done = completed([sys.executable, tmp_path / "try.py"], check=False)
    assert done.returncode == 1
    assert done.stderr.count('File "') == 2
    assert done.stderr.splitlines()[-1].startswith("mjsim.errors.ModuleFault: estimator Failing")
