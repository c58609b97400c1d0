"""Scenes of Gazebo and MuJoCo come in as worlds: what stands where, what moves, and what is lost."""

import itertools
import math
from pathlib import Path

import numpy as np
import pytest
import shapely

from mjsim.errors import UsageError
from mjsim.exchange.import_world import bring_file
from mjsim.exchange.scenes.scene_solids import MAX_SOLIDS, Scene, SceneSolid, SceneThing
from mjsim.exchange.scenes.sdf_in import read_sdf
from mjsim.exchange.world_import import Brought, Newcomer, Reading
from mjsim.world import CylinderObstacle, ModelObstacle, Source, World, parse_world, solid
from tests.exchange.bringing import typed

BOX = "<geometry><box><size>{}</size></box></geometry>"
POST = "<geometry><cylinder><radius>0.2</radius><length>1</length></cylinder></geometry>"


def link(pose: str, geometry: str, *, more: str = "", name: str = "l") -> str:
    return f"<link name='{name}'><pose>{pose}</pose>{more}<collision name='c'>{geometry}</collision></link>"


def model(links: str, *, pose: str = "0 0 0 0 0 0", static: bool = True, name: str = "m") -> str:
    return f"<model name='{name}'><static>{str(static).lower()}</static><pose>{pose}</pose>{links}</model>"


WALLS = model(
    link("3 4 1.25 0 0 0", BOX.format("6 0.15 2.5"), name="n")
    + link("3 0 1.25 0 0 0", BOX.format("6 0.15 2.5"), name="s")
    + link("0 2 1.25 0 0 1.570796", BOX.format("4 0.15 2.5"), name="w")
    + link("6 2 1.25 0 0 1.570796", BOX.format("4 0.15 2.5"), name="e"),
    name="walls",
)


def scene(folder: Path, content: str, *, version: str = "1.6", name: str = "room.world") -> Path:
    path = folder / name
    path.write_text(f"<?xml version='1.0'?><sdf version='{version}'><world name='w'>{content}</world></sdf>")
    return path


def brought(path: Path, *, robot: Newcomer | None = None) -> tuple[World, Brought]:
    """Return the world of a scene, read in this process, and what the importer gives."""
    found = bring_file(path, robot=robot, reading=Reading(folder="models"))
    return parse_world(found.text, source=Source(folder=path.parent, attached=found.files)), found


def test_a_room_of_boxes_is_walls_and_a_post_is_a_cylinder(tmp_path):
    stock = "<include><uri>model://sun</uri></include><include><uri>model://ground_plane</uri></include>"
    post = model(link("0 0 0 0 0 0", POST), pose="2 2 0.5 0 0 0", name="post")
    world, found = brought(scene(tmp_path, stock + WALLS + post))
    assert [wall.thickness for wall in world.walls] == [0.15] * 4
    assert {wall.height for wall in world.walls} == {2.5}
    assert solid(world).bounds == pytest.approx((-0.075, -0.075, 6.075, 4.075))
    (post,) = world.obstacles
    assert (post.name, post.at, post.cylinder) == ("post", (2.0, 2.0), (0.2, 1.0))
    assert found.report[1:] == ["kept: wall 'walls'", "kept: static model 'post'"]


def test_boxes_on_one_line_are_a_wall_with_its_doorway_and_window(tmp_path):
    sizes = {(1.0, 0.0, 2.5): 2.0, (2.45, 2.1, 2.5): 0.9, (3.95, 0.0, 2.5): 2.1}
    sizes |= {(5.5, 0.0, 0.9): 1.0, (5.5, 2.0, 2.5): 1.0, (6.5, 0.0, 2.5): 1.0}
    parts = [
        link(f"{x} 0 {(low + high) / 2} 0 0 0", BOX.format(f"{long} 0.2 {high - low}"), name=f"l{k}")
        for k, ((x, low, high), long) in enumerate(sizes.items())
    ]
    world, _ = brought(scene(tmp_path, model("".join(parts), pose="1 2 0 0 0 0.5")))
    (wall,) = world.walls
    assert not world.obstacles
    assert np.hypot(*np.subtract(*wall.points)) == pytest.approx(7.0, abs=1e-3)
    found = [(opening.at, opening.width, opening.sill, opening.head) for opening in wall.openings]
    assert found == [(2.0, 0.9, 0.0, 2.1), (5.0, 1.0, 0.9, 2.0)]


