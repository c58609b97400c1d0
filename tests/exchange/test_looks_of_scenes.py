"""What cameras see of scenes: albedo maps, scripts of materials, textures of meshes; and parts of meshes by name."""

import numpy as np
import pytest

from mjsim.exchange.scenes.build import build_world
from mjsim.exchange.scenes.mjcf_in import read_mjcf
from mjsim.exchange.scenes.sdf_in import read_sdf
from mjsim.inventory import inventory
from mjsim.models import encode_png, read_picture
from mjsim.world import ModelObstacle
from tests.exchange.test_scenes import BOX, brought, link, model, scene

RED = encode_png(np.full((4, 4, 3), (200, 30, 20), dtype=np.uint8))
SCRIPT = """material Other { technique { pass { texture_unit { texture no.png } } } }
material House/Red : Base
{ technique { pass { diffuse 0.1 0.2 0.4 1 texture_unit {
  texture red.png
  scale 1 1 } } } }
"""


def shown(geometry: str, material: str) -> str:
    return f"<visual name='v'><geometry>{geometry}</geometry><material>{material}</material></visual>"


def boxed(material: str, *, at: str, size: str = "1 2 0.5", name: str = "l") -> str:
    whole = BOX.format(size)
    return link(at, whole, more=f"<visual name='v'>{whole}<material>{material}</material></visual>", name=name)


def test_textures_of_boxes_and_walls_are_those_of_maps_and_scripts(tmp_path):
    (tmp_path / "textures").mkdir()
    (tmp_path / "textures" / "red.png").write_bytes(RED)
    (tmp_path / "scripts").mkdir()
    (tmp_path / "scripts" / "house.material").write_text(SCRIPT)
    albedo = "<pbr><metal><albedo_map>textures/red.png</albedo_map></metal></pbr>"
    script = "<script><uri>scripts</uri><uri>textures</uri><name>House/Red</name></script>"
    stock = "<script><uri>file://media/materials/scripts/gazebo.material</uri><name>Gazebo/Bricks</name></script>"
    content = (
        model(boxed(albedo, at="5 5 0.25 0 0 0"), name="chest")
        + model(boxed(script, at="0 0 1.25 0 0 0", size="4 0.1 2.5"), name="wall")
        + model(boxed(stock, at="9 5 0.25 0 0 0"), name="bricks")
        + model(boxed(albedo.replace("red", "no"), at="13 5 0.25 0 0 0"), name="lost")
    )
    world, found = brought(scene(tmp_path, content))
    chest, bricks, lost = world.obstacles
    (wall,) = world.walls
    assert (chest.texture, chest.tile) == (wall.texture, 0.5)
    assert (wall.tile, wall.color, bricks.texture, lost.texture) == (2.5, "#1a3366", "materials/brick.jpg", None)
    assert (read_picture(found.files[wall.texture]) == (200, 30, 20)).all()
    assert "left out: texture 'textures/no.png': not found" in found.report
    assert "guessed: material Gazebo/Bricks 'bricks': the texture materials/brick.jpg of mjsim" in found.report


def test_no_picture_outside_is_read(tmp_path):
    folder = tmp_path / "a" / "b" / "c" / "d" / "e"
    (folder / "scripts").mkdir(parents=True)
    (tmp_path / "red.png").write_bytes(RED)
    (folder / "link.png").symlink_to(tmp_path / "red.png")
    named = [f"{tmp_path}/red.png", f"file://{tmp_path}/red.png", "../../../../../red.png", "link.png"]
    scripts = [f"material M{k} {{ {{ texture {name} }} }}\n" for k, name in enumerate(named)]
    (folder / "scripts" / "a.material").write_text("".join(scripts))
    looks = [f"<pbr><metal><albedo_map>{name}</albedo_map></metal></pbr>" for name in named]
    looks += [f"<script><uri>scripts</uri><name>M{k}</name></script>" for k in range(len(named))]
    content = [model(boxed(look, at=f"{4 * k} 5 0.25 0 0 0"), name=f"m{k}") for k, look in enumerate(looks)]
    world, found = brought(scene(folder, "".join(content)))
    assert [thing.texture for thing in world.obstacles] == [None] * 8
    assert not found.files
    for k, name in enumerate([named[0], *named[2:]]):
        (folder / f"{k}.xml").write_text(
            f"""<mujoco><asset><texture name="t" type="2d" file="{name}"/><material name="m" texture="t"/></asset>
            <worldbody><geom type="box" size=".3 .3 .3" pos="0 0 .3" material="m"/></worldbody></mujoco>"""
        )
        world, found = brought(folder / f"{k}.xml")
        assert world.obstacles[0].texture is None
        assert "left out: texture 't': not in the folder of the scene; put it there" in found.report
        assert not found.files


SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
TENT = "mtllib a.mtl\n" + SQUARE + "usemtl red\nf 1/1 2/2 5/3\nf 2/1 3/2 5/3\nf 3/1 4/2 5/3\nf 4/1 1/2 5/3\n"


@pytest.mark.slow  # trimesh is imported
def test_a_mesh_that_is_seen_keeps_its_picture_and_what_collides_is_not_seen(tmp_path):
    (tmp_path / "a.obj").write_text(TENT)
    (tmp_path / "a.mtl").write_text("newmtl red\nKd 1 1 1\nmap_Kd red.png\n")
    (tmp_path / "red.png").write_bytes(RED)
    seen = "<visual name='v'><geometry><mesh><uri>a.obj</uri></mesh></geometry></visual>"
    world, _ = brought(scene(tmp_path, model(link("3 3 0.5 0 0 0", BOX.format("1 1 1"), more=seen), name="tent")))
    (tent,) = world.obstacles
    assert isinstance(tent, ModelObstacle)
    file = tent.shape.model
    looks = [k for k in range(file.ngeom) if not file.geom_contype[k]]
    touched = [k for k in range(file.ngeom) if file.geom_contype[k]]
    assert (len(looks), len(touched), file.ntex) == (1, 1, 1)
    assert file.geom_size[touched[0]].tolist() == [0.5, 0.5, 0.5]
    assert file.mat_texid[file.geom_matid[looks[0]]].max() == 0
    assert (file.tex_data.reshape(-1, 3) == (200, 30, 20)).all()


TWO = """<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="1"/><up_axis>Z_UP</up_axis></asset><library_geometries>{}</library_geometries>
<library_visual_scenes><visual_scene id="w">{}</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#w"/></scene></COLLADA>"""
GEOMETRY = """<geometry id="{0}-id" name="{0}"><mesh><source id="{0}p">
<float_array id="{0}a" count="12">{1}</float_array>
<technique_common><accessor source="#{0}a" count="4" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source><vertices id="{0}v">
<input semantic="POSITION" source="#{0}p"/></vertices><triangles count="4"><input semantic="VERTEX" source="#{0}v"
offset="0"/><p>0 2 1 0 1 3 0 3 2 1 2 3</p></triangles></mesh></geometry>"""


OBJECTS = """o small
v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
f 1 3 2
f 1 2 4
f 1 4 3
f 2 3 4
o large
v 10 0 0
v 12 0 0
v 10 2 0
v 10 0 2
f 5 7 6
f 5 6 8
f 5 8 7
f 6 7 8
"""
"""The same as Wavefront OBJ."""


def two_tetrahedra() -> str:
    """Return Collada with 'small', 1 m wide, and 'large' at x = 10 m, 2 m wide."""
    corners = {"small": "0 0 0 1 0 0 0 1 0 0 0 1", "large": "10 0 0 12 0 0 10 2 0 10 0 2"}
    geometries = "".join(GEOMETRY.format(name, numbers) for name, numbers in corners.items())
    return TWO.format(
        geometries, "".join(f'<node id="n{name}"><instance_geometry url="#{name}-id"/></node>' for name in corners)
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("inside", "low", "high"),
    [
        ("", (0, 0, 0), (12, 2, 2)),
        ("<submesh><name>large</name></submesh>", (10, 0, 0), (12, 2, 2)),
        ("<submesh><name>large</name><center>true</center></submesh>", (-1, -1, -1), (1, 1, 1)),
        ("<submesh><name>small</name></submesh>", (0, 0, 0), (1, 1, 1)),
    ],
)
@pytest.mark.parametrize("file", ["two.dae", "two.obj"])
def test_a_submesh_is_the_part_of_that_name(file, inside, low, high, tmp_path):
    (tmp_path / "two.dae").write_text(two_tetrahedra())
    (tmp_path / "two.obj").write_text(OBJECTS)
    mesh = f"<geometry><mesh><uri>{file}</uri>{inside}</mesh></geometry>"
    found = read_sdf(scene(tmp_path, model(link("0 0 0 0 0 0", mesh))), search=[])
    corners = np.concatenate([solid.corners() for thing in found.things for solid in thing.solids])
    assert corners.min(axis=0) == pytest.approx(low)
    assert corners.max(axis=0) == pytest.approx(high)


