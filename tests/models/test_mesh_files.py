"""Meshes of Collada, glTF, OBJ and STL: sizes in metres, z up, colours and textures, and what is broken."""

import base64
import json
import struct

import cv2
import mujoco
import numpy as np
import pytest

from mjsim.models import gather_robot, spec_of
from mjsim.models.mesh_files import gazebo_triangles, is_small_stl, mesh_parts, stl, whole_mesh

CORNERS = np.array([[0, 0, 0], [4, 0, 0], [0, 2, 0], [0, 0, 1]], dtype=float)
FACES = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
EFFECT = """<library_effects><effect id="e"><profile_COMMON><technique sid="t"><lambert><diffuse>
  <color>1 0.2 0 1</color></diffuse></lambert></technique></profile_COMMON></effect></library_effects>
  <library_materials><material id="m"><instance_effect url="#e"/></material></library_materials>"""


def collada(unit: str, up: str, *, corners: np.ndarray = CORNERS) -> bytes:
    """Return a tetrahedron of one colour as Collada."""
    numbers = " ".join(f"{value:g}" for value in corners.ravel())
    indices = " ".join(str(index) for face in FACES for index in face)
    return f"""<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
    <asset>{unit}{up}</asset>{EFFECT}<library_geometries><geometry id="g"><mesh><source id="p">
    <float_array id="a" count="{corners.size}">{numbers}</float_array><technique_common>
    <accessor source="#a" count="{len(corners)}" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
    <param name="Z" type="float"/></accessor></technique_common></source><vertices id="v">
    <input semantic="POSITION" source="#p"/></vertices><triangles count="4" material="s">
    <input semantic="VERTEX" source="#v" offset="0"/><p>{indices}</p></triangles></mesh></geometry></library_geometries>
    <library_visual_scenes><visual_scene id="w"><node id="n"><instance_geometry url="#g"><bind_material>
    <technique_common><instance_material symbol="s" target="#m"/></technique_common></bind_material>
    </instance_geometry></node></visual_scene></library_visual_scenes>
    <scene><instance_visual_scene url="#w"/></scene></COLLADA>""".encode()


