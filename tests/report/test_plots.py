"""What the plots of reports, comparisons and mechanisms show: lines, units, bands and labels, as numbers."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats

from mjsim.geometry import wrap_angle
from mjsim.record import JointTrack, Landmarks, RobotEvent, SensorTrack, Track
from mjsim.report import arm_plots, mechanism_plots, plots
from mjsim.report.arm_statistics import arm_figures
from mjsim.report.labels import setting_labels
from mjsim.report.report_page import _page
from mjsim.world import parse_world

N = 90
WORLD = parse_world("mjsim: 1\nwalls: [{points: [[-4, -4], [4, -4], [4, 4], [-4, 4]], closed: true}]\n")


def lines(axes):
    """Return the drawn lines by label; those without one by their number."""
    return {line.get_label(): np.column_stack(line.get_data()) for line in axes.lines}


def text(axes):
    return axes.get_title() or axes.get_title(loc="left"), axes.get_xlabel(), axes.get_ylabel()


def legend(axes):
    return [each.get_text() for each in axes.get_legend().get_texts()]


@pytest.fixture(scope="module")
def track():
    rng = np.random.default_rng(0)
    time = 0.1 * np.arange(N)
    truth = np.column_stack([np.cos(time), np.sin(time), time + np.pi / 2 - 2 * np.pi])
    estimate = truth + rng.normal(size=(N, 3)) * [0.1, 0.2, 0.05] + [0.0, 0.0, 2 * np.pi]
    mean, P = np.array([[[1.0, 2.0], [np.nan, np.nan], [-1.0, 0.5]]]), np.tile(np.diag([0.04, 0.01]), (1, 3, 1, 1))
    innovations = tuple((("a", np.array([0.2, 0.1]), np.diag([0.04, 0.05])),) if k % 2 else () for k in range(N))
    return Track(
        time=time,
        truth=truth,
        truth_pose=np.zeros((N, 7)),
        odometry=truth + 0.5,
        odometry_covariance=np.zeros((N, 3, 3)),
        estimate=estimate,
        covariance=np.tile(np.diag([0.01, 0.04, 0.0025]), (N, 1, 1)),
        command=np.zeros((N, 3)),
        landmarks=Landmarks(names=("a", "b", "c"), mean=mean, covariance=P),
        sightings=((),) * N,
        innovations=innovations,
        events=(
            RobotEvent(kind="bump", time=0.5, text=""),
            RobotEvent(kind="other", time=0.7, text=""),
        ),
        path=np.array([[0.0, 7.0, 8.0, 0.0], [1.0, 9.0, 6.0, 0.0]]),
    )


def test_paths_are_drawn_in_the_plan_with_ellipses_and_map(track):
    (axes,) = plots.path_plot(WORLD, track, "Ekf").axes
    drawn = lines(axes)
    np.testing.assert_array_equal(drawn["odometry"], track.odometry[:, :2])
    np.testing.assert_array_equal(drawn["truth"], track.truth[:, :2])
    np.testing.assert_array_equal(drawn["Ekf"], track.estimate[:, :2])
    np.testing.assert_array_equal(drawn["final path"], [[7.0, 8.0], [9.0, 6.0]])
    np.testing.assert_array_equal(drawn["landmarks"], [[1.0, 2.0], [-1.0, 0.5]])
    assert legend(axes)[-5:] == ["odometry", "truth", "Ekf", "final path", "landmarks"]
    of_poses, of_map = axes.collections[-2:]
    assert len(of_poses.get_paths()) == 45  # each second pose
    assert len(of_map.get_paths()) == 2
    # 95 % of two freedoms.
    edge = of_map.get_paths()[0].vertices - [1.0, 2.0]
    radius = np.sqrt(stats.chi2.ppf(0.95, 2))
    np.testing.assert_allclose(np.hypot(edge[:, 0] / 0.2, edge[:, 1] / 0.1), radius, rtol=1e-6)
    third = of_poses.get_paths()[2].vertices
    np.testing.assert_allclose((third.max(axis=0) + third.min(axis=0)) / 2, track.estimate[4, :2], atol=0.01)
    figure, (larger,) = plots.sheet(1, height=2.0)
    plots.draw_map(larger, track, larger=3.0)
    wide = larger.collections[0].get_paths()[0].vertices
    assert np.ptp(wide[:, 0]) == pytest.approx(6 * 0.2 * radius, rel=0.01)
    unmapped = replace(
        track, landmarks=replace(track.landmarks, mean=np.full((1, 3, 2), np.nan)), path=np.zeros((0, 4))
    )
    (axes,) = plots.path_plot(WORLD, unmapped, "Ekf").axes
    assert not {"landmarks", "final path"} & set(lines(axes))
    assert figure.get_size_inches().tolist() == [9.6, 2.0]


def test_errors_are_drawn_between_three_deviations_and_headings_in_degrees(track):
    panels = plots.error_plot(WORLD, track, "Ekf").axes
    assert [axes.get_ylabel() for axes in panels] == ["x error [m]", "y error [m]", "heading error [deg]"]
    assert panels[-1].get_xlabel() == "time [s]"
    assert legend(panels[0]) == ["3-sigma bounds", "Ekf - truth"]
    bounds = (0.3, 0.6, np.degrees(0.15))
    for axes, column, bound, scale in zip(panels, range(3), bounds, (1, 1, 180 / np.pi), strict=True):
        off = track.estimate[:, column] - track.truth[:, column]
        off = [wrap_angle(each) for each in off] if column == 2 else off
        drawn = lines(axes)["Ekf - truth"]
        np.testing.assert_allclose(drawn[:, 0], track.time)
        np.testing.assert_allclose(drawn[:, 1], np.multiply(off, scale), atol=1e-9)
        shade = axes.collections[0].get_paths()[0].vertices
        assert (shade[:, 1].min(), shade[:, 1].max()) == pytest.approx((-bound, bound))
        assert any(not np.any(line.get_ydata()) for line in axes.lines)


def test_distances_are_drawn_with_the_bumps(track):
    (axes,) = plots.distance_plot(WORLD, track, "Ekf").axes
    drawn = lines(axes)
    np.testing.assert_allclose(drawn["odometry"][:, 1], np.sqrt(0.5))
    off = track.estimate - track.truth
    np.testing.assert_allclose(drawn["Ekf"], np.column_stack([track.time, np.sqrt(off[:, 0] ** 2 + off[:, 1] ** 2)]))
    np.testing.assert_array_equal(drawn["bump"], [[0.5, 0.0]])
    assert text(axes) == ("Localization error, not aligned", "time [s]", "position error [m]")
    assert axes.get_ylim()[0] == 0.0
    assert legend(axes) == ["odometry", "Ekf", "bump"]
    (axes,) = plots.distance_plot(WORLD, replace(track, events=()), "Ekf").axes
    assert legend(axes) == ["odometry", "Ekf"]


def test_nees_and_nis_are_drawn_with_their_bands(track):
    above, below = plots.nees_plot(WORLD, track, "Ekf").axes
    off = track.estimate - track.truth
    off[:, 2] -= 2 * np.pi
    nees = off[:, 0] ** 2 / 0.01 + off[:, 1] ** 2 / 0.04 + off[:, 2] ** 2 / 0.0025
    np.testing.assert_allclose(lines(above)["NEES of x, y, heading"], np.column_stack([track.time, nees]))
    odd = lines(below)["NIS of a sighting"]
    np.testing.assert_allclose(odd[:, 0], track.time[1::2])
    np.testing.assert_allclose(odd[:, 1], 0.2**2 / 0.04 + 0.1**2 / 0.05)
    for axes, freedom in ((above, 3), (below, 2)):
        low, high = stats.chi2.ppf((0.025, 0.975), freedom)
        assert f"95 % band, {low:.2f} to {high:.2f}" in legend(axes)
        assert lines(axes)[f"expected, {freedom}"][:, 1].tolist() == [freedom, freedom]
        (band,) = axes.patches
        assert (band.get_y(), band.get_y() + band.get_height()) == pytest.approx((low, high))
        assert axes.get_yscale() == "symlog"
        assert axes.get_ylim()[0] == 0.0
        assert axes.get_ylim()[1] >= 12.0
        assert axes.get_yticks()[:4].tolist() == [0, 1, 3, 10]
        assert max(axes.get_yticks()) <= axes.get_ylim()[1]
    assert (text(above)[0], above.get_ylabel(), below.get_ylabel(), below.get_xlabel()) == (
        "Consistency of Ekf", "NEES", "NIS", "time [s]",
    )  # fmt: skip
    alone = plots.nees_plot(WORLD, replace(track, innovations=((),) * N), "Ekf")
    assert len(alone.axes) == 1
    assert (alone.get_figheight(), alone.axes[0].get_xlabel()) == (3.6, "time [s]")


def joints(*, torque=2.0):
    time = 0.1 * np.arange(N)
    rows = np.column_stack([np.sin(time), 0.2 * np.cos(time)])
    known = rows.copy()
    known[0] = np.nan
    tool = np.column_stack([time, 2 * time, 1.0 - time, np.zeros((N, 4))])
    return time, JointTrack(
        names=("turn", "slide"), positions=known, velocities=2 * rows, accelerations=3 * rows, torques=torque * rows,
        goal=rows + 0.1, tool=tool,
    )  # fmt: skip


MIXED = np.array([False, True])


@pytest.mark.parametrize(
    ("draw", "words"),
    [
        (lambda time, part: arm_plots.arm_plots(time, part, MIXED), ("q", "qd", "qdd", "torque", "s^2")),
        (
            lambda time, part: mechanism_plots.mechanism_plots(time, part, MIXED, sensors(time)),
            ("position", "speed", "acceleration", "actuators", "s²"),
        ),
    ],
)
def test_joints_are_drawn_in_degrees_and_metres_where_they_are_known(draw, words):
    time, part = joints()
    panels = draw(time, part)["joints"].axes
    assert [axes.get_ylabel() for axes in panels] == [
        f"{words[0]} [deg, m]", f"{words[1]} [deg, m, per s]", f"{words[2]} [deg, m, per {words[4]}]",
        f"{words[3]} [N m, N]",
    ]  # fmt: skip
    assert text(panels[0])[0] == "Joints"
    assert panels[-1].get_xlabel() == "time [s]"
    assert legend(panels[0])[:2] == ["turn", "slide"]
    rows = (part.positions, part.velocities, part.accelerations, part.torques)
    for axes, values, scale in zip(panels, rows, (180 / np.pi,) * 3 + (1.0,), strict=True):
        np.testing.assert_allclose(lines(axes)["turn"], np.column_stack([time, values[:, 0] * scale])[1:])
        np.testing.assert_allclose(lines(axes)["slide"], np.column_stack([time, values[:, 1]])[1:])


def sensors(time):
    names = ("wheel.x", "wheel.y", "energy.kinetic", "energy.potential", "energy.work", "energy.lost", "scale.load")
    columns = [time, 2 * time, time**2, 5.0 - time, 3 * time, 0.5 * time, 7 * time]
    return SensorTrack(names=names, units=("m", "m", "J", "J", "J", "J", "m/s^2"), values=np.column_stack(columns))


def test_goals_of_an_arm_are_dotted_and_its_tool_is_drawn_in_space():
    time, part = joints()
    drawn = arm_plots.arm_plots(time, part, MIXED)
    assert list(drawn) == ["joints", "tool", "tool_path"]
    first = drawn["joints"].axes[0]
    goals = [np.column_stack(line.get_data()) for line in first.lines if line.get_linestyle() == ":"]
    np.testing.assert_allclose(goals[0][:, 1], np.degrees(part.goal[1:, 0]))
    np.testing.assert_allclose(goals[1][:, 1], part.goal[1:, 1])
    assert legend(first).count("goals") == 1
    panels = drawn["tool"].axes
    assert [axes.get_ylabel() for axes in panels] == ["X [m]", "Y [m]", "Z [m]"]
    for axes, column in zip(panels, part.tool.T, strict=False):
        np.testing.assert_allclose(axes.lines[0].get_ydata(), column[1:])
    assert (text(panels[0])[0], panels[-1].get_xlabel()) == ("Tool, world frame", "time [s]")
    (axes,) = drawn["tool_path"].axes
    shadow, path, start, end = (np.array(line.get_data_3d()).T for line in axes.lines)
    np.testing.assert_allclose(path, part.tool[1:, :3])
    np.testing.assert_allclose(start, part.tool[1:2, :3])
    np.testing.assert_allclose(end, part.tool[-1:, :3])
    middle = (part.tool[1, :3] + part.tool[-1, :3]) / 2
    half = 0.55 * 2 * 8.8 + 1e-3  # of the longest side
    for limits, center in zip((axes.get_xlim(), axes.get_ylim(), axes.get_zlim()), middle, strict=True):
        assert limits == pytest.approx((center - half, center + half))
    np.testing.assert_allclose(shadow[:, :2], part.tool[1:, :2])
    np.testing.assert_allclose(shadow[:, 2], middle[2] - half)
    assert (axes.get_title(), axes.get_xlabel(), axes.get_ylabel(), axes.get_zlabel()) == (
        "Path of the tool", "X [m]", "Y [m]", "Z [m]",
    )  # fmt: skip
    assert legend(axes) == ["tool", "start", "end"]


@pytest.mark.parametrize(("slides", "angle", "torque"), [([False, False], "deg", "N m"), ([True, True], "m", "N")])
def test_joints_of_one_kind_have_one_unit(slides, angle, torque):
    time, part = joints()
    for panels in (
        arm_plots.arm_plots(time, part, np.array(slides))["joints"].axes,
        mechanism_plots.mechanism_plots(time, part, np.array(slides), sensors(time))["joints"].axes,
    ):
        assert panels[0].get_ylabel().endswith(f" [{angle}]")
        assert panels[3].get_ylabel().endswith(f" [{torque}]")


def test_wheels_of_a_balancing_base_are_drawn_by_their_lag_rate_and_torque():
    time, part = joints()
    panels = arm_plots.drive_plots(time, part)["wheels"].axes
    assert [axes.get_ylabel() for axes in panels] == ["tracking error [deg]", "rate [deg/s]", "torque [N m]"]
    np.testing.assert_allclose(lines(panels[0])["turn"][:, 1], np.degrees(0.1))
    np.testing.assert_allclose(lines(panels[1])["slide"][:, 1], np.degrees(part.velocities[1:, 1]))
    np.testing.assert_allclose(lines(panels[2])["turn"], np.column_stack([time, part.torques[:, 0]])[1:])
    assert (text(panels[0])[0], panels[-1].get_xlabel()) == ("Wheels", "time [s]")
    assert legend(panels[0]) == ["turn", "slide"]


def test_of_joints_that_were_never_known_nothing_is_drawn():
    time, part = joints()
    unknown = replace(part, positions=np.full((N, 2), np.nan))
    assert arm_plots.arm_plots(time, unknown, MIXED) == {}
    assert arm_plots.drive_plots(time, unknown) == {}
    assert mechanism_plots.mechanism_plots(time, unknown, MIXED, sensors(time)) == {}
    nothing = arm_figures(replace(part, goal=np.full((N, 2), np.nan)))
    assert nothing == {"goal_error": None, "torque_max": None, "tool_distance_m": None}


def test_figures_of_an_arm_are_its_errors_torques_and_the_way_of_its_tool():
    _, part = joints()
    told = arm_figures(part)
    assert told["goal_error"]["turn"] == {"max": pytest.approx(0.1), "rms": pytest.approx(0.1)}
    assert told["torque_max"]["slide"] == pytest.approx(np.abs(part.torques[1:, 1]).max())
    assert told["tool_distance_m"] == pytest.approx(8.8 * np.sqrt(6.0))


def test_a_mechanism_has_phase_plots_sheets_of_its_sensors_and_the_balance_of_its_energy():
    time, part = joints()
    drawn = mechanism_plots.mechanism_plots(time, part, MIXED, sensors(time))
    assert list(drawn) == ["joints", "phase", "sensors_m", "sensors_m_per_s2", "energy"]
    turn, slide = drawn["phase"].axes
    assert text(turn) == ("turn", "[deg]", "[deg/s]")
    assert text(slide) == ("slide", "[m]", "[m/s]")
    pairs = np.degrees(np.column_stack([part.positions[:, 0], part.velocities[:, 0]]))[1:]
    np.testing.assert_allclose(np.column_stack(turn.lines[0].get_data()), pairs)
    np.testing.assert_allclose(np.column_stack(turn.lines[1].get_data()), pairs[:1])
    np.testing.assert_allclose(slide.lines[0].get_ydata(), part.velocities[1:, 1])
    np.testing.assert_allclose(slide.lines[1].get_xdata(), part.positions[1:2, 1])
    (wheel,) = drawn["sensors_m"].axes
    assert text(wheel) == ("Sensors [m]", "time [s]", "wheel\n[m]")
    assert legend(wheel) == ["x", "y"]
    np.testing.assert_allclose(lines(wheel)["y"], np.column_stack([time, 2 * time])[1:])
    above, below = drawn["energy"].axes
    assert legend(above) == ["kinetic", "potential", "work", "lost"]
    np.testing.assert_allclose(lines(above)["potential"][:, 1], time[1] - time[1:])
    np.testing.assert_allclose(lines(above)["kinetic"], np.column_stack([time, time**2])[1:])
    gained = (time**2 - time)[1:] - (time**2 - time)[1]
    np.testing.assert_allclose(below.lines[0].get_ydata(), gained - 3 * time[1:] + 0.5 * time[1:], atol=1e-12)
    assert (above.get_ylabel(), below.get_ylabel(), below.get_xlabel()) == ("[J]", "[J]", "time [s]")
    bare = SensorTrack(names=("s.a",), units=("",), values=np.ones((N, 1)))
    assert list(mechanism_plots.mechanism_plots(time, part, MIXED, bare)) == ["joints", "phase", "sensors_1"]


def test_the_truth_is_wide_and_light_below_what_is_estimated(track):
    figure, (axes,) = plots.sheet(1, height=3.0)
    plots.draw_truth(axes, track.truth)
    (line,) = axes.lines
    assert (line.get_linewidth(), line.get_alpha(), line.get_color(), line.get_label()) == (
        4.5,
        0.4,
        plots.TRUTH,
        "truth",
    )
    assert figure.axes == [axes]
    for name in ("top", "right"):
        assert not axes.spines[name].get_visible()
    assert axes.get_axisbelow()


def test_a_page_tells_what_happened_only_where_something_did():
    run = {"real_time_factor": 2.0, "whole": True, "sim_seconds": 3.0, "seed": 4, "milliseconds": {}}
    quiet = SimpleNamespace(world=WORLD, events=(), robots={})
    page = _page(quiet, run, [])
    assert "3.0 s simulated, 2.0 times real time, seed 4<" in page
    assert "Events of the world" not in page
    cut = _page(quiet, run | {"whole": False, "real_time_factor": None}, [])
    assert "3.0 s simulated, seed 4; the recording is incomplete" in cut


def test_worlds_that_differ_in_more_than_four_settings_go_by_their_names():
    def settings(count):
        return [{f"k{k}.a": str(which) for k in range(count)} for which in range(2)]

    assert setting_labels(settings(4), ["one", "two"])[0].count(",") == 3
    assert setting_labels(settings(5), ["one", "two"]) == ["one", "two"]
    assert setting_labels(settings(5), ["one", "one"]) is None
    assert setting_labels([{"k.a": "1"}] * 2, ["one", "one"]) == ["one", "one"]
    # The order of keys makes no other setting.
    many = settings(5)
    assert setting_labels([*many, dict(reversed(many[0].items()))], ["one", "two", "one"]) == ["one", "two", "one"]
