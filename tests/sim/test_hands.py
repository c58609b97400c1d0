"""Hands of people that events move: where they are, who sees it, and that it repeats."""

import numpy as np
import pytest

import mjsim
from mjsim.errors import WorldError
from mjsim.sim import StillScene
from mjsim.sim.hands import LedPeople
from mjsim.world import looks_after

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
LIDAR = "{lidar3d: scan, at: [0, 0, 1.0], rings: 16, columns: 360, rate_hz: 12.5}"
TO = (1.65, 0.1, 1.0)
EVENT = f"{{time: 0.2, reach: anna, hand: right, to: [{TO[0]}, {TO[1]}, {TO[2]}]}}"


def grip(sim, side="right"):
    return sim.data.site(f"anna/{side}_grip").xpos.copy()


def nearest(sim):
    return float(np.min(sim.sense("r").scans["scan"].ranges))


def test_a_hand_goes_where_an_event_leads_it_and_a_lidar_meets_it_there():
    with mjsim.Simulation(mjsim.parse_world(ROOM.replace("EVENTS", EVENT))) as sim:
        before, left, legs = nearest(sim), grip(sim, "left"), sim.data.body("anna/left_foot").xpos.copy()
        for _ in range(10):
            sim.step()
        np.testing.assert_allclose(grip(sim), TO, atol=1e-3)
        np.testing.assert_array_equal(sim.data.body("anna/left_foot").xpos, legs)
        assert np.linalg.norm(grip(sim, "left") - left) < 0.3  # it hangs on a trunk that may turn
        assert nearest(sim) < before - 0.1
        sim.reset()
        assert nearest(sim) == pytest.approx(before, abs=1e-6)


def test_a_3d_lidar_meets_a_hand_where_it_was_led_and_no_longer_where_it_was():
    room = ROOM.replace("{lidar: scan, at: [0, 0, 1.0], beams: 181, fov_deg: 40, range: [0.05, 10]}", LIDAR)
    with mjsim.Simulation(mjsim.parse_world(room.replace("EVENTS", EVENT))) as sim:
        seen = []
        for _ in range(20):
            sim.step()
            if (cloud := sim.sense("r").clouds.get("scan")) is not None:
                seen.append(float(np.linalg.norm(cloud.points[cloud.points[:, 2] > -0.5], axis=1).min()))
    assert min(seen[-3:]) < seen[0] - 0.1


def test_a_hand_out_of_reach_comes_as_near_as_it_can():
    event = "{time: 0, reach: anna, hand: left, to: [-3, 0, 1.2]}"
    with mjsim.Simulation(mjsim.parse_world(ROOM.replace("EVENTS", event))) as sim:
        x, _, z = grip(sim, "left")
        assert 1.0 < x < 1.6
        assert abs(z - 1.2) < 0.2


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
        ("{time: 0, reach: anna, hand: left, to: [1, 1, 1], tool: [1, 1, 1]}", "'tool' is of a robot's arm"),
    ],
)
def test_a_reach_that_is_half_said_is_refused(event, said):
    with pytest.raises(WorldError) as caught:
        mjsim.parse_world(ROOM.replace("EVENTS", event))
    assert said in str(caught.value)


def test_a_person_that_is_not_there_is_named():
    event = "{time: 0, reach: ana, hand: left, to: [1, 1, 1]}"
    with pytest.raises(WorldError) as caught:
        mjsim.parse_world(ROOM.replace("EVENTS", event))
    assert "no person 'ana' in this world; did you mean 'anna'?" in str(caught.value)


@pytest.mark.slow
def test_a_hand_that_was_led_a_thousand_times_is_shown_from_any_of_them():
    world = mjsim.parse_world(ROOM.replace("EVENTS", ""))
    places = [(1.6, 0.2 * np.sin(k), 1.0 + 0.1 * np.cos(k)) for k in range(1000)]
    reaches = tuple(("right", (float(x), float(y), float(z))) for x, y, z in places)
    people = LedPeople(world)
    there = people.grips({"anna": reaches})["anna"]["right"]
    np.testing.assert_allclose(there, places[-1], atol=2e-3)
    # Back in time, and another way from there.
    np.testing.assert_allclose(people.grips({"anna": reaches[:5]})["anna"]["right"], places[4], atol=2e-3)
    other = LedPeople(world)
    for anew in ((*reaches[:5], reaches[9]), reaches[:6], ()):
        np.testing.assert_array_equal(people.values("anna", anew), other.values("anna", anew))
