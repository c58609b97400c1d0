"""Small valid files of every kind that can be imported, except logs."""

import io
import struct
from collections.abc import Mapping
from pathlib import Path

import cv2
import numpy as np
from changes import Files
from scipy.io import savemat

ROOT = Path(__file__).resolve().parents[2]
DATA = ROOT / "tests" / "data"
WALLS = b"M0 0h400v300H0zM200 0v100M200 200v100"
SVG = b'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 420 320"><style>.t{stroke:#000;stroke-width:1}</style>'
SVG += b'<defs><g id="door"><path class="t" d="M0 0A18 18 0 0 1 18 18V0"/></g></defs><g id="walls" fill="none"'
SVG += b' stroke="black" stroke-width="3" transform="translate(9 9)"><path d="%s"/></g><g id="furniture">' % WALLS
SVG += b'<rect x="60" y="60" width="30" height="20" class="t"/><circle cx="300" cy="90" r="12" class="t"/></g>'
SVG += b'<use href="#door" x="209" y="109"/><polyline class="t" points="20,280 60,280 60,300"/>'
SVG += b"<text>1 : 50</text></svg>"
OBJ = b"v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\nvt 0 0\nvt 1 1\n"
OBJ += b"f 1/1 3/2 2/1\nf 1/1 2/2 4/1\nf 2/1 3/2 4/1\nf 3/1 1/2 4/1\n"
CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]], dtype="<f4")
FACES = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3))
TRIANGLES = b"".join(bytes(12) + CORNERS[list(face)].tobytes() + bytes(2) for face in FACES)
STL = bytes(80) + struct.pack("<I", len(FACES)) + TRIANGLES
MJCF = b"""<mujoco><compiler angle="radian" eulerseq="zYx" meshdir="meshes"/>
<default><geom type="box" size="0.1 0.2 0.3"/><default class="round"><geom type="cylinder" euler="0.3 0 0"/></default>
</default><asset><mesh name="wedge" file="wedge.obj" scale="0.5 1 -1" refpos="0.2 0.1 0" refquat="0.8 0 0.6 0"/>
<mesh name="inline" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/><material name="m" rgba="1 0 0 1" texture="t"/>
<texture name="t" type="2d" builtin="checker" width="8" height="8" rgb1="1 1 1"/></asset>
<worldbody><geom pos="3 0 0" euler="0.1 0.2 0.3" material="m"/><include file="part.xml"/>
<body name="b" pos="0 1 0" axisangle="1 2 0 0.7" childclass="round"><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
<geom/><geom size="0.2" zaxis="1 1 0"/><frame pos="0 0 2" quat="0.6 0.8 0 0"><body pos="1 0 0">
<joint type="slide" axis="0 1 0" ref="0.2" range="-1 1" stiffness="3" damping="1"/>
<geom type="capsule" fromto="0 0 0 1 2 3" size="0.1"/><geom type="mesh" mesh="wedge" xyaxes="0 1 0 -1 0 1"/>
<geom type="mesh" mesh="inline" group="3"/></body></frame></body>
<replicate count="3" offset="1 0 0.1" euler="0 0 0.4"><body><joint type="ball"/><geom size="0.05"/></body></replicate>
</worldbody><contact><exclude body1="b" body2="b"/></contact></mujoco>"""
SDF = b"""<sdf version="1.9"><world name="w"><include><uri>chair</uri><name>c</name><pose>1 2 0 0 0 1</pose>
<placement_frame>back</placement_frame></include><include><uri>model://sun</uri></include><light name="p"
 type="point">
<pose>1 1 2 0 0 0</pose><diffuse>1 1 0 1</diffuse></light><frame name="f">
<pose degrees="true">1 0 0 0 0 90</pose></frame>
<model name="m"><static>1</static><pose relative_to="f">0 0 1 0 0 0</pose><link name="l"><collision name="a"><geometry>
<box><size>4 0.1 2</size></box></geometry></collision><collision name="b"><pose>0 0 3 0.3 0 0</pose><geometry><mesh>
<uri>wedge.obj</uri><scale>2 1 -1</scale></mesh></geometry></collision></link></model><model name="n"><link name="l">
<inertial><mass>2</mass></inertial><collision name="a"><geometry><sphere><radius>0.2</radius></sphere></geometry>
</collision></link><link name="k"><collision name="a"><geometry><polyline><height>1</height><point>0 0</point>
<point>1 0</point><point>0 1</point></polyline></geometry></collision></link></model></world></sdf>"""
CHAIR = b"""<sdf version="1.7"><model name="chair"><static>true</static><frame name="back">
<pose>0.2 0 0 0 0 0</pose></frame>
<link name="l"><pose rotation_format="quat_xyzw">0 0 0.5 0 0 0 1</pose><collision name="a"><geometry><cylinder>
<radius>0.2</radius><length>1</length></cylinder></geometry></collision></link></model></sdf>"""
PART = b'<mujocoinclude><geom pos="0 0 -1" quat="1 1 0 0"/></mujocoinclude>'
URDF = b"""<robot name="cupboard"><link name="case"><visual><geometry><sphere radius="2"/></geometry></visual>
<collision><origin xyz="0 0 0.5" rpy="0 0 0.4"/><geometry><box size="0.4 0.8 1"/></geometry></collision></link>
<link name="door"><inertial><mass value="3"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><geometry><mesh filename="meshes/wedge.stl" scale="0.1 0.2 0.3"/></geometry></collision>
<collision><geometry><cylinder radius="0.05" length="0.9"/></geometry></collision></link>
<joint name="hinge" type="revolute"><parent link="case"/><child link="door"/><origin xyz="0.2 -0.4 0.5"/>
<axis xyz="0 0 1"/><limit lower="0" upper="1.5" effort="9" velocity="9"/></joint></robot>"""
MESH = b"""<mujoco><asset><mesh name="w" file="wedge.%s"/></asset><worldbody><geom type="mesh" mesh="w"/></worldbody>
</mujoco>"""
WHEEL = """<link name="%s_wheel"><inertial><mass value="0.3"/><inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0"
 iyz="0"/></inertial><collision><origin rpy="1.5708 0 0"/><geometry><cylinder radius="0.05" length="0.03"/></geometry>
</collision></link><joint name="%s_wheel_joint" type="continuous"><parent link="base"/><child link="%s_wheel"/>
<origin xyz="0 %s 0"/><axis xyz="0 1 0"/></joint>"""
BASE = """<link name="base"><inertial><mass value="4"/><inertia ixx="0.05" iyy="0.05" izz="0.05" ixy="0" ixz="0"
 iyz="0"/></inertial><visual><geometry><mesh filename="meshes/wedge.stl" scale="0.1 0.1 0.03"/></geometry></visual>
<collision><origin xyz="0 0 0.05"/><geometry><box size="0.3 0.2 0.06"/></geometry></collision></link>
<link name="caster"><collision><geometry><sphere radius="0.02"/></geometry></collision></link>
<joint name="caster_joint" type="fixed"><parent link="base"/><child link="caster"/>
<origin xyz="-0.12 0 -0.03"/></joint>"""
DRIVEN = BASE + WHEEL % ("left", "left", "left", "0.12") + WHEEL % ("right", "right", "right", "-0.12")
"""Links and joints of a robot with two wheels."""
CAR = """<mujoco><compiler meshdir="meshes"/><asset><mesh name="w" file="wedge.obj" scale="0.1 0.1 0.03"/></asset>
<worldbody><body name="base" pos="0 0 0.05"><freejoint/><geom type="box" size="0.15 0.1 0.03" pos="0 0 0.04" mass="4"/>
<geom type="mesh" mesh="w" contype="0" conaffinity="0" mass="0"/><geom type="sphere" size="0.02" pos="-0.12 0 -0.03"/>
<body name="left" pos="0 0.12 0"><joint name="left" axis="0 1 0"/><geom type="cylinder" size="0.05 0.015"
 euler="90 0 0"/></body>
<body name="right" pos="0 -0.12 0"><joint name="right" axis="0 1 0"/><geom type="cylinder" size="0.05 0.015"
 euler="90 0 0"/></body></body></worldbody><actuator>
<velocity joint="left"/><velocity joint="right"/></actuator></mujoco>"""


