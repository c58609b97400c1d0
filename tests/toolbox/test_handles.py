"""What handles name: fields of them, legends of some lines, points that are added, and what no picture shows."""

import numpy as np
import pytest

from mjsim.toolbox.calls import FigureCall
from mjsim.toolbox.draw import ScriptFigures
from mjsim.toolbox.drawing_functions import FUNCTIONS
from mjsim.toolbox.figure_names import DRAWN, FIGURE_FUNCTIONS, INTERACTIVE
from mjsim.toolbox.handle_fields import without_fields
from mjsim.toolbox.marks import math_text

ROW = np.array([[1.0, 2.0, 4.0]])
ONE, TWO = np.array([[1.0]]), np.array([[2.0]])


def drawn(*calls: tuple[str, tuple[object, ...]]) -> ScriptFigures:
    figures = ScriptFigures()
    numbered = enumerate(calls, start=1)
    figures.draw([FigureCall(name, given, 1, number) for number, (name, given) in numbered], FUNCTIONS)
    return figures


def test_every_function_of_the_list_is_drawn_or_said_not_to_be():
    without = {"close", "closereq", "set"}
    assert set(DRAWN) - set(FUNCTIONS) <= without
    assert len(set(FIGURE_FUNCTIONS)) == len(FIGURE_FUNCTIONS)
    assert not set(INTERACTIVE) & set(FIGURE_FUNCTIONS)
    assert drawn(("pareto", (ROW,))).skipped == {"pareto is left out"}


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("h = plot(x); h.LineWidth = 3; % h.Color = 2", "h = plot(x); set(h, 'LineWidth', 3); % h.Color = 2"),
        ("ax(1) = gca; ax(1).XLim = [0, 2], y = 3", "ax(1) = gca; set(ax(1), 'XLim', [0, 2]), y = 3"),
        ("a = axes; a.Title.String = 'x; y'; w = a.XLim;", "a = axes; title(a, 'x; y'); w = get(a, 'XLim');"),
        ("f = figure; f.Position(3:4) = [8 6];", "f = figure; set(f, 'Position', []);"),
        ("l = plot(x); if l.LineWidth == 2, s.LineWidth = 1; end", None),
        ("s.Color = 2; disp('h.Color = 3')", "s.Color = 2; disp('h.Color = 3')"),
    ],
)
def test_fields_of_handles_are_calls_and_fields_of_structs_stay(line, expected):
    expected = expected or "l = plot(x); if get(l, 'LineWidth') == 2, s.LineWidth = 1; end"
    assert without_fields(line) == expected


def test_a_legend_names_the_handles_that_it_is_given_and_may_stand_outside():
    handles = np.array([[1.0, 3.0]])
    words = (handles, ["first", "third"], "Location", "EastOutside", "Orientation", "vertical", "FontSize", 8 * ONE)
    figures = drawn(("plot", (ROW,)), ("hold", ("on",)), ("plot", (2 * ROW,)), ("legend", words))
    figures = drawn(("plot", (ROW,)), ("hold", ("on",)), ("plot", (2 * ROW, "r")), ("legend", words))
    (axes,) = figures.figure(1).axes
    legend = axes.get_legend()
    assert [text.get_text() for text in legend.get_texts()] == ["first", "third"]
    assert legend.get_lines()[1].get_color() == axes.lines[1].get_color()
    assert legend.get_bbox_to_anchor().x0 > axes.bbox.x1


def test_a_legend_without_names_counts_the_lines_that_have_none():
    (axes,) = drawn(("plot", (ROW, ROW, ROW, 2 * ROW)), ("legend", ("show",))).figure(1).axes
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["data1", "data2"]


def test_points_are_added_to_a_line_and_cells_of_values_go_to_its_handles():
    added = [("addpoints", (ONE, k * ONE, 2 * k * ONE)) for k in (1.0, 2.0)]
    (axes,) = drawn(("animatedline", ("Color", "r")), *added).figure(1).axes
    np.testing.assert_array_equal(axes.lines[0].get_data(), [[1, 2], [2, 4]])
    lines = np.array([[1.0], [1.0 + 2.0**-20]])
    given = (lines, ["LineWidth"], [ONE, 3 * ONE])
    (axes,) = drawn(("plot", (ROW, ROW, ROW, 2 * ROW)), ("set", given)).figure(1).axes
    assert [line.get_linewidth() for line in axes.lines] == [1.0, 3.0]


