"""Files as Gazebo, CAD exporters, map servers, drawing tools in the web and loggers write them: small, and our own."""

import math
from pathlib import Path

import numpy as np
from PIL import Image

BOX = "<geometry><box><size>{}</size></box></geometry>"
MAP = "image: {}\nmode: {}\nresolution: 0.05\norigin: [-2.0, -1.0, 0.3]\nnegate: {}\noccupied_thresh: 0.65\n"
WHEEL = '<cylinder radius="0.05" length="0.03"/>'
NO_LIMIT = '<limit lower="0" upper="0" effort="0" velocity="0"/>'


def link(name: str, mass: float, shape: str, at: str = "0 0 0") -> str:
    """Return a link as SolidWorks and Fusion export it."""
    inertia = '<inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/>'
    looks = f'<origin xyz="{at}"/><geometry>{shape}</geometry>'
    whole = f'<inertial><origin xyz="{at}"/><mass value="{mass}"/>{inertia}</inertial>'
    return f'<link name="{name}">{whole}<visual>{looks}</visual><collision>{looks}</collision></link>'


def joint(name: str, child: str, at: str, *, turn: str = "1.5708 0 0", kind: str = "continuous", more: str = "") -> str:
    """Return a joint to the base."""
    ends = f'<parent link="base_link"/><child link="{child}"/><axis xyz="0 0 -1"/>{more}'
    return f'<joint name="{name}" type="{kind}"><origin xyz="{at}" rpy="{turn}"/>{ends}</joint>'


def static(name: str, shape: str, pose: str) -> str:
    """Return a static model of SDF."""
    body = f'<link name="l"><collision name="c">{shape}</collision></link>'
    return f'<model name="{name}"><static>true</static><pose>{pose}</pose>{body}</model>'


