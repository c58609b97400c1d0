"""Configurations of MATLAB become worlds: tables either way, robots, sensors, pictures; what is not used is told."""

import time

import numpy as np
import pytest
from scipy.io import savemat

import mjsim
from mjsim.errors import UsageError
from mjsim.exchange.import_world import bring_file
from mjsim.exchange.matlab.matlab_text import read_assignments
from mjsim.exchange.world_import import Newcomer, Reading
from mjsim.world.check import check_world

CORNERS = np.array([[0.0, 0, 10, 10, 0], [0, 8, 8, 0, 0]])
BEACONS = np.array([[9.9, 4.0, 0.1], [4.0, 7.9, 4.0], [np.pi, -np.pi / 2, 0.0], [1, 2, 0]])


def brought(folder, content, *, rows=False, robot=True, scale=None):
    """Return the world and the lines of the report of a MAT-file, or of a script."""
    path = folder / ("c.m" if isinstance(content, str) else "c.mat")
    if isinstance(content, str):
        path.write_text(content)
    else:
        savemat(path, content)
    found = bring_file(path, robot=Newcomer() if robot else None, reading=Reading(scale, rows=rows))
    told = [line.removeprefix(f"{path}: ") for line in found.report]
    return mjsim.parse_world(found.text), [line.removeprefix("kept: ").removeprefix("guessed: ") for line in told]


def test_corners_and_beacons_of_columns_are_walls_and_beacons_that_face_somewhere(tmp_path):
    world, told = brought(tmp_path, {"walls": CORNERS, "beacons": BEACONS}, robot=False)
    assert [(len(wall.segments()), wall.closed) for wall in world.walls] == [(4, True)]
    assert [(each.at, each.heading_deg, each.image) for each in world.beacons] == [
        ((9.9, 4.0), 180.0, None),
        ((4.0, 7.9), -90.0, None),
        ((0.1, 4.0), 0.0, None),
    ]
    assert "beacons has P = 1, 2, which are not pictures beside the file or in assets: reflectors" in told


def test_rows_are_read_where_only_rows_fit(tmp_path):
    table = np.vstack([BEACONS.T, [5, 5, 0, 0], [6, 6, 0, 0]])
    world, told = brought(tmp_path, {"corners": CORNERS.T, "beacons": table}, robot=False)
    assert [each.at for each in world.beacons] == [tuple(row) for row in table[:, :2].tolist()]
    assert len(world.walls[0].segments()) == 4
    assert not any("--rows" in line for line in told)


@pytest.mark.parametrize(("rows", "first"), [(False, (1.0, 5.0)), (True, (1.0, 2.0))])
def test_a_square_table_is_columns_unless_rows_are_asked_for(tmp_path, rows, first):
    square = np.array([[1.0, 2, 0, 0], [5, 6, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0]])
    world, told = brought(tmp_path, {"lm": square}, rows=rows, robot=False)
    assert world.beacons[0].at == first
    told_as = "row is one item; leave out --rows reverses that" if rows else "column is one item; --rows reverses that"
    assert f"lm is 4 x 4: each {told_as}" in told


SCRIPT = """% a configuration
function c = config()
corners = [0 0; 10 0; 10 8; 0 8];   % not closed
beacons = {9.9, 4, pi, 'lion'; 4, 7.9, -90*pi/180, 'owl.jpg'; 0.1, 4, 0, 0};
robot.radius = 0.2;  robot.wheelbase = 0.3;
robot.v_max = 0.5;   robot.w_max = 1;   robot.noise = [0.02 0.01];
robot.pose = [2 2 pi/2];
sensor.range = [0.2, 6]; sensor.angle = pi; sensor.noises = [0.05 2*pi/180];
wp = [2 8 8 2; ...
      2 2 6 6];
weight = 3;
x = load('y');
"""