def test_arrows_bars_and_levels_are_those_of_their_arguments():
    (axes,) = drawn(("bar", (np.array([[1.0, 2.0], [3.0, 4.0]]), "stacked"))).figure(1).axes
    assert [(bar.get_y(), bar.get_height()) for bar in axes.patches] == [(0, 1), (0, 3), (1, 2), (3, 4)]
    (axes,) = drawn(("quiver", (ROW, 0 * ROW, ROW, ROW, 0 * ONE))).figure(1).axes
    np.testing.assert_array_equal(axes.collections[0].U, ROW[0])
    z = np.add.outer(np.arange(4.0), np.arange(5.0))
    (axes,) = drawn(("contour", (z, np.array([[1.0, 2.5]]), "k"))).figure(1).axes
    np.testing.assert_array_equal(axes.collections[0].levels, [1.0, 2.5])
    (axes,) = (
        drawn(("fill", (np.array([[0.0, 1, 1, 0]]), np.array([[0.0, 0, 1, 1]]), 0.5 * np.ones((1, 3))))).figure(1).axes
    )
    assert axes.patches[0].get_facecolor()[:3] == (0.5, 0.5, 0.5)


def test_texts_stand_at_each_point_and_take_no_room_from_the_axes():
    (axes,) = drawn(("text", (ROW, ROW, ["a", "b", "c"], "BackgroundColor", "y"))).figure(1).axes
    assert [(text.get_text(), text.get_position()) for text in axes.texts] == [
        ("a", (1, 1)),
        ("b", (2, 2)),
        ("c", (4, 4)),
    ]
    assert not any(text.get_in_layout() for text in axes.texts)


def test_symbols_beside_letters_without_mathematics_are_letters_and_bad_latex_is_plain():
    assert math_text(r"关节角 \theta_1 [rad], x^{2}") == "关节角 θ₁ [rad], x²"
    assert math_text(r"$\foo{x}$ [m]") == "foo{x} [m]"
    assert math_text(r"$\ddot{q}$") == r"$\ddot{q}$"


def test_names_and_formats_of_a_script_are_kept():
    calls = [
        ("plot", (ROW,)),
        ("print", ("-depsc2", "a")),
        ("print", ("-dpng", "-r300", "b")),
        ("saveas", (ONE, "c", "epsc")),
    ]
    assert drawn(*calls, ("saveas", (ONE, "d.svg"))).files == [(1, "a.eps"), (1, "b.png"), (1, "c.eps"), (1, "d.svg")]


def test_labels_of_axes_are_handles_and_bounds_without_end_follow_the_data():
    figures = drawn(
        ("plot", (ROW,)),
        ("gca", ()),
        ("label_of", (np.array([[2.0 + 2.0**-13]]), "ylabel")),
        ("set", (np.array([[3.0]]), "String", "q_2")),
        ("axis", (np.array([[0.0, np.inf, -np.inf, 7.0]]),)),
    )
    (axes,) = figures.figure(1).axes
    assert axes.get_ylabel() == "q$\\mathregular{_{2}}$"
    assert (axes.get_xlim()[0], axes.get_ylim()[1]) == (0.0, 7.0)
    assert axes.get_xlim()[1] == pytest.approx(3.1)
    assert not figures.skipped


def test_filled_levels_have_labelled_edges_and_a_mesh_hides_what_is_behind_it():
    x, y = np.meshgrid(np.linspace(-2, 2, 9), np.linspace(-2, 2, 9))
    z = x * np.exp(-x * x - y * y)
    figures = drawn(("contourf", (x, y, z, 6 * ONE)), ("clabel", (np.array([[1.0]]),)), ("colorbar", ()))
    filled, edges = figures.figure(1).axes[0].collections
    assert len(edges.labelTexts) > 0
    assert filled.get_paths()[0].vertices.size > 0
    bar = figures.figure(1).axes[1]
    assert tuple(bar.get_ylim()) == (filled.levels[0], filled.levels[-1])
    figures = drawn(("mesh", (x, y, z)), ("colorbar", ()))
    (made,) = figures.figure(1).axes[0].collections
    assert len(np.unique(made.get_edgecolor(), axis=0)) > 10
    assert len(figures.figure(1).axes) == 2


def test_a_legend_may_stand_at_a_place_that_is_a_number():
    figures = drawn(("plot", (ROW,)), ("legend", ("one", 4 * ONE)))
    legend = figures.figure(1).axes[0].get_legend()
    assert [text.get_text() for text in legend.get_texts()] == ["one"]
    assert legend._loc == 4


def test_a_norm_has_its_bars():
    assert math_text(r"\|e\|") == "\N{DOUBLE VERTICAL LINE}e\N{DOUBLE VERTICAL LINE}"
