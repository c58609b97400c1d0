"""Readers of SDF and MJCF against sizes, poses and masses that are written by hand."""

import math

import numpy as np
import pytest

from mjsim.errors import UsageError
from mjsim.exchange import write_sdf
from mjsim.exchange.import_world import bring_file
from mjsim.exchange.inside import NAMED_FILE, claimed_size
from mjsim.exchange.scenes.build import build_world
from mjsim.exchange.scenes.mjcf_in import read_mjcf
from mjsim.exchange.scenes.sdf_files import Folders
from mjsim.exchange.scenes.sdf_in import read_sdf
from mjsim.inventory import inventory
from mjsim.world import parse_world, solid
from tests.exchange.test_parts_of_scenes import box, posed


def test_files_are_found_by_their_scheme_and_not_outside(tmp_path):
    base = tmp_path / "1/2/3/4/5"
    for place in ("models/cup/model.sdf", "table/model-1_10.sdf", "cup.dae", "sub/own.dae"):
        (base / place).parent.mkdir(parents=True, exist_ok=True)
        (base / place).write_text("<sdf/>")
    (tmp_path / "out.dae").write_text("")
    (tmp_path / "1/near.dae").write_text("")
    search = tmp_path / "other"
    (search / "chair").mkdir(parents=True)
    (tmp_path / "1/package.xml").write_text("<package/>")
    folders = Folders(base / "w.sdf", [search])
    for uri, found in (
        ("model://cup", base / "models/cup"),
        ("package://table", base / "table"),
        ("http://server/models/cup/", base / "models/cup"),
        ("file:///own.dae", base / "sub/own.dae"),
        ("file://cup.dae", base / "cup.dae"),
        (" own.dae ", base / "sub/own.dae"),
        ("../cup.dae", base / "cup.dae"),
        ("model://chair", search / "chair"),
        ("../../../../../near.dae", tmp_path / "1/near.dae"),
        ("../../../../../../out.dae", None),
        ("ftp://cup", None),
        ("model://none", None),
        ("model://\0", None),
    ):
        assert folders.find(uri, base / "sub") == found
    config = base / "table/model.config"
    config.write_text("<m><sdf version='1.9'>a.sdf</sdf><sdf version='1.10'>model-1_10.sdf</sdf><sdf>b.sdf</sdf></m>")
    assert folders.model_file(base / "table") == base / "table/model-1_10.sdf"
    assert folders.model_file(base / "models/cup") == base / "models/cup/model.sdf"
    assert folders.model_file(base / "cup.dae") == base / "cup.dae"
    with pytest.raises(UsageError, match=r"has no model\.sdf"):
        folders.model_file(search / "chair")


def test_above_its_folder_a_scene_reads_packages_and_folders_of_models_alone(tmp_path):
    scene = tmp_path / "home" / "me" / "rooms" / "w.sdf"
    for place in ("home/me/private.png", "home/me/models/cup/cup.dae", "home/me/mugs/mug.dae", "home/me/rooms/own.dae"):
        (tmp_path / place).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / place).write_text("")
    folders = Folders(scene, [])
    assert folders.find("../private.png", scene.parent) is None
    assert folders.find("../mugs/mug.dae", scene.parent) is None
    assert folders.find("own.dae", scene.parent)
    assert folders.find("model://cup/cup.dae", scene.parent)
    (tmp_path / "home/me/mugs/model.config").write_text("<model/>")
    assert folders.find("../mugs/mug.dae", scene.parent)
    assert folders.find("../private.png", scene.parent) is None


def sdf(tmp_path, text):
    path = tmp_path / "w.sdf"
    path.write_text(f"<sdf version='1.9'><world name='w'>{text}</world></sdf>")
    return read_sdf(path, search=[])


POINTS = "".join(f"<point>{at}</point>" for at in ("0 0", "2 0", "2 1", "0 1"))
SHAPE = "<collision name='c'><geometry>{}</geometry></collision>"


