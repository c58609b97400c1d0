"""The services of `simulation_interfaces` at a paused session: results by the package's codes, and one line."""

import numpy as np
import pytest

from mjsim.bridge.simulation_interfaces import SimulationInterfaces
from mjsim.ros import type_hash, typestore
from mjsim.session import Session
from mjsim.world import parse_world
from tests.bridge.desk import Desk

pytest.importorskip("rosbags")

ROOM = """
mjsim: 1
obstacles:
  - {name: crate, box: [0.3, 0.3, 0.4], at: [2, 0], movable: true, mass: 2}
  - {name: shelf, box: [0.3, 0.3, 0.4], at: [3, 0]}
robots: [{name: scout, at: [0, 0]}]
"""
PACKAGE = "simulation_interfaces"


@pytest.fixture(scope="module")
def desk():
    desk, seen = Desk(), []
    with Session(parse_world(ROOM), on_tick=lambda tick: [each(tick) for each in seen]) as session:
        interfaces = SimulationInterfaces(desk, session, patience=20.0)
        seen.append(interfaces.see)
        session.pause()
        session.wait("paused", timeout=20.0)
        desk.call("StepSimulation", 1)
        desk.session = session
        yield desk


def of(kind: str, *values: object):
    return typestore().types[kind](*values)


def state_at(
    x: float, y: float, z: float = 0.0, *, frame: str = "map", w: float = 1.0, forward: float = 0.0, push: float = 0.0
):
    vector, point = "geometry_msgs/msg/Vector3", of("geometry_msgs/msg/Point", x, y, z)
    still = of(vector, 0.0, 0.0, 0.0)
    header = of("std_msgs/msg/Header", of("builtin_interfaces/msg/Time", 0, 0), frame)
    pose = of("geometry_msgs/msg/Pose", point, of("geometry_msgs/msg/Quaternion", 0.0, 0.0, 0.0, w))
    twist = of("geometry_msgs/msg/Twist", of(vector, forward, 0.0, 0.0), still)
    return of(
        f"{PACKAGE}/msg/EntityState",
        header,
        pose,
        twist,
        of("geometry_msgs/msg/Accel", of(vector, push, 0.0, 0.0), still),
    )


def filters(text: str, *, categories: tuple[int, ...] = ()):
    kinds = [of(f"{PACKAGE}/msg/EntityCategory", each) for each in categories]
    empty = of(f"{PACKAGE}/msg/TagsFilter", [], 0), of(f"{PACKAGE}/msg/Bounds", 0, [])
    return of(f"{PACKAGE}/msg/EntityFilters", text, kinds, *empty)


def test_features_are_those_that_answer(desk):
    features = desk.call("GetSimulatorFeatures", 0).features
    assert features.features.tolist() == [0, 1, 10, 11, 14, 20, 24, 25, 26, 31, 32]
    assert len(features.spawn_formats) == 0


def test_entities_are_listed_by_a_regular_expression(desk):
    assert desk.call("GetEntities", filters("")).entities == ["scout", "crate", "shelf"]
    assert desk.call("GetEntities", filters("^s")).entities == ["scout", "shelf"]
    assert desk.call("GetEntities", filters("(")).result.result == 4
    assert desk.call("GetEntities", filters("", categories=(1,))).result.result == 0


def test_an_entity_is_where_it_was_set_after_a_step(desk):
    before = desk.call("GetEntityState", "crate").state.pose.position
    assert (before.x, before.y) == pytest.approx((2.0, 0.0), abs=1e-3)
    assert desk.call("SetEntityState", "crate", state_at(2.0, 1.5), True, False, False).result.result == 1
    assert desk.call("StepSimulation", 2).result.result == 1
    found = desk.call("GetEntityState", "crate").state
    assert (found.pose.position.x, found.pose.position.y) == pytest.approx((2.0, 1.5), abs=1e-3)
    assert found.header.frame_id == "map"


def test_a_state_that_was_told_can_be_set_again_at_its_height(desk):
    for name in ("scout", "crate"):
        told = desk.call("GetEntityState", name).state
        assert desk.call("SetEntityState", name, told, True, False, False).result.result == 1


def test_a_zero_twist_without_a_pose_stops_an_entity_where_it_is(desk):
    here = desk.call("GetEntityState", "crate").state.pose.position
    assert desk.call("SetEntityState", "crate", state_at(9, 9), False, True, False).result.result == 1
    event = desk.session.touched[-1]
    assert (event.move, event.to) == ("crate", pytest.approx((here.x, here.y), abs=1e-3))


