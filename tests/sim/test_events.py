"""Events: what happens to a world at a time, from the world file or from Python, and how it is recorded."""

import math
from pathlib import Path

import numpy as np
import pytest

from mjsim.errors import UsageError
from mjsim.geometry import Pose
from mjsim.interface import Command, JointGoal
from mjsim.record import export_csv, read_recording, same_run
from mjsim.report import statistics, statistics_file
from mjsim.report.report_page import _page
from mjsim.run import Driver, run, ticks
from mjsim.sim import Playback, Simulation
from mjsim.world import LightEvent, MoveEvent, RemoveEvent, check_world, parse_world

HALL = """
mjsim: 1
walls:
  - points: [[0, 0], [8, 0], [8, 6], [0, 6]]
    closed: true
    openings: [{{name: gate, segment: 1, at: 0.5, width: 1, door: {{}}}}]
obstacles:
  - {{box: [0.4, 2, 0.8], at: [4, 3], name: rack}}
  - {{cylinder: [0.2, 0.5], at: [2, 5], movable: true, mass: 3, name: bin}}
  - {{sphere: 0.3, at: [6, 1], name: ball, path: {{points: [[7, 1]]}}}}
beacons:
  - {{name: lion, image: posters/lion.jpg, at: [7.94, 4.5], heading_deg: 180, width: 1}}
  - {{name: plate, at: [-0.2, 0], heading_deg: 180, on: rack, center: 0.5, width: 0.3}}
lamps: [{{name: spot, at: [6.5, 4.5], brightness: 0}}]
robots:
  - name: r
    at: [1, 3]
    sensors:
      - {{camera: eye, at: [0, 0, 0.6], width: 96, height: 72, rate_hz: 25, noise: 0}}
      - {{lidar: scan, at: [0, 0, 0.4], beams: 3, fov_deg: 60, rate_hz: 25}}
      - {{beacons: ring, range: [0.3, 9], fov_deg: 180, rate_hz: 25, noise: {{range: 0, bearing_deg: 0}}}}
run: {{events: [{}]}}
"""


def hall(events: str = "") -> Simulation:
    return Simulation(parse_world(HALL.format(events)))


def step(sim: Simulation, count: int, command: Command | None = None) -> None:
    for _ in range(count):
        sim.apply("r", command or Command())
        sim.step()


@pytest.mark.slow
def test_a_kidnapped_robot_stands_elsewhere_at_the_first_tick_not_before_and_its_odometry_does_not_notice():
    sim = hall("{time: 1.01, move: r, to: [5.5, 2.25], heading_deg: 90}")
    told = Pose(1.0, 3.0, 0.0)
    for tick in range(1, 30):
        sim.apply("r", Command(0.3))
        sim.step()
        seen = sim.odometry("r")
        told = told @ Pose(seen.forward, seen.left, seen.turn)
        if tick == 25:
            assert sim.truth("r").x < 1.3
        if tick == 26:
            # 1.04 s, the first tick at 25 Hz that is not before 1.01 s.
            assert sim.truth("r") == Pose(5.5, 2.25, pytest.approx(math.pi / 2))
            start = sim.model.joint("r/free").dofadr[0]
            assert not sim.data.qvel[start : start + 6].any()
    # Odometry tells of an even drive; to reach its speed twice costs it 0.3^2 / 2 m and 0.3 m/s for 0.1 s.
    assert told.x == pytest.approx(1.0 + 0.3 * 29 * sim.dt - 0.075, abs=0.02)
    assert told.y == pytest.approx(3.0, abs=0.05)
    # From there it drives on to the north.
    step(sim, 25, Command(0.3))
    assert sim.truth("r").y > 2.4


def test_a_robot_that_is_lifted_keeps_its_heading_unless_told_and_stands_still():
    sim = hall()
    step(sim, 50, Command(0.4, turn=0.5))
    heading = sim.truth("r").heading
    sim._script.happen(MoveEvent(time=0.0, move="r", to=(2.0, 1.0)), sim.time)
    assert sim.truth("r").heading == pytest.approx(heading, abs=1e-3)
    step(sim, 25)
    assert (sim.truth("r").x, sim.truth("r").y) == pytest.approx((2.0, 1.0), abs=0.15)