def test_poses_in_frames_chains_and_units_are_followed(tmp_path):
    frames = "<frame name='corner'><pose>1 2 0 0 0 1.5707963</pose></frame>"
    frames += "<frame name='desk' attached_to='corner'><pose>1 0 0 0 0 0</pose></frame>"
    far = "<pose relative_to='desk' degrees='true'>0 0 0.5 0 0 -90</pose>"
    turned = "<pose relative_to='a' rotation_format='quat_xyzw'>0 0 0 0 0 0.70710678 0.70710678</pose>"
    content = (
        f"{frames}<model name='a'><static>1</static>{far}{link('0 0 0 0 0 0', POST)}</model>"
        f"<model name='b'><static>1</static>{turned}{link('1 0 0 0 0 0', POST)}</model>"
    )
    world, _ = brought(scene(tmp_path, content, version="1.9"))
    assert [thing.at for thing in world.obstacles] == [(1.0, 3.0), (1.0, 4.0)]


def test_models_of_folders_are_placed_by_their_frame_and_loops_are_refused(tmp_path):
    inner = tmp_path / "models" / "chair"
    inner.mkdir(parents=True)
    (inner / "model.config").write_text(
        "<model><sdf version='1.4'>old.sdf</sdf><sdf version='1.7'>new.sdf</sdf></model>"
    )
    part = f"{link('0.5 0 0.5 0 0 0', POST)}<frame name='back'><pose>-0.5 0 0 0 0 0</pose></frame>"
    (inner / "new.sdf").write_text(f"<sdf version='1.7'><model name='x'><static>1</static>{part}</model></sdf>")
    placed = "<pose>3 1 0 0 0 0</pose>"
    content = f"<include><uri>model://chair</uri><name>plain</name>{placed}</include>"
    content += (
        f"<include><uri>models/chair</uri><name>held</name>{placed}<placement_frame>back</placement_frame></include>"
    )
    bare = "<include><uri>chair</uri><name>bare</name></include>"
    world, found = brought(scene(tmp_path, content + bare + "<include><uri>model://none</uri></include>"))
    assert {thing.name: thing.at for thing in world.obstacles} == {
        "plain": (3.5, 1.0),
        "held": (4.0, 1.0),
        "bare": (0.5, 0.0),
    }
    assert found.report[-1].startswith("left out: model 'model://none': not found; put its folder beside the file")
    (inner / "new.sdf").write_text("<sdf><model name='x'><include><uri>model://chair</uri></include></model></sdf>")
    with pytest.raises(UsageError, match="nests models more than 12 deep; is it a loop"):
        brought(scene(tmp_path, content))


def test_what_moves_has_its_mass_and_several_shapes_are_one_model(tmp_path):
    weight = "<inertial><mass>3.5</mass></inertial>"
    crate = model(
        link("0 0 0.2 0 0 0", BOX.format("0.4 0.3 0.4"), more=weight), pose="1 1 0 0 0 0.3", static=False, name="crate"
    )
    legs = "".join(link(f"{x} 0 0.3 0 0 0", BOX.format("0.1 0.5 0.6"), more=weight, name=f"leg{x}") for x in (0, 1))
    table = model(legs, pose="3 2 0 0 0 1.2", static=False, name="table")
    world, _ = brought(scene(tmp_path, crate + table + table.replace("'table'", "'other'").replace("3 2", "5 3")))
    box, *tables = world.obstacles
    assert (box.box, box.mass, box.heading_deg) == ((0.4, 0.3, 0.4), 3.5, pytest.approx(17.19))
    assert [(thing.mass, thing.movable, thing.at) for thing in tables] == [
        (7.0, True, (3.0, 2.0)),
        (7.0, True, (5.0, 3.0)),
    ]
    assert isinstance(tables[0], ModelObstacle)
    assert tables[0].model == tables[1].model  # one file for equal things
    shape = tables[0].shape
    assert (shape.low, shape.high) == (0.0, pytest.approx(0.6))


