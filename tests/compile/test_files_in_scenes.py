"""Masses, friction and marks that a scene has from files and from world files."""

import mujoco
import numpy as np
import pytest

from mjsim.compile import compile_world, export_scene
from mjsim.world import load_world, parse_world
from mjsim.world.language.templates import MAX_ITEMS, MAX_VALUES, Budget, TooMuchError

FILE = """<mujoco><worldbody><body name="b">
  <geom type="box" size="0.2 0.1 0.3" density="300" friction="0.9 0.1 0.1"/>
  <geom type="sphere" size="0.05" pos="0 0 0.5" mass="2"/>
</body></worldbody></mujoco>"""


def compiled(folder, text: str) -> mujoco.MjModel:
    (folder / "thing.xml").write_text(FILE)
    (folder / "w.yaml").write_text(f"mjsim: 1\n{text}\n")
    return compile_world(load_world(folder / "w.yaml")).compile()


@pytest.mark.parametrize(
    ("keys", "mass", "size"), [("", None, 1.0), (", mass: 8", 8.0, 1.0), (", scale: 2", None, 2.0)]
)
def test_an_object_of_a_file_has_its_mass_or_the_one_that_the_world_gives(tmp_path, keys, mass, size):
    model = compiled(tmp_path, f"obstacles: [{{name: t, model: thing.xml, at: [0, 0], movable: true{keys}}}]")
    own = mujoco.MjModel.from_xml_string(FILE)
    wanted = own.body_mass[1] * size**3 if mass is None else mass
    body = model.body("obstacle/t")
    assert body.subtreemass[0] == pytest.approx(wanted)
    part = model.body_mass.argmax()
    np.testing.assert_allclose(model.body_ipos[part], own.body_ipos[1] * size, atol=1e-9)
    factor = wanted / own.body_mass[1] * size**2
    np.testing.assert_allclose(model.body_inertia[part], own.body_inertia[1] * factor, rtol=1e-6)


@pytest.mark.parametrize(("keys", "friction"), [("", 0.9), (", friction: 0.3", 0.3)])
def test_a_body_of_a_file_in_a_mechanism_has_its_friction_or_the_one_that_the_world_gives(tmp_path, keys, friction):
    joint = "{revolute: q, of: [ground, bar], axis: [0, 1, 0]}"
    bar = f"{{name: bar, model: thing.xml{keys}}}"
    model = compiled(
        tmp_path, f"mechanisms: [{{name: m, at: [0, 0], elevation: 2, bodies: [{bar}], joints: [{joint}]}}]"
    )
    assert model.geom("m/bar").friction[0] == pytest.approx(friction)


def test_a_bar_on_a_robot_shows_its_heading_and_fits_on_its_narrow_side():
    world = parse_world("mjsim: 1\nrobots: [{name: r, at: [0, 0], body: {box: [0.6, 0.2, 0.3]}}]\n")
    model = compile_world(world).compile()
    (mark,) = (
        number
        for number in range(model.ngeom)
        if model.geom_size[number, 2] == 0.004 and model.geom_type[number] == mujoco.mjtGeom.mjGEOM_BOX
    )
    np.testing.assert_allclose(model.geom_size[mark], [0.3 * 0.46, 0.1 * 0.11, 0.004])
    np.testing.assert_allclose(model.geom_pos[mark][:2], [0.15, 0.0])


def test_values_and_items_of_an_expansion_are_counted_together():
    budget = Budget()
    budget.take(None, MAX_VALUES - 1)
    budget.take(None, 1)
    with pytest.raises(TooMuchError, match=f"more than {MAX_VALUES} values"):
        budget.take(None, 1)
    budget.check_items(None, MAX_ITEMS - 3)
    with pytest.raises(TooMuchError, match=f"more than {MAX_ITEMS} items"):
        budget.check_items(None, MAX_ITEMS - 2)


DICE = """<mujoco><asset>
<texture name="sides" type="cube" builtin="gradient" rgb1="1 0 0" rgb2="0 1 0" width="4" height="4"/>
<texture name="spots" type="2d" builtin="checker" rgb1="1 0 0" rgb2="0 1 0" width="6" height="4"/>
<material name="sides" texture="sides"/><material name="spots" texture="spots"/></asset><worldbody>
<geom type="box" size="0.1 0.1 0.1" material="sides"/><geom type="box" size="1 1 1" material="spots"/>
</worldbody></mujoco>"""
PICTURES = """
mjsim: 1
obstacles: [{model: dice.xml, at: [2, 0], movable: true}]
beacons: [{name: tag, marker: {dictionary: 4x4_50, id: 7}, at: [3, 0]}]
"""


def test_pictures_of_a_written_scene_are_those_of_the_scene_in_memory(tmp_path):
    (tmp_path / "dice.xml").write_text(DICE)
    (tmp_path / "w.yaml").write_text(PICTURES)
    world = load_world(tmp_path / "w.yaml")
    ours = compile_world(world).compile()
    theirs = mujoco.MjModel.from_xml_path(str(export_scene(world, tmp_path / "out")))
    assert sorted(ours.tex_type) == [mujoco.mjtTexture.mjTEXTURE_2D] * 2 + [mujoco.mjtTexture.mjTEXTURE_CUBE]
    for key in ("tex_type", "tex_height", "tex_width", "tex_data"):
        np.testing.assert_array_equal(getattr(theirs, key), getattr(ours, key))
