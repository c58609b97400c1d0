"""Hands of people that events move: where they are, who sees it, and that it repeats."""

import inspect
import sys
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest

import mjsim
from mjsim.errors import UsageError, WorldError
from mjsim.posture import from_above
from mjsim.sim import StillScene
from mjsim.sim.person_hands import LedPeople
from mjsim.world import HandLed, ReachEvent, ReleaseEvent, check_world, event_text, looks_after

ROOM = """
mjsim: 1
people:
  - {name: anna, sex: female, at: [2, 0], heading_deg: 180}
robots:
  - name: r
    at: [0, 0]
    sensors: [{lidar: scan, at: [0, 0, 1.0], beams: 181, fov_deg: 40, range: [0.05, 10]}]
run: {seconds: 1, events: [EVENTS]}
"""
LIDAR = "{lidar3d: scan, at: [0, 0, 1.0], rings: 16, columns: 180, rate_hz: 5}"
TO = (1.65, 0.1, 1.0)
EVENT = f"{{time: 0.2, reach: anna, hand: right, to: [{TO[0]}, {TO[1]}, {TO[2]}]}}"


def grip(sim, side="right"):
    return sim.data.site(f"anna/{side}_grip").xpos.copy()


def nearest(sim):
    return float(np.min(sim.sense("r").scans["scan"].ranges))


def test_a_hand_goes_where_an_event_leads_it_and_a_lidar_meets_it_there():
    with mjsim.Simulation(mjsim.parse_world(ROOM.replace("EVENTS", EVENT))) as sim:
        before, left, legs = nearest(sim), grip(sim, "left"), sim.data.body("anna/left_foot").xpos.copy()
        for _ in range(40):
            sim.step()
        np.testing.assert_allclose(grip(sim), TO, atol=1e-3)
        np.testing.assert_array_equal(sim.data.body("anna/left_foot").xpos, legs)
        assert np.linalg.norm(grip(sim, "left") - left) < 0.3  # it hangs on a trunk that may turn
        assert nearest(sim) < before - 0.1
        sim.reset()
        assert nearest(sim) == pytest.approx(before, abs=1e-6)


@pytest.mark.slow
def test_a_3d_lidar_meets_a_hand_where_it_was_led_and_no_longer_where_it_was():
    room = ROOM.replace("{lidar: scan, at: [0, 0, 1.0], beams: 181, fov_deg: 40, range: [0.05, 10]}", LIDAR)
    with mjsim.Simulation(mjsim.parse_world(room.replace("EVENTS", EVENT))) as sim:
        seen = []
        for _ in range(50):
            sim.step()
            if (cloud := sim.sense("r").clouds.get("scan")) is not None:
                seen.append(float(np.linalg.norm(cloud.points[cloud.points[:, 2] > -0.5], axis=1).min()))
    assert min(seen[-3:]) < seen[0] - 0.1


@pytest.mark.slow
def test_a_hand_out_of_reach_moves_as_close_as_possible_and_the_event_has_the_distance():
    event = "{time: 0, reach: anna, hand: left, to: [-3, 0, 1.2]}"
    with mjsim.Simulation(mjsim.parse_world(ROOM.replace("EVENTS", event))) as sim:
        (happened,) = sim.happened()
        for _ in range(60):
            sim.step()
        x, _, z = there = grip(sim, "left")
        assert 1.0 < x < 1.6
        assert abs(z - 1.2) < 0.2
        assert isinstance(happened, ReachEvent)
        assert happened.short == pytest.approx(np.linalg.norm(there - (-3, 0, 1.2)), abs=2e-3)
        assert event_text(happened).endswith(f", which is {happened.short:.2g} m out of reach")
        sim.reset()
        sim.reach("anna", {"hand": "right", "to": TO})
        assert [event.short for event in sim.happened()[1:]] == [0.0]


def speeds(sim, ticks):
    """Return the speeds of both hands over so many ticks [m/s], shape (ticks, 2)."""
    places = []
    for _ in range(ticks + 1):
        places.append([grip(sim, "left"), grip(sim, "right")])
        sim.step()
    return np.linalg.norm(np.diff(places, axis=0), axis=2) / sim.dt