HARMONIC = f"""<?xml version="1.0"?><sdf version="1.10"><world name="demo">
<physics name="1ms" type="ignored"><max_step_size>0.001</max_step_size></physics>
<plugin filename="gz-sim-physics-system" name="gz::sim::systems::Physics"/>
<gui fullscreen="0"><plugin filename="MinimalScene" name="3D View"/></gui>
<light type="directional" name="sun"><direction>-0.5 0.1 -0.9</direction></light>
<include><uri>https://fuel.gazebosim.org/1.0/OpenRobotics/models/Walking actor</uri></include>
{static("wall_n", BOX.format("8 0.2 2.5"), "0 3 1.25 0 0 0")}
{static("cone", "<geometry><cone><radius>0.3</radius><length>1</length></cone></geometry>", "-2 1 0.5 0 0 0")}
<actor name="walker"><skin><filename>walk.dae</filename></skin></actor><wind/>
<model name="diff"><pose>0 -1 0.1 0 0 0.5</pose><link name="b"><collision name="c">{BOX.format("0.4 0.3 0.1")}
</collision></link><plugin filename="gz-sim-diff-drive-system" name="gz::sim::systems::DiffDrive"/></model>
</world></sdf>"""
NESTED = f"""<sdf version="1.9"><model name="outer"><static>true</static>
<frame name="f"><pose>1 0 0 0 0 1.5708</pose></frame><model name="inner" placement_frame="tip">
<pose relative_to="f">0 0 0.5 0 0 0</pose><link name="l"><collision name="c">{BOX.format("1 0.2 1")}</collision></link>
<frame name="tip"><pose>0.5 0 0 0 0 0</pose></frame></model></model></sdf>"""
SIDES = ((0, 3, 4, 0.1), (0, -3, 4, 0.1), (4, 0, 0.1, 3), (-4, 0, 0.1, 3))
HOUSE = (
    '<mujoco model="h"><compiler angle="degree" autolimits="true"/><default><default class="wall"><geom type="box"/>'
    '</default></default><worldbody><light directional="true"/><geom type="plane" size="5 5 .1"/>'
    + "".join(f'<geom class="wall" pos="{x} {y} 1.2" size="{a} {b} 1.2"/>' for x, y, a, b in SIDES)
    + '<body name="fridge" pos="-3.5 2.5 0"><geom type="box" pos="0 0 .9" size=".3 .3 .9"/>'
    '<body name="door" pos="0 -.32 .9"><joint axis="0 0 1" pos="-.3 0 0" range="-120 0"/>'
    '<geom type="box" size=".3 .02 .9" mass="6"/></body></body>'
    '<body name="lamp" pos="2 2 2.6"><geom type="sphere" size=".1"/></body></worldbody></mujoco>'
)
SOLIDWORKS = (
    "<?xml version='1.0' encoding='utf-8'?><!-- automatically created by SolidWorks to URDF Exporter! -->"
    '<robot name="My Robot v2">'
    + link("base_link", 2.5, '<box size="0.3 0.2 0.1"/>', "0 0 0.02")
    + "".join(link(f"{side} wheel", 0.2, WHEEL) for side in "LR")
    + link("caster ball", 0.05, '<sphere radius="0.02"/>')
    + joint("L wheel joint", "L wheel", "0 0.12 0", more=NO_LIMIT)
    + joint("R wheel joint", "R wheel", "0 -0.12 0", more=NO_LIMIT)
    + joint("caster joint", "caster ball", "-0.12 0 -0.03", kind="fixed")
    + "</robot>"
)
FUSION = (
    '<robot name="fusion">'
    + link("base_link", 3, '<box size="0.3 0.2 0.1"/>', "-0.05 0 0")
    + link("wheel_1", 0.2, WHEEL)
    + link("wheel_2", 0.2, WHEEL)
    + joint("Rev1", "wheel_1", "0 0.12 0", turn="-1.5708 0 0")
    + joint("Rev2", "wheel_2", "0 -0.12 0", turn="-1.5708 0 0")
    + "</robot>"
)
FIGMA = (
    '<svg width="800" height="600" viewBox="0 0 800 600" fill="none" xmlns="http://www.w3.org/2000/svg">'
    '<g clip-path="url(#c)"><rect width="800" height="600" fill="white"/><g id="Walls">'
    '<rect x="50" y="50" width="700" height="10" fill="#111"/>'
    '<rect x="50" y="540" width="700" height="10" fill="#111"/>'
    '<rect x="50" y="50" width="10" height="500" fill="#111"/>'
    '<rect x="740" y="50" width="10" height="500" fill="#111"/>'
    '</g><path id="sofa" d="M100 100H220V160H100Z" fill="#ccc" stroke="black"/></g>'
    '<defs><clipPath id="c"><rect width="800" height="600" fill="white"/></clipPath></defs></svg>'
)
DRAWIO = (
    '<svg xmlns="http://www.w3.org/2000/svg" width="601px" height="401px" viewBox="-0.5 -0.5 601 401"><g>'
    '<g data-cell-id="w"><g transform="translate(0.5,0.5)"><path'
    ' d="M 0 0 L 600 0 L 600 400 L 0 400 Z M 300 0 L 300 250" fill="none" stroke="#000" stroke-width="6"/></g></g></g>'
    "<text>Room</text><switch><foreignObject/></switch></svg>"
)
FLOORPLANNER = (
    '<svg xmlns="http://www.w3.org/2000/svg" width="210mm" height="148mm" viewBox="0 0 210 148"><text>1 : 50</text><g>'
    '<path style="fill:none;stroke:#000;stroke-width:3" d="m 20,20 h 160 v 100 h -160 z"/>'
    '<path style="fill:none;stroke:#000;stroke-width:3" d="m 100,20 v 40"/></g><image href="x.png"/></svg>'
)
LINES = ((0, 0, 6, 0), (6, 0, 6, 4), (6, 4, 0, 4), (0, 4, 0, 0))
R12 = (
    "0\nSECTION\n2\nENTITIES\n"
    + "".join(f"0\nLINE\n8\nWALLS\n10\n{a}\n20\n{b}\n11\n{c}\n21\n{d}\n" for a, b, c, d in LINES)
    + "0\nTEXT\n8\nT\n10\n1\n20\n1\n40\n0.2\n1\nKitchen\n0\nENDSEC\n0\nEOF\n"
)
SCAN = " ".join(f"{2 + math.sin(0.1 * k):.2f}" for k in range(180))
CARMEN = "# message_name [message contents] ipc_timestamp\nPARAM robot_frontlaser_offset 0.08 nohost 0\n" + "".join(
    f"ODOM {0.05 * k:.3f} 0 0 0.25 0 0 {1e9 + 0.2 * k:.3f} h {0.2 * k:.3f}\n"
    f"FLASER 180 {SCAN} {0.05 * k:.3f} 0 0 {0.05 * k:.3f} 0 0 {1e9 + 0.2 * k:.3f} h {0.2 * k:.3f}\n"
    for k in range(60)
)
G2O = "".join(f"VERTEX_SE2 {k} {0.1 * k} 0 0\n" for k in range(20)) + "".join(
    f"EDGE_SE2 {k} {k + 1} 0.1 0 0 100 0 0 100 0 100\n" for k in range(19)
)
KITTI = "".join(f"1 0 0 0 0 1 0 0 0 0 1 {0.1 * k}\n" for k in range(20))
TUM = "".join(f"{0.1 * k} {0.1 * k} 0 0 0 0 0 1\n" for k in range(20))
TEXTS = {
    **{"harmonic.sdf": HARMONIC, "nested.sdf": NESTED, "house.xml": HOUSE, "figma.svg": FIGMA, "drawio.svg": DRAWIO},
    **{"floorplanner.svg": FLOORPLANNER, "r12.dxf": R12, "solidworks.urdf": SOLIDWORKS, "fusion.urdf": FUSION},
    **{"old.clf": CARMEN, "graph.g2o": G2O, "kitti.txt": KITTI, "traj.tum": TUM},
    "no_mesh.xml": '<mujoco><asset><mesh name="m" file="no.obj"/></asset><worldbody><geom type="mesh" mesh="m"/>'
    "</worldbody></mujoco>",
    **{f"{mode}.yaml": MAP.format("m.png", mode, 0) + "free_thresh: 0.196\n" for mode in ("trinary", "scale", "raw")},
    "negated.yaml": MAP.format("n.png", "trinary", 1) + "free_thresh: 0.25\n",
    "alpha.yaml": MAP.format("a.png", "trinary", 0) + "free_thresh: 0.25\n",
    "tabs.yaml": MAP.format("m.png", "trinary", 0).replace("\n", "\t\n") + "free_thresh:\t0.196\t# as Nav2 has it\n",
}
"""Name -> text."""


def write_files(folder: Path) -> None:
    """Write all of them, and the pictures of the maps: a room of 7 x 5 m with a wall in it, unknown outside."""
    for name, text in TEXTS.items():
        (folder / name).write_text(text)
    grey = np.full((120, 160), 254, np.uint8)
    grey[:10] = grey[-10:] = grey[:, :10] = grey[:, -10:] = 205
    for rows, columns in (
        ((10, 13), (10, 150)),
        ((107, 110), (10, 150)),
        ((10, 110), (10, 13)),
        ((10, 110), (147, 150)),
    ):
        grey[slice(*rows), slice(*columns)] = 0
    grey[50:53, 13:90] = 0
    Image.fromarray(grey).save(folder / "m.png")
    Image.fromarray(255 - grey).save(folder / "n.png")
    clear = np.where(grey == 205, 0, 255).astype(np.uint8)
    Image.fromarray(np.dstack([grey, grey, grey, clear])).save(folder / "a.png")
