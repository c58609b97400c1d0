"""Worlds of Webots come in: solids by their bounding objects, walls, doors and furniture of its library, both axes."""

import codecs
import math

import mujoco
import numpy as np
import pytest

from mjsim.compile import compile_world
from mjsim.errors import UsageError
from mjsim.exchange.scenes.wbt_in import read_wbt
from mjsim.exchange.world_import import Newcomer
from mjsim.world import solid
from tests.exchange.test_scenes import brought

HEAD = "#VRML_SIM R2023b utf8\n"
ROOM = (
    HEAD
    + """
EXTERNPROTO "webots://projects/objects/apartment_structure/protos/Wall.proto" # a comment with "quotes"
WorldInfo { title "room" basicTimeStep 16 }
Viewpoint { position 1 2 3 }
DEF SOUTH Wall { translation 3 0 0 rotation 0 0 1 1.5707963 size 0.15 6 2.5 name "south" }
Wall { translation 3 4 0 rotation 0 0 1 1.5707963 size 0.15 6 2.5 name "north" }
Wall { translation 0 2 0 size 0.15 4 2.5 name "west" appearance PBRAppearance { baseColor 1 0 0 metalness 0 } }
Wall { translation 6 0.75 0 size 0.15 1.5 2.5 }
Door { translation 6 2 0 size 0.15 1 2.5 name "exit" canBeOpen TRUE jointAtLeft FALSE }
Window { translation 6 3.25 0 size 0.15 1.5 2.5 bottomWallHeight 0.8 windowHeight 1.2 }
Table { translation 2 2 0 name "table" size 1 1.8 0.7 feetSize 0.1 0.1 frameThickness 0.05 }
Cabinet { translation 0.1 3 0 name "cabinet" depth 0.4 outerThickness 0.02
  columnsWidths [ 0.5, 0.5 ] rowsHeights [ 0.4 0.4 ] }
Chair { translation 4 3 0 name "chair" }
Transform { translation 4 1 0 children [ DEF BALL Solid { translation 0 0 0.2 name "ball"
  physics Physics { mass 0.5 density -1 }
  boundingObject Sphere { radius 0.2 } children [ Shape { geometry Sphere { radius 0.2 } } ] } ] }
TurtleBot3Burger { translation 1 1 0 rotation 0 0 1 0.5 controller "nothing" }
Lego { translation 3 3 0 name "duplo" }
PointLight { location 2 2 2.4 color 1 1 0 }
"""
)

DOUBLED = "DEF A0 Group { children [ Pose { } ] }" + "".join(
    f"DEF A{k} Group {{ children [ USE A{k - 1} USE A{k - 1} ] }}" for k in range(1, 40)
)
"""Few nodes that use each other twice: 2^40."""
CHAINED = "DEF A0 Group { }" + "".join(
    f"DEF A{k} " + "Group { children [" * 60 + f"USE A{k - 1}" + "] }" * 60 for k in range(1, 30)
)
"""Nodes that are 60 deep each, one in the other."""


def world_of(text: str, folder, *, name: str = "room.wbt"):
    path = folder / name
    path.write_text(text)
    return path


def test_walls_doors_windows_and_furniture_of_the_library_stand_where_webots_puts_them(tmp_path):
    world, found = brought(world_of(ROOM, tmp_path), robot=Newcomer("turtlebot3_burger"))
    assert solid(world).bounds[:2] == pytest.approx((-0.075, -0.075), abs=1e-3)
    holes = sorted((hole.sill, hole.head, hole.width) for wall in world.walls for hole in wall.openings)
    assert holes == [pytest.approx((0.0, 2.0, 1.0)), pytest.approx((0.8, 2.0, 1.5))]
    assert any(wall.color == "#ff0000" for wall in world.walls)
    things = {thing.name: thing for thing in world.obstacles}
    assert (things["ball"].sphere, things["ball"].mass, things["ball"].at) == (0.2, 0.5, (4.0, 1.0))
    assert (things["cabinet"].box, things["cabinet"].at) == ((0.4, 1.04, 0.84), (0.3, 3.0))
    legs = [thing for name, thing in things.items() if name.startswith("table")]
    assert sorted(leg.elevation for leg in legs) == [0.0] * 4 + [0.65]
    assert (world.robots[0].at, round(math.radians(world.robots[0].heading_deg), 2)) == ((1.0, 1.0), 0.5)
    assert world.lamps[0].at == (2.0, 2.0)
    report = "\n".join(found.report)
    assert "guessed: Chair PROTO 'chair': a box of 0.5 x 0.45 x 0.9 m" in report
    assert "left out: node 'Lego': unknown to mjsim; for a PROTO" in report
    assert "left out: robot 'Robot': its start is kept" in report