def test_tilted_shapes_spheres_overhead_things_and_floors_come_in_or_are_told(tmp_path):
    content = "".join(
        model(link(pose, shape), name=name)
        for name, pose, shape in (
            ("ramp", "2 2 0.5 0.5 0 0", BOX.format("1 1 0.1")),
            ("ball", "1 1 0.3 1 1 0", "<geometry><sphere><radius>0.3</radius></sphere></geometry>"),
            ("roof", "3 2 2.6 0 0 0", BOX.format("6 4 0.1")),
            ("slab", "3 2 0.05 0 0 0", BOX.format("6 4 0.1")),
            ("pill", "4 3 1 0 0 0", "<geometry><capsule><radius>0.1</radius><length>1</length></capsule></geometry>"),
        )
    )
    world, found = brought(scene(tmp_path, content, version="1.10"))
    assert [thing.name for thing in world.obstacles] == ["ramp", "ball", "pill"]
    assert world.obstacles[1].elevation == 0.0
    assert world.obstacles[2].cylinder == (0.1, 1.2)
    assert "guessed: floor 'slab': its top, at 0.10 m, is that of the world's floor" in found.report
    assert "left out: overhead part 'roof': it begins above 2.2 m" in found.report
    assert "guessed: capsule 'pill': a cylinder of its size" in found.report


def test_a_robot_in_the_scene_is_where_the_new_one_starts_and_lamps_shine(tmp_path):
    drive = "<plugin name='d' filename='libgazebo_ros_diff_drive.so'/>"
    robot = model(link("0 0 0.1 0 0 0", POST) + drive, pose="1.5 3 0 0 0 1.5707963", static=False, name="bot")
    lamp = "<light name='lamp' type='point'><pose>2 1 2.2 0 0 0</pose><diffuse>1 0.5 0 1</diffuse></light>"
    sun = "<light name='far' type='directional'/>"
    world, found = brought(scene(tmp_path, WALLS + robot + lamp + sun), robot=Newcomer("turtlebot3_burger"))
    assert world.robots[0].at == (1.5, 3.0)
    assert world.robots[0].heading_deg == pytest.approx(90.0, abs=0.1)
    assert [(each.at, each.height, each.color) for each in world.lamps] == [((2.0, 1.0), 2.2, "#ff8000")]
    assert "left out: robot 'bot': its start is kept; import it with mjsim new --robot-from" in found.report
    assert "left out: directional light 'far': a world has ambient light and lamps" in found.report


def obj(path: Path, corners: list[tuple[float, float, float]], faces: list[tuple[int, ...]]) -> None:
    rows = [f"v {x} {y} {z}" for x, y, z in corners] + [f"f {' '.join(str(k + 1) for k in face)}" for face in faces]
    path.write_text("\n".join(rows) + "\n")


def prism(ring: list[tuple[float, float]], high: float, first: int, *, inward: bool = False) -> tuple[list, list]:
    """Return corners and triangles of the side faces of a prism, whose ring is counter-clockwise."""
    count = len(ring)
    corners = [(x, y, z) for z in (0.0, high) for x, y in ring]
    faces = []
    for k in range(count):
        a, b, c, d = k, (k + 1) % count, (k + 1) % count + count, k + count
        faces += [(a, b, c), (a, c, d)]
    return corners, [tuple(first + v for v in (face[::-1] if inward else face)) for face in faces]


@pytest.mark.slow
@pytest.mark.parametrize(("start", "kept"), [("6 -4", True), ("3 3.2", True), ("2.1 2.1", False), ("1e4 0", False)])
def test_a_robot_on_an_open_floor_starts_where_the_scene_has_it(start, kept, tmp_path):
    plugin = "<plugin filename='gz-sim-diff-drive-system' name='d'/>"
    robot = model(link("0 0 0.1 0 0 0", BOX.format("0.3 0.2 0.1")) + plugin, pose=f"{start} 0 0 0 0", static=False)
    post = model(link("0 0 0.5 0 0 0", POST), pose="2 2 0 0 0 0", name="post")
    shelf = model(link("0 0 1.25 0 0 0", BOX.format("4 0.1 2.5")), pose="3 0 0 0 0 0", name="shelf")
    world, found = brought(scene(tmp_path, post + shelf + robot), robot=Newcomer("turtlebot3_burger"))
    assert (world.robots[0].at == tuple(map(float, start.split()))) == kept
    assert any("is not free" in line for line in found.report) != kept


