"""Pictures of scripts: stems, patches in space, options of arms, texts over a figure, axes on axes."""

import numpy as np
import pytest

from mjsim.toolbox.calls import FigureCall
from mjsim.toolbox.draw import ScriptFigures
from mjsim.toolbox.drawing_functions import FUNCTIONS
from mjsim.toolbox.marks import line_format, math_text

ROW = np.array([[1.0, 2.0, 4.0]])
LINK = {"theta": 0.0, "d": 0.0, "a": 1.0, "alpha": 0.0, "sigma": 0.0, "offset": 0.0, "mdh": 0.0, "qlim": np.zeros(0)}
ARM = {"links": [LINK, LINK], "name": "plane", "base": np.eye(4), "tool": np.eye(4), "gravity": np.zeros(3)}


def number(value: float) -> np.ndarray:
    return np.array([[float(value)]])


def drawn(*calls: tuple[str, tuple[object, ...]]) -> ScriptFigures:
    figures = ScriptFigures()
    numbered = enumerate(calls, start=1)
    figures.draw([FigureCall(name, given, 1, count) for count, (name, given) in numbered], FUNCTIONS)
    return figures


def axes_of(*calls):
    figures = drawn(*calls)
    assert figures.skipped == set()
    return figures.figure(1).axes


def test_an_arm_has_the_workspace_and_the_view_that_the_script_asks_for():
    limits = np.array([[-3.0, 3.0, -2.0, 2.0, -1.0, 1.0]])
    plot = (ARM, np.zeros((1, 2)), "workspace", limits, "noshadow")
    (axes,) = axes_of(("robot", plot), ("view", (number(30), number(40))))
    assert [*axes.get_xlim(), *axes.get_ylim(), *axes.get_zlim()] == limits.ravel().tolist()
    assert (axes.azim, axes.elev) == (-60.0, 40.0)
    assert drawn(("robot", (ARM, np.zeros((1, 2)), "wrokspace", limits))).skipped == {
        "plot of an arm: it has no option 'wrokspace'"
    }


def test_axes_of_a_grid_take_the_place_of_those_beneath_them():
    grid = (number(2), number(1))
    axes = axes_of(("plot", (ROW,)), ("subplot", (*grid, number(1))), ("plot", (ROW,)), ("subplot", (*grid, number(2))))
    assert len(axes) == 2


def test_a_stem_has_its_color_and_marker_and_is_filled_if_asked_for():
    (axes,) = axes_of(("stem", (ROW, 2 * ROW, "r^", "filled")))
    markers = axes.containers[0].markerline
    assert (markers.get_color(), markers.get_marker(), markers.get_markerfacecolor()) == ("#d00000", "^", "#d00000")
    np.testing.assert_array_equal(markers.get_ydata(), [2, 4, 8])


def test_patches_of_vertices_in_space_are_in_space():
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 2.0]])
    (axes,) = axes_of(("patch", ("Vertices", corners, "Faces", np.array([[1, 2, 3], [1, 3, 4.0]]), "FaceColor", "c")))
    assert axes.name == "3d"
    assert axes.get_zlim()[1] >= 2.0


def test_arrows_with_nothing_among_them_are_drawn():
    (axes,) = axes_of(("quiver", (ROW, ROW, np.array([[1.0, np.nan, 2.0]]), ROW)))
    assert np.nanmax(axes.collections[0].U) > 0.0


def test_bars_have_the_width_and_histograms_the_centres_that_are_given():
    (axes,) = axes_of(("bar", (ROW, number(0.4))))
    assert [bar.get_width() for bar in axes.patches] == pytest.approx([0.4, 0.4, 0.4])
    (axes,) = axes_of(("hist", (np.array([[1, 2, 2, 3, 3, 9.0]]), np.array([[1, 2, 3.0]]), number(1))))
    assert [bar.get_height() for bar in axes.patches] == pytest.approx([1 / 6, 2 / 6, 3 / 6])


def test_a_second_scale_has_the_second_color():
    left, right = axes_of(("yyaxis", ("left",)), ("plot", (ROW,)), ("yyaxis", ("right",)), ("plot", (ROW,)))
    assert (left.lines[0].get_color(), right.lines[0].get_color()) == ("#0072bd", "#d95319")


def test_texts_arrows_and_ellipses_stand_over_the_figure():
    figures = drawn(
        ("annotation", ("textbox", np.array([[0.1, 0.2, 0.3, 0.1]]), "String", "note")),
        ("annotation", ("arrow", np.array([[0.2, 0.5]]), np.array([[0.3, 0.6]]))),
    )
    assert figures.skipped == set()
    assert [text.get_text() for text in figures.figure(1).texts] == ["note"]
    assert len(figures.figure(1).artists) == 2


def test_a_rectangle_of_full_curvature_is_an_ellipse():
    (axes,) = axes_of(("rectangle", ("Position", np.array([[0, 0, 4, 2.0]]), "Curvature", np.array([[1, 1.0]]))))
    assert (axes.patches[0].width, axes.patches[0].height) == (4.0, 2.0)


def test_lines_of_equal_damping_have_their_angle():
    axes = axes_of(("plot", (-ROW, ROW)), ("sgrid", ()))[0]
    slopes = {round(float(line.get_ydata()[1] / -line.get_xdata()[1]), 3) for line in axes.lines[1:3]}
    assert slopes == {round(np.sqrt(1 - 0.04) / 0.2, 3), -round(np.sqrt(1 - 0.04) / 0.2, 3)}


def test_formats_of_octave_have_names_and_texts_have_fonts():
    assert line_format("k--;asymptotes;") == {"label": "asymptotes", "color": "black", "linestyle": "--"}
    assert math_text(r"\fontsize{14}big {\bf bold} \color{red}red") == "big bold red"
    assert line_format("a;b") is None


def test_tick_labels_have_symbols_and_none_leaves_none():
    labels = ["0", r"\pi/2", r"\pi"]
    (axes,) = axes_of(("plot", (ROW,)), ("xticks", (ROW,)), ("xticklabels", (labels,)))
    assert [tick.get_text() for tick in axes.get_xticklabels()] == ["0", r"$\pi$/2", r"$\pi$"]
    (axes,) = axes_of(("plot", (ROW,)), ("xticklabels", (np.zeros((0, 0)),)))
    assert {tick.get_text() for tick in axes.get_xticklabels()} == {""}
