"""Goals while a run goes on: from the world file, from Python and by hand; with a heading or without."""

import math

import numpy as np
import pytest

import mjsim
from mjsim.algorithms.go_to_goal.go_to_goal import GoToGoal
from mjsim.errors import UsageError
from mjsim.session import keep_events

WORLD = """
mjsim: 1
walls: [{points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true}]
robots: [{name: scout, preset: pioneer3dx, at: [2, 2], odometry: {noise: {distance: 0, turn: 0}}}]
run: {seconds: 2, drivers: {scout: {navigator: {use: "mjsim.algorithms.go_to_goal:GoToGoal", goals: [[2, 2, -90]]}}}}
"""
WAYPOINTS = WORLD.replace("go_to_goal:GoToGoal", "waypoints:Waypoints").replace(
    "goals: [[2, 2, -90]]", "points: [[2, 2]]"
)
EVENT = "run: {events: [{time: 0.4, goal: scout, to: [5, 2], heading_deg: 45}], "


class Heard:
    """A navigator that stands still and keeps its goals."""

    def start(self, robot, map, rng):
        self.goals = []

    def command(self, seen, belief):
        self.time = seen.time
        return mjsim.Command()

    def take_goal(self, x, y, heading):
        self.goals.append((x, y, heading))


@pytest.mark.parametrize("heading", [-60, 75])
def test_a_robot_at_its_goal_turns_the_shorter_way_to_the_heading_of_the_goal(heading):
    run = mjsim.run(mjsim.parse_world(WORLD.replace("-90", str(heading))), seconds=1.6)
    track = run.robots["scout"].truth
    assert math.degrees(math.remainder(track[-1, 2] - math.radians(heading), 2 * math.pi)) == pytest.approx(0, abs=4.5)
    assert np.hypot(*(track[-1, :2] - (2, 2))) < 0.05
    turned = np.degrees(np.unwrap(track[:, 2]))
    assert turned.max() - turned.min() < abs(heading) + 5


def test_a_goal_event_reaches_the_navigator_at_its_tick_and_is_recorded():
    navigator = Heard()
    world = mjsim.parse_world(WORLD.replace("run: {", EVENT))
    run = mjsim.run(world, seconds=0.48, drivers={"scout": mjsim.Driver(navigator=navigator)})
    assert navigator.goals == [(5.0, 2.0, pytest.approx(math.pi / 4))]
    (event,) = run.events
    assert (event.goal, event.to, event.time) == ("scout", (5.0, 2.0), pytest.approx(0.4))


def test_a_goal_from_python_replaces_the_others():
    with mjsim.Simulation(mjsim.parse_world(WORLD), seed=1) as sim:
        ahead = GoToGoal([0.6, 2.0])
        for tick in mjsim.ticks(sim, {"scout": mjsim.Driver(navigator=ahead)}):
            if round(tick.time / sim.dt) == 1:
                sim.set_goal("scout", (5.0, 2.0))
            if tick.time > 1.0:
                break
        assert tick.truth["scout"].x > 2.1


@pytest.mark.parametrize("step", [0.0, 0.002], ids=["the same", "one that moves"])
def test_a_goal_that_comes_at_every_tick_does_not_hold_the_robot(step):
    with mjsim.Simulation(mjsim.parse_world(WORLD), seed=1) as sim:
        for tick in mjsim.ticks(sim, {"scout": mjsim.Driver(navigator=GoToGoal([5.0, 2.0]))}):
            if tick.time > 1.6:
                break
            sim.set_goal("scout", (5.0, 2.0 + step * tick.time / sim.dt))
        assert tick.truth["scout"].x > 2.5


def test_a_goal_by_hand_reaches_the_navigator_and_can_be_kept_in_the_world_file():
    navigator = Heard()
    with mjsim.Session(mjsim.parse_world(WORLD), drivers={"scout": mjsim.Driver(navigator=navigator)}) as session:
        session.pause()
        session.wait("paused")
        session.set_goal("scout", (5, 2), math.pi / 2)
        session.tick()
        session.touch({"goal": "scout", "to": [4, 1]})
        session.stop()
        session.wait(timeout=10.0)
        kept = mjsim.parse_world(keep_events(WORLD, session.touched))
    assert navigator.goals[0] == (5.0, 2.0, pytest.approx(math.pi / 2))
    assert [(event.to, event.heading_deg) for event in kept.run.events] == [((5.0, 2.0), 90.0), ((4.0, 1.0), None)]


def test_a_goal_for_who_takes_none_is_refused_in_a_line_and_the_run_goes_on():
    with mjsim.Session(mjsim.parse_world(WAYPOINTS)) as session:
        session.pause()
        session.wait("paused")
        with pytest.raises(UsageError, match=r"Waypoints, the navigator of robot 'scout', takes no goals; choose one"):
            session.set_goal("scout", (5, 2))
        with pytest.raises(UsageError, match=r"no robot that drives 'scot' in this world; did you mean 'scout'\?"):
            session.set_goal("scot", (5, 2))
        assert session.touched == ()
    with pytest.raises(UsageError, match="takes no goals"):
        mjsim.run(mjsim.parse_world(WAYPOINTS.replace("run: {", EVENT)))


@pytest.mark.parametrize(
    ("goals", "line"),
    [
        ([[1, 2, 3, 4]], r"goals is \[\[1, 2, 3, 4\]\]; give at least one \[x, y\], or \[x, y, heading\]"),
        ([], r"goals is \[\]; give at least one"),
        (["a"], r"give at least one"),
        ([[1, math.nan]], "give finite numbers"),
    ],
)
def test_goals_that_are_none_are_refused(goals, line):
    with pytest.raises(ValueError, match=line):
        GoToGoal(goals)


def test_goals_costs_and_candidates_are_shown_if_that_is_wanted_five_times_a_second():
    text = WORLD.replace("goals: [[2, 2, -90]]", "goals: [[5, 2, 90]], show_all: true")
    shown = mjsim.run(mjsim.parse_world(text), seconds=0.36).robots["scout"].shown
    assert len({id(items) for items in shown}) == 2
    costs, candidates, goals, arrow, path = shown[-1]
    assert [item.name for item in (costs, candidates, goals, path)] == ["costs", "candidates", "goals", "planned path"]
    np.testing.assert_allclose(goals.points, [[5, 2, 0]])
    np.testing.assert_allclose(arrow.points[:, :2], [[5, 2], [5, 2.4]], atol=1e-9)
    # The walls at x = 0 cost 1, the middle of the room nothing.
    row, wall = (int((2.0 - origin) / costs.resolution) for origin in (costs.origin.y, costs.origin.x + 2.0))
    assert costs.cells[row, wall] == 1.0
    assert costs.cells[row, wall + int(2.0 / costs.resolution)] < 0.5
    starts = candidates.points[::2, :2].reshape(len(candidates.points) // 12, -1, 2)[:, 0]
    assert np.hypot(*(starts - (2, 2)).T).max() < 0.2
