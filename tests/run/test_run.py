"""The loop: determinism, safety through real physics, and faults of user modules that are named."""

from contextlib import contextmanager

import numpy as np
import pytest

import mjsim
from mjsim.record import same_run

ROOM = """
mjsim: 1
name: room
walls: [{points: [[-2, -2], [2, -2], [2, 2], [-2, 2]], closed: true}]
obstacles: [{box: [0.3, 0.3, 0.6], at: [1.2, 1.2]}]
robots:
  - name: scout
    preset: pioneer3dx
    at: [0, 0]
    heading_deg: 20
    drive: {noise: {speed: 0.02, turn: 0.02}}
    odometry: {noise: {distance: 0.01, turn: 0.02}}
"""


class Steady:
    """A navigator that always says the same."""

    def __init__(self, command):
        self.said = command

    def start(self, robot, map, rng):
        pass

    def command(self, seen, belief):
        return self.said


class Script(Steady):
    """A navigator that says one thing after the other: (until, command) pairs."""

    def command(self, seen, belief):
        return next(command for until, command in self.said if seen.time < until)


class Estimating:
    """An estimator that returns, or raises, what it is made of."""

    def __init__(self, make):
        self.make = make

    def start(self, robot, catalogue, rng):
        pass

    def update(self, seen):
        return self.make(seen)


def run(record=None, *, seed=1, seconds=4.0, text=ROOM, **modules):
    with mjsim.Simulation(mjsim.parse_world(text), seed=seed) as sim:
        return mjsim.run(sim, drivers={"scout": mjsim.Driver(**modules)}, seconds=seconds, record=record)


def kinds(recording):
    return [event.kind for event in recording.robots["scout"].events]


def test_one_seed_gives_the_same_bytes_and_another_does_not(tmp_path):
    files = [tmp_path / f"{name}.mcap" for name in "abc"]
    for file, seed in zip(files, (1, 1, 2), strict=True):
        run(file, seed=seed, navigator=Steady(mjsim.Command(0.4, 0.0, 0.3)))
    assert same_run(files[0], files[1])
    assert not same_run(files[0], files[2])


@pytest.mark.parametrize("progress", [True, False])
def test_progress_is_shown_up_to_the_end_of_each_tick_or_not_at_all(monkeypatch, progress):
    from mjsim.run import loop

    shown, seen = [], []

    @contextmanager
    def watched(label, *, total, unit):
        shown.append((label, total, unit))
        yield shown.append

    monkeypatch.setattr(loop, "watched", watched)
    mjsim.run(mjsim.parse_world(ROOM), seconds=0.2, watch=seen.append, progress=progress)
    assert [tick.time for tick in seen] == pytest.approx([0.0, 0.04, 0.08, 0.12, 0.16])
    assert shown == ([("run room", 0.2, "s"), *(tick.time + 0.04 for tick in seen)] if progress else [])


def test_without_modules_a_robot_stands_still_but_for_its_noise():
    track = run(seconds=2.0).robots["scout"]
    assert 0.0 < np.linalg.norm(track.truth[-1, :2] - track.truth[0, :2]) < 0.15
    np.testing.assert_array_equal(track.estimate, track.odometry)
    np.testing.assert_array_equal(track.command, 0.0)


def test_a_run_has_one_tick_a_period_from_zero_on():
    recording = run(seconds=2.0)
    np.testing.assert_allclose(recording.time, np.arange(50) * 0.04, atol=1e-9)


@pytest.mark.slow
def test_a_robot_commanded_to_continue_bumps_stops_and_wriggles():
    recording = run(navigator=Steady(mjsim.Command(0.7)), seconds=14.0)
    track = recording.robots["scout"]
    assert kinds(recording)[:1] == ["bump"]
    assert "blocked" in kinds(recording)
    stuck = track.truth[track.time > 8.0]
    # The face of the wall at x = 1.95; the body's radius is 0.22.
    assert np.all(stuck[:, 0] < 1.95 - 0.22 + 0.005)
    assert np.ptp(stuck[:, :2], axis=0).max() < 0.6
    assert np.ptp(stuck[:, 2]) > 0.01


@pytest.mark.slow
def test_a_robot_that_bumped_can_turn_and_back_off():
    script = Script([(5.0, mjsim.Command(0.7)), (8.0, mjsim.Command(-0.3)), (10.0, mjsim.Command(0.0, 0.0, 1.0))])
    track = run(navigator=script, seconds=9.9, text=ROOM.replace("heading_deg: 20", "heading_deg: 0")).robots["scout"]
    assert track.truth[124, 0] > 1.6
    assert track.truth[199, 0] < 1.2
    assert abs(track.truth[-1, 2] - track.truth[199, 2]) > 1.0