@pytest.mark.parametrize(
    ("geometry", "kind", "size"),
    [
        ("<box><size>1 2 3</size></box>", "box", (1, 2, 3)),
        ("<sphere><radius>0.5</radius></sphere>", "sphere", (0.5,)),
        ("<cylinder><radius>0.5</radius><length>2</length></cylinder>", "cylinder", (0.5, 2)),
        ("<capsule><radius>0.5</radius><length>2</length></capsule>", "cylinder", (0.5, 3)),
        ("<cone><radius>0.5</radius><length>2</length></cone>", "cylinder", (0.5, 2)),
        (f"<polyline>{POINTS}<height>3</height></polyline>",
         "mesh", ()),
    ],
)  # fmt: skip
def test_shapes_of_sdf_have_their_sizes_and_the_masses_of_their_links(geometry, kind, size, tmp_path):
    links = f"<link name='l'><inertial><mass>2.5</mass></inertial>{SHAPE.format(geometry)}</link><link name='m'/>"
    scene = sdf(tmp_path, f"<model name='a'><pose>1 2 3 0 0 0.5</pose>{links}</model>")
    (thing,) = scene.things
    (solid,) = thing.solids
    assert (solid.kind, solid.size, thing.mass) == (kind, pytest.approx(size), 3.5)
    np.testing.assert_allclose(thing.pose, posed(1, 2, 3, yaw=0.5), atol=1e-9)
    if kind == "mesh":
        np.testing.assert_allclose(np.ptp(solid.vertices, axis=0), [2, 1, 3])
    else:
        np.testing.assert_allclose(solid.pose, thing.pose, atol=1e-9)


@pytest.mark.parametrize(
    ("inside", "starts", "things"),
    [
        ("<static>true</static>", 0, 1),
        ("<static>1</static><plugin filename='libgazebo_ros_diff_drive.so'/>", 0, 1),
        ("<plugin filename='libgazebo_ros_diff_drive.so'/>", 1, 0),
        ("<plugin name='ackermann_STEERING'/>", 1, 0),
        ("<joint type='continuous'/><joint type='revolute'/><link name='s'><sensor/></link>", 1, 0),
        ("<joint type='continuous'/><joint type='fixed'/><link name='s'><sensor/></link>", 0, 1),
        ("<joint type='continuous'/><joint type='revolute'/>", 0, 1),
    ],
)
def test_a_model_that_drives_is_a_robot_and_gives_its_start(inside, starts, things, tmp_path):
    link = f"<link name='l'>{SHAPE.format('<sphere><radius>1</radius></sphere>')}</link>"
    scene = sdf(tmp_path, f"<model name='r'><pose>1 2 0 0 0 2.5</pose>{inside}{link}</model>")
    assert (len(scene.starts), len(scene.things)) == (starts, things)
    if starts:
        assert scene.starts[0] == pytest.approx((1.0, 2.0, 2.5))
    elif "<static>" in inside:
        assert scene.things[0].mass is None


def test_lights_and_planes_of_sdf_are_lamps_and_the_floor(tmp_path):
    plane = "<plane><normal>{}</normal></plane>"
    scene = sdf(
        tmp_path,
        "<light name='sun' type='directional'/><light name='other' type='directional'/>"
        "<light name='p' type='point'><pose>1 2 3 0 0 0</pose><diffuse>1 0 0 1</diffuse>"
        "<attenuation><range>7</range></attenuation></light>"
        "<light name='s' type='spot'/>"
        + "".join(
            f"<model name='{name}'><pose>0 0 {z} 0 0 0</pose><link>{SHAPE.format(plane.format(normal))}</link></model>"
            for name, z, normal in (("a", 0.04, "0 0 1"), ("b", 0.06, "0 0 1"), ("c", 0, "0 1 1"), ("d", 0, "0 0 5"))
        ),
    )
    (point, spot) = scene.lights
    assert (point.place.tolist(), point.color, point.reach) == ([1, 2, 3], "#ff0000", 7.0)
    assert (spot.place.tolist(), spot.color, spot.reach) == ([0, 0, 0], "#ffffff", 10.0)
    assert [(item.kind, item.name) for item in scene.items] == [
        ("directional light", "other"), ("spot light", "s"), ("plane", "b"), ("plane", "c")
    ]  # fmt: skip