@pytest.mark.slow
def test_a_house_in_one_mesh_becomes_its_walls(tmp_path):
    outer = prism([(0, 0), (6, 0), (6, 4), (0, 4)], 2.5, 0)
    inner = prism([(0.2, 0.2), (5.8, 0.2), (5.8, 3.8), (0.2, 3.8)], 2.5, 8, inward=True)
    obj(tmp_path / "house.obj", outer[0] + inner[0], outer[1] + inner[1])
    mesh = "<geometry><mesh><uri>house.obj</uri><scale>1 1 1</scale></mesh></geometry>"
    world, found = brought(scene(tmp_path, model(link("0 0 0 0 0 0", mesh), name="house")))
    assert not world.obstacles
    wanted = shapely.box(0, 0, 6, 4) - shapely.box(0.2, 0.2, 5.8, 3.8)
    assert solid(world).symmetric_difference(wanted).area < 0.1 * wanted.area
    assert any(line.startswith("guessed: hollow mesh 'house'") for line in found.report)


def test_a_mesh_that_is_a_box_is_a_box_and_missing_ones_are_named(tmp_path):
    corners = list(itertools.product((0.0, 0.8), (0.0, 0.6), (0.0, 1.1)))
    faces = [
        (0, 1, 3),
        (0, 3, 2),
        (4, 6, 7),
        (4, 7, 5),
        (0, 4, 5),
        (0, 5, 1),
        (2, 3, 7),
        (2, 7, 6),
        (0, 2, 6),
        (0, 6, 4),
        (1, 5, 7),
        (1, 7, 3),
    ]
    obj(tmp_path / "crate.obj", corners, faces)
    shape = "<geometry><mesh><uri>file://{}</uri><scale>2 1 1</scale></mesh></geometry>"
    content = model(link("1 1 0 0 0 0", shape.format("crate.obj")), name="crate")
    content += model(link("1 1 0 0 0 0", shape.format("gone.dae")), name="gone")
    world, found = brought(scene(tmp_path, content))
    (crate,) = world.obstacles
    assert sorted(crate.box) == pytest.approx([0.6, 1.1, 1.6])
    assert crate.at == pytest.approx((1.8, 1.3))
    assert any("left out: mesh 'file://gone.dae': not found" in line for line in found.report)
    assert not any("no collision shape" in line for line in found.report)