@pytest.mark.slow
@pytest.mark.parametrize("heading", [0, 37, 90, 200])
def test_no_speed_brings_a_robot_through_a_wall(heading):
    text = ROOM.replace("heading_deg: 20", f"heading_deg: {heading}").replace("drive: {", "drive: {max_speed: 3, ")
    track = run(navigator=Steady(mjsim.WheelCommand((40.0, 40.0))), seconds=6.0, text=text).robots["scout"]
    assert np.abs(track.truth[:, :2]).max() < 1.95 - 0.22 + 0.02


@pytest.mark.slow
def test_avoidance_keeps_a_robot_told_to_go_on_from_bumping():
    recording = run(navigator=Steady(mjsim.Command(0.7)), avoidance=True, seconds=30.0)
    assert kinds(recording) == []
    track = recording.robots["scout"]
    assert np.hypot(*np.diff(track.truth[:, :2], axis=0).T).sum() > 5.0


def test_a_driver_for_a_robot_that_is_not_there_is_refused():
    with mjsim.Simulation(mjsim.parse_world(ROOM)) as sim, pytest.raises(mjsim.UsageError) as caught:
        next(mjsim.ticks(sim, {"scoot": mjsim.Driver()}))
    assert str(caught.value) == "no robot 'scoot' in this world; did you mean 'scout'?"


def failing(seen):
    if seen.time > 0.99:
        return 1 / 0
    return mjsim.Estimate(mjsim.Pose(0.0, 0.0, 0.0), np.eye(3))


def answering(**parts):
    values = {"pose": mjsim.Pose(0.0, 0.0, 0.0), "covariance": np.eye(3)} | parts
    return lambda seen: mjsim.Estimate(**values)


def test_a_run_without_a_file_that_fails_leaves_nothing(tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    with pytest.raises(mjsim.ModuleFault):
        run(None, estimator=Estimating(failing))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("make", "complaint"),
    [
        (failing, "at 1.00 s raised ZeroDivisionError: division by zero (test_run.py:"),
        (lambda seen: None, "at 0.00 s returned None; it must be an Estimate"),
        (answering(pose=mjsim.Pose(np.nan, 0.0, 0.0)), "returned a pose that is not finite: [nan, 0.0, 0.0]"),
        (answering(covariance=np.eye(2)), "returned the covariance of the pose of shape (2, 2); it must be (3, 3)"),
        (
            answering(landmarks={"lion": (np.zeros(3), np.eye(2))}),
            "returned the mean of landmark 'lion' of shape (3,); it must be (2,)",
        ),
    ],
)
def test_a_module_that_fails_is_named_and_what_was_recorded_stays(tmp_path, make, complaint):
    file = tmp_path / "run.mcap"
    with pytest.raises(mjsim.ModuleFault) as caught:
        run(file, estimator=Estimating(make))
    message = str(caught.value)
    assert message.startswith("estimator Estimating of robot 'scout' at ")
    assert complaint in message
    assert "\n" not in message
    if make is failing:
        recording = mjsim.read_recording(file)
        assert len(recording.time) == 25
        assert kinds(recording)[-1] == "fault"


def test_what_a_navigator_shows_is_checked_as_that_of_an_estimator(tmp_path):
    class Showing(Steady):
        def show(self):
            return [mjsim.ShownText(name="note", text="here", at=(0, 1)), "path"]

    complaint = "navigator Showing of robot 'scout' at 0.00 s returned a value of type str in its show"
    with pytest.raises(mjsim.ModuleFault, match=complaint):
        run(tmp_path / "run.mcap", navigator=Showing(mjsim.Command()))


@pytest.mark.parametrize(
    ("command", "complaint"),
    [
        (mjsim.Command(np.inf), "returned a command that is not finite: [inf, 0.0, 0.0]"),
        (mjsim.WheelCommand((1.0,)), "returned 1 wheel speeds; the wheels are wheel_left, wheel_right"),
        ("go", "returned a value of type str; it must be a Command or a WheelCommand"),
        (mjsim.Command("fast"), "returned a command that holds something other than numbers"),
    ],
)
def test_a_command_that_cannot_be_followed_is_refused(command, complaint):
    with pytest.raises(mjsim.ModuleFault, match=r"navigator Steady of robot 'scout' at 0\.00 s") as caught:
        run(navigator=Steady(command))
    assert complaint in str(caught.value)


def test_an_observation_holds_what_a_robot_senses_and_no_truth():
    settled = (
        "time dt odometry sightings cameras scans imu proximity bump messages encoders ranges joints clouds compasses"
    )
    assert set(mjsim.Observation.__slots__) == set(settled.split())


class Mapped(Estimating):
    """An estimator that asks for the map."""

    def take_map(self, map):
        self.map = map


def test_an_estimator_that_asks_gets_the_map_where_the_world_tells_it():
    for said, text in ((True, ROOM + "run: {map: known}\n"), (False, ROOM)):
        estimator = Mapped(lambda seen: mjsim.Estimate(mjsim.Pose(0, 0, 0), np.eye(3)))
        run(estimator=estimator, text=text, seconds=0.1)
        assert (estimator.map is not None) is said
        if said:
            assert estimator.map.segments.min() == pytest.approx(-2.05, abs=0.1)