def test_geoms_of_mjcf_have_their_full_sizes(tmp_path):
    path = tmp_path / "scene.xml"
    path.write_text(
        "<mujoco><worldbody><light name='l' pos='1 2 3'/><light name='d' directional='true'/>"
        "<geom type='plane' size='1 1 1'/><geom type='box' size='1 2 3' pos='0 0 3' rgba='1 0 0 1'/>"
        "<geom type='cylinder' size='0.5 2' pos='9 0 2'/><geom type='capsule' size='0.5 2' pos='12 0 3'/>"
        "<geom type='sphere' size='0.5' pos='15 0 1'/><geom type='ellipsoid' size='1 2 3' pos='19 0 3'/>"
        "<body name='free' pos='30 0 1'><freejoint/><geom type='box' size='.1 .1 .1' mass='4'/></body>"
        "<body name='hung' pos='40 0 1'><joint type='hinge'/><geom type='box' size='.1 .1 .1'/></body>"
        "</worldbody></mujoco>"
    )
    scene = read_mjcf(path)
    sizes = [(solid.kind, solid.size) for thing in scene.things for solid in thing.solids]
    assert sizes[:5] == [
        ("box", (2.0, 4.0, 6.0)), ("cylinder", (0.5, 4.0)), ("cylinder", (0.5, 5.0)), ("sphere", (0.5,)),
        ("box", (2.0, 4.0, 6.0)),
    ]  # fmt: skip
    assert {thing.name: thing.mass for thing in scene.things} == {
        "world": None,
        "free": pytest.approx(4.0),
        "hung": None,
    }
    assert [(light.name, light.place.tolist(), light.reach) for light in scene.lights] == [("l", [1, 2, 3], 10.0)]
    assert {item.kind for item in scene.items} == {"capsule", "ellipsoid", "directional light"}


@pytest.mark.parametrize("number", [math.nan, math.inf, 1.1e4])
def test_numbers_of_solids_are_finite_and_sizes_above_0(number):
    with pytest.raises(ValueError, match="not finite"):
        box((1, number, 1), 0, 0, 0)
    with pytest.raises(ValueError, match="not finite"):
        box((1, 1, 1), 0, -number, 0)
    with pytest.raises(ValueError, match="a size of 0 m"):
        box((1, 0, 1), 0, 0, 0)


HALL = """mjsim: 1
walls:
  - {name: wall-1, points: [[0, 0], [6, 0]], thickness: 0.2, height: 2.4, color: "#ff0000",
     openings: [{at: 1, width: 0.9}, {at: 3, width: 1.2, sill: 0.9, head: 2}]}
obstacles:
  - {name: box, box: [0.8, 0.5, 0.4], at: [1, 3], heading_deg: 30, color: "#00ff00"}
  - {name: tin, cylinder: [0.2, 0.5], at: [5, 1], elevation: 0.25, color: "#0000ff"}
  - {name: ball, sphere: 0.3, at: [4, -2], color: "#102030"}
  - {name: chest, box: [0.8, 0.5, 0.4], at: [-1, 3], heading_deg: -60, movable: true, mass: 4, color: "#00ff00"}
lamps: [{at: [1, 2], height: 2.2, color: "#ff8000", range: 6}]
"""


def test_a_world_that_is_written_as_sdf_reads_back_equal(tmp_path):
    world = parse_world(HALL)
    back, _ = build_world(read_sdf(write_sdf(world, tmp_path / "w.sdf"), search=[]), name="w", folder="f")
    (wall,), (found,) = world.walls, back.walls
    # It may be seen from its other end.
    assert sorted(found.points) == sorted(wall.points)
    assert (found.thickness, found.height, found.color) == (0.2, 2.4, "#ff0000")
    assert len(found.openings) == 2
    shape, expected = solid(back), solid(world)
    assert shape.symmetric_difference(expected).area < 1e-3
    for one, other in zip(world.obstacles, back.obstacles, strict=True):
        assert other.name == f"obstacle_{one.name}"
        kept = one.model_dump(include={"box", "cylinder", "sphere", "at", "heading_deg", "elevation", "mass", "color"})
        assert other.model_dump(include=kept.keys()) == kept
    (lamp,), (other,) = world.lamps, back.lamps
    assert (other.at, other.height, other.color, other.range) == (lamp.at, lamp.height, lamp.color, lamp.range)