def test_a_door_of_webots_opens_about_its_hinge(tmp_path):
    world, _ = brought(world_of(ROOM, tmp_path))
    model = compile_world(world).compile()
    (hinge,) = [k for k in range(model.njnt) if "leaf" in model.joint(k).name]
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    # At the right end of the leaf, in front of the wall and its frame.
    assert data.xanchor[hinge][:2] == pytest.approx([6.0 + 0.075 + 0.05, 2.0 + 0.475], abs=1e-3)
    assert model.jnt_range[hinge] == pytest.approx([-0.01, 1.57], abs=1e-3)


@pytest.mark.parametrize(
    ("axes", "place", "turn", "size"),
    [("R2023b", "1 2 0.25", "0 0 1", "2 0.6 0.5"), ("R2020a", "2 0.25 1", "0 1 0", "0.6 0.5 2")],
)
def test_old_worlds_with_y_up_are_turned(axes, place, turn, size, tmp_path):
    body = f'Solid {{ name "a" translation {place} rotation {turn} 0.4 boundingObject Box {{ size {size} }} }}'
    scene = read_wbt(world_of(f"#VRML_SIM {axes} utf8\n{body}", tmp_path))
    (thing,) = scene.things
    (box,) = thing.solids
    assert box.size == (2.0, 0.6, 0.5)
    assert box.pose[:3, 3] == pytest.approx([1.0, 2.0, 0.25])
    assert box.heading == pytest.approx(0.4)


def test_bounding_objects_groups_scales_and_uses_are_followed(tmp_path):
    text = (
        HEAD
        + """
    DEF CRATE Solid { translation 1 0 0 name "crate" boundingObject DEF B Group { children [
      Pose { translation 0 0 0.5 children [ Box { size 1 1 1 } ] }
      Transform { translation 2 0 0.5 scale 2 2 1 children [ Shape { geometry Cylinder { radius 0.25 height 1 } } ] }
      ] } }
    Solid { translation 1 9 0 name "other" boundingObject USE B }
    Solid { translation 5 5 0 name "roof" boundingObject IndexedFaceSet { coord Coordinate { point [
      0 0 0, 2 0 0, 2 1 0, 0 1 0, 1 0.5 1 ] } coordIndex [ 3 2 1 0 -1, 0 1 4 -1, 1 2 4 -1, 2 3 4 -1, 3 0 4 ] } }
    Solid { name "seen" children [ Shape { geometry Box { size 1 1 1 } } ] }
    """
    )
    scene = read_wbt(world_of(text, tmp_path))
    crate, other, roof = scene.things
    assert [solid.size for solid in crate.solids] == [(1.0, 1.0, 1.0), (0.5, 1.0)]
    assert other.solids[1].pose[:3, 3] == pytest.approx([3.0, 9.0, 0.5])
    assert np.concatenate([solid.corners() for solid in roof.solids]).max(axis=0) == pytest.approx([7.0, 6.0, 1.0])
    assert [(item.kind, item.name) for item in scene.items] == [("visible solid", "seen")]