def test_a_script_gives_walls_pictures_robot_sensor_and_way_and_tells_the_rest(tmp_path):
    world, told = brought(tmp_path, SCRIPT)
    assert [each.image for each in world.beacons] == ["posters/lion.jpg", "posters/owl.jpg", None]
    assert [each.heading_deg for each in world.beacons] == [180.0, -90.0, 0.0]
    (robot,) = world.robots
    assert (robot.at, robot.heading_deg, robot.body.radius) == ((2.0, 2.0), 90.0, 0.2)
    assert (robot.drive.track, robot.drive.max_speed, robot.drive.noise.turn) == (0.3, 0.5, 0.01)
    assert robot.drive.max_turn_deg == pytest.approx(np.degrees(1.0), abs=1e-5)
    (sensor,) = robot.sensors
    assert (tuple(sensor.range), sensor.fov_deg) == ((0.2, 6.0), 180.0)
    assert (sensor.noise.range, sensor.noise.bearing_deg) == (0.05, 2.0)
    assert world.run.drivers["scout"].navigator.arguments()["points"] == [[8, 2], [8, 6], [2, 6]]
    for line in (
        "left out: variable 'weight'",
        "left out: line 12: 'x = load ( y )' is not a literal assignment",
        "corners does not end at its first corner: it stays open there",
    ):
        assert line in told


@pytest.mark.parametrize(
    "table",
    [
        "beacons = {'lion', 9.9, 4, pi; 'owl', 4, 7.9, 0; 'cat', 1, 1, 0};",
        "beacons = {'lion', 'owl', 'cat'; 9.9, 4, 1; 4, 7.9, 1; pi, 0, 0};",
        "beacons(1).P = 'lion'; beacons(1).x = 9.9; beacons(1).y = 4; beacons(1).w = pi;",
    ],
)
def test_a_picture_may_be_named_first(table, tmp_path):
    world, _ = brought(tmp_path, table)
    first = world.beacons[0]
    assert (first.image, first.at, first.heading_deg) == ("posters/lion.jpg", (9.9, 4.0), 180.0)


@pytest.mark.parametrize(
    ("table", "expected"),
    [
        ("beacons = [9.9 4 0; 4 7.9 1; pi 0 0]; pics = {'owl', 'lion', 'nobody'};", ["owl", "lion", None]),
        (
            "beacons = [9.9 4 0 1; 4 7.9 1 2; pi 0 0 0; 2 1 0 2]; pics = {'owl.jpg'; 'lion.jpg'};",
            ["lion", "owl", None, "lion"],
        ),
        ("beacons = [9.9 4; 4 7.9; pi 0; 1 3]; pics = {'owl', 'lion'}; notes = {'a', 'lion'};", ["owl", None]),
    ],
)
def test_pictures_are_named_in_a_list_of_their_own(table, expected, tmp_path):
    world, told = brought(tmp_path, table)
    images = [each.image for each in world.beacons]
    assert images == [name and f"posters/{name}.jpg" for name in expected]
    assert "pictures of beacons, named by pics" in told
    assert "left out: variable 'pics'" not in told
    assert ("left out: variable 'notes'" in told) == ("notes" in table)
    assert any("nobody, which is not a picture" in line for line in told) == ("nobody" in table)
    savemat(tmp_path / "c.mat", {"beacons": BEACONS[:3], "names": np.array(["owl", "lion", "fox"], dtype=object)})
    found = bring_file(tmp_path / "c.mat", robot=None, reading=Reading(None, rows=False))
    assert "posters/owl.jpg" in found.text


def test_a_scale_is_that_of_the_start_too_and_a_start_that_is_no_number_is_told(tmp_path):
    lines = "lm = [100 300; 200 400];\nrobot.pose = [{} 150 pi];\n"
    world, _ = brought(tmp_path, lines.format("250"), scale=0.01)
    assert (world.beacons[1].at, world.robots[0].at) == ((3.0, 4.0), (2.5, 1.5))
    world, told = brought(tmp_path, lines.format("250").replace("pi", "90"), scale=0.01)
    assert world.robots[0].heading_deg == 90.0
    assert "robot.pose is the start: 2.5, 1.5, 90 degrees, as it exceeds 2 pi" in told
    world, told = brought(tmp_path, lines.format("NaN"), scale=0.01)
    assert world.robots[0].at == (2.0, 3.0)
    assert "left out: variable 'robot.pose'" in told


@pytest.mark.parametrize(
    "table",
    [
        "lm = {1, {2, [3 4]}};",
        "lm(1).x = 1; lm(1).y = [];",
        "lm(1).x = 1; lm(1).y = {{2}, 'a'};",
        "lm.x.y = 1; lm.z = 2;",
    ],
)
def test_values_in_values_are_no_table(table, tmp_path):
    with pytest.raises(UsageError, match=r"has lm of .*; it must be 2 x n numbers, x above y"):
        brought(tmp_path, table)


