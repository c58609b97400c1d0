"""The bridge over a bus within the process: who commands what, and what of a tick is sent."""

import math

import numpy as np
import pytest

import mjsim.bridge.bridge as module
from mjsim.bridge.bridge import Bridge
from mjsim.errors import UsageError
from mjsim.interface import Command
from mjsim.ros import CLOCK, typestore
from mjsim.world import parse_world
from tests.bridge.desk import Desk

pytest.importorskip("rosbags")

WORLD = """mjsim: 1
walls: [{points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true}]
beacons: [{name: a, at: [5.9, 2], heading_deg: 180}, {name: b, at: [3, 3.9], heading_deg: -90}]
robots:
  - {name: scout, preset: pioneer3dx, at: [1, 2], sensors: [{beacons: ring, rate_hz: 5}]}
  - {name: other.2, at: [4, 1], heading_deg: 90}
run:
  rate_hz: 25
  drivers:
    scout:
      estimator: {use: "mjsim.algorithms.ekf_slam:EkfSlam"}
      navigator: {use: "mjsim.algorithms.go_to_goal:GoToGoal", goals: [1, 2]}
"""


def of(kind: str, *values: object):
    return typestore().types[kind](*values)


def twist(forward: float, left: float, turn: float, *, stamped: bool = False):
    vector = "geometry_msgs/msg/Vector3"
    plain = of("geometry_msgs/msg/Twist", of(vector, forward, left, 9.0), of(vector, 8.0, 7.0, turn))
    header = of("std_msgs/msg/Header", of("builtin_interfaces/msg/Time", 77, 0), "")
    return of("geometry_msgs/msg/TwistStamped", header, plain) if stamped else plain


def goal(x: float, y: float, z: float, w: float, *, frame: str = "map"):
    header = of("std_msgs/msg/Header", of("builtin_interfaces/msg/Time", 0, 0), frame)
    turned = of("geometry_msgs/msg/Quaternion", 0.0, 0.0, z, w)
    place = of("geometry_msgs/msg/Point", x, y, 0.0)
    return of("geometry_msgs/msg/PoseStamped", header, of("geometry_msgs/msg/Pose", place, turned))


class Run:
    """A bridge that is stepped, and all its ticks."""

    def __init__(self, **options: object) -> None:
        self.bridge = Bridge(parse_world(WORLD), speed=None, **options)
        self.desk: Desk = self.bridge._bus

    def step(self) -> Command:
        """Take a tick; return what the first robot was commanded."""
        told = self.desk.ask("/mjsim/step", 0)
        assert told.success, told.message
        return self.bridge.session.newest.orders["scout"].command


@pytest.fixture(scope="module", params=[False, True], ids=["alone", "with modules"])
def run(request):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "Bus", Desk)
        run = Run(watchdog=0.12, modules=request.param)
        run.modules = request.param
        assert not run.desk.is_started
        with run.bridge:
            run.bridge.start(paused=True)
            assert run.bridge.session.wait("paused", "failed", timeout=10.0) == "paused"
            yield run
        assert run.desk.is_started
        assert run.desk.is_closed


def test_a_twist_holds_for_the_time_of_the_watchdog_from_when_it_comes(run):
    for stamped in (False, True):
        assert run.desk.hear("/scout/cmd_vel", twist(0.3, 0.1, -0.2, stamped=stamped)) == 1
        commands = [run.step() for _ in range(6)]
        assert [(each.forward, each.left, each.turn) for each in commands[:4]] == [(0.3, 0.1, -0.2)] * 4
        # Three ticks of 0.04 s after the one that it came with.
        assert all(each.forward != 0.3 for each in commands[4:])
    assert run.desk.hear("/other_2/cmd_vel", twist(0.1, 0.0, 0.0)) == 1
    run.step()
    assert run.bridge.session.newest.orders["other.2"].command.forward == 0.1


def test_a_goal_goes_to_the_navigator_in_the_map_with_its_heading(run):
    heard = run.desk.hear("/scout/goal_pose", goal(2.0, 3.0, math.sin(1.0), math.cos(1.0)))
    assert heard == int(run.modules), "without modules nobody takes goals"
    if not run.modules:
        return
    # A quaternion and its negative are one rotation.
    for w, frame, told in ((1.0, "map", 2.0), (-1.0, "", 2.0)):
        run.desk.hear("/scout/goal_pose", goal(2.0, 3.0, w * math.sin(1.0), w * math.cos(1.0), frame=frame))
        event = run.bridge.session.touched[-1]
        assert (event.goal, event.to) == ("scout", (2.0, 3.0))
        assert event.heading_deg == pytest.approx(math.degrees(told))
    with pytest.raises(UsageError, match="the goal for 'scout' is in the frame 'odom'; give it in 'map'"):
        run.desk.hear("/scout/goal_pose", goal(1.0, 1.0, 0.0, 1.0, frame="odom"))


