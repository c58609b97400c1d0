"""Recorded calls are drawn with the data and the properties that MATLAB sees in their arguments."""

import numpy as np

from mjsim.toolbox.calls import FigureCall
from mjsim.toolbox.draw import ScriptFigures
from mjsim.toolbox.drawing_functions import FUNCTIONS

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
