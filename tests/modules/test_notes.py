"""A module that uses readings which its robot never gets is told in one line: in check, in run and in the studio."""

import pytest

import mjsim
from mjsim.cli import main
from mjsim.modules import notes_on, unfed_modules
from mjsim.web.worlds.parsed import parsed
from mjsim.world import Source, shipped_worlds

NOISE = "odometry: {noise: {distance: 0, turn: 0}}"
LION = "beacons: [{name: lion, at: [3, 0]}]"
MINE = """
from mjsim import Estimate, Pose
from helper import corrected

class Turns:
    def start(self, robot, catalogue, rng): self.scans = []
    def update(self, seen):
        self.scans.append(seen.time)
        return Estimate(Pose(0, 0, 0), None)

class Slam(Turns):
    def update(self, obs):
        return corrected(obs)

class Both(Turns):
    def update(self, obs):
        return [*obs.sightings, *obs.scans.values()]

class Gyro(Turns):
    def update(self, obs):
        return obs.imu

class Eyes:
    def __init__(self, camera="front"): self.camera = camera
    def start(self, robot, catalogue, rng): pass
    def observe(self, obs): return [obs.cameras.get(self.camera)]
"""
HELPER = "def corrected(values):\n    return list(values.sightings)\n"
OCTAVE = "function [est, state] = my_slam(o, robot, state)\n  % o.scans\n  z = o.z; s = struct('imu', 1);\n"


@pytest.fixture
def notes(tmp_path):
    """Return a function that gives the lines about a world's modules."""
    (tmp_path / "mine.py").write_text(MINE)
    (tmp_path / "helper.py").write_text(HELPER)
    (tmp_path / "my_slam.m").write_text(OCTAVE)

    def lines(*sensors, beacons="", **modules):
        drivers = ", ".join(f"{role}: {use}" for role, use in modules.items())
        text = f"robots: [{{name: r, at: [0, 0], {NOISE}, sensors: [{', '.join(sensors)}]}}]\n{beacons}\n"
        text += f"run: {{drivers: {{r: {{{drivers}}}}}}}\n"
        world = mjsim.parse_world(text, source=Source(file="w", folder=tmp_path))
        return [problem.message for problem in notes_on(world)]

    return lines


SLAM = '{use: "mjsim.algorithms.ekf_slam:EkfSlam"}'
VISION = '{use: "mjsim.algorithms.beacon_vision:BeaconVision", camera: front}'
RECKONS = "which robot 'r' does not get, so it is dead reckoning"


@pytest.mark.parametrize(
    "name", ["ekf_slam:EkfSlam", "fastslam:FastSlam", "cooperative_slam:CooperativeSlam", "textbook:TextbookEkfSlam"]
)
def test_an_estimator_without_sightings_is_dead_reckoning(notes, name):
    assert notes(estimator=f'{{use: "mjsim.algorithms.{name}"}}', beacons=LION) == [
        f"estimator {name.partition(':')[2]} uses sightings, {RECKONS}; add a sensor (beacons: NAME) or an observer"
    ]


def test_so_is_one_of_the_user_that_hands_what_it_sees_to_a_function_in_another_file(notes):
    assert notes(estimator='{use: "mine.py:Slam"}') == [
        f"estimator Slam uses sightings, {RECKONS}; add a sensor (beacons: NAME) or an observer"
    ]
    assert notes(estimator='{use: "mine.py:Turns"}') == []


def test_so_is_one_in_octave(notes):
    (line,) = notes(estimator="{use: my_slam.m}")
    assert line.startswith(f"estimator my_slam.m uses sightings, {RECKONS}")


def test_a_beacon_sensor_gives_sightings_of_beacons_that_are_there(notes):
    assert notes("{beacons: ring}", beacons=LION, estimator=SLAM) == []
    assert notes("{beacons: ring}", estimator=SLAM) == [
        f"estimator EkfSlam uses sightings, {RECKONS}; this world has no beacons, add some"
    ]


def test_an_observer_gives_them_with_a_camera_that_is_there(notes):
    both = {"observer": VISION, "estimator": SLAM, "beacons": LION}
    assert notes("{camera: front, noise: 0}", **both) == []
    assert notes(**both) == [
        "observer BeaconVision uses cameras, which robot 'r' does not get, so it sees nothing;"
        " add a sensor (camera: NAME)"
    ]
    assert notes("{camera: back, noise: 0}", **both) == [
        "observer BeaconVision uses camera 'front', which robot 'r' does not have; it has back"
    ]
    assert notes("{camera: back, noise: 0}", observer='{use: "mine.py:Eyes"}') == [
        "observer Eyes uses camera 'front', which robot 'r' does not have; it has back"
    ]


def test_one_of_several_readings_of_what_is_around_is_enough(notes):
    assert notes("{lidar: scan}", estimator='{use: "mine.py:Both"}') == []
    (line,) = notes("{imu: imu}", estimator='{use: "mine.py:Both"}')
    assert line.startswith(f"estimator Both uses scans and sightings, {RECKONS}")


@pytest.mark.parametrize(
    ("use", "sensor", "kind"),
    [
        ("mjsim.algorithms.lidar_slam:LidarSlam", "lidar: a", "scans"),
        ("mine.py:Gyro", "imu: a", "imu"),
    ],
)
def test_scans_and_the_imu_are_missed_as_sightings_are(notes, use, sensor, kind):
    assert notes(f"{{{sensor}}}", estimator=f'{{use: "{use}"}}') == []
    (line,) = notes("{uwb: tag}", estimator=f'{{use: "{use}"}}')
    assert f"uses {kind}, {RECKONS}" in line


@pytest.mark.parametrize("name", sorted(shipped_worlds()))
def test_every_module_of_a_shipped_world_gets_what_it_uses(name):
    assert unfed_modules(mjsim.load_world(name)) == []


def test_check_and_run_say_it_and_the_run_goes_on(tmp_path, capsys):
    path = tmp_path / "room.yaml"
    run = f"run: {{seconds: 0.04, drivers: {{r: {{estimator: {SLAM}}}}}}}"
    path.write_text(f"robots: [{{name: r, at: [0, 0], {NOISE}}}]\n{LION}\n{run}\n")
    line = f"{path}:3:53: estimator EkfSlam uses sightings, {RECKONS};"
    for words in (["check", str(path)], ["run", str(path), "-o", str(tmp_path / "run.mcap")]):
        with pytest.raises(SystemExit) as ended:
            main(words)
        told = capsys.readouterr().err
        assert (ended.value.code, told.count(line)) == (0, 1), told
    assert (tmp_path / "run.mcap").is_file()


def test_the_studio_shows_it_where_the_module_is_written(tmp_path):
    text = f"robots: [{{name: r, at: [0, 0], {NOISE}}}]\nrun: {{drivers: {{r: {{estimator: {SLAM}}}}}}}\n"
    (problem,) = parsed(text, Source(file="w", folder=tmp_path)).content["problems"]
    assert problem["message"].startswith(f"estimator EkfSlam uses sightings, {RECKONS}")
    assert (problem["kind"], problem["line"], problem["path"]) == (
        "warning",
        2,
        ["run", "drivers", "r", "estimator", "use"],
    )
