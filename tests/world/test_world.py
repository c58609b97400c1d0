"""Text to world and back: the same values, the same comments, nothing of YAML 1.1."""

import dataclasses
import json
import sys
from pathlib import Path

import pytest
from pydantic import TypeAdapter

from mjsim.errors import UsageError, WorldError
from mjsim.world import (
    Beacon,
    BoxObstacle,
    Camera,
    CylinderObstacle,
    Opening,
    Robot,
    Source,
    Wall,
    World,
    format_world,
    load_checked,
    load_world,
    parse_world,
    with_settings,
    world_schema,
)
from mjsim.world.ground.model_base import ModelPath
from tests.children import completed

ROOM = """\
mjsim: 1
name: gallery
walls:
  - points: [[0, 0], [12, 0], [12, 8], [0, 8]]   # centrelines
    closed: true                        # the closing segment is the last one
    thickness: 0.12
    openings:                           # doorways and windows
      - {segment: 0, at: 4.0, width: 0.9}                         # a door
      - {segment: 2, at: 3.0, width: 1.2, sill: 0.9, head: 2.0}   # a window
obstacles:
  - {box: [0.8, 0.5, 1.1], at: [3, 4], heading_deg: 30}           # full sizes
  - {cylinder: [0.2, 1.0], at: [6, 2], name: pillar}
beacons:
  - {name: r1, at: [0.1, 3]}            # a reflector
robots:
  - name: scout
    preset: pioneer3dx                  # keys here override it
    at: [1, 1]
    drive: {max_speed: 0.5, noise: {speed: 0.02, turn: 0.02}}
    sensors:
      - {camera: front, at: [0.15, 0, 0.35], rate_hz: 12.5}
run:
  seconds: 120
  drivers:
    scout:
      estimator: {use: "mjsim.algorithms.ekf_slam:EkfSlam", jacobians: first-estimates}
      avoidance: true                   # false, or the user's own
"""


@pytest.fixture(scope="module")
def room():
    return parse_world(ROOM)


def test_a_text_says_what_the_same_values_in_python_say(room):
    built = World(
        name="gallery",
        walls=(
            Wall(
                points=((0, 0), (12, 0), (12, 8), (0, 8)),
                closed=True,
                thickness=0.12,
                openings=(Opening(at=4.0, width=0.9), Opening(segment=2, at=3, width=1.2, sill=0.9, head=2.0)),
            ),
        ),
        obstacles=(
            BoxObstacle(box=(0.8, 0.5, 1.1), at=(3, 4), heading_deg=30),
            CylinderObstacle(cylinder=(0.2, 1.0), at=(6, 2), name="pillar"),
        ),
        beacons=(Beacon(name="r1", at=(0.1, 3)),),
        robots=(
            Robot.model_validate(
                {
                    "name": "scout",
                    "preset": "pioneer3dx",
                    "at": (1, 1),
                    "drive": {"max_speed": 0.5, "noise": {"speed": 0.02, "turn": 0.02}},
                    "sensors": (Camera(camera="front", at=(0.15, 0, 0.35)),),
                }
            ),
        ),
        run=room.run,
    )
    assert built == room
    assert parse_world(format_world(built)) == room


def test_a_written_world_reads_back_equal_and_keeps_its_text(room):
    assert format_world(room) == ROOM
    assert parse_world(format_world(room)) == room


def test_a_world_that_changed_since_it_was_read_keeps_its_comments(room):
    robot = room.robots[0].model_copy(update={"at": (2.0, 3.5)})
    beacons = (*room.beacons, Beacon(name="r2", at=(5, 5)))
    changed = room.model_copy(update={"robots": (robot,), "beacons": beacons, "obstacles": room.obstacles[1:]})
    text = format_world(changed)
    assert parse_world(text) == changed
    gone = "# full sizes"
    for comment in (line.partition("#")[2] for line in ROOM.splitlines() if "# " in line):
        assert (comment in text) is (comment not in gone), comment


