"""A short run of two robots with odd names and all kinds of sensors that data sets hold."""

import pytest

import mjsim
from mjsim.record import Recording, read_recording

WORLD = """mjsim: 1
name: two
walls: [{points: [[0, 0], [6, 0], [6, 5], [0, 5]], closed: true}]
obstacles: [{box: [0.4, 0.6, 1.0], at: [3.5, 2.2]}]
robots:
  - name: 7.tip-top
    preset: pioneer3dx
    at: [1, 1]
    heading_deg: 20
    drive: {noise: {speed: 0.02, turn: 0.02}}
    odometry: {noise: {distance: 0.05, turn: 0.1}}
    sensors:
      - {camera: eye, at: [0.1, 0, 0.5], pitch_deg: -10, width: 64, height: 48, rate_hz: 12.5, depth: true, latency: 1}
      - {camera: wide, at: [0, 0.1, 0.6], yaw_deg: 90, width: 48, height: 48, rate_hz: 5, fov_deg: 150,
         lens: {fisheye: [0.01, 0, 0, 0]}}
      - {lidar: scan, at: [0.15, 0.02, 0.3], yaw_deg: 30, beams: 61, fov_deg: 240, range: [0.3, 3.0],
         rate_hz: 12.5, intensity: true}
      - {lidar: rear, at: [-0.1, 0, 0.2], yaw_deg: 180, beams: 31, rate_hz: 5, noise: {range: 0.01}}
      - {imu: imu, at: [0.02, 0, 0.1], yaw_deg: 90, rate_hz: 125, noise: {acceleration: 0.02, turn: 0.002}}
  - {name: bare, at: [4, 4]}
run:
  seconds: 0.8
  rate_hz: 25
  seed: 3
  drivers:
    7.tip-top:
      estimator: {use: "mjsim.algorithms.occupancy:OccupancyMapping"}
      navigator: {use: "mjsim.algorithms.constant:ConstantCommand", forward: 0.3, turn: 0.4}
"""


@pytest.fixture(scope="session")
def run(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    path = tmp_path_factory.mktemp("data-sets") / "run.mcap"
    with mjsim.Simulation(mjsim.parse_world(WORLD)) as sim:
        mjsim.run(sim, record=path)
    return read_recording(path)