def _landmarks(**keywords: bool) -> bytes:
    file = io.BytesIO()
    savemat(file, {"lm": [[1.0, 4.0, 7.0], [2.0, 5.0, 8.0]], "wp": [[1.0, 3.0], [1.0, 3.0]]}, **keywords)
    return file.getvalue()


def _room() -> np.ndarray:
    cells = np.full((40, 60), 254, np.uint8)
    cells[[2, -3], 2:-2] = cells[2:-2, [2, -3]] = cells[2:20, 30] = 0
    return cells


def _picture(kind: str) -> bytes:
    noise = np.random.default_rng(1).integers(0, 255, (24, 32, 3), np.uint8)
    return bytes(cv2.imencode(f".{kind}", cv2.resize(noise, (64, 48)))[1])


def _plan(name: str) -> Files:
    return {f"plan{Path(name).suffix}": (DATA / "plans" / name).read_bytes()}


def _map(kind: str) -> Files:
    header = f"image: map.{kind}\nresolution: 0.1\norigin: [-1, -2, 0]\nnegate: 0\noccupied_thresh: 0.65\n"
    return {"map.yaml": header.encode(), f"map.{kind}": bytes(cv2.imencode(f".{kind}", _room())[1])}


def _thing(name: str, text: bytes) -> Files:
    return {name: text, "part.xml": PART, "meshes/wedge.obj": OBJ, "meshes/wedge.stl": STL}