@pytest.mark.parametrize(("version", "turn"), [("R2023b", "0 0 1"), ("R2020b", "0 1 0")])
def test_urdf_repair_act_on_all_that_is_in_a_node(version, turn, tmp_path):
    """A box of 0.5 m, twice as large, a quarter turn, and moved by twice its offset; its door by the same."""
    at = {"R2023b": "1 0 0.25", "R2020b": "0 0.25 1"}[version]
    solid_box = "boundingObject Box { size 0.5 0.5 0.5 }"
    door = "HingeJoint { jointParameters HingeJointParameters { anchor 0.5 0.5 0.5 } endPoint Solid { name"
    text = (
        f"#VRML_SIM {version} utf8\nTransform {{ scale 2 2 2 rotation {turn} 1.5707963 children [ Solid {{ name "
        f'"a" translation {at} {solid_box} children [ {door} "leaf" {solid_box} }} }} ] }} ] }}'
        f"Solid {{ scale 0.5 0.5 0.5 boundingObject Sphere {{ radius 0.4 }} }}"
    )
    thing, ball = read_wbt(world_of(text, tmp_path)).things
    ((box,), (part,)) = thing.solids, thing.parts
    assert (box.size, part.solids[0].size) == ((1.0, 1.0, 1.0), (1.0, 1.0, 1.0))
    np.testing.assert_allclose(box.pose @ [0.5, 0.5, 0.5, 1.0], [-0.5, 2.5, 1.0, 1.0], atol=1e-6)
    np.testing.assert_allclose(part.joints[0].anchor, [-1.0, 3.0, 1.5], atol=1e-6)
    assert np.linalg.norm(part.joints[0].axis) == pytest.approx(1.0)
    assert np.linalg.norm(thing.pose[:3, :3], axis=0) == pytest.approx(1.0)
    assert ball.solids[0].size == pytest.approx((0.2,))


def test_a_mirrored_face_set_still_looks_outwards(tmp_path):
    faces = "coordIndex [ 0 2 1 -1 0 1 3 -1 1 2 3 -1 2 0 3 ]"
    text = f"""{HEAD}Pose {{ children [ Solid {{ scale -2 1 1 name "tip" boundingObject IndexedFaceSet {{
      coord Coordinate {{ point [ 0 0 0, 1 0 0, 0 1 0, 0 0 1 ] }} {faces} }} }} ] }}"""
    (thing,) = read_wbt(world_of(text, tmp_path)).things
    (tip,) = thing.solids
    corners = tip.vertices[tip.faces] @ tip.pose[:3, :3].T
    a, b, c = corners.transpose(1, 0, 2)
    assert float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0 == pytest.approx(2 / 6)
    assert tip.corners().min(axis=0) == pytest.approx([-2.0, 0.0, 0.0])


def test_a_door_of_absurd_mass_still_makes_a_world(tmp_path):
    leaf = 'Solid { name "leaf" boundingObject Box { size 0.04 0.9 2 } physics Physics { density -1 mass 1e300 } }'
    world, found = brought(world_of(f"{HEAD}Solid {{ children [ HingeJoint {{ endPoint {leaf} }} ] }}", tmp_path))
    assert compile_world(world).compile().body_mass.sum() == pytest.approx(1e5)
    assert [line for line in found.report if "1e+300 kg; made 100000 kg" in line]


def test_a_mark_of_byte_order_before_the_first_line_is_no_fault(tmp_path):
    path = world_of("", tmp_path)
    path.write_bytes(codecs.BOM_UTF8 + ROOM.encode())
    assert len(brought(path, robot=None)[0].walls) == 4


def test_inverted_stops_are_told(tmp_path):
    leaf = 'endPoint Solid { name "leaf" boundingObject Box { size 0.04 0.9 2 } }'
    hinge = "jointParameters HingeJointParameters { minStop 1 maxStop -1 }"
    scene = read_wbt(world_of(f"{HEAD}Solid {{ children [ HingeJoint {{ {hinge} {leaf} }} ] }}", tmp_path))
    assert scene.things[0].parts[0].joints[0].range is None
    assert [(item.kind, item.name) for item in scene.items] == [("stops of joint", "leaf")]