@pytest.mark.parametrize(
    ("service", "fields", "code", "says"),
    [
        ("GetEntityState", ("crat",), 2, "no entity 'crat'; did you mean 'crate'?"),
        ("DeleteEntity", ("box",), 2, "no entity 'box'"),
        ("DeleteEntity", ("scout",), 4, "no beacon or obstacle 'scout'"),
        ("SetEntityState", ("shelf", state_at(1, 1), True, False, False), 4, "no robot or movable obstacle 'shelf'"),
        ("SetEntityState", ("crate", state_at(1, 1, frame="odom"), True, False, False), 101, "the frame 'odom'"),
        ("SetEntityState", ("crate", state_at(1, 1, w=0.5), True, False, False), 101, "has length 0.5"),
        ("SetEntityState", ("crate", state_at(np.nan, 1), True, False, False), 101, "not finite"),
        ("SetEntityState", ("crate", state_at(1, 1, forward=1.0), True, True, False), 0, "acceleration at zero"),
        ("SetEntityState", ("crate", state_at(1, 1, push=1.0), True, False, True), 0, "acceleration at zero"),
        ("SetEntityState", ("crate", state_at(1, 1, 0.3), True, False, False), 101, "z is 0.3 m; 'crate' keeps its"),
        ("SetEntityState", ("scout", state_at(1, 1, -0.1), True, False, False), 101, "z is -0.1 m; 'scout' keeps"),
        ("StepSimulation", (0,), 4, "steps is 0; it must be from 1"),
        ("ResetSimulation", (1,), 0, "scope is 1; only the whole"),
        ("SetSimulationState", (of(f"{PACKAGE}/msg/SimulationState", 2),), 101, "in this state already"),
        ("SetSimulationState", (of(f"{PACKAGE}/msg/SimulationState", 3),), 0, "ended where it was started"),
        ("SetSimulationState", (of(f"{PACKAGE}/msg/SimulationState", 9),), 103, "of one world"),
    ],
)
def test_a_wrong_request_has_a_result_and_one_line(desk, service, fields, code, says):
    result = desk.call(service, *fields).result
    assert (result.result, says in result.error_message) == (code, True), result.error_message
    assert "\n" not in result.error_message


def test_what_was_deleted_is_an_entity_until_a_reset(desk):
    assert desk.call("DeleteEntity", "shelf").result.result == 1
    assert desk.call("GetEntities", filters("")).entities == ["scout", "crate"]
    assert desk.call("ResetSimulation", 0).result.result == 1
    assert desk.call("GetEntities", filters("")).entities == ["scout", "crate", "shelf"]


def spawn(
    desk,
    uri: str,
    x: float,
    y: float,
    z: float = 0.0,
    *,
    text: str = "",
    name: str = "",
    renames: bool = True,
    at="",
    w=1.0,
):
    """Return the answer of SpawnEntity."""
    state = state_at(x, y, z, frame="map", w=w)
    pose = of("geometry_msgs/msg/PoseStamped", state.header, state.pose)
    return desk.call("SpawnEntity", name, renames, of(f"{PACKAGE}/msg/Resource", uri, text), at, pose)


def spawnables(desk) -> list[str]:
    answer = desk.call("GetSpawnables", [])
    assert answer.result.result == 1
    return [each.entity_resource.uri for each in answer.spawnables]


def test_what_was_deleted_is_spawnable_and_comes_back_at_its_pose(desk):
    assert spawnables(desk) == []
    assert desk.call("DeleteEntity", "crate").result.result == 1
    assert spawnables(desk) == ["crate"]
    desk.call("StepSimulation", 1)
    assert spawnables(desk) == ["crate"]
    answer = spawn(desk, "crate", 1.0, 1.5, name="box")
    assert (answer.result.result, answer.entity_name) == (1, "crate"), answer.result.error_message
    assert spawnables(desk) == []
    desk.call("StepSimulation", 2)
    place = desk.call("GetEntityState", "crate").state.pose.position
    assert (place.x, place.y) == pytest.approx((1.0, 1.5), abs=1e-3)
    assert desk.call("GetSpawnables", ["/usr/share/models"]).result.error_message.startswith("no source '/usr/share")


