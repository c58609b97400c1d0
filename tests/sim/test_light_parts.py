"""What drawing in baked light consists of, without pictures: shadows by closed forms, and the sum of light maps."""

import mujoco
import numpy as np
import pytest

from mjsim.light import ALWAYS, DOOR, GENERAL, LAMP, BakedLight, LightGroup, LightProbes, coded
from mjsim.sim.rendering.contact_shadows import SHADOW_SIDE, shadows_of
from mjsim.sim.rendering.lit_scene import LightMix

GAMMA = 2.2


def shadow(geom: str, name: str = "thing"):
    """Return the shadows of a free body of one geom."""
    body = f'<body name="{name}"><freejoint/><geom {geom}/></body>'
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{body}</worldbody></mujoco>")
    return shadows_of(model, np.arange(model.ngeom))


def hidden(opacity: float) -> float:
    """Return the share of linear light that an opacity takes away, on a 0 to 255 scale."""
    return 1.0 - (1.0 - opacity / 255.0) ** GAMMA


@pytest.mark.parametrize("height", [0.15, 0.3, 0.6])
def test_a_disc_hides_as_much_as_its_form_factor(height: float):
    (found,) = shadow(f'type="cylinder" size="0.3 0.0005" pos="0 0 {height}"')
    middle = found.opacity[
        SHADOW_SIDE // 2 - 1 : SHADOW_SIDE // 2 + 1, SHADOW_SIDE // 2 - 1 : SHADOW_SIDE // 2 + 1
    ].mean()
    # Howell, A Catalog of Radiation Configuration Factors, B-12: an element on the axis of a parallel disc.
    assert hidden(float(middle)) == pytest.approx(0.3**2 / (0.3**2 + height**2), abs=0.05)


def test_a_high_wall_hides_half_of_the_light_at_its_foot_and_all_below_it():
    (found,) = shadow('type="box" size="1 0.05 2" pos="0 0 2"')
    column = found.opacity[:, SHADOW_SIDE // 2].astype(float)
    y = found.low[1] + (np.arange(SHADOW_SIDE) + 0.5) / SHADOW_SIDE * found.size[1]
    assert hidden(float(np.interp(0.1, y, column))) == pytest.approx(0.5, abs=0.07)
    assert hidden(float(np.interp(0.0, y, column))) > 0.9
    np.testing.assert_allclose(column, column[::-1], atol=12)
    assert column[0] == column[-1] == 0.0


def test_what_never_moves_and_the_leaves_of_doors_have_no_shadow_of_their_own():
    assert shadow('type="sphere" size="0.2"', name="door/a") == []
    model = mujoco.MjModel.from_xml_string("<mujoco><worldbody><geom size='0.2'/></worldbody></mujoco>")
    assert shadows_of(model, np.arange(1)) == []


def light(rng: np.random.Generator) -> BakedLight:
    """Return light of four groups, of which a lamp and a door shine on some rows alone."""
    texels = rng.uniform(0.0, 0.4, (4, 20, 8, 3)).astype(np.float16)
    texels[2, :5] = texels[2, 9:] = 0.0
    texels[3, :12] = 0.0
    texels[3] -= np.float16(0.2) * (texels[3] != 0)
    names = (ALWAYS, GENERAL, f"{LAMP}a", f"{DOOR}b")
    groups = tuple(LightGroup(name, each, np.ones(3)) for name, each in zip(names, texels, strict=True))
    probes = LightProbes(np.zeros(3), np.ones(3), np.ones((4, 1, 1, 1, 3), dtype=np.float16))
    return BakedLight((), groups, probes, 0.8)


def test_rows_that_weights_change_replace_the_map_and_the_result_does_not_depend_on_the_way():
    rng = np.random.default_rng(3)
    baked = light(rng)
    mix, image = LightMix(baked), np.zeros((20, 8, 3), dtype=np.uint8)
    weights = np.ones((4, 3))
    rows = []
    for group in (None, 2, 3, 3, 1, 2):
        if group is not None:
            weights[group] = rng.uniform(0.0, 1.0, 3)
        first, part = mix.changed(weights)
        image[first : first + len(part)] = part
        rows.append((first, len(part)))
        exact = coded(baked.total(weights)).astype(int)
        assert np.abs(image - exact).max() <= 1
        np.testing.assert_array_equal(image, LightMix(baked).changed(weights)[1])
    assert rows == [(0, 20), (5, 4), (12, 8), (12, 8), (0, 20), (5, 4)]
    assert mix.changed(weights.copy()) is None
