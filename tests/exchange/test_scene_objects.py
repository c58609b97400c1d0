"""Models of Gazebo: as objects of a world that names them, and where a saved state has them."""

import pytest

from mjsim.errors import UsageError, WorldError
from mjsim.world import CylinderObstacle, Source, parse_world, solid
from tests.exchange.test_scenes import BOX, POST, WALLS, brought, link, model, scene


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
        WorldError, match="has 2 models beside its worlds; an object has one, else import it as a world"
    ):
        parse_world(text, source=Source(folder=tmp_path))


def test_models_stand_where_the_state_that_gazebo_saved_has_them(tmp_path):
    state = (
        "<state world_name='w'><sim_time>281 0</sim_time><model name='walls'><pose>0 0 0 0 0 0</pose></model>"
        "<model name='post'><pose>2 1.5 -2e-06 6e-06 2e-06 0.5</pose><scale>1 1 1</scale><link name='l'>"
        "<pose>2 1.5 0.5 0 0 0.5</pose></link></model><model name='grown'><pose>1 3 0 0 0 0</pose>"
        "<scale>1 1 2</scale></model></state>"
        "<state world_name='w'><model name='post'><pose>9 9 0 0 0 0</pose></model></state>"
    )
    posts = "".join(
        model(link("0 0 0.5 0 0 0", POST), pose="5 3 0 0 0 0", static=False, name=name) for name in ("post", "grown")
    )
    world, found = brought(scene(tmp_path, WALLS + posts + state))
    places = {thing.name: thing.at for thing in world.obstacles}
    assert places["post"] == pytest.approx((2.0, 1.5), abs=1e-3)
    assert places["grown"] == pytest.approx((1.0, 3.0), abs=1e-3)
    assert all(isinstance(thing, CylinderObstacle) for thing in world.obstacles)
    assert len(world.walls) == 4
    assert any("place" in line and "'post'" in line and "state" in line for line in found.report)
    assert any(line.startswith("left out: ") and "scale" in line and "'grown'" in line for line in found.report)


def test_links_stand_where_the_state_has_them_unless_a_joint_holds_them(tmp_path):
    saved = "<link name='{}'><pose>{}</pose></link>"
    loose = link("0 0 0.5 0 0 0", POST, name="a") + link("0 0 0.5 0 0 0", POST, name="b")
    door = (
        link("0 0 0.5 0 0 0", BOX.format("0.1 0.1 1"), name="a")
        + link("0.3 0 0.5 0 0 0", BOX.format("0.4 0.1 1"), name="b")
        + "<joint name='j' type='revolute'><parent>a</parent><child>b</child></joint>"
    )
    state = (
        "<state world_name='w'><model name='loose'><pose>1 1 0 0 0 1.5708</pose>"
        f"{saved.format('a', '1 1.001 0.5 0 0 1.5708')}{saved.format('b', '1 3 0.5 0 0 1.5708')}</model>"
        f"<model name='door'><pose>3 3 0 0 0 0</pose>{saved.format('b', '3 3.3 0.5 0 0 1.5708')}</model>"
        "<insertions><model name='late'/></insertions></state>"
    )
    models = model(loose, name="loose") + model(door, pose="3 3 0 0 0 0", static=False, name="door")
    world, found = brought(scene(tmp_path, WALLS + models + state))
    posts = sorted(thing.at for thing in world.obstacles if isinstance(thing, CylinderObstacle))
    assert posts == [pytest.approx((1.0, 1.0), abs=1e-3), pytest.approx((1.0, 3.0), abs=1e-3)]
    said = "\n".join(found.report)
    assert "kept: place of a link 'loose::b': that in the state which Gazebo saved" in said
    assert "left out: place of a link 'door::b': that in the state which Gazebo saved: it is on a joint" in said
    assert "left out: state of Gazebo: insertions 'late': not applied" in said


def test_sensors_of_a_scene_are_told(tmp_path):
    eye = "<sensor name='eye' type='camera'/>"
    _, found = brought(scene(tmp_path, WALLS + model(f"<link name='l'>{eye}</link>", name="pole")))
    assert "left out: camera sensor 'pole::eye': only robots have sensors" in found.report
    path = tmp_path / "room.xml"
    path.write_text(
        "<mujoco><worldbody><geom type='box' size='1 1 1'/><camera name='top' pos='0 0 5'/></worldbody></mujoco>"
    )
    assert "left out: camera 'top': only robots have sensors" in brought(path)[1].report


def test_a_world_of_stage_is_no_world_of_gazebo(tmp_path):
    path = tmp_path / "a.world"
    path.write_text("# Stage\nsize [16 16]\n")
    with pytest.raises(UsageError, match=r"line 1, column 1, and so no world of Gazebo \(SDF\)$"):
        brought(path)