@pytest.mark.parametrize(
    ("geometry", "line"),
    [
        ("", "collision 'm::c': it has no shape"),
        ("<box><size>1 0 1</size></box>", "box 'm': its size is 0"),
        ("<mesh/>", "mesh 'm': it names no file; give it a <uri>"),
        ("<polyline/>", "polyline 'm': it has no area, or no height"),
        (f"<polyline>{3 * '<point>0 1</point>'}</polyline>", "polyline 'm': it has no area, or no height"),
        (f"<polyline>{POINTS}<height>0</height></polyline>", "polyline 'm': it has no area, or no height"),
        ("<torus/>", "torus 'm': no such shape in mjsim"),
    ],
)
def test_shapes_without_a_size_or_a_file_are_told(geometry, line, tmp_path):
    scene = sdf(tmp_path, f"<model name='m'><static>1</static><link name='l'>{SHAPE.format(geometry)}</link></model>")
    assert inventory(scene.items) == [f"left out: {line}"]
    assert not any(thing.solids for thing in scene.things)


def test_what_is_visible_but_not_touched_has_a_line(tmp_path):
    seen = "<visual name='v'><geometry><sphere><radius>1</radius></sphere></geometry></visual>"
    gone = "<visual name='v'><geometry><mesh><uri>gone.dae</uri></mesh></geometry></visual>"
    solid = SHAPE.format("<box><size>1 1 1</size></box>")
    links = "".join(
        f"<link name='{name}'>{parts}</link>"
        for name, parts in (("a", seen + solid), ("b", 3 * seen + solid), ("c", 2 * gone + solid))
    )
    items = sdf(tmp_path, f"<model name='m'><static>1</static>{links}</model>").items
    assert [(item.fate.name, item.name) for item in items] == [("LEFT_OUT", "m::b"), ("LEFT_OUT", "m::c")]
    assert [item.why.partition(" more than collision shapes")[0] for item in items] == ["2", "1"]


def test_limits_of_a_scene_grow_with_the_files_that_it_names(tmp_path):
    (tmp_path / "w.world").write_text(200 * "<include><uri>model://a</uri></include>")
    (tmp_path / "m.xml").write_text("<mujoco><mesh file='a.obj'/></mujoco>")
    (tmp_path / "p.svg").write_text("<uri>")
    sizes = {path.name: claimed_size(path) - path.stat().st_size for path in tmp_path.iterdir()}
    assert sizes == {"w.world": 200 * NAMED_FILE, "m.xml": NAMED_FILE, "p.svg": 0}


def test_a_world_of_stage_is_told_from_one_of_gazebo_and_its_map_is_named(tmp_path):
    (tmp_path / "a.world").write_text(
        'resolution 0.02 # [m]\nfloorplan\n(\n  size [16 16 0.8]\n  bitmap "cave.png"\n)\n'
    )
    with pytest.raises(UsageError, match=r"is a world of Stage, .* bring in its map by mjsim new --from cave\.png"):
        bring_file(tmp_path / "a.world", robot=None)


def test_sdf_with_the_suffix_of_a_model_is_a_scene(tmp_path):
    shape = "<collision name='c'><geometry><box><size>1 2 3</size></box></geometry></collision>"
    text = f"<sdf version='1.6'><model name='m'><static>1</static><link name='l'>{shape}</link></model></sdf>"
    (tmp_path / "world.model").write_text(text)
    (thing,) = parse_world(bring_file(tmp_path / "world.model", robot=None).text).obstacles
    assert thing.box == (1.0, 2.0, 1.5)
