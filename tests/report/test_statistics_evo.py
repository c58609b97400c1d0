"""ATE and RPE of recordings are those that evo computes of their exported trajectories."""

import copy

import numpy as np
import pytest

import mjsim
from mjsim.record import export_tum

WORLD = """
mjsim: 1
walls: [{{points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true}}]
beacons: [{{name: a, at: [5.9, 1]}}, {{name: b, at: [0.1, 3]}}, {{name: c, at: [3, 3.9]}}, {{name: d, at: [3, 0.1]}}]
robots:
  - {{name: scout, {robot}, at: [2, 1], odometry: {{noise: {{distance: 0.05, turn: 0.1}}}},
     sensors: [{{beacons: ring, range: [0.3, 8], fov_deg: 300, rate_hz: 5, noise: {{range: 0.05, bearing_deg: 1}}}}]}}
run: {{seconds: 12, rate_hz: 10, map: known, events: [{events}], drivers: {{scout: {{
    {estimator}
    navigator: {{use: "mjsim.algorithms.constant:ConstantCommand", forward: 0.5, turn: {turn}}}}}}}}}
"""
SLAM = 'estimator: {use: "mjsim.algorithms.ekf_slam:EkfSlam"},'
LOCALIZATION = 'estimator: {use: "mjsim.algorithms.localization:EkfLocalization"},'
KINDS = {
    "slam": {"robot": "preset: pioneer3dx", "estimator": SLAM, "turn": 0.45, "events": ""},
    "kidnapped": {
        "robot": "preset: turtlebot3_burger",
        "estimator": LOCALIZATION,
        "turn": 0.3,
        "events": "{time: 5, move: scout, to: [4, 3], heading_deg: 170}",
    },
    "wheels": {"robot": "preset: robotino", "estimator": "", "turn": -0.6, "events": ""},
}


@pytest.fixture(scope="module", params=KINDS)
def run(request, tmp_path_factory):
    """Statistics of a run, and its trajectories as evo reads them and projects them onto the floor."""
    from evo.core.trajectory import Plane
    from evo.tools.file_interface import read_tum_trajectory_file

    folder = tmp_path_factory.mktemp(request.param)
    with mjsim.Simulation(mjsim.parse_world(WORLD.format(**KINDS[request.param])), seed=3) as sim:
        recording = mjsim.run(sim)
    export_tum(recording, folder)
    paths = {kind: read_tum_trajectory_file(folder / f"scout_{kind}.tum") for kind in ("truth", "estimate", "odometry")}
    for path in paths.values():
        path.project(Plane.XY)  # A robot nods by millimetres; the figures are those of the plane.
    return mjsim.statistics(recording)["scout"], paths


def of_evo(metric, truth, estimate):
    metric.process_data((truth, estimate))
    return metric.get_all_statistics()


@pytest.mark.slow
@pytest.mark.parametrize(("key", "kind"), [("ate_m", "estimate"), ("odometry_ate_m", "odometry")])
def test_the_ate_is_that_of_evo(run, key, kind):
    from evo.core.metrics import APE, PoseRelation

    figures, paths = run
    aligned = copy.deepcopy(paths[kind])
    aligned.align(paths["truth"])
    theirs = of_evo(APE(PoseRelation.translation_part), paths["truth"], aligned)
    for name, value in figures[key].items():
        assert value == pytest.approx(theirs[name], abs=1e-9)
    assert figures[key]["max"] > 0.01


@pytest.mark.slow
@pytest.mark.parametrize(("key", "kind"), [("rpe_m", "estimate"), ("odometry_rpe_m", "odometry")])
def test_the_rpe_over_a_metre_is_that_of_evo(run, key, kind):
    from evo.core.metrics import RPE, PoseRelation, Unit

    figures, paths = run
    metric = RPE(PoseRelation.translation_part, delta=1.0, delta_unit=Unit.meters)
    theirs = of_evo(metric, paths["truth"], paths[kind])
    for name, value in figures[key].items():
        assert value == pytest.approx(theirs[name], abs=1e-9)


@pytest.mark.slow
def test_the_rpe_in_heading_is_that_of_evo(run):
    from evo.core.metrics import RPE, PoseRelation, Unit

    figures, paths = run
    metric = RPE(PoseRelation.rotation_angle_deg, delta=1.0, delta_unit=Unit.meters)
    theirs = of_evo(metric, paths["truth"], paths["estimate"])
    # Evo takes the angle out of a rotation matrix, which costs half of the digits of small ones.
    assert figures["rpe_deg"]["rmse"] == pytest.approx(theirs["rmse"], abs=1e-6)


@pytest.mark.slow
def test_the_error_that_is_not_aligned_is_that_of_evo(run):
    from evo.core.metrics import APE, PoseRelation

    figures, paths = run
    theirs = of_evo(APE(PoseRelation.translation_part), paths["truth"], paths["odometry"])
    assert figures["odometry_error_m"]["rmse"] == pytest.approx(theirs["rmse"], abs=1e-9)
    assert np.isfinite(figures["nees"]["mean"])
