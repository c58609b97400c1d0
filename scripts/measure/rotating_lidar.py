"""Print the errors of LidarSlam with a lidar that rotates while the robot turns, with and without undoing the motion.

    python scripts/measure/rotating_lidar.py [SEEDS]

The robot drives circles in a room at 0.3 m/s and 1 rad/s for 30 s.
"""

import sys

import numpy as np

import mjsim
from mjsim.world import with_settings

ROOM = """
mjsim: 1
name: room
walls:
  - {points: [[0, 0], [10, 0], [10, 7], [0, 7]], closed: true}
  - {points: [[4, 7], [4, 5]]}
obstacles:
  - {box: [1.2, 0.6, 0.8], at: [7.5, 5.2], heading_deg: 20}
  - {box: [0.6, 0.6, 1.0], at: [1.5, 5.6]}
robots:
  - name: scout
    preset: pioneer3dx
    at: [5, 2.5]
    drive: {max_turn_deg: 120}
    sensors: [{lidar: scan, at: [0.1, 0, 0.3], beams: 360, fov_deg: 360, range: [0.1, 12], noise: {range: 0.01}}]
run:
  seconds: 30
  drivers:
    scout:
      estimator: {use: "mjsim.algorithms.lidar_slam:LidarSlam"}
      navigator: {use: "mjsim.algorithms.constant:ConstantCommand", forward: 0.3, turn: 1.0}
"""
LIDAR, ESTIMATOR = "robots.scout.sensors.scan", "run.drivers.scout.estimator"
CASES = {
    "all beams at once": [],
    "rotates, motion undone": [f"{LIDAR}.rotating=true"],
    "rotates, `deskew: false`": [f"{LIDAR}.rotating=true", f"{ESTIMATOR}.deskew=false"],
}


def errors(settings: list[str], seeds: int) -> list[float]:
    """Return RMSE of position [mm] and heading [deg], and ATE [mm], each the root of the mean square over seeds."""
    world = with_settings(mjsim.parse_world(ROOM), settings)
    found = []
    for seed in range(1, seeds + 1):
        of_robot = mjsim.statistics(mjsim.run(world, seed=seed))["scout"]
        found.append([1e3 * of_robot["position_error_m"]["rmse"], of_robot["heading_error_deg"]["rmse"]])
        found[-1].append(1e3 * of_robot["ate_m"]["rmse"])
    return np.sqrt(np.mean(np.square(found), axis=0)).tolist()


def main() -> None:
    """Print the table."""
    seeds = int(sys.argv[1]) if len(sys.argv) > 1 else 3
    print("| lidar | scans per second | position | heading | ATE |\n|---|---|---|---|---|")
    for rate in (12.5, 5):
        for name, settings in CASES.items():
            position, heading, ate = errors([f"{LIDAR}.rate_hz={rate}", *settings], seeds)
            print(f"| {name} | {rate} | {position:.0f} mm | {heading:.2f} deg | {ate:.0f} mm |", flush=True)


if __name__ == "__main__":
    main()
