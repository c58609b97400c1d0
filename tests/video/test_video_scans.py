"""Scans on plans: dots where the walls are, when the belief is the truth."""

import numpy as np
import shapely

from mjsim.interface import Command
from mjsim.plan import PlanItem
from mjsim.run import Driver, run
from mjsim.sim import Simulation
from mjsim.video import PAPER, Letters
from mjsim.video.beam_points import recorded_points
from mjsim.video.ink import SCANNED
from mjsim.video.moment import moments
from mjsim.video.paper import Paper
from mjsim.video.plan_view import PlanView
from mjsim.world import parse_world, solid

WORLD = parse_world("""
mjsim: 1
walls: [{points: [[-2, -2], [3, -2], [3, 2], [-2, 2]], closed: true}]
robots:
  - name: r
    at: [0, 0]
    odometry: {noise: {distance: 0, turn: 0}}
    sensors:
      - {lidar: front, at: [0.1, 0, 0.3], beams: 30}
      - {lidar: rear, at: [-0.1, 0.05, 0.3], yaw_deg: 180, beams: 30, rate_hz: 5, latency: 2}
  - {name: blind, at: [1, 1]}
""")


class Turn:
    def start(self, robot, map, rng):
        pass

    def command(self, seen, belief):
        return Command(0.3, turn=0.8)


def test_dots_of_every_lidar_lie_where_its_beams_met_something_and_stay_until_the_next_scan():
    with Simulation(WORLD) as sim:
        recording = run(sim, drivers={"r": Driver(navigator=Turn()), "blind": Driver()}, seconds=1.0)
    rows = [0, 1, 2, 9, 20, 24]
    shown = [moment.scans for moment in moments(recording, "r", rows)]
    room = solid(WORLD, height=0.3)
    assert [set(scans) for scans in shown] == [{"front"}] * 2 + [{"front", "rear"}] * 4
    for scans in shown:
        for points in scans.values():
            assert len(points) > 20
            # Dead reckoning without noise is off by millimetres after a second.
            assert shapely.distance(shapely.points(points), room.boundary).max() < 0.02
    np.testing.assert_array_equal(shown[0]["front"], shown[1]["front"])
    assert not any(recorded_points(recording, "blind"))


def test_dots_outside_of_the_picture_are_left_out():
    page = np.full((40, 60, 3), PAPER, dtype=np.uint8)
    view = PlanView(0.0, 0.0, 1.0, 60, 40)
    points = view.world([[30.0, 20.0], [-5.0, 3.0], [1e9, 1e9], [59.0, 39.0]])
    Paper(page, view, Letters(), 6.0).draw([PlanItem(role="scan", kind="dots", parts=(points,))])
    inked = np.argwhere((page != PAPER).any(axis=2))
    assert {tuple(page[20, 30])} == {SCANNED}
    near = np.minimum(np.hypot(*(inked - [20, 30]).T), np.hypot(*(inked - [39, 59]).T))
    assert near.max() < 4
