"""The renderer: the same pixels as MuJoCo's own reading, exact instances, depth as rays measure it."""

import gc
import threading
from collections.abc import Iterator

import mujoco
import numpy as np
import pytest

from mjsim.bench.rooms import GALLERY, cast, forwarded, look_from, place
from mjsim.closing import join
from mjsim.compile import compile_world
from mjsim.errors import UsageError
from mjsim.sim import Canvas, OnboardCamera, Renderer, streams_of
from mjsim.sim.gl import make_context
from mjsim.sim.imaging.lens import intrinsics_of
from mjsim.sim.rendering import canvas as canvases
from mjsim.sim.rendering.canvas import Quality
from mjsim.sim.sensors import robot_from_camera, ticks_between
from mjsim.world import Camera, World, load_world, parse_world

WIDTH, HEIGHT = 320, 240
POSES = np.array([[1.0, 1.0, 0.6], [6.5, 5.0, -2.0], [3.0, 4.0, 2.5]])
BARE = """mjsim: 1
beacons: [{name: lion, image: posters/lion.jpg, at: [2, 0], heading_deg: 180}]
robots: [{name: scout, at: [0, 0], sensors: [{camera: front}]}]
"""


@pytest.fixture(scope="module")
def world() -> World:
    return parse_world(GALLERY)


@pytest.fixture(scope="module")
def model(world: World) -> mujoco.MjModel:
    return compile_world(world).compile()


@pytest.fixture(scope="module")
def canvas(model: mujoco.MjModel) -> Iterator[Canvas]:
    canvas = Canvas(model)
    yield canvas
    canvas.close()


@pytest.fixture(scope="module")
def renderer(model: mujoco.MjModel, canvas: Canvas) -> Renderer:
    return Renderer(model, width=WIDTH, height=HEIGHT, canvas=canvas)


def drawn(model: mujoco.MjModel, camera: str, quality: Quality) -> np.ndarray:
    """Return a picture by a canvas of its own."""
    canvas = Canvas(model, quality=quality)
    try:
        return Renderer(model, width=WIDTH, height=HEIGHT, canvas=canvas).render(forwarded(model), camera)
    finally:
        canvas.close()


@pytest.mark.slow
def test_canvases_one_after_the_other_share_a_context_and_draw_as_in_new_ones(model: mujoco.MjModel, monkeypatch):
    made: list[tuple[int, int]] = []
    monkeypatch.setattr(canvases, "make_context", lambda *size: made.append(size) or make_context(*size))
    other = compile_world(parse_world(BARE)).compile()
    pictures = (model, "scout/front", "normal"), (other, "scout/front", "high")
    monkeypatch.setattr(canvases, "MAX_IDLE", 0)
    monkeypatch.setattr(canvases, "SHADOW_PIXELS", 512)
    monkeypatch.setattr(canvases, "_idle", [])
    alone = [drawn(*each) for each in pictures]
    assert len(made) == 2
    monkeypatch.setattr(canvases, "MAX_IDLE", 1)
    for _ in range(2):
        for each, expected in zip(pictures, alone, strict=True):
            np.testing.assert_array_equal(drawn(*each), expected)
    assert len(made) == 3
    canvases._idle.pop().free()


@pytest.mark.slow
def test_a_picture_is_what_mujoco_reads_turned_upright(model: mujoco.MjModel, canvas: Canvas):
    data, width, height = forwarded(model), 317, 201
    image = Renderer(model, width=width, height=height, canvas=canvas).render(data, "scout/front")
    camera, scene, theirs = mujoco.MjvCamera(), mujoco.MjvScene(model, 1000), np.empty((height, width, 3), np.uint8)
    camera.type, camera.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, model.camera("scout/front").id
    options = mujoco.MjvOption()
    options.geomgroup[:] = [1, 1, 0, 0, 0, 0]
    mujoco.mjv_updateScene(model, data, options, None, camera, mujoco.mjtCatBit.mjCAT_ALL, scene)
    scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = scene.flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = 0
    with canvas.at_work(width, height):
        rect = mujoco.MjrRect(0, 0, width, height)
        mujoco.mjr_render(rect, scene, canvas.mjr)
        mujoco.mjr_readPixels(theirs, None, rect, canvas.mjr)
    theirs = theirs[::-1]
    painted = theirs.any(axis=2)
    assert painted.mean() > 0.5
    np.testing.assert_array_equal(image[painted], theirs[painted])
    assert len(np.unique(image[~painted], axis=0)) <= 1


def test_a_picture_is_the_same_where_opengl_reads_from_the_bottom_only(
    model: mujoco.MjModel, canvas: Canvas, renderer: Renderer
):
    data = forwarded(model)
    upright = renderer.render(data, "scout/front")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(canvas.gl, "reads_from_top", False)
        np.testing.assert_array_equal(renderer.render(data, "scout/front"), upright)


