"""The world in MATLAB: its EKF-SLAM is the standard filter to rounding, and its page is true."""

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

import mjsim
from mjsim.algorithms.balance import plant, regulator, turning_plant
from mjsim.algorithms.ekf_slam.ekf_filter import EkfSlamFilter
from mjsim.algorithms.estimation.ekf_models import odometry_motion
from mjsim.geometry import roll_and_pitch
from mjsim.modules import check_modules, load_runnable
from mjsim.world import with_settings
from tests.modules.processes import gone

ROOT = Path(__file__).parents[2]
WORLD = ROOT / "worlds" / "matlab" / "loop.yaml"
needs_octave = pytest.mark.skipif(
    not (shutil.which("octave-cli") or shutil.which("octave")),
    reason="no Octave here; type: sudo apt-get install --no-install-recommends octave",
)


def test_its_modules_are_there_and_fit():
    world = load_runnable(WORLD)
    assert check_modules(world) == []
    assert len(world.beacons) == 28
    assert check_modules(load_runnable(WORLD.parent / "balancer.yaml")) == []


@needs_octave
@pytest.mark.slow
def test_its_controller_holds_a_shoved_robot_upright_on_its_way():
    sooner = "run.events=[{time: 2, shove: joe, impulse: [3, 0, 0]}]"
    with mjsim.Simulation(with_settings(load_runnable(WORLD.parent / "balancer.yaml"), [sooner])) as sim:
        track = mjsim.run(sim, seconds=5.0).robots["joe"]
    leans = np.degrees([roll_and_pitch(pose[3:])[1] for pose in track.truth_pose])
    assert leans[0] == pytest.approx(3.0, abs=0.01)
    assert np.abs(leans).max() < 10.0  # a push of 3 N s at 2 s
    assert track.truth[-1, 0] - track.truth[0, 0] == pytest.approx(5.0 * 0.3, abs=0.4)
    assert gone("mjsim_serve")


@needs_octave
@pytest.mark.slow
def test_its_feedback_is_that_of_the_regulator_in_python(tmp_path):
    text = (WORLD.parent / "hold_upright.m").read_text(encoding="utf-8")
    told = "dlmwrite('K.txt', [state.push, state.twist], 'precision', 17);"
    (tmp_path / "hold.m").write_text(text.replace("    f = fast.imu", f"    {told}\n    f = fast.imu", 1))
    (tmp_path / "room.yaml").write_text(
        "robots: [{name: joe, preset: balancer, at: [0, 0]}]\n"
        "run: {seconds: 0.1, drivers: {joe: {controllers: {drive: {use: hold.m, rate_hz: 125}}}}}\n"
    )
    with mjsim.Simulation(load_runnable(tmp_path / "room.yaml")) as sim:
        joe = sim.robots["joe"]
        mjsim.run(sim)
    R = np.array([[0.2]])
    A, B = plant(joe.balancing, wheel_radius=joe.wheel_radius)
    push = regulator(A, B, np.diag([20.0, 20.0, 5.0, 2.0]), R, dt=1 / 125)
    A, B = turning_plant(joe.balancing, wheel_radius=joe.wheel_radius, track=joe.track)
    twist = regulator(A, B, np.diag([20.0, 2.0]), R, dt=1 / 125)
    np.testing.assert_allclose(np.loadtxt(tmp_path / "K.txt", delimiter=","), [*push, *twist], rtol=1e-6)


@needs_octave
@pytest.mark.slow
def test_its_ekf_slam_agrees_with_the_standard_filter_over_15_s():
    world = with_settings(load_runnable(WORLD), ["run.drivers.scout.estimator.gate=1e9"])
    with mjsim.Simulation(world) as sim:
        robot = sim.robots["scout"]
        recording = mjsim.run(sim, seconds=15.0)
    track, names = recording.robots["scout"], [beacon.name for beacon in world.beacons]
    beside = EkfSlamFilter(jacobians="standard", pose=robot.prior.as_array(), covariance=robot.prior_covariance)
    motion, apart = odometry_motion(), []
    for row, seen in enumerate(recording.observations("scout")):
        moved = seen.odometry
        beside.predict(motion, (moved.forward, moved.left, moved.turn), moved.covariance)
        if seen.sightings:
            z = [(each.range, each.bearing) for each in seen.sightings]
            beside.update([each.name for each in seen.sightings], z, [each.covariance for each in seen.sightings])
        apart.append(np.abs(track.estimate[row, :2] - beside.pose[:2]).max())
        np.testing.assert_allclose(track.covariance[row], beside.covariance, atol=1e-9)
    assert row == 374
    assert max(apart) < 1e-6
    landmarks = beside.landmarks()
    assert set(track.landmarks.names) == set(landmarks) <= set(names)
    assert len(landmarks) == 10  # it has not been everywhere yet
    for column, name in enumerate(track.landmarks.names):
        np.testing.assert_allclose(track.landmarks.mean[-1, column], landmarks[name][0], atol=1e-6)
        np.testing.assert_allclose(track.landmarks.covariance[-1, column], landmarks[name][1], atol=1e-9)
    figures = mjsim.statistics(recording)["scout"]
    assert figures["bumps"] == 0
    assert figures["distance_m"] > 8.0
    assert figures["position_error_m"]["rmse"] < 0.5 * figures["odometry_error_m"]["rmse"]
    assert figures["nis"]["mean"] == pytest.approx(2.0, abs=0.2)  # two degrees of freedom


def test_the_files_of_worlds_hold_no_syntax_of_octaves_own():
    own = r"(^|\s)(end_?(if|for|while|function|switch)\b|until\b|unwind_protect)|\+=|-=|\+\+|!=|!|#|printf|\*\*"
    driver = ROOT / "mjsim" / "modules" / "octave" / "driver"
    files = [*(ROOT / "worlds").glob("*/*.m"), *driver.glob("*.m")]
    assert len(files) == 6
    for file in files:
        for line in file.read_text(encoding="utf-8").splitlines():
            code = re.sub(r"'[^']*'", "''", line).partition("%")[0].replace("sprintf", "")
            assert not re.search(own, code), f"{file.name}: {line}"
            assert '"' not in code, f"{file.name}: {line}"
