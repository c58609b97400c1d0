"""The compiled scene: names, physics, clipping, views, and the folder that plain MuJoCo loads."""

import json
import math
import sys
from pathlib import Path

import cv2
import mujoco
import numpy as np
import pytest

from mjsim.bench.rooms import GALLERY, forwarded, look_from, png
from mjsim.compile import compile_world, export_scene
from mjsim.errors import UsageError
from mjsim.models import bounded, read_picture
from mjsim.sim import Renderer
from mjsim.world import Beacon, BoxObstacle, World, item_names, parse_world
from tests.children import completed

RUN_IN_PLAIN_MUJOCO = """
import json, sys
import mujoco
model = mujoco.MjModel.from_xml_path(sys.argv[1])
data = mujoco.MjData(model)
data.ctrl[:] = 3.0
for _ in range(100):
    mujoco.mj_step(model, data)
assert not any(name.startswith("mjsim") for name in sys.modules)
print(json.dumps([model.ngeom, model.nbody, model.ntex, data.qpos.tolist()]))
"""


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    return compile_world(parse_world(GALLERY)).compile()


def test_everything_has_the_name_that_the_world_gives_it(model: mujoco.MjModel):
    names = {model.geom(index).name for index in range(model.ngeom)}
    assert {"floor", "obstacle/1", "obstacle/pillar", "beacon/lion", "wall/1/0", "wall/2/0"} <= names
    cameras = {model.camera(index).name for index in range(model.ncam)}
    assert {"overview", "scout/front", "scout/chase"} <= cameras


def test_items_without_a_name_are_numbered_past_those_that_have_one():
    items = [BoxObstacle(box=(1, 1, 1), at=(0, 0), name=name) for name in (None, "2", None, "chair")]
    assert item_names(items) == ["1", "2", "3", "chair"]
    items = [BoxObstacle(box=(1, 1, 1), at=(0, 0), name=name) for name in (None, None, "1")]
    assert sorted(item_names(items)) == ["1", "2", "3"]


def test_physics_is_set_for_wheels_and_never_resets_itself(model: mujoco.MjModel):
    assert model.opt.timestep == 0.004
    assert model.opt.integrator == mujoco.mjtIntegrator.mjINT_EULER
    assert model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_AUTORESET
    # Tyres creep sideways in a pyramid's friction, and with friction as soft as the normal force.
    assert model.opt.cone == mujoco.mjtCone.mjCONE_ELLIPTIC
    assert model.opt.impratio == 10.0


@pytest.mark.parametrize("size", [4.0, 60.0, 300.0])
def test_near_and_far_do_not_depend_on_the_size_of_the_world(size: float):
    text = f"mjsim: 1\nwalls: [{{points: [[0, 0], [{size}, 0], [{size}, {size}], [0, {size}]], closed: true}}]"
    model = compile_world(parse_world(text)).compile()
    assert model.vis.map.znear * model.stat.extent == pytest.approx(0.02)
    assert model.vis.map.zfar * model.stat.extent > 2 * size


def test_an_empty_world_has_a_floor_and_a_view():
    model = compile_world(parse_world("mjsim: 1")).compile()
    with Renderer(model, width=64, height=48) as renderer:
        assert (renderer.segment(forwarded(model), "overview") == model.geom("floor").id).all()


def test_a_beacon_is_flat_and_as_large_as_the_world_says(model: mujoco.MjModel):
    data, lion = forwarded(model), model.geom("beacon/lion")
    picture = cv2.imdecode(np.frombuffer(parse_world(GALLERY).read_asset("posters/lion.jpg"), np.uint8), 1)
    np.testing.assert_allclose(lion.size[:2], [0.3, 0.3 * picture.shape[0] / picture.shape[1]])
    np.testing.assert_allclose(data.geom("beacon/lion").xpos, [0.07, 2.0, 1.2])
    # Its x to the viewer's right, y up, z along its heading: the viewer looks along -x, so right is +y.
    np.testing.assert_allclose(
        data.geom("beacon/lion").xmat.reshape(3, 3), [[0, 0, 1], [1, 0, 0], [0, 1, 0]], atol=1e-12
    )


def test_planes_are_drawn_undivided(model: mujoco.MjModel):
    # MuJoCo draws a plane in squares of twice its third size: a thousand to a picture would cost most of a frame.
    planes = model.geom_type == mujoco.mjtGeom.mjGEOM_PLANE
    assert (model.geom_size[planes, 2] > model.geom_size[planes, :2].max(axis=1)).all()