def test_a_movable_obstacle_is_put_down_upright():
    sim = hall("{time: 0, move: bin, to: [3, 1], heading_deg: 45}")
    step(sim, 10)
    place = sim.things()["obstacle/bin"]
    assert (place.x, place.y, place.heading) == pytest.approx((3, 1, math.pi / 4), abs=1e-3)
    assert sim.data.xpos[sim.model.body("obstacle/bin").id, 2] == pytest.approx(0.0, abs=1e-3)


@pytest.mark.slow
def test_doors_open_and_close_when_the_time_has_come():
    sim = hall("{time: 0.2, open: gate, angle_deg: -70}, {time: 6, close: gate}")
    found = {}
    while sim.time < 12.0:
        step(sim, 1)
        found[round(sim.time, 2)] = math.degrees(sim.door_angle("gate"))
    assert found[0.2] == 0.0
    assert found[0.4] < -1.0
    assert found[5.0] == pytest.approx(-70, abs=0.5)
    assert found[11.0] == pytest.approx(0, abs=0.5)


@pytest.mark.slow
def test_the_light_goes_out_and_a_lamp_goes_on_in_the_camera():
    sim = hall("{time: 0.2, light: 0}, {time: 0.4, lamp: spot, brightness: 1.5}")
    means = []
    for _ in range(15):
        means.append(sim.sense("r").cameras["eye"].image.mean() / 255)
        step(sim, 1)
    assert min(means[:5]) > 0.4
    assert max(means[5:10]) < 0.01
    assert min(means[10:]) > 0.05


@pytest.mark.slow
def test_what_is_taken_away_is_neither_seen_nor_met_nor_touched():
    sim = hall("{time: 0.2, remove: rack}")
    before = sim.sense("r")
    assert before.scans["scan"].ranges[1] == pytest.approx(2.8, abs=1e-3)
    assert {seen.name for seen in before.sightings} == {"plate"}
    step(sim, 5)
    after = sim.sense("r")
    assert after.scans["scan"].ranges[1] == pytest.approx(6.95, abs=1e-3)
    # With the rack goes what hung on it, and what it hid is in sight.
    assert {seen.name for seen in after.sightings} == {"lion"}
    assert (after.cameras["eye"].image != before.cameras["eye"].image).mean() > 0.05
    step(sim, 300, Command(0.5))
    assert sim.truth("r").x > 5.0
    sim.remove("lion")
    step(sim, 1)
    assert sim.sense("r").sightings == ()


def test_a_movable_thing_that_is_taken_away_falls_out_of_nothing():
    sim = hall()
    sim.remove("bin")
    step(sim, 100)
    assert sim.data.qpos[sim.model.joint("obstacle/bin").qposadr[0] + 2] == pytest.approx(0.0, abs=1e-3)
    assert "obstacle/bin" not in sim.things()
    sim.move("r", Pose(2.0, 5.0, 0.0))
    step(sim, 25)
    assert (sim.truth("r").x, sim.truth("r").y) == pytest.approx((2.0, 5.0), abs=0.02)


def test_nothing_is_moved_into_what_would_throw_it_out_unless_this_is_asked_for():
    sim = hall()
    before = sim.truth("r")
    for x, y, inside in [(0.0, 3.0, r"walls\[0\]"), (4.0, 3.0, "obstacle 'rack'"), (6.0, 1.0, "obstacle 'ball'")]:
        with pytest.raises(UsageError, match=f"'r' is placed at .* inside {inside}; move it to a free place"):
            sim.move("r", Pose(x, y, 0.0))
        assert sim.truth("r") == before
    sim.move("r", Pose(20.0, 20.0, 0.0))  # on the floor around the room
    sim.move("r", Pose(0.0, 3.0, 0.0), anywhere=True)
    assert sim.truth("r").x == pytest.approx(0.0)