@pytest.mark.parametrize(
    ("script", "says"),
    [
        ("lm = [1 2 3\n4 5", "it holds nothing; line 1: 'lm = [ 1 2 3 4 5' is not a literal assignment"),
        ("a = 1;\nlm = load('m');\nb = f(a);", "it holds a; line 2: 'lm = load ( m )' is not a literal assignment"),
    ],
)
def test_a_script_without_a_map_is_told_with_its_first_line_that_was_not_read(tmp_path, script, says):
    with pytest.raises(UsageError) as caught:
        brought(tmp_path, script)
    assert str(caught.value).endswith(f"holds no landmarks: lm, 2 x n; {says}")


def test_a_struct_array_of_a_mat_file_gives_beacons_by_field(tmp_path):
    kind = [("x", object), ("y", object), ("omega", object), ("P", object)]
    items = np.array([(1.0, 2.0, 0.5, "lion"), (3.0, 4.0, 0.0, 7.0)], dtype=kind)
    robot = {"radius": 0.25, "noise": {"v": 0.03}}
    world, told = brought(tmp_path, {"beacons": items, "robot": robot, "note": "mine"})
    assert [(each.at, each.image) for each in world.beacons] == [((1, 2), "posters/lion.jpg"), ((3, 4), None)]
    assert world.robots[0].body.radius == 0.25
    assert world.robots[0].drive.noise.speed == 0.03
    assert "left out: variable 'note'" in told


def test_walls_of_several_pieces_and_of_segments_are_read(tmp_path):
    gap = np.hstack([CORNERS, [[np.nan], [np.nan]], [[2.0, 4], [1, 1]]])
    world, _ = brought(tmp_path, {"walls": gap}, robot=False)
    assert [len(wall.segments()) for wall in world.walls] == [4, 1]
    world, _ = brought(tmp_path, {"walls": [[0.0, 0, 5, 0], [5, 0, 5, 4], [5, 4, 0, 4]]}, robot=False)
    assert [[*map(tuple, wall.points)] for wall in world.walls][2] == [(5, 4), (0, 4)]


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("x = [1 -2]", [[1, -2]]),
        ("x = [1 - 2]", [[-1]]),
        ("x = [1, 2; 3 4]'", [[1, 3], [2, 4]]),
        ("a = [1 2]; x = [a' a']", [[1, 1], [2, 2]]),
        ("x = 0:0.5:1", [[0, 0.5, 1]]),
        ("x = -2^2 + 2^-1", [[-3.5]]),
        ("x = 2^3^2 + 2^-3^2", [[64.015625]]),
        ("x = [1 2; 3 4].^2", [[1, 4], [9, 16]]),
        ("x = 30*pi/180 % angle", [[np.pi / 6]]),
        ("x = [1, ... first\n 2]", [[1, 2]]),
        ("x = [1 2\n 3 4]", [[1, 2], [3, 4]]),
        ("%{\nx = 1;\n%}\nx = 1e3", [[1000]]),
        ("%{\r\nx = 1;\r\n%}\r\nx = 1e3\r\n%{\r\n", [[1000]]),
        ("x = diag([1 2]) * ones(2, 1)", [[1], [2]]),
        ("if true\n x = 1;\nend\nx = .5", [[0.5]]),
        ("if nargin < 1, x = 3; end", [[3]]),
        ("if ~exist('x', 'var'), x = 3; else x = 4; end", [[3]]),
        ("x = []; x(end+1, :) = [1 2]; x(end+1, :) = [3 4];", [[1, 2], [3, 4]]),
        ("x = zeros(2, 0); x(:, end+1) = [1; 2]; x(:, 2) = 3;", [[1, 3], [2, 3]]),
        ("a = [1 2 3; 4 5 6]; x = a(1:2, [1 3])'", [[1, 4], [3, 6]]),
        ("a = [1 2 3; 4 5 6]; x = [a(end, :) a(3)]", [[4, 5, 6, 2]]),
        ("x = [1 2; 3 4]; x(1, :) = 10 * x(1, :);", [[10, 20], [3, 4]]),
        ("x = [1 2]; x(4) = 5;", [[1, 2, 0, 5]]),
        ("x = repmat([1 2], 2, 2)", [[1, 2, 1, 2], [1, 2, 1, 2]]),
    ],
)
def test_literals_are_what_matlab_makes_of_them(text, value):
    np.testing.assert_allclose(read_assignments(text).values["x"], value)


