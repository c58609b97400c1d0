"""Baked light in pictures: colours times light maps, on the shapes that plain pictures have."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial

import mujoco
import numpy as np
import pytest

from mjsim.bench.rooms import forwarded, look_from
from mjsim.compile import compile_world, compiled, dim_lamp, dim_light
from mjsim.light import ALWAYS, DOOR, GENERAL, LAMP, LightProbes, bake, linear
from mjsim.sim import Onlooker, Playback, Renderer, Simulation
from mjsim.sim.rendering import canvas as canvases
from mjsim.sim.rendering.canvas import Canvas
from mjsim.sim.rendering.light_weights import DOOR_STEPS, LightWeights
from mjsim.sim.rendering.lit_scene import LitScene
from mjsim.sim.rendering.merged import UNSEEN
from mjsim.world import parse_world
from tests.sim.evenly_lit import evenly_lit

WIDTH, HEIGHT = 96, 72
ROOM = """
mjsim: 1
walls:
  - points: [[0, 0], [5, 0], [5, 4], [0, 4]]
    closed: true
    openings: [{name: gate, segment: 0, at: 3.6, width: 1, door: {hinge: left}}]
obstacles:
  - {name: chest, box: [0.8, 0.5, 0.6], at: [2.8, 3.2], heading_deg: 30, color: "#a05030"}
  - {name: pillar, cylinder: [0.2, 1.0], at: [3.5, 1.2]}
  - {name: crate, box: [0.4, 0.4, 0.4], at: [2.6, 2.0], movable: true, color: "#ffffff"}