def test_two_robots_are_moved_to_each_others_places():
    sim = Simulation(parse_world("mjsim: 1\nrobots: [{name: r, at: [0, 0]}, {name: s, at: [1, 0]}]\n"))
    r, s = sim.truth("r"), sim.truth("s")
    sim.move("r", s)
    sim.move("s", r)
    assert (sim.truth("r").x, sim.truth("s").x) == pytest.approx((1.0, 0.0))


def test_what_is_not_there_is_named_with_its_fix():
    sim = hall()
    for call, message in [
        (lambda: sim.move("rr", Pose(1, 1, 0)), "no robot or movable obstacle 'rr' in this world; did you mean 'r'"),
        (lambda: sim.move("rack", Pose(1, 1, 0)), "no robot or movable obstacle 'rack'"),
        (lambda: sim.open_door("gaet"), "no door 'gaet' in this world; did you mean 'gate'"),
        (lambda: sim.set_lamp("sport", 1.0), "no lamp 'sport' in this world; did you mean 'spot'"),
        (lambda: sim.remove("lino"), "no beacon or obstacle 'lino' in this world; did you mean 'lion'"),
        (lambda: sim.set_light(-0.5), "light is -0.5; it must be at least 0"),
        (lambda: sim.move("r", Pose(math.nan, 1, 0)), "it must be"),
    ]:
        with pytest.raises(UsageError, match=message):
            call()
    assert sim.happened() == ()


EVENTS = (
    "{time: 0.3, light: 0.4}, {time: 0.5, remove: rack}, {time: 0.6, lamp: spot, brightness: 1.2},"
    " {time: 0.7, open: gate}, {time: 0.3, move: r, to: [3, 3]}"
)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list]:
    path, pictures = tmp_path_factory.mktemp("events") / "run.mcap", []
    with hall(EVENTS) as sim:
        run(sim, seconds=1.0, record=path, watch=lambda tick: pictures.append(tick.seen["r"].cameras["eye"].image))
    return path, pictures


@pytest.mark.slow
def test_events_and_things_stand_in_the_recording_at_their_ticks(recorded):
    recording = read_recording(recorded[0])
    found = [(event.time, type(event).__name__) for event in recording.events]
    assert found == [
        (pytest.approx(0.32), "LightEvent"),
        (pytest.approx(0.32), "MoveEvent"),
        (pytest.approx(0.52), "RemoveEvent"),
        (pytest.approx(0.6), "LampEvent"),
        (pytest.approx(0.72), "OpenEvent"),
    ]
    assert recording.events[0] == LightEvent(time=recording.events[0].time, light=0.4)
    assert [recording.looks(row).light for row in (7, 8)] == [1.0, 0.4]
    assert [recording.looks(row).removed for row in (12, 13)] == [frozenset(), {"rack", "plate"}]
    assert set(recording.things) == {"obstacle/bin", "obstacle/ball", "door/gate"}
    np.testing.assert_allclose(recording.things["obstacle/ball"][:, 0], 6.0 + 0.5 * recording.time, atol=1e-9)
    assert recording.robots["r"].truth[8, 0] == 3.0


@pytest.mark.slow
def test_pictures_drawn_again_from_the_recording_are_the_ones_that_were_taken(recorded):
    recording, pictures = read_recording(recorded[0]), recorded[1]
    with Playback(recording.world, width=96, height=72, events=recording.events) as playback:
        # Backwards too: a film may be looked at from any time.
        for row in (3, 10, 14, 17, 24, 9, 0):
            again = playback.picture(recording.qpos[row], "r/eye", time=recording.time[row])
            np.testing.assert_array_equal(again, pictures[row], err_msg=str(row))


@pytest.mark.slow
def test_a_run_with_events_is_the_same_again(recorded, tmp_path: Path):
    with hall(EVENTS) as sim:
        run(sim, seconds=1.0, record=tmp_path / "run.mcap")
    assert same_run(recorded[0], tmp_path / "run.mcap")


@pytest.mark.slow
def test_the_error_of_a_kidnapped_robot_goes_on_being_counted(recorded):
    found = statistics(read_recording(recorded[0]))["r"]
    # Dead reckoning believes that it still stands where it was, 2 m away; and it drove none of them.
    assert found["position_error_m"]["final"] == pytest.approx(2.0, abs=0.05)
    assert found["distance_m"] < 0.05


