"""Recorded calls are drawn with the data and the properties that MATLAB sees in their arguments."""

import numpy as np
import pytest

from mjsim.toolbox.calls import FigureCall
from mjsim.toolbox.draw import ScriptFigures
from mjsim.toolbox.drawing_functions import FUNCTIONS
from mjsim.toolbox.local_functions import apart
from mjsim.toolbox.marks import _value

ROW = np.array([[1.0, 2.0, 4.0]])
TWO = np.array([[2.0]])


def drawn(*calls: tuple[str, tuple[object, ...]]) -> ScriptFigures:
    figures = ScriptFigures()
    numbered = enumerate(calls, start=1)
    figures.draw([FigureCall(name, given, 1, number) for number, (name, given) in numbered], FUNCTIONS)
    assert figures.skipped == set()
    return figures


def test_values_of_properties_are_no_data():
    figures = drawn(("line", (ROW, ROW, "LineWidth", TWO)), ("bar", (ROW, "FaceColor", ROW)))
    (axes,) = figures.figure(1).axes
    assert axes.name != "3d"
    assert [bar.get_height() for bar in axes.patches] == [1.0, 2.0, 4.0]


def test_a_figure_of_the_number_of_a_handle_leaves_the_handle():
    figures = ScriptFigures()
    calls = [("plot", (ROW,), 1, 2), ("figure", (TWO,), 2, 2), ("set", (TWO, "LineWidth", 3 * TWO), 2, 3)]
    figures.draw([FigureCall(*call) for call in calls], FUNCTIONS)
    (line,) = figures.figure(1).axes[0].lines
    assert line.get_linewidth() == 6.0


def test_a_text_stands_where_it_is_put_in_the_plane_and_in_space():
    (flat,) = drawn(("text", (TWO, 3 * TWO, "here"))).figure(1).axes[0].texts
    assert (flat.get_position(), flat.get_text()) == ((2.0, 6.0), "here")
    (deep,) = drawn(("plot3", (ROW, ROW, ROW)), ("text", (TWO, TWO, 2 * TWO, "there"))).figure(1).axes[0].texts
    assert deep.get_position_3d() == (2.0, 2.0, 4.0)


def test_data_set_on_a_handle_move_its_line_of_several():
    first, second = np.array([[1.0], [1.0 + 2.0**-20]])
    calls = [
        ("plot", (TWO, TWO, "b", TWO, TWO, "r")),
        ("set", (first + 0.0, "xdata", ROW)),
        ("set", (second, "xdata", TWO)),
    ]
    figures = drawn(*calls, ("set", (first, "ydata", 2 * ROW)))
    one, two = figures.figure(1).axes[0].lines
    np.testing.assert_array_equal(one.get_data(), [[1, 2, 4], [2, 4, 8]])
    np.testing.assert_array_equal(two.get_xdata(), [2])
    assert figures.figure(1).axes[0].dataLim.x1 == 4.0


def test_a_handle_of_axes_before_the_arguments_chooses_them():
    grid = (np.array([[2.0]]), np.array([[1.0]]))
    handle = np.array([[1.0 + 2.0**-13]])
    upper, lower = (
        drawn(
            ("subplot", (*grid, np.array([[1.0]]))),
            ("subplot", (*grid, TWO)),
            ("plot", (handle, ROW)),
            ("title", (handle, "above")),
            ("set", (handle, "XTick", ROW, "YScale", "log")),
        )
        .figure(1)
        .axes
    )
    assert (upper.get_title(), len(upper.lines), len(lower.lines)) == ("above", 1, 0)
    assert upper.get_yscale() == "log"
    np.testing.assert_array_equal(upper.get_xticks(), [1, 2, 4])


def test_an_image_begins_at_its_upper_left_unless_axes_are_turned():
    image = np.arange(6.0).reshape(2, 3)
    (axes,) = drawn(("imagesc", (image,))).figure(1).axes
    assert axes.get_xlim() == (0.5, 3.5)
    assert axes.get_ylim() == (2.5, 0.5)
    (turned,) = drawn(("imagesc", (image,)), ("axis", ("xy",))).figure(1).axes
    assert turned.get_ylim() == (0.5, 2.5)


def test_points_have_areas_and_bars_their_spacing():
    (axes,) = drawn(("scatter", (ROW, ROW, 10 * ROW, "filled"))).figure(1).axes
    np.testing.assert_array_equal(axes.collections[0].get_sizes(), [10, 20, 40])
    (axes,) = drawn(("bar", (0.1 * ROW, ROW))).figure(1).axes
    assert axes.patches[0].get_width() == pytest.approx(0.08)


def test_shapes_have_faces_and_rectangles_their_place():
    square = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
    words = ("Faces", np.array([[1.0, 2, 3], [1, 3, 4]]), "Vertices", square, "FaceColor", "y")
    (axes,) = drawn(("patch", words)).figure(1).axes
    assert len(axes.patches) == 2
    (axes,) = drawn(("rectangle", ("Position", np.array([1.0, 2, 3, 4]), "EdgeColor", "r"))).figure(1).axes
    assert axes.dataLim.extents.tolist() == [1, 2, 4, 6]


def test_a_second_scale_shares_the_time():
    left, right = (
        drawn(("yyaxis", ("left",)), ("plot", (ROW,)), ("yyaxis", ("right",)), ("plot", (9 * ROW,))).figure(1).axes
    )
    assert left.get_shared_x_axes().joined(left, right)
    assert (len(left.lines), len(right.lines)) == (1, 1)


def test_functions_of_a_script_come_apart_on_their_lines():
    own, functions = apart("a = f(1);\nif a(end), b = 'end'; end % end\nfunction y = f(x)\n  y = x;\nend\n")
    assert own == "a = f(1);\nif a(end), b = 'end'; end % end\n\n\n\n"
    assert functions == {"f": "\n\nfunction y = f(x)\n  y = x;\nend"}
    first = "function g()\n  for k = 1:3, disp(k'), end\nendfunction\ng()\n"
    assert apart(first) == ("\n\n\ng()\n", {"g": "function g()\n  for k = 1:3, disp(k'), end\nendfunction"})
    assert apart("function h\nx = 1;\n") == ("function h\nx = 1;\n", {})


def test_colours_are_hexadecimal_none_or_have_a_name():
    known = ["none", "#a1B2c3", "#a1B2c", "nonsense", "b#a1B2c3"]
    assert [_value("color", each) for each in known] == ["none", "#a1B2c3", None, None, None]
    assert _value("facecolor", np.array([0.2, 2.0, -1.0])) == [0.2, 1.0, 0.0]