beacons: [{name: lion, image: posters/lion.jpg, at: [4.93, 2.6], heading_deg: 180, width: 0.8, center: 0.8}]
floor: {texture: floors/oak.jpg, tile: 1.3}
lamps: [{name: desk, at: [2, 2], height: 2.0, brightness: 0.5, color: "#ff8040"}]
robots: [{name: r, at: [0.6, 2], sensors: [{camera: eye, at: [0, 0, 0.8]}]}]
"""
WORLD = parse_world(ROOM)
CRATE = (2.6, 2.0)


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    return compiled(compile_world(WORLD))


@pytest.fixture(scope="module")
def canvas(model: mujoco.MjModel) -> Iterator[Canvas]:
    canvas = Canvas(model)
    lit(canvas).render(forwarded(model), "r/eye")  # The first picture compiles what draws.
    yield canvas
    canvas.close()


@pytest.fixture(scope="module")
def plain(model: mujoco.MjModel) -> Iterator[Renderer]:
    with Renderer(model, width=WIDTH, height=HEIGHT) as renderer:
        for draw in (renderer.render, renderer.segment):
            draw(forwarded(model), "r/eye")
        yield renderer


def lit(canvas: Canvas, *groups, **keys) -> Renderer:
    """Return a renderer in light that is even on each geom."""
    model, baked = canvas.model, evenly_lit(canvas.model, *groups, **keys)
    with canvas.at_work(WIDTH, HEIGHT):
        canvas.lit = LitScene(canvas.gl, canvas.mjr, model, baked)
    return Renderer(model, width=WIDTH, height=HEIGHT, canvas=canvas)


@contextmanager
def own_canvas(model: mujoco.MjModel, *groups, quality="normal") -> Iterator[Renderer]:
    """Give a renderer with a canvas of its own, as worlds have it."""
    baked = evenly_lit(model, *groups)
    canvas = Canvas(model, quality=quality, light=lambda: baked)
    try:
        yield Renderer(model, width=WIDTH, height=HEIGHT, canvas=canvas)
    finally:
        canvas.close()


def almost_all_within(limit: float, picture: np.ndarray, expected: np.ndarray) -> bool:
    """Return whether values agree but for outlines of round shapes, which have other facets."""
    return bool((np.abs(picture - expected) <= limit).mean() > 0.998)


def colors(model: mujoco.MjModel, plain: Renderer, data: mujoco.MjData) -> np.ndarray:
    """Return a plain picture in even light of full strength: the colours of surfaces."""
    head = model.vis.headlight
    kept = model.light_active.copy(), head.ambient.copy(), head.diffuse.copy(), model.mat_emission.copy()
    try:
        model.light_active[:], head.ambient[:], head.diffuse[:] = 0, 1.0, 0.0
        return plain.render(data, "r/eye").astype(float)
    finally:
        model.light_active[:], head.ambient[:], head.diffuse[:], model.mat_emission[:] = kept


def still(model: mujoco.MjModel, plain: Renderer, data: mujoco.MjData) -> np.ndarray:
    """Return the static geom at each pixel but those of the floor, where shadows are; -1 elsewhere."""
    seen = plain.segment(data, "r/eye")
    stands = (model.body_weldid[model.geom_bodyid[seen]] == 0) & (seen >= 0) & (seen != model.geom("floor").id)
    return np.where(stands, seen, -1)


def values(geom: int) -> np.ndarray:
    """Return a light of its own for each geom, as values of pictures."""
    return np.array([0.3, 0.55, 0.8])[np.roll(np.arange(3), geom)] + 0.02 * (geom % 7)


def test_a_picture_is_the_colour_of_surfaces_times_their_light(model: mujoco.MjModel, plain: Renderer, canvas: Canvas):
    data = forwarded(model)
    albedo, geoms = colors(model, plain, data), still(model, plain, data)
    renderer = lit(canvas, (ALWAYS, values))
    picture = renderer.render(data, "r/eye")
    shown = geoms >= 0
    names = {model.geom(int(geom)).name for geom in np.unique(geoms[shown])}
    assert names >= {"beacon/lion", "obstacle/chest", "obstacle/pillar"}
    expected = albedo[shown] * np.array([values(int(geom)) for geom in geoms[shown]])
    # The map is rounded, then the product.
    assert almost_all_within(2.0, picture[shown], expected)


def test_tiles_of_the_floor_lie_where_plain_pictures_have_them(model: mujoco.MjModel, plain: Renderer, canvas: Canvas):
    data = forwarded(model)
    albedo, floor = colors(model, plain, data), plain.segment(data, "r/eye") == model.geom("floor").id
    renderer = lit(canvas)
    error = np.abs(renderer.render(data, "r/eye") - albedo)[floor].max(axis=1)
    assert np.ptp(albedo[floor]) > 50.0
    assert (error <= 1.0).mean() > 0.5  # Elsewhere are shadows.


def test_depth_and_instances_are_those_of_plain_pictures(model: mujoco.MjModel, plain: Renderer, canvas: Canvas):
    data = forwarded(model)
    renderer = lit(canvas)
    depths: list[np.ndarray] = []
    renderer.render(data, "r/eye", depths=depths)
    np.testing.assert_array_equal(renderer.segment(data, "r/eye"), plain.segment(data, "r/eye"))
    np.testing.assert_array_equal(renderer.depth(data, "r/eye"), plain.depth(data, "r/eye"))
    np.testing.assert_array_equal(depths[0], plain.depth(data, "r/eye"))


def test_events_change_the_weights_of_lamps_and_of_the_general_light(
    model: mujoco.MjModel, plain: Renderer, canvas: Canvas
):
    data, lamp = forwarded(model), WORLD.lamps[0]
    albedo, shown = colors(model, plain, data), still(model, plain, data) >= 0
    groups = (GENERAL, lambda geom: (0.5, 0.5, 0.5)), (f"{LAMP}desk", lambda geom: (0.6, 0.6, 0.6))
    color = np.array([0xFF, 0x80, 0x40]) / 255

    def expected(level: float, brightness: float) -> np.ndarray:
        light = linear(0.5) * linear(level) + linear(0.6) * linear(brightness * color)
        return albedo[shown] * light ** (1 / 2.2)

    renderer = lit(canvas, *groups)
    for level, brightness in ((1.0, 0.5), (0.2, 0.5), (0.2, 0.0), (0.0, 1.0), (1.0, 0.5)):
        dim_light(model, level)
        dim_lamp(model, "lamp/desk", lamp, brightness)
        assert almost_all_within(2.5, renderer.render(data, "r/eye")[shown], expected(level, brightness))


def test_an_open_door_adds_its_share_and_a_half_open_one_half(model: mujoco.MjModel, plain: Renderer, canvas: Canvas):
    data = forwarded(model)
    hinge = model.joint("door/gate").qposadr[0]
    groups = (ALWAYS, lambda geom: (0.8, 0.8, 0.8)), (f"{DOOR}gate", lambda geom: (-0.5, -0.5, 0.3))
    renderer = lit(canvas, *groups)
    for angle, share in ((0.0, 0.0), (np.pi / 4, 0.5), (np.pi / 2, 1.0), (-np.pi / 2, 0.0)):
        data.qpos[hinge] = angle
        mujoco.mj_kinematics(model, data)
        albedo, shown = colors(model, plain, data), still(model, plain, data) >= 0
        light = linear(0.8) + share * np.array([-1, -1, 1]) * linear(np.array([0.5, 0.5, 0.3]))
        assert almost_all_within(2.5, renderer.render(data, "r/eye")[shown], albedo[shown] * light ** (1 / 2.2))


def test_a_picture_depends_on_the_state_alone_not_on_light_before(model: mujoco.MjModel, canvas: Canvas):
    data = forwarded(model)
    groups = (GENERAL, lambda geom: (0.5, 0.61, 0.73)), (f"{LAMP}desk", values)
    renderer = lit(canvas, *groups)
    first = renderer.render(data, "r/eye")
    for level in (0.37, 0.111, 1.0):
        dim_light(model, level)
        again = renderer.render(data, "r/eye")
    np.testing.assert_array_equal(again, first)


def test_a_lamp_that_shares_a_map_is_named_once_when_it_changes(model: mujoco.MjModel, capsys):
    data, weights = forwarded(model), LightWeights(model, evenly_lit(model))
    for active in (1, 0, 0):
        model.light_active[model.light("lamp/desk").id] = active
        weights.of(data)
    model.light_active[model.light("lamp/desk").id] = 1
    assert capsys.readouterr().err == (
        "mjsim: lamp 'desk' shares a light map with others, so its change does not show; name it in an event of the"
        " world, or set shading: plain\n"
    )


def probes(**light: float) -> LightProbes:
    """Return probes at x = 0 and x = 5 m with a light each, as values of pictures."""
    values = np.empty((1, 2, 1, 1, 3), dtype=np.float16)
    values[:, 0], values[:, 1] = linear(light["near"]), linear(light["far"])
    return LightProbes(np.zeros(3), np.array([5.0, 1.0, 1.0]), values)


def crate_light(renderer: Renderer, model: mujoco.MjModel, data: mujoco.MjData) -> float:
    crate = renderer.segment(data, "r/eye") == model.body("obstacle/crate").geomadr[0]
    assert crate.sum() > 30
    return float(renderer.render(data, "r/eye")[crate].mean() / 255)


def test_a_movable_thing_has_the_light_of_the_place_where_it_is(model: mujoco.MjModel, canvas: Canvas):
    data = forwarded(model)
    renderer = lit(canvas, probes=probes(near=1.0, far=0.25))
    middle = crate_light(renderer, model, data)
    data.qpos[model.joint("obstacle/crate").qposadr[0]] = 4.5
    mujoco.mj_forward(model, data)
    far = crate_light(renderer, model, data)
    expected = [((1 - share) + share * linear(0.25)) ** (1 / 2.2) for share in (2.6 / 5.0, 4.5 / 5.0)]
    # The side that faces west gets 0.90 of the light from all directions.
    np.testing.assert_allclose([middle, far], 0.90 * np.array(expected), rtol=0.03)


def floor_light(renderer: Renderer, model: mujoco.MjModel, data: mujoco.MjData, x: float, y: float) -> float:
    """Return how bright the floor is at a place, seen from right above."""
    look_from(model, data, "overview", [x, y, 0.35], [0.0, 0.0, -1.0])
    return float(
        renderer.render(data, "overview")[HEIGHT // 2 - 3 : HEIGHT // 2 + 3, WIDTH // 2 - 3 : WIDTH // 2 + 3].mean()
    )


def test_a_movable_thing_darkens_the_floor_beside_it_wherever_it_is(model: mujoco.MjModel, canvas: Canvas):
    data = forwarded(model)
    start = model.joint("obstacle/crate").qposadr[0]
    beside, apart = (CRATE[0] + 0.26, CRATE[1]), (1.3, 0.6)
    renderer = lit(canvas)
    with_crate = floor_light(renderer, model, data, *beside)
    data.qpos[start : start + 2] = apart[0] - 0.26, apart[1]
    mujoco.mj_forward(model, data)
    without = floor_light(renderer, model, data, *beside)
    moved = floor_light(renderer, model, data, *apart)
    data.qpos[start + 2] += 1.0
    mujoco.mj_forward(model, data)
    lifted = floor_light(renderer, model, data, *apart)
    model.geom_group[model.body("obstacle/crate").geomadr[0]], kept = UNSEEN, 0
    data.qpos[start + 2] -= 1.0
    mujoco.mj_forward(model, data)
    removed = floor_light(renderer, model, data, *apart)
    model.geom_group[model.body("obstacle/crate").geomadr[0]] = kept
    # At the foot of a high wall half of the light from above is hidden; a low one hides a little less.
    assert 0.6 < with_crate / without < 0.85
    assert 0.6 < moved / lifted < 0.85
    assert removed == lifted


@pytest.mark.slow
def test_high_quality_in_baked_light_smooths_edges_and_changes_nothing_else(model: mujoco.MjModel):
    data = forwarded(model)
    with own_canvas(model, (ALWAYS, values)) as normal, own_canvas(model, (ALWAYS, values), quality="high") as high:
        one, four = (renderer.render(data, "r/eye").astype(int) for renderer in (normal, high))
    different = (np.abs(one - four) > 12).any(axis=2).mean()
    assert 0.005 < different < 0.15


def test_renderers_that_share_a_canvas_share_its_light(model: mujoco.MjModel, canvas: Canvas):
    data = forwarded(model)
    first = lit(canvas, (ALWAYS, values))
    other = Renderer(model, width=48, height=36, canvas=first._canvas)
    large = first.render(data, "r/eye")
    small = other.render(data, "r/eye").astype(float)
    np.testing.assert_array_equal(first.render(data, "r/eye"), large)
    halves = large.reshape(36, 2, 48, 2, 3).mean(axis=(1, 3))
    assert np.median(np.abs(halves - small)) < 3.0


def test_mujoco_draws_as_baked_light_needs_it():
    canvases.why_not_lit.cache_clear()
    assert canvases.why_not_lit() == ""


@pytest.mark.slow
def test_a_mujoco_that_draws_otherwise_is_named_once_and_drawn_plain(
    model: mujoco.MjModel, plain: Renderer, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    data = forwarded(model)
    # As if another layout of geoms had moved the number of the list.
    monkeypatch.setattr(canvases.LitScene, "_prepare", lambda self, scene, data: None)
    canvases.why_not_lit.cache_clear()
    try:
        with own_canvas(model, (ALWAYS, values)) as renderer:
            np.testing.assert_array_equal(renderer.render(data, "r/eye"), plain.render(data, "r/eye"))
        with own_canvas(model, (ALWAYS, values)) as renderer:
            renderer.render(data, "r/eye")
    finally:
        canvases.why_not_lit.cache_clear()
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("mjsim: baked light is drawn as plain: surfaces do not show their light map")


EVENTFUL = """
mjsim: 1
walls:
  - points: [[0, 0], [3, 0], [3, 2], [0, 2]]
    closed: true
    openings: [{name: gate, segment: 0, at: 1, width: 1, door: {hinge: left, angle_deg: 30}}]