def test_a_world_whose_aliases_cannot_be_changed_alone_is_written_without_them():
    text = "walls:\n- &w {points: [[0, 0], [1, 0]]}\n- *w\n"
    world = parse_world(text)
    changed = world.model_copy(update={"walls": (world.walls[0], world.walls[1].model_copy(update={"height": 1.0}))})
    assert parse_world(format_world(changed)) == changed


def test_a_value_that_overrides_a_preset_with_the_common_default_is_written(room):
    from mjsim.world.items import presets

    below = presets.over_preset("pioneer3dx", {}, Source())
    robot = Robot(name="a", at=(0, 0), preset="pioneer3dx")
    assert robot.body.mass == below["body"]["mass"]
    heavy = Robot.model_validate({"name": "a", "at": (0, 0), "preset": "pioneer3dx", "body": {"mass": 20.0}})
    world = World(robots=(heavy,))
    assert heavy.body.radius == below["body"]["radius"]
    assert parse_world(format_world(world)) == world
    assert "mass: 20" in format_world(world)
    assert "radius" not in format_world(world)


def test_values_of_yaml_1_1_stay_text():
    use = "{use: 'a.b:C', switch: no, time: 12:30, day: 2026-01-02, number: 1e3, mask: 0x1F, octal: 010, nothing: ~}"
    world = parse_world(f"robots: [{{name: a, at: [0, 0]}}]\nrun: {{drivers: {{a: {{navigator: {use}}}}}}}\n")
    navigator = world.run.drivers["a"].navigator
    assert navigator is not None
    assert navigator.arguments() == {
        "switch": "no",
        "time": "12:30",
        "day": "2026-01-02",
        "number": 1000.0,
        "mask": 31,
        "octal": 10,
        "nothing": None,
    }
    assert parse_world(format_world(World(robots=world.robots, run=world.run))) == world


def test_a_file_may_begin_with_a_byte_order_mark_and_end_its_lines_as_windows_does(tmp_path):
    path = tmp_path / "room.yaml"
    path.write_bytes(b"\xef\xbb\xbf" + ROOM.replace("\n", "\r\n").encode())
    assert load_world(path) == parse_world(ROOM)


def test_pictures_are_found_beside_the_file_then_among_the_assets_then_attached(tmp_path):
    import cv2
    import numpy as np

    data = cv2.imencode(".png", np.zeros((2, 3, 3), np.uint8))[1].tobytes()
    text = "floor: {texture: tile.png}"
    (tmp_path / "tile.png").write_bytes(data)
    (tmp_path / "room.yaml").write_text(text)
    assert load_world(tmp_path / "room.yaml").read_asset("tile.png") == data
    assert parse_world(text, source=Source(attached={"tile.png": data})).read_asset("tile.png") == data
    with pytest.raises(WorldError, match=r"world.yaml:1:18: no file 'tile.png' beside the world file or in assets"):
        parse_world(text)


def test_what_is_well_written_but_cannot_be_meant_is_refused_by_load_checked_only(tmp_path):
    path = tmp_path / "room.yaml"
    path.write_text("walls: [{points: [[0, 0], [4, 0]]}]\nrobots: [{name: a, at: [1, 0.1]}]\n")
    load_world(path)
    with pytest.raises(WorldError, match=r"room.yaml:2:24: robot 'a' at \[1, 0.1\] starts inside walls\[0\]"):
        load_checked(path)


def test_a_file_that_is_not_there_is_the_users_mistake(tmp_path):
    with pytest.raises(UsageError, match="no file"):
        load_world(tmp_path / "none.yaml")


def test_single_values_are_set_by_their_path(room):
    changed = with_settings(room, ["robots.scout.odometry.noise.turn=0.02", "walls.0.height=3", "run.seconds=20"])
    assert changed.robots[0].odometry.noise.turn == 0.02
    assert changed.robots[0].drive == room.robots[0].drive
    assert (changed.walls[0].height, changed.run.seconds) == (3.0, 20.0)
    assert parse_world(format_world(changed)) == changed