def test_text_cells_and_structs_are_what_they_say():
    found = read_assignments("""s(1).x = 'it''s'; s(2).x = "two"; c = {'a', 1}; t.u.v = 'w';""").values
    assert [item["x"] for item in found["s"]] == ["it's", "two"]
    assert found["c"][0][0] == "a"
    assert found["t"] == {"u": {"v": "w"}}


@pytest.mark.parametrize(
    "text",
    [
        "x = zeros(1e9)",
        "x = 1:1e12",
        "x = (1:1e4)' * (1:1e4)",
        "x = repmat(ones(300), 300)",
        "x = ones(2, 2)(3, 3)",
        "x(1:2, 1e6) = 1",
        "x = " + "-" * 20_000 + "1",
        "x = " + "(" * 5000,
        "x = system('ls')",
        "x(3) = 1",
        "x = [1 2; 3 4]^2",
        "x = [1 2; 3]",
        "x = 'open",
        "x = 1 +",
        "= 3",
    ],
)
def test_what_is_no_literal_is_told_with_its_line(text):
    found = read_assignments("\n" + text)
    assert "x" not in found.values
    assert found.unread[0].startswith("line 2: ")


@pytest.mark.parametrize("text", ["x = " + "1" * 10_000 + "b", "%{\n" * 10_000, "x = [1 " + "." * 10_000])
def test_text_that_repeats_itself_is_read_in_moments(text):
    began = time.process_time()
    assert "x" not in read_assignments(text).values
    assert time.process_time() - began < 1.0, "without bounds it took 2 s to hours"


def test_structs_around_the_tables_are_opened(tmp_path):
    script = """function cfg = setup()
cfg.env.room = [0 0; 10 0; 10 8; 0 8; 0 0];
cfg.landmarkPositions = [1 1; 9 1; 9 7; 5 4; 2 6];
cfg.robotParams.radius = 0.25; cfg.robotParams.trackWidth = 0.3; cfg.robotParams.noise.odometry = [0.02 0.03];
cfg.sensor.max_range = single(5);
end
"""
    world, told = brought(tmp_path, script)
    assert len(world.walls[0].segments()) == 4
    assert [beacon.at for beacon in world.beacons] == [(1, 1), (9, 1), (9, 7), (5, 4), (2, 6)]
    (robot,) = world.robots
    assert (robot.body.radius, robot.sensors[0].range[1]) == (0.25, 5.0)
    assert robot.odometry.noise.turn == 0.03
    assert not [line for line in told if line.startswith("not used")]
    inner = {"config": {"corners": CORNERS, "robot": {"radius": 0.3}}}
    world, _ = brought(tmp_path, inner)
    assert (len(world.walls), world.robots[0].body.radius) == (1, 0.3)


def test_corners_in_cells_are_one_wall(tmp_path):
    world, _ = brought(tmp_path, "corners = {[0 0], [10 0], [10 8], [0 8], [0 0]};")
    assert [(len(wall.segments()), wall.closed) for wall in world.walls] == [(4, True)]


def test_a_file_of_windows_with_a_mark_of_its_encoding_is_read(tmp_path):
    world, told = brought(tmp_path, "\ufeffcorners = [0 5 5 0 0\r\n 0 0 4 4 0];\r\n% \u4e2d\u6587\r\n")
    assert [(len(wall.segments()), wall.closed) for wall in world.walls] == [(4, True)]
    assert not [line for line in told if "literal" in line]


GERMAN = """ECKEN = [0 0; 8.2 0; 8.2 5.6; 0 5.6; 0 0]';
BAKEN = [8.1 2 180 1; 2 5.5 -90 2; 0.1 2 0 0; 5 0.1 90 4; 3 0.1 90 0]';
Roboter.Radius = 0.18;  Roboter.Radstand = 0.31;  Roboter.Startpose = [1 1 0];
Sensor.Reichweite = [0.2 6];  Sensor.Oeffnungswinkel = [-60 60];  Sensor.Rauschen = [0.04 2];
WEGPUNKTE = [1 1; 7 1; 7 5]';
"""