@pytest.mark.slow
def test_hands_move_no_faster_than_people_do_and_without_jolts_also_when_led_elsewhere_on_the_way():
    again = "{time: 0.6, reach: anna, hand: right, to: [1.7, -0.3, 1.5]}"
    back = "{time: 1.0, release: anna, hand: right}"
    world = mjsim.parse_world(ROOM.replace("EVENTS", f"{EVENT}, {again}, {back}"))
    with mjsim.Simulation(world) as sim:
        start = sim.model.body_quat.copy()
        found = speeds(sim, 150)
        assert 0.5 < found.max() <= 1.0
        # A jump of the speed would be one of some 0.8 m/s; people speed up by some 5 m/s^2.
        assert np.abs(np.diff(found, axis=0)).max() / sim.dt < 6.0
        # Given back, it is where it was, to the last bit, and rests.
        assert found[-5:].max() == 0.0
        np.testing.assert_allclose(sim.model.body_quat, start, atol=1e-12)


@pytest.mark.slow
def test_a_hand_that_is_given_back_leaves_the_other_one_where_it_was_led():
    left = "{time: 0, reach: anna, hand: left, to: [1.6, -0.2, 1.1]}"
    back = "{time: 0.4, release: anna, hand: right}"
    with mjsim.Simulation(mjsim.parse_world(ROOM.replace("EVENTS", f"{left}, {EVENT}, {back}"))) as sim:
        before = grip(sim)
        for _ in range(200):
            sim.step()
        np.testing.assert_allclose(grip(sim, "left"), (1.6, -0.2, 1.1), atol=2e-3)
        assert np.linalg.norm(grip(sim) - before) < 0.3  # it hangs on a trunk that leans
        assert np.linalg.norm(grip(sim) - TO) > 0.3


SEAT = "{name: chair, box: [0.4, 0.5, 0.4], at: [2, 0], heading_deg: 180, seat: {at: [0, 0, 0.49], back_deg: 10}}"


def test_who_sits_reaches_from_the_seat_and_is_given_back_to_it():
    at, back = (1.6, 0.2, 0.9), "{time: 2, release: anna, hand: right}"
    event = f"{{time: 0.2, reach: anna, hand: right, to: [{at[0]}, {at[1]}, {at[2]}]}}"
    room = ROOM.replace("at: [2, 0], heading_deg: 180", "seat: chair").replace("EVENTS", f"{event}, {back}")
    with mjsim.Simulation(mjsim.parse_world(f"{room}obstacles: [{SEAT}]\n")) as sim:
        start, hips = grip(sim), sim.data.body("anna/pelvis").xpos.copy()
        legs = sim.data.body("anna/left_foot").xpos.copy()
        assert hips[2] < 0.7
        for _ in range(49):
            sim.step()
        np.testing.assert_allclose(grip(sim), at, atol=2e-3)
        np.testing.assert_array_equal(sim.data.body("anna/pelvis").xpos, hips)
        np.testing.assert_array_equal(sim.data.body("anna/left_foot").xpos, legs)
        for _ in range(60):
            sim.step()
        np.testing.assert_allclose(grip(sim), start, atol=1e-9)


def test_a_plan_draws_people_as_they_stand_when_a_hand_was_led_and_says_nothing_of_others():
    world = mjsim.parse_world(ROOM.replace("EVENTS", EVENT))
    people, looks = LedPeople(world), looks_after(world, world.run.events)
    (anna,) = people.outlines(looks).values()
    at_hand = [np.linalg.norm(outline.mean(axis=0) - TO[:2]) for outline, _ in anna]
    assert min(at_hand) < 0.06
    before = [outline for outline, _ in from_above(world, world.people[0])]
    assert min(np.linalg.norm(outline.mean(axis=0) - TO[:2]) for outline in before) > 0.15
    assert people.outlines(looks_after(world, ())) == {}
    # Given back, they are as the plan draws them.
    given_back = [*world.run.events, ReleaseEvent(time=3, release="anna", hand="right")]
    (anna,) = people.outlines(looks_after(world, given_back)).values()
    for (outline, _), was in zip(anna, before, strict=True):
        np.testing.assert_allclose(outline, was, atol=1e-9)


@pytest.mark.slow
def test_a_still_scene_shows_a_hand_on_its_way_as_the_run_had_it():
    world = mjsim.parse_world(ROOM.replace("EVENTS", EVENT))
    scene = StillScene(world)
    with mjsim.Simulation(world) as sim:
        happened = list(sim.happened())
        for _ in range(15):
            sim.step()
            happened += sim.happened()
        assert np.linalg.norm(grip(sim) - TO) > 0.1
        scene.show(sim.data.qpos, looks=looks_after(world, happened, time=sim.time))
        np.testing.assert_array_equal(scene.data.site("anna/right_grip").xpos, grip(sim))


