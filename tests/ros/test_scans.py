"""Scans as ROS 2 messages."""

import numpy as np
import pytest

import mjsim
from mjsim.ros import messages

ROOM = """
mjsim: 1
walls: [{points: [[0, 0], [8, 0], [8, 6], [0, 6]], closed: true}]
robots: [{name: scout, at: [3, 2], sensors: [{lidar: scan, beams: 90, fov_deg: 360, rotating: ROTATING}]}]
"""


@pytest.mark.parametrize("rotating", [True, False])
def test_the_stamp_is_that_of_the_first_beam_and_others_follow(rotating):
    world = mjsim.parse_world(ROOM.replace("ROTATING", str(rotating).lower()))
    with mjsim.Simulation(world) as sim:
        for _ in range(4):
            sim.step()
        scan, sheet = sim.sense("scout").scans["scan"], sim.robots["scout"].sensors["scan"]
    message = messages.laser_scan(scan, "scan", sheet)
    first = message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec
    last = first + message.time_increment * (len(message.ranges) - 1)
    assert last == pytest.approx(0.16, abs=1e-7)
    assert message.scan_time == pytest.approx(0.08)
    assert message.time_increment == pytest.approx(0.08 / 90 if rotating else 0.0)
    np.testing.assert_array_equal(message.ranges, scan.ranges.astype(np.float32))