@pytest.mark.parametrize(
    ("setting", "reason"),
    [
        ("run.secnds=2", "no key 'secnds'; did you mean 'seconds'?"),
        ("robots.scot.at=[1, 2]", "no item 'scot'; did you mean 'scout'?"),
        ("run.seconds=-1", "seconds is -1 s; it must be above 0"),
        (
            "robots.scout.at=[0, 2]",
            "robot 'scout' at [0, 2] starts inside walls[0]; its body needs 0.22 m free all around",
        ),
    ],
)
def test_a_setting_that_does_not_fit_is_the_users_mistake(room, setting, reason):
    with pytest.raises(UsageError) as caught:
        with_settings(room, [setting])
    assert str(caught.value) == f"--set {setting}: {reason}"


@pytest.mark.slow
def test_the_schema_knows_every_key_with_its_meaning_and_bounds_lists_by_length():
    schema = world_schema()
    text = json.dumps(schema)
    assert "prefixItems" not in text
    assert set(schema["properties"]) == set(World.model_fields)
    wall = schema["$defs"]["Wall"]["properties"]
    assert wall["thickness"] == {
        "default": 0.1,
        "description": "[m]",
        "exclusiveMinimum": 0,
        "maximum": 10000.0,
        "title": "Thickness",
        "type": "number",
    }
    assert (wall["points"]["items"]["minItems"], wall["points"]["items"]["maxItems"]) == (2, 2)
    assert schema["$defs"]["Wall"]["additionalProperties"] is False
    assert schema["$defs"]["Robot"]["required"] == ["name", "at"]


@pytest.mark.slow
def test_reading_worlds_brings_in_neither_shapely_nor_mujoco():
    code = (
        "import sys, mjsim; mjsim.parse_world(sys.argv[1]);"
        "assert not {'shapely', 'mujoco', 'matplotlib'} & set(sys.modules)"
    )
    completed([sys.executable, "-c", code, ROOM])


@pytest.mark.parametrize("end", [".xml", ".mjcf", ".urdf", ".xacro", ".sdf"])
def test_models_are_known_by_their_ending_in_letters_of_either_case(end):
    path = TypeAdapter(ModelPath)
    assert [path.validate_python(f"Chair{text}") for text in (end, end.upper())] == [
        f"Chair{end}",
        f"Chair{end.upper()}",
    ]
    with pytest.raises(ValueError, match="is not a model; name an MJCF"):
        path.validate_python(f"Chair{end}.obj")


def test_worlds_are_equal_whatever_they_were_read_from():
    given = {"file": "a", "text": "b", "folder": Path("c"), "attached": {"d": b""}, "included": {"e": b""}}
    given |= {"variables": {"f": 1}, "written": 1, "admit": print, "live": {"g": 1}}
    assert given.keys() == {field.name for field in dataclasses.fields(Source)}
    assert all(Source(**{name: value}) == Source() for name, value in given.items())


@pytest.mark.parametrize(
    ("drive", "body", "said"),
    [
        ("balancing", "box: [0.2, 0.3, 0.5], center: 0.3, at: [0.05, 0]", "centred above the axle; leave out 'at'"),
        ("differential", "box: [0.4, 0.3, 0.5], at: [0.3, 0]", r"origin \[0, 0\] is outside the body"),
        ("differential", "polygon: [[0.1, 0.1], [0.5, 0.1], [0.5, 0.5]], height: 0.2", "is outside the body"),
    ],
)
def test_a_body_lies_around_the_origin_of_its_robot(drive, body, said):
    text = "mjsim: 1\nrobots: [{name: r, at: [0, 0], drive: {type: DRIVE}, body: {BODY}}]\n"
    with pytest.raises(WorldError, match=said):
        parse_world(text.replace("DRIVE", drive).replace("BODY", body))