@pytest.mark.slow
def test_a_submesh_that_is_not_there_is_told_with_those_that_are(tmp_path):
    (tmp_path / "two.dae").write_text(two_tetrahedra())
    mesh = "<geometry><mesh><uri>two.dae</uri><submesh><name>huge</name></submesh></mesh></geometry>"
    found = read_sdf(scene(tmp_path, model(link("0 0 0 0 0 0", mesh))), search=[])
    (item,) = [each for each in found.items if each.kind == "mesh"]
    assert item.why == "'two.dae' has no mesh 'huge'; its meshes are large, small"


def test_textures_of_mjcf_are_on_boxes_and_walls_and_others_are_told(tmp_path):
    (tmp_path / "t").mkdir()
    (tmp_path / "t" / "red.png").write_bytes(RED)
    (tmp_path / "house.xml").write_text(
        """<mujoco><compiler texturedir="t"/><asset><texture type="skybox" builtin="gradient" width="32" height="32"/>
        <texture name="chess" type="2d" builtin="checker" rgb1="1 0 0" rgb2="0 0 1" width="64" height="64"/>
        <texture name="red" type="2d" file="red.png"/><texture name="gone" type="2d" file="gone.png"/>
        <texture name="cube" type="cube" builtin="flat" rgb1="0 1 0" rgb2="0 1 0" width="16" height="16"/>
        <material name="chess" texture="chess" texrepeat="4 4" texuniform="true"/>
        <material name="red" texture="red" texrepeat="2 2"/><material name="gone" texture="gone"/>
        <material name="cube" texture="cube"/></asset><worldbody>
        <geom type="plane" size="5 5 1" material="chess"/><geom type="box" size="3 .05 1" pos="0 4 1" material="chess"/>
        <geom type="box" size=".3 .3 .4" pos="0 0 .4" material="red"/>
        <geom type="cylinder" size=".3 .4" pos="2 0 .4" material="cube"/>
        <geom type="box" size=".3 .3 .4" pos="-2 0 .4" material="gone"/></worldbody></mujoco>"""
    )
    scene = read_mjcf(tmp_path / "house.xml")
    world, files = build_world(scene, name="w", folder="f")
    (wall,) = world.walls
    looks = {thing.at[0]: (thing.texture, thing.tile) for thing in world.obstacles if thing.texture is not None}
    assert (wall.texture, wall.tile) == ("f/chess_0.png", 0.25)
    assert looks == {0.0: ("f/red_1.png", 0.4), 2.0: ("f/cube_2.png", 0.8)}
    chess, cube = read_picture(files["f/chess_0.png"]), read_picture(files["f/cube_2.png"])
    assert chess.shape == (64, 64, 3)
    assert {tuple(each) for each in chess.reshape(-1, 3).tolist()} == {(255, 0, 0), (0, 0, 255)}
    assert {tuple(each) for each in cube.reshape(-1, 3).tolist()} == {(0, 255, 0)}
    assert [line for line in inventory(scene.items) if "texture" in line] == [
        "left out: texture 'sky': a world has no sky of its own",
        "left out: texture 'gone': not in the folder of the scene; put it there",
        "left out: texture of the floor 'chess': set another one with floor: in the world",
    ]


@pytest.mark.parametrize(
    ("data", "why"),
    [
        (RED[:44] + bytes(6) + RED[50:], "MuJoCo cannot read this texture or another one"),
        (b"GIF89a" + bytes(40), "is not a PNG or JPEG picture; convert it"),
        (b"", "is not a PNG or JPEG picture; convert it"),
    ],
)
def test_a_scene_comes_in_without_a_damaged_texture(data, why, tmp_path):
    (tmp_path / "a.png").write_bytes(data)
    (tmp_path / "house.xml").write_text(
        """<mujoco><asset><texture name="a" type="2d" file="a.png"/><material name="a" texture="a" rgba="1 0 0 1"/>
        </asset><worldbody><geom type="box" size=".3 .3 .4" pos="0 0 .4" material="a"/></worldbody></mujoco>"""
    )
    scene = read_mjcf(tmp_path / "house.xml")
    assert inventory(scene.items) == [f"left out: texture 'a': {why}"]
    assert scene.things[0].solids[0].color == "#ff0000"