def test_a_given_array_is_filled_and_another_shape_is_refused(model: mujoco.MjModel, renderer: Renderer):
    data, out = forwarded(model), np.zeros((HEIGHT, WIDTH, 3), dtype=np.uint8)
    assert renderer.render(data, "scout/front", out) is out
    np.testing.assert_array_equal(out, renderer.render(data, "scout/front"))
    with pytest.raises(ValueError, match="must be C-contiguous uint8"):
        renderer.render(data, "scout/front", out[:, ::2])


def test_an_unknown_camera_is_named_with_its_fix(model: mujoco.MjModel, renderer: Renderer):
    with pytest.raises(UsageError, match="no camera 'scout/frnt' in this scene; did you mean 'scout/front'"):
        renderer.render(forwarded(model), "scout/frnt")


@pytest.mark.parametrize("alpha", [1.0, 0.5], ids=["opaque", "transparent"])
def test_the_depth_of_an_image_is_that_which_is_drawn_alone(alpha: float):
    pane = f'<geom type="box" size="0.1 1 1" pos="3 0 0" rgba="1 0 0 {alpha}"/>'
    eye = '<camera name="eye" pos="0 0 0.5" xyaxes="0 -1 0 0 0 1"/>'
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><worldbody><geom type="plane" size="5 5 1"/>{pane}{eye}</worldbody></mujoco>'
    )
    data, depths = forwarded(model), list[np.ndarray]()
    with Renderer(model, width=32, height=24) as renderer:
        renderer.render(data, "eye", depths=depths)
        np.testing.assert_array_equal(depths[0], renderer.depth(data, "eye"))
    assert depths[0][12, 16] == pytest.approx(2.9, abs=1e-4)


def test_depth_is_what_rays_measure_along_the_optical_axis(world: World, model: mujoco.MjModel, renderer: Renderer):
    data, camera = forwarded(model), world.robots[0].sensors[0].model_copy(update={"width": WIDTH, "height": HEIGHT})
    intrinsics, transform = intrinsics_of(camera), robot_from_camera(camera)
    v, u = (grid.ravel() for grid in np.mgrid[3:HEIGHT:9, 4:WIDTH:9])
    for pose in POSES:
        place(model, data, "scout", pose)
        depth = renderer.depth(data, "scout/front")[v, u]
        p_camera = (
            np.column_stack([u - intrinsics.cx, v - intrinsics.cy, np.full(len(u), intrinsics.fx)]) / intrinsics.fx
        )
        base = data.body("scout/base").xmat.reshape(3, 3)
        eye = data.body("scout/base").xpos + base @ transform[:3, 3]
        np.testing.assert_allclose(data.cam("scout/front").xpos, eye, atol=1e-12)
        measured = cast(model, data, eye, p_camera @ (base @ transform[:3, :3]).T)
        # Pictures are seen and not met by rays; the cylinder is drawn with facets, a millimetre inside.
        left_out = [i for i in range(model.ngeom) if model.geom(i).name.startswith(("beacon", "obstacle/pillar"))]
        solid = ~np.isin(renderer.segment(data, "scout/front")[v, u], left_out) & np.isfinite(measured)
        assert solid.mean() > 0.5
        assert (np.abs(depth[solid] - measured[solid]) < 1e-3).mean() > 0.99


def test_leaving_out_what_is_out_of_sight_changes_no_pixel(model: mujoco.MjModel, renderer: Renderer):
    data = forwarded(model)
    groups = model.geom_group.copy()
    for pose in POSES:
        place(model, data, "scout", pose)
        seen = renderer.segment(data, "scout/front")
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(renderer._in_view, "unseen", lambda data, view: renderer._drawn[:0])
            np.testing.assert_array_equal(seen, renderer.segment(data, "scout/front"))
        np.testing.assert_array_equal(groups, model.geom_group)