def test_a_still_scene_shows_hands_as_events_left_them_forwards_and_backwards():
    world = mjsim.parse_world(ROOM.replace("EVENTS", EVENT))
    scene = StillScene(world)
    qpos = scene.data.qpos.copy()
    scene.show(qpos)
    first = scene.data.site("anna/right_grip").xpos.copy()
    scene.show(qpos, looks=looks_after(world, world.run.events))
    np.testing.assert_allclose(scene.data.site("anna/right_grip").xpos, TO, atol=1e-3)
    scene.show(qpos)
    np.testing.assert_array_equal(scene.data.site("anna/right_grip").xpos, first)


@pytest.mark.parametrize(
    ("event", "said"),
    [
        ("{time: 0, reach: anna, hand: left}", "a person reaches with a hand; give hand: left or right, and to:"),
        ("{time: 0, reach: anna, hand: left, to: [1, 1, 1], tool: [1, 1, 1]}", "'tool' is for a robot's arm"),
        ("{time: 0, release: anna, hand: left, arm: boom}", "'arm' is for a robot's arm, 'hand' for people"),
        ("{time: 0, release: anna, hand: up}", "hand is 'up'"),
    ],
)
def test_a_reach_that_is_half_said_is_refused(event, said):
    with pytest.raises(WorldError) as caught:
        mjsim.parse_world(ROOM.replace("EVENTS", event))
    assert said in str(caught.value)


@pytest.mark.parametrize("event", ["{time: 0, release: anna}", "{time: 0, reach: anna, tool: [1, 1, 1]}"])
def test_an_event_of_a_person_that_says_no_hand_is_refused(event):
    said = "'anna' is a person; name the hand: left or right"
    world = mjsim.parse_world(ROOM.replace("EVENTS", event))
    assert said in str(check_world(world)[0])
    with pytest.raises(UsageError, match=said):
        mjsim.Simulation(world)


@pytest.mark.parametrize("what", ["reach: ana, hand: left, to: [1, 1, 1]", "release: ana, hand: left"])
def test_a_person_that_is_not_there_is_named(what):
    event = f"{{time: 0, {what}}}"
    with pytest.raises(WorldError) as caught:
        mjsim.parse_world(ROOM.replace("EVENTS", event))
    assert "no person 'ana' in this world; did you mean 'anna'?" in str(caught.value)


@contextmanager
def nesting_at_most(calls):
    """Let functions call each other so deep from here on, and no deeper."""
    limit = sys.getrecursionlimit()
    sys.setrecursionlimit(len(inspect.stack(0)) + calls)
    try:
        yield
    finally:
        sys.setrecursionlimit(limit)


@pytest.mark.slow
def test_a_hand_that_was_led_more_often_than_calls_may_nest_is_shown_from_any_of_them():
    world = mjsim.parse_world(ROOM.replace("EVENTS", ""))
    places = [(1.6, 0.2 * np.sin(k), 1.0 + 0.1 * np.cos(k)) for k in range(80)]
    turns = tuple(HandLed(3.0 * k, "right", (float(x), float(y), float(z))) for k, (x, y, z) in enumerate(places))
    people, looks = LedPeople(world), looks_after(world, ())
    LedPeople(world).values("anna", turns[:1])  # imports, whose calls nest deeper than the others
    with nesting_at_most(60):
        there = people.grips(replace(looks, reached={"anna": turns}))["anna"]["right"]
    np.testing.assert_allclose(there, places[-1], atol=2e-3)
    # Back in time, and another way from there.
    there = people.grips(replace(looks, reached={"anna": turns[:5]}))["anna"]["right"]
    np.testing.assert_allclose(there, places[4], atol=2e-3)
    other = LedPeople(world)
    for anew in ((*turns[:5], turns[9]), turns[:6], ()):
        np.testing.assert_array_equal(people.values("anna", anew), other.values("anna", anew))


def test_others_take_over_how_a_hand_moves_from_the_run_and_get_what_they_would_compute():
    with mjsim.Simulation(mjsim.parse_world(ROOM.replace("EVENTS", EVENT))) as sim:
        for _ in range(6):
            sim.step()
        turns = sim.looks.reached["anna"]
        assert turns[0].motion is not None
        plain = tuple(replace(turn, motion=None) for turn in turns)
        np.testing.assert_array_equal(
            LedPeople(sim.world).values("anna", turns, 0.3), LedPeople(sim.world).values("anna", plain, 0.3)
        )
        # It is taken over, not computed again.
        shifted = tuple(replace(turn, motion=replace(turn.motion, values=turn.motion.values + 1.0)) for turn in turns)
        np.testing.assert_array_equal(LedPeople(sim.world).values("anna", shifted), turns[0].motion.values + 1.0)
