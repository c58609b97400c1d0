"""Objects from models of Gazebo: their shapes, sizes and colours."""

import mujoco
import numpy as np
import pytest

from mjsim.models import gather_model, read_model

LINK = "<link name='l'><pose>0 0 1 0 0 0</pose>{}<collision name='c'><geometry>{}</geometry></collision></link>"
VISUAL = "<visual name='v'><material><diffuse>{}</diffuse></material></visual>"


def read(shape: str, visual: str = "") -> mujoco.MjModel:
    """Return the model of an SDF file with one shape."""
    text = f"<sdf version='1.9'><model name='m'>{LINK.format(visual, shape)}</model></sdf>"
    return read_model("a.sdf", lambda _: text.encode()).model


@pytest.mark.parametrize(
    ("shape", "size"),
    [
        ("<box><size>2 4 6</size></box>", [1, 2, 3]),
        ("<sphere><radius>2</radius></sphere>", [2]),
        ("<cylinder><radius>2</radius><length>6</length></cylinder>", [2, 3]),
        ("<capsule><radius>2</radius><length>6</length></capsule>", [2, 3]),
    ],
)
def test_shapes_of_an_sdf_model_have_its_sizes_and_place(shape, size):
    model = read(shape)
    assert model.ngeom == 1
    np.testing.assert_allclose(model.geom_size[0, : len(size)], size)
    assert model.geom_pos[0, 2] + model.body_pos[:, 2].sum() == pytest.approx(1.0)


@pytest.mark.parametrize("diffuse", ["a dozen words", "nan 0 0 1", "1", "9 -1 0 1"])
def test_a_wrong_colour_of_an_sdf_model_does_not_refuse_it(diffuse):
    (rgba,) = read("<sphere><radius>2</radius></sphere>", VISUAL.format(diffuse)).geom_rgba
    np.testing.assert_allclose(rgba, [1, 0, 0, 1] if diffuse[0] == "9" else [0.5, 0.5, 0.5, 1], atol=1 / 255)


def test_a_shape_of_sdf_that_no_object_has_is_named():
    with pytest.raises(ValueError, match="has the shape <cone>; make it of boxes, cylinders, spheres and meshes"):
        gather_model("a.sdf", lambda _: f"<sdf><model>{LINK.format('', '<cone/>')}</model></sdf>".encode())
