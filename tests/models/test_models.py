"""Things from files of MJCF and URDF: where they stand, what they weigh, how they turn, and what no file may do."""

import math
import shutil

import mujoco
import numpy as np
import pytest
import shapely

import mjsim
from mjsim.compile import check_models, compile_world, export_scene
from mjsim.errors import UsageError, WorldError
from mjsim.models import encode_png, gather_model
from mjsim.models.model_reader import compiled, solid_parts
from mjsim.world import (
    check_world,
    footprint,
    format_world,
    load_world,
    parse_world,
    prisms,
    segments,
    solid,
    top,
    with_settings,
)
from mjsim.world.plan.outlines import cut

FURNITURE = ("chair.xml", "office_chair.xml", "table.xml", "plant.xml", "shelf.urdf")
WEDGE = "v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
TWISTED = """
<mujoco>
  <compiler angle="radian" eulerseq="zYx" meshdir="meshes"/>
  <default>
    <geom type="box" size="0.1 0.2 0.3"/>
    <default class="round"><geom type="cylinder" size="0.1 0.4" euler="0.3 0 0"/></default>
  </default>
  <asset>
    <mesh name="wedge" file="wedge.obj" scale="0.5 1 -1" refpos="0.2 0.1 0" refquat="0.8 0 0.6 0"/>
    <mesh name="inline" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/>
  </asset>
  <worldbody>
    <geom type="plane" size="9 9 9"/>
    <geom name="loose" pos="3 0 0" euler="0.1 0.2 0.3"/>
    <include file="part.xml"/>
    <body pos="0 1 0" axisangle="1 2 0 0.7" childclass="round">
      <freejoint/>
      <geom name="inherits"/>
      <geom name="own" size="0.25" zaxis="1 1 0"/>
      <geom name="box" type="box" size="0.1 0.1 0.5" xyaxes="0 1 0 -1 0 1"/>
      <frame pos="0 0 2" quat="0.6 0.8 0 0">
        <body pos="1 0 0">
          <joint axis="0 1 0" ref="0.2"/>
          <geom type="capsule" fromto="0 0 0 1 2 3" size="0.1"/>
          <geom type="ellipsoid" size="0.1 0.2 0.3" pos="1 1 1"/>
          <geom type="mesh" mesh="wedge" pos="0 0 1" euler="1 0 0"/>
          <geom type="mesh" mesh="inline" axisangle="0 0 1 0.5"/>
        </body>
      </frame>
      <geom name="ghost" type="sphere" size="5" contype="0" conaffinity="0"/>
    </body>
    <replicate count="4" offset="1 0 0.1" euler="0 0 0.4">
      <body pos="0 3 0"><geom type="box" fromto="0 0 0 1 0 1" size="0.05"/></body>
    </replicate>
  </worldbody>
  <actuator/>
</mujoco>
"""
CUPBOARD = """
<robot name="cupboard">
  <link name="case">
    <visual><geometry><sphere radius="2"/></geometry></visual>
    <collision><origin xyz="0 0 0.5" rpy="0 0 0.4"/><geometry><box size="0.4 0.8 1"/></geometry></collision>
  </link>
  <link name="door">
    <inertial><mass value="3"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0 0.4 0" rpy="0.1 0.2 0.3"/>
      <geometry><mesh filename="package://cupboard/meshes/wedge.obj" scale="0.1 0.2 0.3"/></geometry></collision>
    <collision><geometry><cylinder radius="0.05" length="0.9"/></geometry></collision>
  </link>
  <joint name="hinge" type="revolute">
    <parent link="case"/><child link="door"/><origin xyz="0.2 -0.4 0.5" rpy="0.2 0 0.5"/>
    <axis xyz="0 0 1"/><limit lower="0" upper="1.5" effort="9" velocity="9"/>
  </joint>
</robot>
"""
SWING = """
<mujoco>
  <worldbody>
    <geom name="case" type="box" size="0.2 0.4 0.5" pos="0 0 0.5"/>
    <body name="leaf" pos="0.2 -0.4 0.5">
      <joint name="hinge" axis="0 0 1" range="0 90" damping="0.5"/>
      <geom type="box" size="0.01 0.4 0.5" pos="0.011 0.4 0" mass="2"/>
    </body>
  </worldbody>
</mujoco>
"""


