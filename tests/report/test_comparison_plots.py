"""What the plots of comparisons show, as numbers."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from mjsim.plan import GROUPS
from mjsim.report import comparison_plots
from mjsim.report.comparison import Compared, Comparison, Group, Series, Spread
from mjsim.report.figures import FIGURES
from mjsim.report.html_page import Heading
from mjsim.report.over_time import mean_of, middle_of, on_one_clock, shared_seed
from mjsim.report.paired import Difference
from mjsim.report.report_page import _arm_blocks, _times
from tests.report.test_plots import WORLD, lines, text


def series(scale=1.0, *, end=10.0, path=True):
    time = np.linspace(0.0, end, 11)
    points = np.column_stack([time, np.zeros(11)])
    return Series(
        time=time, position_error_m=scale * time, nees=np.full(11, scale),
        truth=points if path else None, estimate=points + scale if path else None, world=WORLD,
    )  # fmt: skip


def group(label, runs, *, no_nees="", errors=()):
    values = {figure.key: {} for figure in FIGURES} | {"position_error_m.mean": dict(enumerate(errors))}
    spread = Spread(count=3, mean=2.0, median=2.0, std=1.0, low=None, high=None)
    spreads = {figure.key: spread for figure in FIGURES}
    return Group(label=label, robot="r", values=values, spreads=spreads, failed=(), series=runs, no_nees=no_nees)


def test_runs_are_put_on_the_clock_of_the_longest():
    curves = [(np.arange(11.0), np.arange(11.0)), (np.arange(11.0) / 2, 1.5 * np.arange(11.0))]
    time, values = on_one_clock(curves)
    np.testing.assert_allclose(time, np.arange(11.0))
    np.testing.assert_allclose(values[1][:6], 3.0 * np.arange(6))
    assert np.isnan(values[1][6:]).all()
    np.testing.assert_allclose(mean_of(curves)[1], [*(2.0 * np.arange(6)), *np.arange(6.0, 11.0)])
    _, (low, middle, high) = middle_of([(np.arange(4.0), np.full(4, float(k))) for k in range(1, 6)])
    assert (low[3], middle[3], high[3]) == pytest.approx((1.2, 3.0, 4.8))
    _, (low, _, high) = middle_of([(np.arange(4.0), np.full(4, float(k))) for k in range(1, 6)], share=0.5)
    assert (low[3], high[3]) == pytest.approx((2.0, 4.0))
    assert on_one_clock([])[1].shape == (0, 0)


def test_the_shared_seed_is_the_first_that_most_groups_have():
    with_paths = [group("a", {7: series(), 3: series()}), group("b", {7: series(), 5: series(), 3: series(path=False)})]
    assert shared_seed(with_paths) == 7
    assert shared_seed([group("a", {7: series(), 3: series()})]) == 3
    assert shared_seed([group("a", {1: series(path=False)})]) is None


def test_errors_and_nees_of_groups_are_drawn_over_time():
    many = {seed: series(float(seed + 1)) for seed in range(5)}
    told = Comparison(groups=(group("one_$", {0: series(2.0)}), group("many", many)), differences=(), remarks=())
    (axes,) = comparison_plots.error_plot(told).axes
    drawn = lines(axes)
    np.testing.assert_allclose(drawn[r"one_\$"][:, 1], 2.0 * np.arange(11))
    np.testing.assert_allclose(drawn["many: median of 5, nine of ten"][:, 1], 3.0 * np.arange(11))
    shade = axes.collections[0].get_paths()[0].vertices
    assert shade[:, 1].max() == pytest.approx(48.0)
    assert text(axes) == ("Localization error, not aligned", "time [s]", "position error [m]")
    assert [line.get_color() for line in axes.lines] == [GROUPS[0], GROUPS[1]]
    assert [line.get_linewidth() for line in axes.lines] == [2.4, 1.0]
    assert axes.get_ylim()[0] == 0.0
    (axes,) = comparison_plots.nees_plot(told).axes
    drawn = lines(axes)
    assert drawn["many"][:, 1].tolist() == [3.0] * 11
    assert drawn[r"one_\$"][:, 1].tolist() == [2.0] * 11
    low, high = stats.chi2.ppf((0.025, 0.975), 3 * 5) / 5
    assert (axes.patches[0].get_y(), axes.patches[0].get_height()) == pytest.approx((low, high - low))
    assert text(axes) == ("Consistency, averaged over up to 5 runs", "time [s]", "NEES")
    silent = replace(told, groups=(group("a", {0: series()}), group("b", {0: series()}, no_nees="no estimator")))
    (axes,) = comparison_plots.nees_plot(silent).axes
    assert text(axes)[0] == "Consistency, one run each"
    assert {"a"} == {"a", "b"} & set(lines(axes))
    empty = Comparison(groups=(group("a", {}),), differences=(), remarks=())
    assert [draw(empty) for _, draw in comparison_plots.PLOTS] == [None] * 5


def test_a_few_runs_are_drawn_each_with_one_label():
    told = Comparison(groups=(group("few", {0: series(1.0), 1: series(2.0)}),), differences=(), remarks=())
    (axes,) = comparison_plots.error_plot(told).axes
    assert len(axes.lines) == 2
    assert axes.get_legend_handles_labels()[1] == ["few"]
    assert axes.lines[0].get_linewidth() == 1.4


def test_paths_of_a_shared_truth_are_drawn_over_it_and_others_each_with_its_own():
    other = replace(series(2.0), truth=series().truth + 1.0)
    same = Comparison(groups=(group("a", {4: series(1.0)}), group("b", {4: series(2.0)})), differences=(), remarks=())
    (axes,) = comparison_plots.path_plot(same).axes
    drawn = lines(axes)
    np.testing.assert_allclose(drawn["truth"], series().truth)
    np.testing.assert_allclose(drawn["b"], series().truth + 2.0)
    assert text(axes) == ("Paths of seed 4, not aligned", "x [m]", "y [m]")
    own = replace(same, groups=(group("a", {4: series(1.0)}), group("b", {4: other}), group("c", {5: series()})))
    (axes,) = comparison_plots.path_plot(own).axes
    drawn = lines(axes)
    assert "truth" not in drawn
    np.testing.assert_allclose(drawn["b: truth"], series().truth + 1.0)
    assert "a: truth" in drawn
    assert "c" not in drawn
    unseen = replace(same, groups=(group("a", {4: series(1.0)}), group("b", {4: series(path=False)})))
    assert "b" not in lines(comparison_plots.path_plot(unseen).axes[0])


def test_boxes_hold_the_middle_half_of_five_runs_or_more():
    values = [1.0, 2.0, 3.0, 4.0, 10.0]
    told = Comparison(
        groups=(group("a", {}, errors=values), group("b", {}), group("c", {}, errors=values[:2])),
        differences=(),
        remarks=(),
    )
    drawing = comparison_plots.box_plot(told)
    (axes,) = drawing.axes
    assert [tick.get_text() for tick in axes.get_yticklabels()] == ["a", "b", "c"]
    box = axes.patches[0].get_path().vertices
    assert (box[:, 0].min(), box[:, 0].max()) == (2.0, 4.0)
    dots = [line for line in axes.lines if line.get_marker() == "."]
    assert [dot.get_xdata().tolist() for dot in dots] == [values, values[:2]]
    assert all(np.abs(dot.get_ydata() - row).max() <= 0.16 for dot, row in zip(dots, (0, 2), strict=True))
    assert dots[1].get_color() == GROUPS[2]
    assert axes.get_ylim() == pytest.approx((2.6, -0.6))
    assert axes.get_xlabel() == next(figure.heading for figure in FIGURES if figure.key == "position_error_m.mean")
    assert drawing.get_figheight() == pytest.approx(0.9 + 0.6 + 0.32 * 3)
    assert comparison_plots.box_plot(replace(told, groups=told.groups[1:])) is None


def test_differences_are_drawn_in_per_cent_of_the_first():
    error = next(figure for figure in FIGURES if figure.key == "position_error_m.mean")
    unitless = next(figure for figure in FIGURES if not (figure.better and figure.unit))

    def item(first, second, mean, verdict, figure=error, half=0.5):
        bounds = (None, None) if half is None else (mean - half, mean + half)
        told = Difference(
            pairs=8, mean=mean, low=bounds[0], high=bounds[1], confidence=0.95, verdict=verdict, reason=""
        )
        return Compared(figure=figure, first=first, second=second, difference=told)

    better = item("a", "b", -1.0, "second")
    assert (better.better, better.worse, better.size) == ("b", "a", "1 [0.5, 1.5] m")
    assert better.sentence == f"b is better than a in {error.title}: by 1 [0.5, 1.5] m, 8 pairs"
    worse = item("a", "b", 1.0, "first")
    assert (worse.better, worse.worse, worse.size) == ("a", "b", "1 [0.5, 1.5] m")
    groups = tuple(group(name, {}) for name in "abc")
    given = (
        item("a", "b", 1.0, "first"), item("a", "b", -1.0, "second"), item("a", "c", 0.2, ""),
        item("b", "c", 1.0, "", unitless), item("b", "c", 1.0, "", half=None),
    )  # fmt: skip
    drawing = comparison_plots.difference_plot(Comparison(groups=groups, differences=given, remarks=()))
    above, below = drawing.axes
    assert (above.get_title(), below.get_title()) == ("b less a", "c less a")
    zero, first, first_dot, second, _ = above.lines
    assert zero.get_xdata() == [0.0, 0.0]
    assert np.column_stack(first.get_data()).tolist() == [[25.0, 0.0], [75.0, 0.0]]
    assert (first_dot.get_xdata().item(), first_dot.get_ydata().item()) == (50.0, 0)
    assert np.column_stack(second.get_data()).tolist() == [[-75.0, 1.0], [-25.0, 1.0]]
    assert [first.get_color(), second.get_color(), below.lines[1].get_color()] == [GROUPS[0], GROUPS[1], "#888888"]
    assert above.get_ylim() == pytest.approx((1.6, -0.6))
    assert [tick.get_text() for tick in above.get_yticklabels()] == [error.title] * 2
    assert "% of the first's mean" in below.get_xlabel()
    assert drawing.get_figheight() == pytest.approx(0.3 + 2 * 0.95 + 3 * 0.26)


def test_blocks_of_a_page_name_what_they_show():
    blocks = list(_arm_blocks("scout", {"arm": {"joints": b"1", "tool": b"2"}}))
    assert blocks[0] == Heading("scout/arm")
    assert [each.title for each in blocks[1:]] == ["joints of scout/arm", "tool of scout/arm"]
    costs = {"a": {"mean": 1.0, "p99": 2.0}, "b": {"mean": 3.0, "p99": 4.0}}
    heading, table = _times({"milliseconds": costs})
    assert list(table.rows) == [("b", "3.000", "4.000"), ("a", "1.000", "2.000")]
    assert heading.text == "Wall-clock time per tick"
    assert list(_times({"milliseconds": {}})) == []