@pytest.mark.parametrize(
    ("given", "more", "code", "says"),
    [
        (("shelf", 2.0, 2.0), {}, 109, "'shelf' is fixed and comes back where it stood: x = 3, y = 0, heading 0 deg"),
        (("shelf", 3.0, 0.0), {"name": "rack", "renames": False}, 102, "leave name empty, or allow renaming"),
        (("shelf", 3.0, 0.0), {"at": "/left"}, 105, "leave entity_namespace empty"),
        (("shelf", 3.0, 0.0, 0.4), {}, 109, "z is 0.4 m; 'shelf' keeps its height"),
        (("shelf", 3.0, 0.0), {"w": 0.0}, 109, "the quaternion has length 0"),
        (("scout", 3.0, 0.0), {}, 101, "'scout' is there already; there are shelf"),
        (("file:///box.sdf", 3.0, 0.0), {}, 2, "no uri 'file:///box.sdf'; there are shelf; a running world takes no"),
        (("", 3.0, 0.0), {}, 104, "give a uri; there are shelf"),
        (("", 3.0, 0.0), {"text": "<sdf/>"}, 103, "give a uri; there are shelf"),
    ],
)
def test_what_cannot_be_spawned_has_its_code_and_a_line_with_what_can(desk, given, more, code, says):
    if spawnables(desk) != ["shelf"]:
        desk.call("DeleteEntity", "shelf")
    answer = spawn(desk, *given, **more)
    assert (answer.result.result, says in answer.result.error_message) == (code, True), answer.result.error_message
    assert answer.entity_name == ""
    assert "\n" not in answer.result.error_message


def test_a_fixed_entity_comes_back_where_it_stood_but_not_into_another(desk):
    desk.call("ResetSimulation", 0)
    desk.call("DeleteEntity", "shelf")
    desk.call("StepSimulation", 1)
    desk.call("SetEntityState", "crate", state_at(3.0, 0.0), True, False, False)
    blocked = spawn(desk, "shelf", 3.0, 0.0).result
    assert (blocked.result, blocked.error_message) == (
        4,
        "'shelf' would come back inside obstacle 'crate'; move that away first",
    )
    desk.call("SetEntityState", "crate", state_at(2.0, 0.0), True, False, False)
    assert spawn(desk, "shelf", 3.0, 0.0).result.result == 1
    desk.call("StepSimulation", 1)
    assert desk.call("GetEntities", filters("")).entities == ["scout", "crate", "shelf"]


def test_what_an_event_removes_at_the_start_waits_to_be_spawned():
    events = "run: {events: [{time: 0, remove: spare}, {time: 0.04, remove: rack}]}"
    spare = "  - {name: spare, cylinder: [0.2, 0.5], at: [0, 3], movable: true}\n"
    rack = "  - {name: rack, box: [0.4, 0.4, 1], at: [5, 0]}\n"
    hung = "beacons: [{name: plate, at: [-0.2, 0], heading_deg: 180, on: rack, center: 0.5, width: 0.3}]\n"
    world = parse_world(ROOM.replace("robots:", f"{spare}{rack}{hung}robots:") + events)
    desk, seen = Desk(), []
    with Session(world, on_tick=lambda tick: [each(tick) for each in seen]) as session:
        interfaces = SimulationInterfaces(desk, session, patience=20.0)
        seen.append(interfaces.see)
        session.pause()
        session.wait("paused", timeout=20.0)
        desk.call("StepSimulation", 3)
        assert spawnables(desk) == ["spare", "rack"]  # the plate comes with the rack
        assert spawn(desk, "rack", 5.0, 0.0).result.result == 1
        assert spawn(desk, "spare", 1.0, 1.0).result.result == 1
        desk.call("StepSimulation", 1)
        assert spawnables(desk) == []
        assert desk.call("GetEntities", filters("a")).entities == ["crate", "spare", "rack", "plate"]


def test_it_plays_pauses_and_stops(desk):
    def now() -> int:
        return desk.call("GetSimulationState", 0).state.state

    for wanted in (1, 2, 0, 2, 1):
        changed = desk.call("SetSimulationState", of(f"{PACKAGE}/msg/SimulationState", wanted)).result
        assert (changed.result, now()) == (1, wanted), changed.error_message
    assert desk.call("StepSimulation", 1).result.result == 4
    desk.call("SetSimulationState", of(f"{PACKAGE}/msg/SimulationState", 2))


def test_services_have_the_hash_of_the_package():
    # By rosbags from the definitions of tag 2.1.0.
    known = "913fe0653690ce6bf8f09f316e6a626747012e9fca31e26719910d417aa8565c"
    assert type_hash(f"{PACKAGE}/srv/msg/StepSimulation_Request") == f"RIHS01_{known}"
