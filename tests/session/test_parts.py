"""Parts of a session without a run: pace by a clock of the test's own, commands that expire, times that are written."""

import math
from types import SimpleNamespace

import pytest

from mjsim.errors import UsageError
from mjsim.interface import Command
from mjsim.session import gate
from mjsim.session.helm import Helm
from mjsim.session.touches import _written_time, joints_keys, noise_kept, touch_of
from mjsim.world import NoiseEvent, parse_world


@pytest.fixture
def clock(monkeypatch):
    clock = SimpleNamespace(now=100.0)
    monkeypatch.setattr(gate, "time", SimpleNamespace(perf_counter=lambda: clock.now))
    return clock


def test_ticks_are_due_at_a_multiple_of_real_time_from_the_first_on(clock):
    half = gate.Pace(0.5)
    assert half.left(3.0) == 0.0
    assert half.left(3.1) == pytest.approx(0.2)
    clock.now += 0.15
    assert half.left(3.1) == pytest.approx(0.05)
    clock.now += 0.3
    assert half.left(3.1) == 0.0
    assert half.left(3.3) == pytest.approx(0.15), "what was late is caught up"
    assert gate.Pace(None).left(1e9) == 0.0


def test_after_a_long_delay_or_a_pause_a_run_goes_on_from_where_it_is(clock):
    one = gate.Pace(1.0)
    one.left(0.0)
    clock.now += 1.2
    assert one.left(0.1) == 0.0
    assert one.left(0.2) == pytest.approx(0.1), "more than a second late: no race"
    one.forget()
    clock.now += 50.0
    assert one.left(0.3) == 0.0
    assert one.left(0.5) == pytest.approx(0.2)


def test_a_command_by_hand_holds_from_its_first_tick_for_its_time_and_no_longer():
    helm, ahead, back = Helm(["a", "b"]), Command(0.3), Command(-0.2)
    helm.take("a", ahead, hold=0.5)
    assert helm.command("b", 7.0) is None
    assert [helm.command("a", now) for now in (7.0, 7.3, 7.5)] == [ahead] * 3
    assert helm.command("a", 7.51) is None
    assert helm.command("a", 7.2) is None, "it has expired for good"
    helm.take("a", ahead, hold=0.5)
    helm.command("a", 8.0)
    helm.take("a", back, hold=0.1)
    assert (helm.command("a", 8.4), helm.command("a", 8.49), helm.command("a", 8.6)) == (back, back, None)
    for end in (lambda: helm.take("a", None, hold=1.0), helm.let_go):
        helm.take("a", ahead, hold=9.0)
        helm.command("a", 9.0)
        helm.take("b", ahead, hold=9.0)
        end()
        assert helm.command("a", 9.1) is None
    assert helm.command("b", 9.1) is None, "all were let go"


@pytest.mark.parametrize("values", [(math.nan, 0.0, 0.0), (0.0, math.inf, 0.0), (0.0, 0.0, math.nan)])
def test_a_command_by_hand_that_cannot_be_is_refused(values):
    helm = Helm(["scout"])
    with pytest.raises(UsageError, match="numbers must be finite"):
        helm.take("scout", Command(*values), hold=1.0)
    with pytest.raises(UsageError, match="numbers must be finite"):
        helm.take("scout", Command(), hold=math.nan)
    with pytest.raises(UsageError, match="no robot 'scut' to drive in this world; did you mean 'scout'"):
        helm.take("scut", Command(), hold=1.0)


def test_a_time_is_written_shortly_and_never_after_its_tick():
    for tick, dt in ((7, 0.04), (1, 1 / 3), (2, 1 / 3), (5, 1 / 7), (299, 0.008)):
        time = _written_time(tick * dt)
        assert time == round(time, 4)
        assert (tick - 1) * dt < time <= tick * dt + 1e-9
        assert tick * dt - time < 1e-4


ARM = "mjsim: 1\nrobots: [{name: r, at: [0, 0], base: fixed, arms: [{name: arm, preset: puma560}]}]\n"


def test_joints_by_hand_are_radians_and_become_degrees():
    world = parse_world(ARM)
    keys = joints_keys(world, "r", "arm", [0.5, -0.5, 0.1, 0.2, 0.3, 0.4])
    assert (keys["reach"], keys["arm"]) == ("r", "arm")
    assert keys["joints_deg"] == pytest.approx([math.degrees(each) for each in (0.5, -0.5, 0.1, 0.2, 0.3, 0.4)])
    assert joints_keys(world, "r", "arm", None) == {"release": "r", "arm": "arm"}
    for wrong in ([0.0] * 5, [0.0] * 5 + [math.nan]):
        with pytest.raises(UsageError, match="arm 'arm' has 6 joints; give as many finite numbers"):
            joints_keys(world, "r", "arm", wrong)
    with pytest.raises(UsageError, match="no arm 'arn'"):
        joints_keys(world, "r", "arn", None)


def test_a_touch_has_no_time_of_its_own():
    with pytest.raises(UsageError, match="a touch has no time of its own"):
        touch_of({"time": 1.0, "light": 0.5})
    assert touch_of({"light": 0.123456789}).light == pytest.approx(0.1235, abs=1e-3)


def test_noise_that_was_changed_by_hand_is_kept_for_the_start_where_it_differs():
    world = parse_world("mjsim: 1\nrobots: [{name: r, at: [0, 0], odometry: {noise: {turn: 0.02}}}]\n")
    turn, distance = "robots.r.odometry.noise.turn", "robots.r.odometry.noise.distance"
    events = [
        NoiseEvent(time=time, noise=key, value=value)
        for time, key, value in ((1.0, turn, 0.3), (2.0, distance, 0.1), (3.0, turn, 0.02), (4.0, distance, 0.2))
    ]
    assert [(each.time, each.noise, each.value) for each in noise_kept(events, world)] == [(0.0, distance, 0.2)]