def _furniture(kind: str) -> list[Files]:
    """Return the shipped models of a kind, each with the pictures beside it."""
    files = {each.name: each.read_bytes() for each in sorted((ROOT / "assets/furniture").iterdir())}
    pictures = {name: data for name, data in files.items() if name.endswith("png")}
    return [{name: data} | pictures for name, data in files.items() if name.endswith(kind)]


SEEDS: Mapping[str, list[Files]] = {
    "svg": [
        {"plan.svg": SVG},
        *({"plan.svg": (DATA / "plans" / f"{n}.svg").read_bytes()} for n in ("illustrator", "inkscape")),
    ],
    "dxf": [*map(_plan, ("house.dxf", "flat.dxf"))],
    "map": [_map("pgm"), _map("png")],
    "image of a map": [{"map.png": _map("png")["map.png"]}, {"map.bmp": bytes(cv2.imencode(".bmp", _room())[1])}],
    "mat": [{"map.mat": _landmarks()}, {"map.mat": _landmarks(do_compression=True)}],
    "robot in URDF": [{"robot.urdf": f'<robot name="r">{DRIVEN}</robot>'.encode(), "meshes/wedge.stl": STL}],
    "robot in MJCF": [{"robot.xml": CAR.encode(), "meshes/wedge.obj": OBJ}],
    "thing in MJCF": [_thing("thing.xml", MJCF), *_furniture("xml")],
    "thing in URDF": [_thing("thing.urdf", URDF), *_furniture("urdf")],
    "scene in SDF": [{"scene.world": SDF, "chair/model.sdf": CHAIR, "wedge.obj": OBJ}],
    "scene in MJCF": [{"scene.xml": MJCF, "part.xml": PART, "meshes/wedge.obj": OBJ}],
    "thing in SDF": [{"thing.sdf": CHAIR}],
    "obj": [{"thing.xml": MESH % b"obj", "wedge.obj": OBJ}],
    "stl": [{"thing.xml": MESH % b"stl", "wedge.stl": STL}],
    "jpg": [{"picture.jpg": _picture("jpg")}],
    "png": [{"picture.png": _picture("png")}],
}
"""Importer -> valid files."""