light: 0.7
shading: baked
lamps:
  - {name: desk, at: [1, 1], height: 1.6, brightness: 0.4, color: "#ff8040"}
  - {name: still, at: [2, 1], height: 1.6}
robots:
  - {name: r, at: [0.6, 1], sensors: [{camera: eye, at: [0, 0, 0.8], width: 96, height: 72, rate_hz: 25, noise: 0}]}
run: {events: [{time: 0.04, lamp: desk, brightness: 0}, {time: 0.08, open: gate, angle_deg: 60}]}
"""


@pytest.mark.slow
def test_the_weights_at_the_start_are_those_of_the_bake():
    world = parse_world(EVENTFUL)
    model = compiled(compile_world(world))
    baked = bake(world, model, processes=1, texel=0.3)
    assert {group.name for group in baked.groups} == {GENERAL, f"{LAMP}desk", f"{LAMP}still", f"{DOOR}gate"}
    np.testing.assert_allclose(
        LightWeights(model, baked).of(forwarded(model)), baked.weights(), rtol=1e-6, atol=0.5 / DOOR_STEPS
    )


@pytest.mark.slow
def test_a_run_its_replay_and_views_of_its_states_show_the_same_light(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("mjsim.light.world_light._baked", partial(bake, processes=1, texel=0.3))
    world = parse_world(EVENTFUL)
    with Simulation(world) as sim:
        before = sim.sense("r").cameras["eye"].image
        for _ in range(10):
            sim.step()
        seen = sim.sense("r").cameras["eye"].image
        qpos, looks, time = sim.state()[0], sim.looks, sim.time
        sim.reset()
        np.testing.assert_array_equal(sim.sense("r").cameras["eye"].image, before)
    assert before.mean() > seen.mean() + 5.0
    with Onlooker(world) as onlooker:
        onlooker.show(qpos, looks)
        np.testing.assert_array_equal(onlooker.onboard("r", "eye").image, seen)
    with Playback(world, width=96, height=72, events=world.run.events) as playback:
        np.testing.assert_array_equal(playback.picture(qpos, "r/eye", time=time), seen)
