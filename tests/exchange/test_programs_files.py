"""Twenty files in the manner of other programs: their sizes, and what their lists say."""

import pytest

from mjsim.errors import UsageError
from mjsim.exchange import Reading, bring_file
from mjsim.logs import listed, read_trajectory
from mjsim.world import parse_world, solid
from tests.exchange.bringing import brought
from tests.exchange.programs_files import TEXTS, write_files
from tests.real_logs import imported


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("programs")
    write_files(folder)
    return folder


ROOM = (7.0, 5.0)
WORLDS = {
    "harmonic.sdf": (None, (8.0, 2.4), 1, "kept: wall 'wall_n'", "guessed: cone 'cone': a cylinder of its size"),
    "nested.sdf": (None, (0.2, 1.0), 0, "kept: static model 'outer'"),
    "house.xml": (None, (8.2, 6.2), 4, "kept: wall 'world'", "left out: overhead part 'lamp': it begins above 2.2 m"),
    "figma.svg": (0.01, ROOM, 1, "kept: 1 piece of furniture", "guessed: heights: a drawing has none"),
    "drawio.svg": (0.01, (6.06, 4.06), 2, "left out: 1 <text>"),
    "floorplanner.svg": (None, (8.15, 5.15), 2, "left out: 1 <image>, 1 <text>"),
    "r12.dxf": (1.0, (6.1, 4.1), 1, "left out: 1 TEXT"),
    **{
        f"{name}.yaml": (None, ROOM, 2, "guessed: heights and colours: a map has none")
        for name in ("trinary", "scale", "negated", "alpha", "tabs")
    },
}
"""Name -> scale, size [m], number of walls, lines of the list."""
REFUSED = {
    "raw.yaml": r"none of its cells is occupied; check the gray values",
    "no_mesh.xml": r"MuJoCo cannot read .*no\.obj",
}


@pytest.mark.parametrize("name", WORLDS)
def test_worlds_have_the_size_of_the_file_and_a_list(name, folder):
    scale, size, walls, *lines = WORLDS[name]
    found = bring_file(folder / name, robot=None, reading=Reading(scale))
    world = parse_world(found.text) if not found.files else None
    assert not {*lines} - {*found.report}
    if world is not None:
        shape = solid(world).minimum_rotated_rectangle if name.endswith(".yaml") else solid(world).envelope
        xs, ys = shape.exterior.coords.xy
        sides = sorted(((xs[k] - xs[k + 1]) ** 2 + (ys[k] - ys[k + 1]) ** 2) ** 0.5 for k in range(2))
        assert sides == pytest.approx(sorted(size), abs=0.06)
        assert len(world.walls) == walls


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_read_is_one_line(name, folder):
    with pytest.raises(UsageError, match=REFUSED[name]) as caught:
        bring_file(folder / name, robot=None)
    assert "\n" not in str(caught.value)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["solidworks.urdf", "fusion.urdf"])
def test_robots_of_cad_exporters_have_their_wheels(name, folder):
    _, said = brought(folder / name, folder)
    assert "of radius 0.0500 m, a track of 0.2400 m" in said


@pytest.mark.parametrize(("name", "period"), [("graph.g2o", 0.1), ("kitti.txt", 0.1), ("traj.tum", None)])
def test_trajectories_are_straight_and_as_long_as_they_say(name, period, folder):
    rows = read_trajectory(folder / name, period=period)
    assert rows[:, 0].tolist() == pytest.approx([0.1 * k for k in range(20)])
    assert rows[:, 1].tolist() == pytest.approx([0.1 * k for k in range(20)])
    assert abs(rows[:, 2:]).max() == 0.0


@pytest.mark.slow
def test_a_log_of_carmen_is_kept(folder):
    assert listed(imported(folder / "old.clf"))[0] == "kept: lidar 'front'"


def test_every_file_is_tried():
    others = {"solidworks.urdf", "fusion.urdf", "graph.g2o", "kitti.txt", "traj.tum", "old.clf"}
    assert {*WORLDS, *REFUSED} | others == {*TEXTS}
    assert len(TEXTS) >= 20