def test_a_mesh_too_large_for_a_world_is_left_out_and_the_rest_stays(tmp_path):
    obj(
        tmp_path / "far.obj", [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    )
    far = "<geometry><mesh><uri>file://far.obj</uri><scale>1e5 1 1</scale></mesh></geometry>"
    world, found = brought(scene(tmp_path, WALLS + model(link("1 1 0 0 0 0", far), name="far")))
    assert (len(world.walls), len(world.obstacles)) == (4, 0)
    assert any(
        "left out: mesh part 'far.obj': a mesh has a number that is not finite, or" in line for line in found.report
    )


@pytest.mark.parametrize(("static", "high"), [(True, 1.0), (False, 1.0), (True, 0.1), (True, 0.05)])
def test_a_robot_stands_beside_what_no_wall_encloses(tmp_path, static: bool, high: float):
    crates = "".join(
        model(link(f"{x} 0 {high / 2} 0 0 0", BOX.format(f"1 1 {high}")), static=static, name=f"c{x}")
        for x in (-0.5, 0.5)
    )
    world, _ = brought(scene(tmp_path, crates), robot=Newcomer())
    assert max(map(abs, world.robots[0].at)) > 1.0
    assert len(world.run.drivers["scout"].navigator.model_dump()["points"]) > 2


HOUSE = """<mujoco><asset><texture name="w" type="2d" builtin="checker" width="8" height="8"/><material name="m"
texture="w" rgba=".8 .2 .2 1"/></asset><worldbody><light name="lamp" pos="2 2 2.4"/><geom type="plane" size="9 9 .1"/>
<geom type="box" pos="3 0 1.25" size="3 .075 1.25" material="m"/><geom type="box" pos="3 4 1.25" size="3 .075 1.25"/>
<geom type="box" pos="0 2 1.25" size=".075 2 1.25"/><geom type="box" pos="6 2 1.25" size="2 .075 1.25" euler="0 0 90"/>
<geom name="stool" type="cylinder" pos="5 1 .2" size=".1 .2"/>
<body name="table" pos="2 2 0"><geom type="box" pos="0 0 .72" size=".6 .4 .02"/></body>
<body name="ball" pos="4 1 .11"><freejoint/><geom type="sphere" size=".11" mass=".4"/></body>
<body name="hatch" pos="5 3 0"><joint axis="0 0 1"/><geom type="box" pos=".4 0 .3" size=".3 .3 .3"/></body>
<body name="bot" pos="1 1 .1"><freejoint/><geom type="cylinder" size=".15 .05"/><body pos="0 .15 0">
<joint name="j" axis="0 1 0"/><geom type="sphere" size=".05"/></body></body></worldbody>
<actuator><velocity joint="j"/></actuator></mujoco>"""


def test_a_scene_of_mujoco_is_the_surroundings_of_a_world(tmp_path):
    path = tmp_path / "house.xml"
    path.write_text(HOUSE)
    world, found = brought(path, robot=Newcomer("turtlebot3_burger"))
    assert len(world.walls) == 4
    assert solid(World(walls=world.walls)).bounds == pytest.approx((-0.075, -0.075, 6.075, 4.075), abs=1e-3)
    assert world.walls[0].color == "#cc3333"
    things = {thing.name: thing for thing in world.obstacles}
    assert set(things) == {"stool", "table", "ball", "hatch"}
    assert (things["ball"].movable, things["ball"].mass, things["ball"].sphere) == (True, 0.4, 0.11)
    assert things["table"].elevation == pytest.approx(0.7)
    assert world.robots[0].at == (1.0, 1.0)
    assert "kept: jointed thing 'hatch'" in found.report
    assert "left out: robot 'bot': its start is kept; import it with mjsim new --robot-from" in found.report


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ("", "has nothing that a robot could touch or sense"),
        (model(link("0 0 x 0 0 0", POST)), "'0 0 x 0 0 0' is not 6 finite numbers"),
        (model(link("0 0 0 0 0", POST)), "is not 6 finite numbers"),
        (model(link("0 0 0 0 0 nan", POST)), "is not 6 finite numbers"),
        (
            model(link("0 0 1e9 0 0 0", POST)),
            "room.world': a cylinder has a number that is not finite, or above 10000 m",
        ),
        (model(link("0 0 0 0 0 0", BOX.format("1 1"))), "'1 1' is not 3 finite numbers"),
        (model(link("0 0 0 0 0 0", BOX.format("1 -1 1"))), "m: size of a box: '1 -1 1' must be above 0, up to 10000 m"),
        (model(link("0 0 0 0 0 0", BOX.format("inf 1 1"))), "is not 3 finite numbers"),
        (
            model(link("0 0 0 0 0 0", "<geometry><cylinder/></geometry>")),
            "m: its <cylinder> has no <radius>; give",
        ),
        (model(link("0 0 0 0 0 0", "<geometry><sphere/></geometry>")), "room.world': m: its <sphere> has no <radius>;"),
        ("<model name='m'><pose relative_to='x'>0 0 0 0 0 0</pose></model>", "no frame 'x'; frames are m"),
        (
            "<frame name='a' attached_to='b'/><frame name='b' attached_to='a'/>"
            f"<model name='m'><pose relative_to='a'>0 0 0 0 0 0</pose>{link('0 0 0 0 0 0', POST)}</model>",
            "the frame 'a' is relative to itself",
        ),
        (
            f"<model name='m'><pose rotation_format='quat_xyzw'>0 0 0 0 0 0 0</pose>"
            f"{link('0 0 0 0 0 0', POST)}</model>",
            "norm",
        ),
        (model(link("0 0 0 0 0 0", POST, more="<inertial><mass>m</mass></inertial>")), "'m' is not a finite"),
    ],
)
def test_a_broken_scene_is_refused_in_one_line(content, says, tmp_path):
    with pytest.raises(UsageError) as caught:
        brought(scene(tmp_path, content))
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("name", "text", "says"),
    [
        ("a.world", "<sdf><world", "is not XML"),
        ("a.sdf", "<robot/>", "begins with <robot>; a scene of Gazebo begins with <sdf>"),
        ("a.sdf", "", "is not XML"),
        ("a.world", "<!DOCTYPE x [<!ENTITY a 'b'>]><sdf/>", "document type"),
        ("a.world", "<sdf>" * 300, "more than 200 deep"),
        ("a.xml", "<robot/>", "has no <mujoco>"),
        ("a.xml", "<mujoco><worldbody><geom/></worldbody></mujoco>", "MuJoCo cannot read"),
        ("a.xml", "<mujoco><worldbody/></mujoco>", "has nothing that a robot could touch or sense"),
    ],
)
def test_a_file_that_is_no_scene_is_refused_in_one_line(name, text, says, tmp_path):
    (tmp_path / name).write_text(text)
    with pytest.raises(UsageError) as caught:
        brought(tmp_path / name)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_mesh_that_is_mirrored_by_its_scale_is_still_a_solid(tmp_path):
    corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
    (tmp_path / "tip.obj").write_text(corners + "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n")
    mesh = "<geometry><mesh><uri>tip.obj</uri><scale>-1 1 1</scale></mesh></geometry>"
    (tip,) = read_sdf(scene(tmp_path, model(link("0 0 0 0 0 0", mesh))), search=[]).things
    a, b, c = (tip.solids[0].vertices[tip.solids[0].faces[:, k]] for k in range(3))
    assert float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0 == pytest.approx(1 / 6)


