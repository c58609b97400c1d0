"""Models of Gazebo as objects of a world that names them."""

import pytest

from mjsim.errors import WorldError
from mjsim.world import Source, parse_world, solid
from tests.exchange.test_scenes import BOX, POST, link


def test_a_model_of_gazebo_is_an_object_of_a_world(tmp_path):
    part = "<visual name='v'><geometry/><material><diffuse>1 0 0 1</diffuse></material></visual>"
    weight = "<inertial><mass>3</mass></inertial>"
    legs = link("0.5 0 0.4 0 0 0", BOX.format("0.2 0.4 0.8"), more=weight + part, name="a")
    legs += link("-0.5 0 0.5 0 0 0", POST, name="b")
    (tmp_path / "desk.sdf").write_text(f"<sdf version='1.7'><model name='desk'>{legs}</model></sdf>")
    text = "mjsim: 1\nobstacles: [{name: desk, model: desk.sdf, at: [2, 2], heading_deg: 90}]\n"
    (desk,) = parse_world(text, source=Source(folder=tmp_path)).obstacles
    assert (desk.shape.low, desk.shape.high) == (0.0, pytest.approx(1.0))
    outline = solid(parse_world(text, source=Source(folder=tmp_path)))
    assert outline.bounds == pytest.approx((1.8, 1.3, 2.2, 2.6), abs=0.01)
    (tmp_path / "desk.sdf").write_text("<sdf><model name='a'/><model name='b'/></sdf>")
    with pytest.raises(
        WorldError, match="has 2 models beside its worlds; an object has one, else bring it in as a world"
    ):
        parse_world(text, source=Source(folder=tmp_path))