def gltf() -> bytes:
    """Return the tetrahedron as glTF, with its numbers inside."""
    data = CORNERS.astype("<f4").tobytes() + np.array(FACES, dtype="<u2").tobytes()
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    views = [{"buffer": 0, "byteOffset": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 24}]
    bounds = {"min": CORNERS.min(axis=0).tolist(), "max": CORNERS.max(axis=0).tolist()}
    accessors = [
        {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", **bounds},
        {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"},
    ]
    mesh = {"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}
    return json.dumps(
        {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "meshes": [mesh],
            "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0, 0, 1, 1]}}],
            "buffers": [{"uri": uri, "byteLength": len(data)}],
            "bufferViews": views,
            "accessors": accessors,
        }
    ).encode()


def size_of(data: bytes) -> list[float]:
    """Return the extent of a binary STL along x, y and z [m]."""
    (count,) = struct.unpack_from("<I", data, 80)
    records = np.frombuffer(data, dtype=[("n", "<f4", 3), ("c", "<f4", (3, 3)), ("a", "<u2")], offset=84, count=count)
    return np.ptp(records["c"].reshape(-1, 3), axis=0).tolist()


def nothing(name: str) -> bytes:
    raise ValueError(f"no file '{name}'")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("unit", "up", "size"),
    [
        ("", "<up_axis>Z_UP</up_axis>", (4, 2, 1)),
        ('<unit name="inch" meter="0.0254"/>', "<up_axis>Z_UP</up_axis>", (0.1016, 0.0508, 0.0254)),
        ('<unit name="inch" meter="0.0254"/>', "<up_axis>Y_UP</up_axis>", (0.1016, 0.0254, 0.0508)),
        ('<unit meter="0.001"/>', "<up_axis>X_UP</up_axis>", (0.002, 0.001, 0.004)),
    ],
)
def test_a_collada_mesh_has_its_own_units_and_up_axis(unit, up, size):
    (part,) = mesh_parts("a.dae", collada(unit, up), nothing)
    assert size_of(part.data) == pytest.approx(size, rel=1e-5)
    assert part.rgba == pytest.approx((1.0, 0.2, 0.0, 1.0), abs=0.01)
    assert size_of(whole_mesh("a.dae", collada(unit, up), nothing).data) == pytest.approx(size, rel=1e-5)
    triangles, _ = gazebo_triangles("a.dae", collada(unit, up))
    upright, _ = gazebo_triangles("a.dae", collada(unit, ""))  # Gazebo reads the unit, but no axis
    np.testing.assert_allclose(triangles, upright)


def test_y_points_up_in_gltf():
    (part,) = mesh_parts("a.gltf", gltf(), nothing)
    assert size_of(part.data) == pytest.approx((4, 1, 2))
    assert part.rgba == pytest.approx((0, 0, 1, 1), abs=0.01)


@pytest.mark.parametrize(
    ("name", "data", "says"),
    [
        ("a.dae", b"<COLLADA", "'a.dae' cannot be read as a mesh"),
        ("a.dae", b'<!DOCTYPE a [<!ENTITY b "c">]><COLLADA/>', "'a.dae' declares a document type"),
        ("a.dae", collada('<unit meter="1e300"/>', ""), "'a.dae' cannot be read as a mesh: its unit is 1e\\+300 m"),
        ("a.dae", collada("", "", corners=CORNERS * np.nan), "'a.dae' cannot be read as a mesh"),
        ("a.glb", b"glTF\2\0\0\0\xff\xff\xff\xff", "'a.glb' cannot be read as a mesh"),
        ("a.gltf", b'{"asset": {"version": "2.0"}}', "'a.gltf' cannot be read as a mesh"),
        ("a.gltf", gltf().replace(b'"count": 12', b'"count": 99999'), "'a.gltf' cannot be read as a mesh"),
        ("a.obj", b"v 1 2 3", "'a.obj' cannot be read as a mesh"),
    ],
)
def test_a_broken_mesh_is_one_line(name, data, says):
    with pytest.raises(ValueError, match=says) as caught:
        mesh_parts(name, data, nothing)
    assert "\n" not in str(caught.value)


OBJ = """mtllib a.mtl
v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\nvt 1 1
usemtl skin\nf 1/1 3/3 2/2\nf 1/1 2/2 4/4\nf 1/1 4/4 3/3\nf 2/2 3/3 4/4\n"""
URDF = """<robot name="r"><link name="a"><inertial><mass value="1"/>
  <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
  <visual><geometry><mesh filename="a.obj"/></geometry></visual>
  <collision><geometry><box size="1 1 1"/></geometry></collision></link></robot>"""


def test_the_texture_of_a_visual_mesh_is_seen_and_read_back_from_the_file_that_is_written():
    green = cv2.imencode(".png", np.full((8, 8, 3), (0, 200, 0), dtype=np.uint8))[1].tobytes()
    files = {"r.urdf": URDF, "a.obj": OBJ, "a.mtl": "newmtl skin\nmap_Kd skin.png\n"}
    read = {**{name: text.encode() for name, text in files.items()}, "skin.png": green}
    robot = gather_robot("r.urdf", lambda name: read[name])
    assert robot.items == ()
    assert sorted(name.rpartition(".")[2] for name in robot.files.assets) == ["obj", "png"]
    model = robot.model
    assert (model.ntex, model.nmat) == (1, 1)
    (seen,) = np.flatnonzero(model.geom_matid >= 0)
    assert model.geom_type[seen] == mujoco.mjtGeom.mjGEOM_MESH
    assert model.tex_data[:3].tolist() == [0, 200, 0]
    assert spec_of(robot.files).compile().ntex == 1


FLAT_OBJ = OBJ.partition("usemtl")[0] + "usemtl skin\nf 1/1 3/3 2/2\n"
SHEET = np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[1, 0, 0], [1, 1, 0], [0, 1, 0]]], dtype=float)


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("a.obj", FLAT_OBJ.encode()),
        ("b.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n"),
        ("b.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1\n"),
        ("b.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n"),
        ("b.obj", b"v 0 0 1\n v 1 0 2\nv 1 1 3\nv 0 1 2\nf 1 2 3 4"),  # oblique
        ("a.stl", stl(SHEET)),
        ("a.stl", stl(SHEET[:1])),
        ("a.dae", collada("", "", corners=CORNERS * [1, 1, 0])),
        ("a.stl", stl(np.concatenate([CORNERS[FACES], CORNERS[FACES][:, ::-1]]))),  # each side seen from both sides
    ],
)
def test_a_mesh_without_volume_is_seen_too(name, data):
    green = cv2.imencode(".png", np.full((8, 8, 3), (0, 200, 0), dtype=np.uint8))[1].tobytes()
    read = {
        "r.urdf": URDF.replace("a.obj", name).encode(),
        "a.mtl": b"newmtl skin\nmap_Kd skin.png\n",
        "skin.png": green,
    }
    robot = gather_robot("r.urdf", lambda asked: (read | {name: data})[asked])
    assert robot.items == ()
    (seen,) = np.flatnonzero(robot.model.geom_type == mujoco.mjtGeom.mjGEOM_MESH)
    assert robot.model.geom_matid[seen] == (0 if name == "a.obj" else -1)
    assert robot.model.geom_rbound[seen] >= 0.7