def test_a_colour_that_is_no_number_is_left_out(tmp_path):
    odd = "<visual name='v'><material><diffuse>nan 0 0 1</diffuse><ambient>inf 0 0 1</ambient></material></visual>"
    world, _ = brought(scene(tmp_path, model(link("1 1 0.5 0 0 0", POST, more=odd))))
    assert world.obstacles[0].color == CylinderObstacle(cylinder=(0.2, 1.0), at=(1, 1)).color


def test_the_number_of_solids_is_that_of_the_whole_scene():
    solid_box = SceneSolid("box", (1.0, 1.0, 1.0), np.eye(4))
    found = Scene()
    found.add(SceneThing("a", [solid_box] * MAX_SOLIDS, np.eye(4)))
    with pytest.raises(ValueError, match="the scene has more than 20000 solids; make it simpler"):
        found.add(SceneThing("b", [solid_box], np.eye(4)))


@pytest.mark.slow
def test_models_are_written_beside_the_world_and_nothing_is_read_elsewhere(tmp_path):
    other = tmp_path / "a" / "b" / "c" / "d" / "e" / "f"
    other.mkdir(parents=True)
    (tmp_path / "secret.sdf").write_text(
        f"<sdf><model name='s'><static>1</static>{link('0 0 0 0 0 0', POST)}</model></sdf>"
    )
    content = model(link("1 1 0.2 0.4 0 0", BOX.format("0.5 0.5 0.3")), name="tilted")
    content += f"<include><uri>file://{tmp_path}/secret.sdf</uri></include>"
    content += "<include><uri>../../../../../../secret.sdf</uri></include>"
    code, said = typed("new", "--from", str(scene(other, WALLS + content)), "-o", str(other / "room.yaml"))
    assert code == 0, said
    assert (other / "room_models" / "tilted_0" / "model.xml").is_file()
    assert "left out: 2 models" in said
    assert typed("check", str(other / "room.yaml"))[0] == 0


@pytest.mark.slow
def test_three_hundred_cylinders_are_read_in_moments(tmp_path):
    posts = [model(link("0 0 0.5 0 0 0", POST), pose=f"{k % 20} {k // 20} 0 0 0 0", name=f"p{k}") for k in range(300)]
    world, _ = brought(scene(tmp_path, "".join(posts)))
    assert len(world.obstacles) == 300
    assert world.obstacles[299].at == (19.0, 14.0)
    assert math.isclose(solid(world).area, 300 * math.pi * 0.04, rel_tol=0.02)
    assert len(read_sdf(tmp_path / "room.world", search=[]).things) == 300