def test_a_file_in_german_and_in_degrees_is_read(tmp_path):
    world, told = brought(tmp_path, GERMAN)
    assert (len(world.walls[0].segments()), len(world.beacons)) == (4, 5)
    (robot,) = world.robots
    assert (robot.at, robot.body.radius, robot.drive.track) == ((1.0, 1.0), 0.18, 0.31)
    (sensor,) = robot.sensors
    assert (tuple(sensor.range), sensor.fov_deg, sensor.noise.bearing_deg) == ((0.2, 6.0), 120.0, 2.0)
    assert world.run.drivers["scout"].navigator.arguments()["points"] == [[7, 1], [7, 5]]
    assert not [line for line in told if "left out" in line]


def test_four_structs_of_four_fields_are_four_items(tmp_path):
    kind = [(name, object) for name in ("x1", "y1", "x2", "y2")]
    walls = np.array([(0, 0, 9, 0), (9, 0, 9, 7), (9, 7, 0, 7), (0, 7, 0, 0)], dtype=kind)
    kind = [(name, object) for name in ("x", "y", "omega", "P")]
    lm = np.array([(1, 2, 0.1, 5), (3, 4, 0.2, 6), (5, 6, 0.3, 7), (7, 1, 0.4, 8)], dtype=kind)
    world, _ = brought(tmp_path, {"World": {"Room": {"Walls": walls}, "Beacons": lm}})
    assert [tuple(wall.points[1]) for wall in world.walls] == [(9, 0), (9, 7), (0, 7), (0, 0)]
    assert [beacon.at for beacon in world.beacons] == [(1, 2), (3, 4), (5, 6), (7, 1)]


def test_a_square_wall_in_a_cell_lies_as_the_others(tmp_path):
    world, told = brought(tmp_path, "murs = {[0 0; 5 0; 5 4; 0 4; 0 0]; [2 1.5; 3 1.5]};")
    assert [tuple(point) for point in world.walls[1].points] == [(2, 1.5), (3, 1.5)]
    assert not [line for line in told if "--rows" in line]


def test_beacons_that_lie_on_walls_hang_on_the_face_that_they_look_from(tmp_path):
    script = (
        "corners = [0 6 6 0 0; 0 0 4 4 0]; beacons = [6 2 pi 1; 3 4 -pi/2 2; 0.02 2 0 0; 3 0 -pi/2 3; 0 0 pi/4 0]';"
    )
    world, told = brought(tmp_path, script, robot=False)
    # Walls are 0.1 m thick; the fourth looks outwards, the last hangs in a corner.
    assert [beacon.at for beacon in world.beacons] == [(5.95, 2), (3, 3.95), (0.05, 2), (3, -0.05), (0.05, 0.05)]
    assert "5 beacons in walls 0.1 m thick: moved to the faces" in told
    assert not check_world(world)


def test_a_value_out_of_bounds_is_told_with_its_key(tmp_path):
    with pytest.raises(UsageError, match=r"the robot's sensors.*fov_deg is 400.*; it should be"):
        brought(tmp_path, "lm = [1 2; 3 4]; sensor.angle = 400;")


def test_a_laser_is_the_sensor_and_lines_are_walls(tmp_path):
    script = (
        "cfg.lines = [0 0 8 0; 8 0 8 6; 8 6 0 6; 0 6 0 0; 0 6 0 6.5]; cfg.features = [1 2 3; 4 5 5];"
        "cfg.laser.range = [0.1 9]; cfg.laser.fov = 270*pi/180; cfg.laser.sigma = 0.03; cfg.goals = [1 7; 1 5];"
    )
    world, told = brought(tmp_path, script)
    assert [tuple(wall.points[1]) for wall in world.walls] == [(8, 0), (8, 6), (0, 6), (0, 0), (0, 6.5)]
    (sensor,) = world.robots[0].sensors
    assert (sensor.range, sensor.fov_deg, sensor.noise.range) == ((0.1, 9), 270, 0.03)
    assert "laser.fov is sensor's fov_deg: 270" in told
    assert not [line for line in told if "left out" in line]
