"""Forty damaged files of ten formats: each is one line, or what is left of it."""

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from mjsim.errors import MjsimError
from mjsim.exchange import RobotOptions, bring_file, bring_robot
from mjsim.exchange.world_import import Reading
from tests.exchange.test_jointed_scenes import CHEST, DOOR, MJCF
from tests.exchange.test_webots import ROOM
from tests.logs.test_rawlogs import RANGES, START, action, frame, pose3, scan
from tests.real_logs import imported

WALLS = [(0, 0, 6, 0), (6, 0, 6, 4), (6, 4, 0, 4), (0, 4, 0, 0)]
SVG = "".join(f"<line x1='{100 * a}' y1='{100 * b}' x2='{100 * c}' y2='{100 * d}'/>" for a, b, c, d in WALLS)
DXF = "".join(f"0\nLINE\n8\nWALLS\n10\n{a}\n20\n{b}\n11\n{c}\n21\n{d}\n" for a, b, c, d in WALLS)
WHEEL = "<link name='{0}'><inertial><mass value='1'/><inertia ixx='.01' iyy='.01' izz='.01' ixy='0' ixz='0' iyz='0'/>"
WHEEL += "</inertial><collision><geometry><cylinder radius='.1' length='.04'/></geometry></collision></link>"
HINGE = "<joint name='{0}_j' type='continuous'><parent link='b'/><child link='{0}'/><axis xyz='0 0 1'/>"
HINGE += "<origin xyz='0 {1} 0.1' rpy='-1.5708 0 0'/></joint>"
URDF = "<robot name='r'><link name='b'><collision><geometry><box size='.4 .3 .1'/></geometry></collision></link>"
URDF += "".join(WHEEL.format(name) + HINGE.format(name, y) for name, y in (("l", 0.2), ("r", -0.2))) + "</robot>"
RAWLOG = b"".join(
    frame(scan(8, START + number, RANGES, pose=pose3(3, 0, 0, 0.3, 0))) + action(0.1, 0, 0) for number in range(20)
)
CARMEN = "".join(
    f"ODOM {0.1 * k} 0 0 0.5 0 0 {k} host {k}\nFLASER 5 1 2 3 4 5 0 0 0 {0.1 * k} 0 0 {k}.1 host {k}\n"
    for k in range(40)
)
MAP = "image: m.png\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.25\n"


def picture() -> bytes:
    cells = np.full((80, 100), 254, dtype=np.uint8)
    cells[[5, 74], 5:95] = cells[5:75, 5] = cells[5:75, 94] = 0
    return cv2.imencode(".png", cells)[1].tobytes()


FILES: dict[str, bytes] = {
    "room.world": f"<sdf version='1.9'><world name='w'>{DOOR}{CHEST}</world></sdf>".encode(),
    "house.xml": MJCF.encode(),
    "room.wbt": ROOM.encode(),
    "plan.svg": f"<svg xmlns='http://www.w3.org/2000/svg' stroke='black'><g id='walls'>{SVG}</g></svg>".encode(),
    "plan.dxf": f"0\nSECTION\n2\nENTITIES\n{DXF}0\nENDSEC\n0\nEOF\n".encode(),
    "map.yaml": MAP.encode(),
    "m.png": picture(),
    "robot.urdf": URDF.encode(),
    "run.rawlog": RAWLOG,
    "run.clf": CARMEN.encode(),
}


def read(path: Path) -> None:
    if path.suffix in (".rawlog", ".clf"):
        imported(path)
    elif path.suffix == ".urdf":
        bring_robot(path, name="r", options=RobotOptions(), packages={}, arguments={})
    else:
        scale = {".svg": 0.01, ".dxf": 1.0}.get(path.suffix)
        bring_file(path.with_name("map.yaml") if path.suffix == ".png" else path, robot=None, reading=Reading(scale))


def refusal(path: Path) -> str:
    """Return the message with which a file is refused; '' if it is read."""
    try:
        read(path)
    except MjsimError as error:
        return str(error)
    return ""


DAMAGE: dict[str, Callable[[bytes, np.random.Generator], bytes]] = {
    "cut": lambda data, rng: data[: int(rng.integers(1, len(data)))],
    "a hole": lambda data, rng: data[: (at := int(rng.integers(len(data) // 2)))] + data[at + len(data) // 5 :],
    "other bytes": lambda data, rng: bytes(int(rng.integers(256)) if rng.random() < 0.01 else byte for byte in data),
    "repeated": lambda data, rng: data[: (at := int(rng.integers(len(data))))] + 40 * data[at : at + 200] + data[at:],
}


@pytest.mark.slow
@pytest.mark.parametrize("name", FILES)
def test_a_damaged_file_is_one_line_or_what_is_left_of_it(name, tmp_path):
    rng = np.random.default_rng([*name.encode()])
    (tmp_path / "m.png").write_bytes(FILES["m.png"])
    (tmp_path / "map.yaml").write_bytes(FILES["map.yaml"])
    (tmp_path / name).write_bytes(FILES[name])
    read(tmp_path / name)
    for damaged in DAMAGE.values():
        (tmp_path / name).write_bytes(damaged(FILES[name], rng))
        lines = refusal(tmp_path / name).splitlines()
        assert all(len(line) < 500 for line in lines)
        # The text of a map has a line for each mistake, with its place.
        assert len(lines) <= 1 or all(line.startswith(str(tmp_path / "map.yaml:")) for line in lines)