def test_instances_are_geoms_and_nothing_else(model: mujoco.MjModel, renderer: Renderer):
    data = forwarded(model)
    look_from(model, data, "scout/front", [6.0, 1.0, 0.5], [0.0, 1.0, 0.0])
    seen = renderer.segment(data, "scout/front")
    assert seen.dtype == np.int32
    assert seen[HEIGHT // 2, WIDTH // 2] == model.geom("obstacle/pillar").id
    assert seen[-1, 0] == model.geom("floor").id
    assert seen[0, 0] == -1 or model.geom(seen[0, 0]).name.startswith("wall/")
    assert all(index == -1 or model.geom_group[index] in (0, 1) for index in np.unique(seen))


def test_threads_take_turns_on_one_canvas(model: mujoco.MjModel, renderer: Renderer):
    data, seen = forwarded(model), []
    mine = renderer.render(data, "overview")
    for _ in range(2):
        thread = threading.Thread(target=lambda: seen.append(renderer.render(data, "overview")))
        thread.start()
        join(thread)
    np.testing.assert_array_equal(seen[0], mine)
    np.testing.assert_array_equal(seen[1], mine)


@pytest.mark.slow
def test_high_quality_casts_shadows_smooths_edges_and_keeps_instances(model: mujoco.MjModel, renderer: Renderer):
    data = forwarded(model)
    with Renderer(model, width=WIDTH, height=HEIGHT, quality="high") as high:
        plain, fine = renderer.render(data, "overview").astype(int), high.render(data, "overview").astype(int)
        assert len(np.unique(fine.reshape(-1, 3), axis=0)) > len(np.unique(plain.reshape(-1, 3), axis=0))
        floor = renderer.segment(data, "overview") == model.geom("floor").id
        assert (plain[floor] - fine[floor]).max() > 10
        np.testing.assert_array_equal(high.segment(data, "overview"), renderer.segment(data, "overview"))
    assert model.vis.quality.offsamples == 0


def test_a_renderer_that_nobody_closed_takes_nothing_from_one_at_work(model: mujoco.MjModel):
    data, canvas = forwarded(model), Canvas(model)
    near, far = (Renderer(model, width=16, height=16, canvas=canvas) for _ in range(2))
    unclosed = Renderer(model, width=16, height=16)
    first = near.render(data, "overview")
    unclosed.render(data, "overview")
    with canvas.at_work(16, 16):
        del unclosed  # as the garbage collector does, at any time
        gc.collect(1)  # of what is new: to look through all there is takes half a second
    assert (near.render(data, "scout/front") != first).any()
    np.testing.assert_array_equal(far.render(data, "overview"), first)
    canvas.close()


def test_a_renderer_can_be_closed_twice(model: mujoco.MjModel):
    renderer = Renderer(model, width=16, height=16)
    renderer.render(forwarded(model), "overview")
    renderer.close()
    renderer.close()


def test_the_pixels_of_an_onboard_camera_err_by_what_the_world_says(
    world: World, model: mujoco.MjModel, canvas: Canvas
):
    data, robot = forwarded(model), world.robots[0]
    camera = Camera(camera="front", width=WIDTH, height=HEIGHT, rate_hz=12.5, noise=4.0)

    def frame(camera: Camera, seed: int):
        streams = streams_of(seed, robot.name, camera.camera)
        return OnboardCamera(model, robot, camera, streams=streams, canvas=canvas).frame(data, 0.4)

    clean = frame(camera.model_copy(update={"noise": 0.0}), 3)
    frames = [frame(camera, seed) for seed in (3, 3, 4)]
    assert clean.stamp == 0.4
    np.testing.assert_array_equal(frames[0].image, frames[1].image)
    assert (frames[0].image != frames[2].image).any()
    unclipped = (clean.image > 25) & (clean.image < 230)
    errors = (frames[0].image.astype(float) - clean.image)[unclipped]
    # 50,000 values at least: the mean errs by 0.02, the deviation by 0.015; rounding adds 1/12 to the variance.
    assert abs(errors.mean()) < 0.1
    assert abs(errors.std() - np.hypot(4.0, np.sqrt(1 / 12))) < 0.1


def test_a_rate_that_does_not_divide_the_loops_is_refused():
    assert [ticks_between(25.0, rate) for rate in (25.0, 12.5, 5.0)] == [1, 2, 5]
    with pytest.raises(UsageError, match=r"rate_hz is 10; it must divide the loop's 25, the nearest is 12.5"):
        ticks_between(25.0, 10.0)
    with pytest.raises(UsageError, match=r"rate_hz is 50; it must divide the loop's 25, the nearest is 25"):
        ticks_between(25.0, 50.0)


def test_the_calibration_is_the_one_that_mujoco_draws_with(world: World, model: mujoco.MjModel):
    intrinsics = intrinsics_of(world.robots[0].sensors[0])
    fovy = np.radians(model.cam_fovy[model.camera("scout/front").id])
    assert (intrinsics.cx, intrinsics.cy) == (319.5, 239.5)
    np.testing.assert_allclose([intrinsics.fx, intrinsics.fy], 240 / np.tan(fovy / 2))
    np.testing.assert_allclose(320 / intrinsics.fx, np.tan(np.radians(30)))


def test_the_mast_of_one_camera_does_not_stand_before_another():
    robot = "{{name: scout, at: [1, 1], sensors: [{{camera: low, at: [0, 0, 0.3]}}{}]}}"
    pictures = []
    for mast in ("", ", {camera: high, at: [0, 0, 0.9]}"):
        world = parse_world(f"mjsim: 1\nrobots: [{robot.format(mast)}]\n")
        model = compile_world(world).compile()
        with Renderer(model, width=64, height=48) as renderer:
            pictures.append(renderer.render(forwarded(model), "scout/low"))
    np.testing.assert_array_equal(pictures[0], pictures[1])


@pytest.mark.slow
@pytest.mark.parametrize("name", ["control", "press"])
def test_a_bare_floor_in_high_quality_has_no_specks_where_its_shadows_end(name):
    model = compile_world(load_world(name)).compile()
    with Renderer(model, width=960, height=400, quality="high") as high:
        floor = high.render(forwarded(model), "overview")[:130, 640:].astype(int)
    off = np.abs(floor - np.median(floor, axis=(0, 1))).max(axis=-1)
    # What stands there differs by more.
    assert ((off > 2) & (off < 30)).sum() < 20