def test_the_overview_sees_every_corner_of_the_world_and_not_much_else(model: mujoco.MjModel):
    data = forwarded(model)
    with Renderer(model, width=320, height=180) as renderer:
        seen = renderer.segment(data, "overview")
    walls = [index for index in range(model.ngeom) if model.geom(index).name.startswith("wall/")]
    rows, columns = np.nonzero(np.isin(seen, walls))
    assert min(rows.min(), columns.min(), 179 - rows.max(), 319 - columns.max()) >= 2
    assert max(np.ptp(rows) / 180, np.ptp(columns) / 320) > 0.85


def test_walls_of_different_directions_are_told_apart_and_white_is_not_burnt_out(model: mujoco.MjModel):
    text = 'mjsim: 1\nwalls: [{points: [[0, 0], [4, 0], [4, 4], [0, 4]], closed: true, color: "#f0f0f0"}]'
    model = compile_world(parse_world(text)).compile()
    data, tones = forwarded(model), []
    with Renderer(model, width=32, height=24) as renderer:
        for heading in np.radians([0, 90, 180, 270]):
            look_from(model, data, "overview", [2, 2, 1], [math.cos(heading), math.sin(heading), 0.0])
            tones.append(int(renderer.render(data, "overview")[12, 16].max()))
    assert np.diff(sorted(tones)).min() >= 6
    assert 150 < min(tones) < max(tones) < 250


@pytest.mark.slow
def test_plain_mujoco_loads_the_folder_and_runs_as_the_scene_in_memory_does(tmp_path: Path):
    world = parse_world(GALLERY)
    scene = export_scene(world, tmp_path / "out")
    assert scene == tmp_path / "out" / "scene.xml"
    assert {path.suffix for path in (tmp_path / "out" / "assets").rglob("*.*")} == {".png"}
    run = completed([sys.executable, "-c", RUN_IN_PLAIN_MUJOCO, str(scene)], cwd=tmp_path)
    geoms, bodies, textures, qpos = json.loads(run.stdout)
    model = compile_world(world).compile()
    data = mujoco.MjData(model)
    data.ctrl[:] = 3.0
    for _ in range(100):
        mujoco.mj_step(model, data)
    assert (geoms, bodies, textures) == (model.ngeom, model.nbody, model.ntex)
    # 15 digits in the file; contacts let such errors grow.
    np.testing.assert_allclose(qpos, data.qpos, atol=1e-8)


def test_nothing_is_written_of_a_world_whose_picture_is_none(tmp_path: Path):
    folder = tmp_path / "out"
    with pytest.raises(UsageError, match=r"^no file 'flag.png' beside the world file or in assets"):
        export_scene(World(beacons=(Beacon(name="flag", image="flag.png", at=(1, 1)),)), folder)
    assert not folder.exists()


def test_a_folder_that_cannot_be_written_is_named(tmp_path: Path):
    (tmp_path / "out").write_text("a file")
    with pytest.raises(UsageError, match=r"out' exists and is not a folder"):
        export_scene(parse_world("mjsim: 1"), tmp_path / "out")


def test_pictures_of_every_kind_are_read_as_rgb():
    rgb = np.full((20, 30, 3), (250, 100, 20), dtype=np.uint8)
    np.testing.assert_array_equal(read_picture(png(rgb)), rgb)
    gray = bytes(cv2.imencode(".png", rgb[..., 1])[1])
    np.testing.assert_array_equal(read_picture(gray), np.full_like(rgb, 100))
    clear = np.dstack([rgb[..., ::-1], np.zeros((20, 30), np.uint8)])
    np.testing.assert_array_equal(read_picture(bytes(cv2.imencode(".png", clear)[1])), np.full_like(rgb, 255))
    deep = bytes(cv2.imencode(".png", rgb[..., ::-1].astype(np.uint16) * 257)[1])
    np.testing.assert_array_equal(read_picture(deep), rgb)
    jpeg = bytes(cv2.imencode(".jpg", rgb[..., ::-1])[1])
    np.testing.assert_allclose(read_picture(jpeg), rgb, atol=6)
    with pytest.raises(ValueError, match="not a picture"):
        read_picture(b"")


def test_textures_are_no_larger_than_what_can_be_seen():
    picture = np.zeros((3000, 1500, 3), dtype=np.uint8)
    assert bounded(picture, 640).shape == (640, 320, 3)
    assert bounded(picture[:100, :50], 640).shape == (100, 50, 3)
    assert bounded(np.zeros((5000, 2, 3), dtype=np.uint8), 640).shape == (640, 1, 3)