def test_what_python_does_between_ticks_is_in_the_next_one():
    with hall() as sim:
        loop = ticks(sim, {})
        first = next(loop)
        sim.remove("rack")
        second = next(loop)
        assert (first.events, second.events) == ((), (RemoveEvent(time=0.0, remove="rack"),))
        assert second.looks is not None
        assert second.looks.removed == {"rack", "plate"}
        assert next(loop).events == ()


@pytest.mark.slow
def test_events_and_things_are_told_in_tables_and_in_the_report(recorded, tmp_path: Path):
    recording = read_recording(recorded[0])
    export_csv(recording, tmp_path)
    events = (tmp_path / "events.csv").read_text().splitlines()
    assert events[:3] == ["time,text", "0.32,the ambient light is set to 0.4", '0.32,"r is placed at [3, 3]"']
    things = (tmp_path / "things.csv").read_text().splitlines()
    assert len(things) == 1 + 3 * 25
    assert "0.04,obstacle/ball,6.02,1.0,0.0" in things
    assert "<td>rack is removed</td><td>0.52 s</td>" in _page(recording, statistics_file(recording)["run"], [])


class Ahead:
    """Drives straight on."""

    def start(self, *given: object) -> None:
        """Need nothing."""

    def command(self, *given: object) -> Command:
        """Return half a metre a second."""
        return Command(0.5)


@pytest.mark.slow
@pytest.mark.parametrize("push", [False, True])
def test_a_driver_that_may_push_goes_on_where_a_bump_stops_others(push, tmp_path: Path):
    text = """
mjsim: 1
obstacles: [{cylinder: [0.2, 0.5], at: [1, 0], movable: true, mass: 4, name: bin}]
robots: [{name: r, at: [0, 0]}]
"""
    with Simulation(parse_world(text)) as sim:
        run(sim, drivers={"r": Driver(navigator=Ahead(), push=push)}, seconds=5, record=tmp_path / "run.mcap")
        assert (sim.things()["obstacle/bin"].x > 1.5) == push


ARM = """
mjsim: 1
robots: [{name: r, base: fixed, at: [1, 2], heading_deg: 90, arms: [{preset: puma560}]}]
run: {seconds: 3, events: [{time: 0.2, reach: r, joints_deg: [30, 0, 0, 0, 0, 0]}, {time: 1.5, reach: r, tool: PLACE}]}
"""


@pytest.mark.slow
def test_an_event_moves_an_arm_at_a_radian_a_second_and_then_its_tool_to_a_place():
    world = parse_world(ARM.replace("PLACE", "[0.5, 0.2, 0.6]"))
    with Simulation(world) as sim:
        goals = []
        while sim.time < 1.4:
            sim.apply("r", Command(joints={"arm": JointGoal(positions=(0.0,) * 6)}))
            sim.step()
            goals.append(float(sim.motions()["r/arm"].goal[0]))
        assert max(np.diff(goals)) == pytest.approx(sim.dt)
        assert goals[-1] == pytest.approx(math.radians(30))
        while sim.time < 6.0:
            sim.step()
        arm = world.robots[0].arms[0].arm
        np.testing.assert_allclose(arm.fkine(sim.motions()["r/arm"].goal)[:3, 3], [0.5, 0.2, 0.6], atol=1e-6)
        sim.release("r")
        sim.apply("r", Command(joints={"arm": JointGoal(positions=(0.1,) * 6)}))
        assert sim.motions()["r/arm"].goal == pytest.approx([0.1] * 6)
        with pytest.raises(UsageError, match="joint 1 of arm 'arm' cannot go to 900; its range is -160 to 160"):
            sim.reach("r", {"joints_deg": [900, 0, 0, 0, 0, 0]})


def test_an_event_for_a_place_that_a_tool_does_not_reach_is_named_with_its_line():
    (problem,) = check_world(parse_world(ARM.replace("PLACE", "[5, 0, 0]")))
    assert str(problem).startswith("world.yaml:4:112: the tool of 'arm' does not reach 5, 0, 0 m; it misses by 4.1")
