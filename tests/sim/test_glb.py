"""A .glb file holds the surfaces that MuJoCo has, at their places, readable by the rules of glTF 2.0."""

import json
import struct

import mujoco
import numpy as np
import pytest

from mjsim.bench.rooms import forwarded
from mjsim.compile import compile_world, compiled
from mjsim.errors import UsageError
from mjsim.light import ALWAYS
from mjsim.sim import StillScene, glb_bytes, write_glb
from mjsim.world import parse_world
from tests.sim.evenly_lit import evenly_lit

ROOM = """
mjsim: 1
walls: [{points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true, height: 2.2, thickness: 0.2}]
obstacles: [{name: chest, box: [0.8, 0.5, 0.4], at: [2, 3], heading_deg: 30}]
beacons: [{name: owl-1, image: posters/owl.jpg, at: [0.11, 2], width: 0.8, center: 1.0}]
robots: [{name: scout, at: [4, 2], heading_deg: 90, sensors: [{camera: cam}]}]
"""
DTYPES = {5126: np.float32, 5123: np.uint16, 5125: np.uint32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


def read(data: bytes) -> tuple[dict, bytes]:
    """Return both parts of a file."""
    magic, version, length = struct.unpack_from("<4sII", data)
    assert (magic, version, length) == (b"glTF", 2, len(data))
    size, kind = struct.unpack_from("<I4s", data, 12)
    assert kind == b"JSON"
    rest, binary = struct.unpack_from("<I4s", data, 20 + size)
    assert binary == b"BIN\0"
    assert 28 + size + rest == len(data)
    return json.loads(data[20 : 20 + size]), data[28 + size :]


def values(document: dict, binary: bytes, accessor: int) -> np.ndarray:
    """Return an array of a file, shape (n, width)."""
    said = document["accessors"][accessor]
    view = document["bufferViews"][said["bufferView"]]
    assert view["byteOffset"] % 4 == 0
    part = binary[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
    return np.frombuffer(part, DTYPES[said["componentType"]]).reshape(said["count"], WIDTHS[said["type"]])


def turned(points: np.ndarray, node: dict) -> np.ndarray:
    """Return points (n, 3) of a node in the frame of what it hangs on."""
    x, y, z, w = node["rotation"]
    matrix = np.empty(9)
    mujoco.mju_quat2Mat(matrix, np.array([w, x, y, z]))
    return points @ matrix.reshape(3, 3).T + node.get("translation", [0.0, 0.0, 0.0])


def surfaces(data: bytes) -> dict[str, np.ndarray]:
    """Return the triangles of each node in the world, y up as glTF has it, shape (m, 3, 3) [m]."""
    document, binary = read(data)
    root, found = document["nodes"][0], {}
    for child in root["children"]:
        node = document["nodes"][child]
        parts = []
        for primitive in document["meshes"][node["mesh"]]["primitives"] if "mesh" in node else []:
            points = values(document, binary, primitive["attributes"]["POSITION"])
            corners = values(document, binary, primitive["indices"]).reshape(-1, 3)
            assert sum(count for _, count in primitive["extras"]["things"]) == len(corners)
            parts.append(turned(turned(points, node), root)[corners])
        found[node["name"]] = np.concatenate(parts) if parts else np.zeros((0, 3, 3))
    return found


def hit(triangles: np.ndarray, start: np.ndarray, way: np.ndarray) -> float:
    """Return how far a ray goes to triangles that face it (Moeller and Trumbore 1997) [m]; infinity when it misses."""
    a, one, other = triangles[:, 0], triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    across = np.cross(way, other)
    scale = np.einsum("ij,ij->i", one, across)
    facing = scale > 1e-12
    inverse = 1.0 / np.where(facing, scale, 1.0)
    u = np.einsum("ij,ij->i", start - a, across) * inverse
    up = np.cross(start - a, one)
    v, distance = up @ way * inverse, np.einsum("ij,ij->i", other, up) * inverse
    met = facing & (u >= 0) & (v >= 0) & (u + v <= 1) & (distance > 0)
    return float(distance[met].min(initial=np.inf))


@pytest.mark.slow
def test_rays_meet_the_surfaces_of_a_file_where_mujoco_meets_them(tmp_path):

    world = parse_world(ROOM)
    scene = StillScene(world)
    scene.show(scene.model.qpos0)
    found = surfaces(write_glb(world, tmp_path / "room.glb").read_bytes())
    still = found["world"]
    rng, start = np.random.default_rng(0), np.array([3.1, 1.3, 1.2])
    groups = np.array([1, 1, 1, 0, 0, 0], dtype=np.uint8)
    # In the first two groups are what does not move and all of the robot; the robot is left out by its body.
    robot = scene.model.body("scout/base").id
    for way in rng.normal(size=(200, 3)):
        way /= np.linalg.norm(way)
        said = mujoco.mj_ray(scene.model, scene.data, start, way, groups, 1, robot, np.empty(1, np.int32), None)
        up = np.array([way[0], way[2], -way[1]])
        read_back = hit(still, start[[0, 2, 1]] * [1, 1, -1], up)
        assert read_back == pytest.approx(said if said >= 0 else np.inf, abs=1e-4)
    low, high = found["scout/base"].min(axis=(0, 1)), found["scout/base"].max(axis=(0, 1))
    assert low[0] < 4.0 < high[0]
    assert low[2] < -2.0 < high[2]


@pytest.mark.parametrize(
    ("shape", "size", "volume"),
    [
        ("box", "0.1 0.2 0.3", 8 * 0.1 * 0.2 * 0.3),
        ("sphere", "0.2", 4 / 3 * np.pi * 0.2**3),
        ("ellipsoid", "0.1 0.2 0.3", 4 / 3 * np.pi * 0.1 * 0.2 * 0.3),
        ("cylinder", "0.1 0.3", np.pi * 0.1**2 * 0.6),
        ("capsule", "0.1 0.3", np.pi * 0.1**2 * 0.6 + 4 / 3 * np.pi * 0.1**3),
    ],
)
def test_a_shape_is_closed_and_looks_outwards(shape, size, volume):
    xml = f"<mujoco><worldbody><body><joint/><geom type='{shape}' size='{size}'/></body></worldbody></mujoco>"
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    triangles = np.concatenate(list(surfaces(glb_bytes(model, data)).values())).astype(float)
    enclosed = np.einsum("ij,ij->i", triangles[:, 0], np.cross(triangles[:, 1], triangles[:, 2])).sum() / 6
    # Corners lie on the surface, so a faceted shape has a little less.
    assert 0.95 * volume < enclosed <= volume * (1 + 1e-6)
    area = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]).sum(axis=0)
    np.testing.assert_allclose(area, 0.0, atol=1e-6)