@pytest.fixture
def folder(tmp_path):
    """A folder of a world with models and what they name."""
    (tmp_path / "cupboard" / "meshes").mkdir(parents=True)
    (tmp_path / "meshes").mkdir()
    for place in ("meshes", "cupboard/meshes"):
        (tmp_path / place / "wedge.obj").write_text(WEDGE)
    (tmp_path / "twisted.xml").write_text(TWISTED)
    (tmp_path / "part.xml").write_text('<mujocoinclude><geom pos="0 0 -1" quat="1 1 0 0"/></mujocoinclude>')
    (tmp_path / "cupboard" / "cupboard.urdf").write_text(CUPBOARD)
    (tmp_path / "swing.xml").write_text(SWING)
    return tmp_path


def world_of(folder, obstacle, rest=""):
    path = folder / "world.yaml"
    path.write_text(f"mjsim: 1\nobstacles:\n  - {{{obstacle}}}\n{rest}")
    return load_world(path)


def boxes_of(model):
    """Lowest and highest corner of each solid geom, shape (n, 6), worked out by the kind of geom, sorted."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    found = []
    for number in range(model.ngeom):
        if not (model.geom_contype[number] or model.geom_conaffinity[number]):
            continue
        rotation, size = data.geom_xmat[number].reshape(3, 3), model.geom_size[number]
        match int(model.geom_type[number]):
            case mujoco.mjtGeom.mjGEOM_BOX:
                reach = np.abs(rotation) @ size
            case mujoco.mjtGeom.mjGEOM_SPHERE:
                reach = np.full(3, size[0])
            case mujoco.mjtGeom.mjGEOM_CAPSULE:
                reach = np.abs(rotation[:, 2]) * size[1] + size[0]
            case mujoco.mjtGeom.mjGEOM_CYLINDER:
                reach = np.abs(rotation[:, 2]) * size[1] + np.sqrt(1 - rotation[:, 2] ** 2) * size[0]
            case mujoco.mjtGeom.mjGEOM_ELLIPSOID:
                reach = np.sqrt((rotation * size) ** 2 @ np.ones(3))
            case mujoco.mjtGeom.mjGEOM_MESH:
                first, count = (int(model.mesh(model.geom_dataid[number]).vertadr[0]),) * 2
                count = int(model.mesh_vertnum[model.geom_dataid[number]])
                corners = model.mesh_vert[first : first + count] @ rotation.T + data.geom_xpos[number]
                found.append([*corners.min(axis=0), *corners.max(axis=0)])
                continue
            case _:
                continue
        found.append([*(data.geom_xpos[number] - reach), *(data.geom_xpos[number] + reach)])
    return np.array(sorted(np.round(found, 5).tolist()))


def told_boxes(parts):
    return np.array(sorted(np.round([[*part.min(axis=0), *part.max(axis=0)] for part in parts], 5).tolist()))


def mujoco_reads(text, assets):
    spec = mujoco.MjSpec.from_string(text, assets=assets)
    return spec.compile()


def test_what_a_file_of_mjcf_fills_is_what_mujoco_makes_of_it(folder):
    files = gather_model("twisted.xml", lambda path: (folder / path).read_bytes())
    text = TWISTED.replace('<include file="part.xml"/>', '<geom pos="0 0 -1" quat="1 1 0 0"/>')
    text = text.replace('meshdir="meshes"', "").replace("<freejoint/>", "")
    theirs = boxes_of(mujoco_reads(text, {"wedge.obj": WEDGE.encode()}))
    ours = told_boxes(solid_parts(compiled(files), urdf=False))
    # A circle of ours has 32 corners.
    np.testing.assert_allclose(ours, theirs, atol=0.005)


def test_what_a_file_of_urdf_fills_is_what_mujoco_makes_of_it(folder):
    files = gather_model("cupboard/cupboard.urdf", lambda path: (folder / path).read_bytes())
    theirs = boxes_of(mujoco_reads(CUPBOARD, {"wedge.obj": WEDGE.encode()}))
    np.testing.assert_allclose(told_boxes(solid_parts(compiled(files), urdf=True)), theirs, atol=0.001)


@pytest.mark.parametrize("name", FURNITURE)
def test_shipped_furniture_is_in_the_scene_where_the_plan_has_it(name):
    world = parse_world(
        f"mjsim: 1\nobstacles: [{{model: furniture/{name}, at: [2, 1], heading_deg: 30, elevation: 0.1}}]"
    )
    (obstacle,) = world.obstacles
    boxes = boxes_of(compile_world(world).compile())
    assert boxes[:, 2].min() == pytest.approx(0.1, abs=1e-5)
    assert boxes[:, 5].max() == pytest.approx(top(obstacle), abs=1e-5)
    for outline in (footprint(obstacle), np.concatenate([part for part, _, _ in prisms(obstacle)])):
        np.testing.assert_allclose(outline.min(axis=0), boxes[:, :2].min(axis=0), atol=2e-3)
        np.testing.assert_allclose(outline.max(axis=0), boxes[:, 3:5].max(axis=0), atol=2e-3)


def test_a_scaled_mesh_from_beside_the_world_stands_on_the_floor(folder):
    world = world_of(folder, "model: cupboard/cupboard.urdf, at: [1, 2], scale: 0.5")
    boxes = boxes_of(compile_world(world).compile())
    model = mujoco_reads(CUPBOARD, {"wedge.obj": WEDGE.encode()})
    theirs = boxes_of(model)
    theirs = (theirs - [0, 0, theirs[:, 2].min()] * 2) * 0.5 + [1, 2, 0] * 2
    np.testing.assert_allclose(boxes, theirs, atol=2e-5)


def test_a_plan_at_the_height_of_robots_shows_the_legs_of_a_table_and_not_its_top():
    world = parse_world("mjsim: 1\nobstacles: [{model: furniture/table.xml, at: [0, 0]}]")
    legs = [shapely.Polygon(outline) for outline in cut(world.obstacles[0], 0.2)]
    assert [round(leg.area, 6) for leg in legs] == [0.0036] * 4
    assert solid(world, height=0.73).area == pytest.approx(1.4 * 0.8)


def test_a_robot_may_start_under_a_table_but_not_in_its_leg():
    text = "mjsim: 1\nobstacles: [{model: furniture/table.xml, at: [0, 0]}]\nrobots: [{name: r, at: [AT]}]"
    assert not check_world(parse_world(text.replace("AT", "0, 0")))
    (problem,) = check_world(parse_world(text.replace("AT", "0.6, 0.3")))
    assert "starts inside obstacles[0]" in str(problem)


@pytest.mark.slow
def test_a_movable_model_weighs_what_the_world_says_or_else_the_file():
    masses = {}
    for key, mass in (("own", ""), ("small", ", scale: 0.5"), ("said", ", mass: 9")):
        text = f"mjsim: 1\nobstacles: [{{name: c, model: furniture/chair.xml, at: [0, 0], movable: true{mass}}}]"
        masses[key] = float(compile_world(parse_world(text)).compile().body("obstacle/c").subtreemass[0])
    own = boxes_of(mujoco.MjModel.from_xml_path("assets/furniture/chair.xml"))
    volume = np.prod([0.42, 0.42, 0.025]) + 4 * np.prod([0.036, 0.036, 0.44]) + 2 * np.prod([0.032, 0.036, 0.47])
    volume += np.prod([0.018, 0.33, 0.12]) + np.prod([0.018, 0.33, 0.06]) + 2 * np.prod([0.32, 0.018, 0.024])
    assert len(own) == 11
    assert masses["own"] == pytest.approx(550 * volume)
    assert masses["small"] == pytest.approx(550 * volume / 8)
    assert masses["said"] == pytest.approx(9)


@pytest.mark.slow
def test_a_robot_pushes_a_movable_chair_and_is_stopped_by_one_that_stands():
    text = """
    mjsim: 1
    obstacles: [{name: c, model: furniture/chair.xml, at: [1, 0], movable: MOVABLE}]
    robots: [{name: scout, at: [0, 0.18]}]
    """
    driven = {}
    for movable in ("true", "false"):
        with mjsim.Simulation(parse_world(text.replace("MOVABLE", movable))) as simulation:
            for _ in range(100):
                simulation.apply("scout", mjsim.Command(forward=0.6))
                simulation.step()
            driven[movable] = simulation.truth("scout").x
            assert simulation.sense("scout").bump
    assert driven["true"] > 1.0
    assert driven["false"] == pytest.approx(1 - 0.215 - 0.22, abs=0.03)


def test_the_seat_of_the_office_chair_swivels_on_its_foot():
    model = compile_world(
        parse_world("mjsim: 1\nobstacles: [{name: c, model: furniture/office_chair.xml, at: [0, 0], movable: true}]")
    ).compile()
    data, swivel = mujoco.MjData(model), model.joint("obstacle/c/swivel")
    data.qvel[swivel.dofadr[0]] = 6.0
    for _ in range(750):
        mujoco.mj_step(model, data)
    assert data.qpos[swivel.qposadr[0]] > 1.0
    assert abs(data.qvel[swivel.dofadr[0]]) < 0.1
    # The foot hardly turns, and nothing tips over.
    assert data.body("obstacle/c").xmat[8] == pytest.approx(1.0, abs=1e-3)
    assert data.body("obstacle/c").xmat[0] > 0.9


def test_the_door_of_a_cupboard_that_stands_swings_to_its_limit(folder):
    world = world_of(folder, "name: cup, model: swing.xml, at: [0, 0]")
    model = compile_world(world).compile()
    data, hinge = mujoco.MjData(model), model.joint("obstacle/cup/hinge")
    assert hinge.range == pytest.approx([0.0, math.pi / 2])
    data.qfrc_applied[hinge.dofadr[0]] = -3.0
    for _ in range(1000):
        mujoco.mj_step(model, data)
    # The leaf touches its own case all the time, and passes.
    assert data.ncon == 0
    assert data.qpos[hinge.qposadr[0]] == pytest.approx(0.0, abs=0.03)
    data.qfrc_applied[hinge.dofadr[0]] = 3.0
    for _ in range(1000):
        mujoco.mj_step(model, data)
    assert data.qpos[hinge.qposadr[0]] == pytest.approx(math.pi / 2, abs=0.03)


def test_the_map_has_models_that_stand_and_no_movable_ones():
    text = "mjsim: 1\nobstacles: [{model: furniture/shelf.urdf, at: [0, 0], movable: MOVABLE}]"
    assert len(segments(parse_world(text.replace("MOVABLE", "true")))) == 0
    faces = segments(parse_world(text.replace("MOVABLE", "false")))
    np.testing.assert_allclose(np.abs(faces).reshape(-1, 2).max(axis=0), [0.45, 0.15], atol=1e-6)


def test_a_scene_with_models_is_written_for_plain_mujoco(folder, tmp_path):
    world = world_of(
        folder,
        "name: a, model: cupboard/cupboard.urdf, at: [1, 2]",
        "  - {name: b, model: twisted.xml, at: [5, 5]}\n"
        "  - {name: c, model: furniture/office_chair.xml, at: [9, 5], movable: true}\n",
    )
    theirs = mujoco.MjModel.from_xml_path(str(export_scene(world, tmp_path / "out")))
    ours = compile_world(world).compile()
    assert (theirs.nbody, theirs.njnt, theirs.nexclude) == (ours.nbody, ours.njnt, ours.nexclude)
    np.testing.assert_allclose(boxes_of(theirs), boxes_of(ours), atol=2e-5)
    np.testing.assert_allclose(theirs.body_inertia, ours.body_inertia, rtol=1e-6, atol=1e-9)


def test_a_world_with_models_is_written_and_read_back_equal(folder):
    world = world_of(folder, "model: twisted.xml, at: [1, 2], scale: 0.5, movable: true, mass: 3")
    assert parse_world(format_world(world), source=world.source) == world
    assert parse_world(world.model_dump_json(exclude_unset=True), source=world.source) == world


def test_a_model_beside_the_world_is_still_there_when_values_are_set(folder):
    world = world_of(folder, "name: cup, model: swing.xml, at: [1, 2]")
    (changed,) = with_settings(world, ["obstacles.cup.scale=2"]).obstacles
    assert top(changed) == pytest.approx(2.0)
    with pytest.raises(UsageError, match=r"no file 'none\.xml' beside the world file or in assets"):
        with_settings(world, ["obstacles.cup.model=none.xml"])


@pytest.mark.slow
def test_a_camera_sees_the_texture_of_a_mesh_the_right_way_round(tmp_path):
    picture = np.zeros((64, 64, 3), dtype=np.uint8)
    picture[:32, :32], picture[:32, 32:], picture[32:, :32] = (255, 0, 0), (0, 255, 0), (0, 0, 255)
    (tmp_path / "flag.png").write_bytes(encode_png(picture))
    # A plate that looks to -x: its left side, seen from there, is at y = 0.5.
    points = "v 0 0.5 0\nv 0 -0.5 0\nv 0 -0.5 1\nv 0 0.5 1\nv 0.1 0 0.5\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
    faces = "f 1/1 2/2 3/3\nf 1/1 3/3 4/4\nf 2/2 1/1 5/1\nf 3/3 2/2 5/1\nf 4/4 3/3 5/1\nf 1/1 4/4 5/1\n"
    (tmp_path / "plate.obj").write_text(points + faces)
    (tmp_path / "plate.xml").write_text(
        '<mujoco><asset><texture name="f" type="2d" file="flag.png"/><material name="f" texture="f"/>'
        '<mesh name="m" file="plate.obj"/></asset>'
        '<worldbody><geom type="mesh" mesh="m" material="f"/></worldbody></mujoco>'
    )
    robot = "robots: [{name: scout, at: [0, 0], sensors: [{camera: eye, at: [0, 0, 0.5], width: 64, height: 48}]}]\n"
    with mjsim.Simulation(world_of(tmp_path, "model: plate.xml, at: [1.2, 0]", robot)) as simulation:
        image = simulation.sense("scout").cameras["eye"].image.astype(int)
    for column, row, color in ((22, 14, 0), (42, 14, 1), (22, 34, 2)):
        assert image[row, column, color] > 150
        assert image[row, column].sum() - image[row, column, color] < 40
    assert image[34, 42].sum() < 40


def test_what_only_mujoco_finds_wrong_is_told_at_the_line_too(tmp_path):
    (tmp_path / "odd.xml").write_text('<mujoco><worldbody><geom size="1" material="none"/></worldbody></mujoco>')
    with pytest.raises(WorldError) as caught:
        world_of(tmp_path, "name: odd, at: [1, 1], model: odd.xml", "  - {at: [5, 1], model: odd.xml}\n")
    assert [(problem.line, problem.column) for problem in caught.value.problems] == [(3, 36), (4, 25)]
    for problem in caught.value.problems:
        assert problem.message.startswith("MuJoCo cannot read 'odd.xml': Error: material 'none' not found")


def test_a_thing_without_mass_is_not_movable(tmp_path):
    (tmp_path / "air.xml").write_text('<mujoco><worldbody><geom size="1" mass="0"/></worldbody></mujoco>')
    check_models(world_of(tmp_path, "at: [1, 1], model: air.xml"))
    with pytest.raises(WorldError, match="is movable but has no mass"):
        check_models(world_of(tmp_path, "at: [1, 1], model: air.xml, movable: true"))


def test_an_object_that_the_physics_cannot_move_is_an_error_before_the_run(folder):
    (folder / "cupboard" / "heavy.urdf").write_text(CUPBOARD.replace('mass value="3"', 'mass value="1e20"'))
    with pytest.raises(WorldError, match=r"weighs 1e\+20 kg, too much for an object; check its units"):
        check_models(world_of(folder, "at: [1, 1], model: cupboard/heavy.urdf, movable: true"))
    with pytest.raises(WorldError, match="too small for the physics; scale it up or make it heavier"):
        check_models(world_of(folder, "at: [1, 1], model: twisted.xml, scale: 1e-4, movable: true"))


@pytest.mark.slow
def test_a_recording_alone_holds_all_that_its_models_need(folder):
    obstacle = "name: t, model: twisted.xml, at: [4, 2], movable: true"
    world = world_of(
        folder, obstacle, "  - {model: furniture/chair.xml, at: [3, -2]}\nrobots: [{name: r, at: [0, 0]}]\n"
    )
    (obstacle, chair) = world.obstacles
    assert set(obstacle.shape.files.paths) == {"twisted.xml", "part.xml", "meshes/wedge.obj"}
    assert chair.shape.files.paths == ("furniture/chair.xml", "furniture/wood.png")
    with mjsim.Simulation(world) as simulation:
        scene = simulation.model
        recording = mjsim.run(simulation, drivers={}, seconds=0.2, record=folder / "run.mcap")
    shutil.move(folder / "run.mcap", folder / "meshes" / "run.mcap")
    for name in ("twisted.xml", "part.xml"):
        (folder / name).unlink()
    read = mjsim.read_recording(folder / "meshes" / "run.mcap")
    assert read.world == recording.world == world
    np.testing.assert_array_equal(boxes_of(compile_world(read.world).compile()), boxes_of(scene))