def test_what_is_only_seen_or_of_no_use_is_told(tmp_path):
    text = f"""{HEAD}
    Solid {{ name "cad" children [ CadShape {{ url [ "a.obj" "b.obj" ] }} ] }}
    Solid {{ name "gap" boundingObject IndexedFaceSet {{ coordIndex [ 0 1 2 ] }} }}
    """
    scene = read_wbt(world_of(text, tmp_path))
    assert [(item.kind, item.name) for item in scene.items] == [("visible solid", "cad"), ("IndexedFaceSet", "gap")]


def test_a_proto_beside_the_world_is_read(tmp_path):
    (tmp_path / "protos").mkdir()
    (tmp_path / "protos" / "Bollard.proto").write_text(
        "#VRML_SIM R2023b utf8\nPROTO Bollard [ field SFVec3f translation 0 0 0 field SFFloat radius 0.1 "
        'field SFString {"a" "b"} kind "a" ]\n{ Solid { translation IS translation '
        "boundingObject Pose { translation 0 0 0.5 children [ Cylinder { radius IS radius height 1 } ] } } }"
    )
    text = HEAD + "Bollard { translation 1 2 0 radius 0.3 }\nBollard { translation 4 2 0 }"
    scene = read_wbt(world_of(text, tmp_path))
    assert [thing.solids[0].size for thing in scene.things] == [(0.3, 1.0), (0.1, 1.0)]
    assert scene.things[0].solids[0].pose[:3, 3] == pytest.approx([1.0, 2.0, 0.5])


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("Solid { }", "does not begin with #VRML_SIM"),
        (HEAD + "Solid { translation 1 2", "ends in the middle of a node; it is truncated"),
        (HEAD + "Solid { boundingObject USE NOTHING }", "USE NOTHING without a DEF"),
        (HEAD + "Solid { 1 2 }", "has '1' where 'a field' should be"),
        (HEAD + "} Solid {", "has '}' where 'NODE {' should be"),
        (HEAD + 'Solid { name "a" boundingObject Box { size 1 -1 1 } }', "a size of -1 m"),
        (HEAD + "Solid { boundingObject Box { size 1 1e999 1 } }", "size is not finite"),
        (HEAD + "Group { children [ " * 200, "nests them over 100 deep"),
        (HEAD + "DEF A Group { children [ USE A ] }", "USE A without a DEF that ends before it"),
        (HEAD + DOUBLED, "has more than 200000 nodes"),
        (HEAD + CHAINED, "nests them over 100 deep"),
        (HEAD + 'WorldInfo { info [ "' + '\\"' * 300_000, "ends in the middle of a node"),
        (HEAD + "Cabinet { columnsWidths [ 1e400 ] }", "'{path}': Cabinet: columnsWidths is not finite"),
        (HEAD + "Solid { boundingObject IndexedFaceSet { coordIndex [ 0 1 -inf ] } }", "coordIndex is not finite"),
        (HEAD + "Solid { scale 1 0 1 boundingObject Box { } }", "a scale of 0"),
        (
            HEAD + "Solid { children [ HingeJoint { jointParameters HingeJointParameters { anchor 1e30 0 0 } endPoint "
            'Solid { name "leaf" boundingObject Box { } } } ] }',
            "'{path}': a joint of 'solid-leaf' is not finite",
        ),
        (HEAD + 'WorldInfo { coordinateSystem "EUN" }', "has the axes EUN; mjsim reads ENU and NUE"),
    ],
)
def test_a_broken_world_of_webots_is_refused_in_one_line(text, says, tmp_path):
    path = world_of(text, tmp_path)
    with pytest.raises(UsageError) as caught:
        brought(path)
    assert says.replace("{path}", str(path)) in str(caught.value)
    assert "\n" not in str(caught.value)