@pytest.mark.slow
def test_many_people_have_fewer_triangles_in_a_view_and_keep_their_forms():
    def scenes(count):
        people = "".join(f"  - {{name: p{k}, sex: female, at: [{k}, 0]}}\n" for k in range(count))
        still = StillScene(parse_world(f"mjsim: 1\npeople:\n{people}"))
        still.show(still.model.qpos0)
        return [surfaces(glb_bytes(still.model, still.data, sparing=sparing)) for sparing in (False, True)]

    few, fewer = scenes(2)
    assert sum(map(len, few.values())) == sum(map(len, fewer.values())) > 40_000
    whole, thin = scenes(3)
    assert sum(map(len, thin.values())) < 0.35 * sum(map(len, whole.values()))
    assert whole.keys() == thin.keys()
    for name in whole.keys() - {"world"}:
        full, coarse = (each[name].reshape(-1, 3).astype(float) for each in (whole, thin))
        # A cell is a tenth of the longest side; a corner is in the middle of those of its cell.
        cell = np.ptp(full, axis=0).max() / 10
        assert np.abs(full.min(axis=0) - coarse.min(axis=0)).max() < cell
        assert np.abs(full.max(axis=0) - coarse.max(axis=0)).max() < cell


def test_heights_of_a_field_stand_where_mujoco_has_them():
    xml = """<mujoco><asset><hfield name='hill' nrow='2' ncol='3' size='1 0.5 2 0.1' elevation='0 0 0  0 0 1'/></asset>
    <worldbody><geom type='hfield' hfield='hill'/></worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    triangles = surfaces(glb_bytes(model, data))["world"]
    for x, y in [(0.9, 0.3), (0.7, 0.45), (-0.5, -0.2), (0.4, -0.1)]:
        start, down = np.array([x, y, 5.0]), np.array([0.0, 0.0, -1.0])
        said = mujoco.mj_ray(model, data, start, down, None, 1, -1, np.empty(1, np.int32), None)
        assert hit(triangles, np.array([x, 5.0, -y]), np.array([0.0, -1.0, 0.0])) == pytest.approx(said, abs=1e-5)


def test_an_empty_scene_is_a_file_too():
    model = mujoco.MjModel.from_xml_string("<mujoco/>")
    state = mujoco.MjData(model)
    mujoco.mj_forward(model, state)
    data = glb_bytes(model, state)
    size = struct.unpack_from("<I", data, 12)[0]
    document = json.loads(data[20 : 20 + size])
    assert len(data) == 20 + size
    assert not {"meshes", "buffers", "cameras"} & set(document)


def test_a_name_without_the_suffix_glb_is_refused(tmp_path):
    with pytest.raises(UsageError, match=r"ends in '\.gltf'; a binary file of glTF ends in \.glb"):
        write_glb(parse_world("mjsim: 1"), tmp_path / "room.gltf")


def test_baked_light_is_in_the_colours_of_corners_of_what_stands():
    world = parse_world(ROOM)
    model = compiled(compile_world(world))
    data = forwarded(model)
    light = np.array([0.9, 0.6, 0.3])
    document, binary = read(glb_bytes(model, data, light=evenly_lit(model, (ALWAYS, lambda geom: light))))
    kinds = {mesh["name"]: mesh for mesh in document["nodes"]}
    found = {}
    for name in ("world", "scout/base"):
        for primitive in document["meshes"][kinds[name]["mesh"]]["primitives"]:
            unlit = "extensions" in document["materials"][primitive["material"]]
            assert unlit == (name == "world")
            colors = values(document, binary, primitive["attributes"]["COLOR_0"]) / 65535
            corners = values(document, binary, primitive["indices"]).reshape(-1, 3)
            first = 0
            for thing, count in primitive["extras"]["things"]:
                found[thing] = colors[corners[first : first + count].ravel(), :3]
                first += count
    assert document["extensionsUsed"] == ["KHR_materials_unlit"]
    for thing, color in {"beacon/owl-1": np.ones(3), "obstacle/chest": model.geom("obstacle/chest").rgba[:3]}.items():
        shown = light * color
        np.testing.assert_allclose(
            found[thing], np.tile(((shown + 0.055) / 1.055) ** 2.4, (len(found[thing]), 1)), atol=2e-3
        )