def pose_of(message) -> tuple[float, float, float]:
    place, turned = message.position, message.orientation
    return place.x, place.y, 2.0 * math.atan2(turned.z, turned.w)


def test_a_tick_is_sent_with_its_odometry_and_an_estimate_where_a_module_has_one(run):
    run.desk.hear("/scout/cmd_vel", twist(0.4, 0.0, 0.6))
    for _ in range(3):
        run.step()
    run.desk.sent.clear()
    run.step()
    tick, sent = run.bridge.session.newest, {each.topic.name: each.message for each in run.desk.sent}
    order = tick.orders["scout"]
    assert next(iter(sent)) == CLOCK.name
    clock = sent[CLOCK.name].clock
    assert clock.sec + 1e-9 * clock.nanosec == pytest.approx(tick.time)
    told = sent["/scout/odom"].pose
    assert pose_of(told.pose) == pytest.approx(tuple(order.dead_reckoning.as_array()))
    planar = np.reshape(told.covariance, (6, 6))[np.ix_([0, 1, 5], [0, 1, 5])]
    np.testing.assert_allclose(planar, order.dead_reckoning_covariance, atol=2e-9)
    true = sent["/scout/truth"].pose
    np.testing.assert_allclose(pose_of(true), tick.poses["scout"].planar().as_array(), atol=1e-6)
    believed = [name for name in sent if "estimate" in name or "amcl" in name]
    assert bool(believed) == run.modules, sent.keys()
    assert not any(name in sent for name in ("/tf_static", "/map")), "these come with the first tick alone"
    assert "/tf" in sent


def test_services_tell_the_state_and_the_time(run):
    assert run.desk.ask("/mjsim/pause", False).message.startswith("running at ")
    told = run.desk.ask("/mjsim/pause", True)
    assert (told.success, told.message.startswith("paused at ")) == (True, True)
    before = run.bridge.session.newest.time
    assert run.desk.ask("/mjsim/step", 0).message == f"paused at {before + 0.04:g} s"
    run.desk.sent.clear()
    told = run.desk.ask("/mjsim/reset", 0)
    assert (told.success, told.message) == (True, "paused at 0 s")
    names = [each.topic.name for each in run.desk.sent]
    assert names[:3] == ["/tf_static", "/map", CLOCK.name]


def test_who_else_publishes_the_clock_is_named_and_other_topics_of_ours_are_said(run, capsys):
    (meant,) = run.desk.asked
    assert [meant(name) for name in ("/clock", "/scout/scan", "/other_2/odom")] == [True] * 3
    assert [meant(name) for name in ("/scout/cmd_vel", "/scout/goal_pose", "/scouts", "/map", "/nav/clock")] == [
        False
    ] * 5
    run.desk.others = {"/scout/scan": "gz 7 on host", "/other_2/odom": ""}
    run.bridge._require_alone()
    line = "another program publishes /other_2/odom and 1 more topics of this world on domain"
    assert line in capsys.readouterr().err
    run.desk.others["/clock"] = "gz 7 on host"
    with pytest.raises(UsageError, match=r"^another program, gz 7 on host, publishes /clock and 2 more topics"):
        run.bridge.start()
    run.desk.others = {}


@pytest.mark.parametrize("watchdog", [0.0, -1.0, 1e8, math.nan])
def test_a_watchdog_without_a_time_is_refused(watchdog):
    with pytest.raises(UsageError, match=r"^watchdog is .* s; it must be above 0$"):
        Bridge(parse_world(WORLD), watchdog=watchdog)


def test_without_namespaces_or_a_map_topics_are_those_of_one_robot(monkeypatch):
    monkeypatch.setattr(module, "Bus", Desk)
    world = parse_world("mjsim: 1\nwalls: [{points: [[2, 0], [2, 1]]}]\nrobots: [{name: r, at: [0, 0]}]\n")
    with Bridge(world, speed=None, seconds=0.2, namespaces=False, publish_map=False) as bridge:
        assert bridge.robots == ["/"]
        bridge.start()
        assert bridge.session.wait("ended", timeout=20.0) == "ended"
        names = {each.topic.name for each in bridge._bus.sent}
        clocks = [each.message.clock.nanosec for each in bridge._bus.sent if each.topic == CLOCK]
    assert "/odom" in names
    assert "/map" not in names
    assert clocks == [0, 40_000_000, 80_000_000, 120_000_000, 160_000_000]