def test_shapes_of_one_name_are_read_without_a_warning(capfd):
    twice = URDF.replace("<visual>", '<visual name="a">').replace("<collision>", '<collision name="a">')
    files = {"r.urdf": twice, "a.obj": OBJ.replace("mtllib a.mtl", "")}
    assert gather_robot("r.urdf", lambda name: files[name].encode()).model.ngeom == 2
    assert capfd.readouterr() == ("", "")


def test_a_mesh_whose_texture_is_missing_has_its_colour():
    files = {"r.urdf": URDF, "a.obj": OBJ, "a.mtl": "newmtl skin\nKd 1 0 0\nmap_Kd skin.png\n"}

    def read(name: str) -> bytes:
        if name not in files:
            raise ValueError(f"no file '{name}'")
        return files[name].encode()

    robot = gather_robot("r.urdf", read)
    assert [(each.kind, each.name) for each in robot.items] == [("missing picture", "skin.png")]
    (seen,) = np.flatnonzero(robot.model.geom_type == mujoco.mjtGeom.mjGEOM_MESH)
    assert robot.model.geom_rgba[seen].tolist() == pytest.approx([1, 0, 0, 1], abs=0.01)


def test_an_stl_in_words_becomes_the_same_triangles_in_bytes():
    corners = CORNERS[FACES]
    lines = "".join(
        "facet normal 0 0 1\nouter loop\n"
        + "".join(f"vertex {x} {y} {z}\n" for x, y, z in face)
        + "endloop\nendfacet\n"
        for face in corners.tolist()
    )
    part = whole_mesh("a.stl", f"solid a\n{lines}endsolid".encode(), nothing)
    assert size_of(part.data) == [4, 2, 1]
    assert is_small_stl(part.data)
    assert whole_mesh("a.stl", stl(corners), nothing).data == stl(corners)


def test_a_fine_mesh_is_made_coarser_within_a_cell(monkeypatch):
    monkeypatch.setattr("mjsim.models.mesh_files.MAX_TRIANGLES", most := 1000)
    x, y = np.meshgrid(np.arange(40), np.arange(25), indexing="ij")
    low = np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 1, 1, 3)
    shifts = np.array([[[0, 0, 0], [1, 0, 0], [1, 1, 0]], [[0, 0, 0], [1, 1, 0], [0, 1, 0]]])
    triangles = (low + shifts).reshape(-1, 3, 3) * [0.05, 0.04, 1.0]
    part = whole_mesh("a.stl", stl(triangles), nothing)
    assert part.coarser
    (count,) = struct.unpack_from("<I", part.data, 80)
    assert most / 3 < count <= most
    assert size_of(part.data) == pytest.approx((2.0, 1.0, 0.0), abs=0.1)
