"""A world as one would write it without thinking of speed: one geom a wall, pictures as they are, lamps with shadows.

The same blocks make a scene of plain MuJoCo, drawn by its own `mujoco.Renderer`, and one of PyBullet.
"""

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import mujoco
from mujoco.rendering.classic import gl_context

from mjsim.compile.room.walls import wall_boxes
from mjsim.geometry import Pose
from mjsim.interface import Picture
from mjsim.models import encode_png, read_picture
from mjsim.sim import make_context
from mjsim.world import BoxObstacle, CylinderObstacle, World

THICKNESS = 0.01
"""Of a picture [m]."""
CAMERA_AT, CAMERA_FOV = (0.1, 0.0, 1.0), math.radians(60.0)
"""On the robot [m]; horizontal [rad]."""
ROBOT = (0.2, 0.12)
"""Radius and half the height of what stands for the robot [m]."""


@dataclass(frozen=True)
class Block:
    """A box or a cylinder that stands upright."""

    half: tuple[float, ...]
    """Half sizes of a box along its heading, across and upwards; radius and half the height of a cylinder [m]."""
    at: tuple[float, float, float]
    """Its middle, world frame [m]."""
    heading: float = 0.0
    """[rad]"""
    picture: str | None = None
    """File of what its faces show."""


def blocks_of(world: World) -> list[Block]:
    """Return the blocks of a world: its walls, its boxes and cylinders, and its pictures."""
    blocks = [
        Block(tuple(box.half.tolist()), tuple(box.center.tolist()), box.heading) for box in wall_boxes(world.walls)
    ]
    for item in world.obstacles:
        if isinstance(item, BoxObstacle):
            x, y, z = (size / 2 for size in item.box)
            blocks.append(Block((x, y, z), (*item.at, z), math.radians(item.heading_deg)))
        elif isinstance(item, CylinderObstacle):
            radius, height = item.cylinder
            blocks.append(Block((radius, height / 2), (*item.at, height / 2)))
    for beacon in world.beacons:
        if beacon.image is not None:
            rows, columns = read_picture(world.read_asset(beacon.image)).shape[:2]
            half = (THICKNESS / 2, beacon.width / 2, beacon.width / 2 * rows / columns)
            blocks.append(
                Block(half, (*beacon.at, beacon.center), math.radians(beacon.heading_deg), picture=beacon.image)
            )
    return blocks


def pictures_of(world: World, blocks: Sequence[Block]) -> dict[str, Picture]:
    """Return the pictures that blocks and the floor show, by file."""
    files = {block.picture for block in blocks} | {world.floor.texture}
    return {file: read_picture(world.read_asset(file)) for file in sorted(file for file in files if file)}


def naive_scene(
    world: World, *, width: int, height: int, lamps: Sequence[tuple[float, float]], visual: str = ""
) -> mujoco.MjModel:
    """Return a scene of plain MuJoCo: a geom a block, a lamp with shadows at each place, MuJoCo's quality.

    Args:
        world: What is in it.
        width: Of pictures [px].
        height: Of pictures [px].
        lamps: Where lamps hang, world frame [m].
        visual: What is to differ from MuJoCo's quality, as MJCF.
    """
    blocks = blocks_of(world)
    pictures = pictures_of(world, blocks)
    names = {file: f"picture{number}" for number, file in enumerate(pictures)}
    assets = [
        f'<texture name="{n}" type="2d" file="{n}.png"/><material name="{n}" texture="{n}"/>' for n in names.values()
    ]
    shown = world.floor.texture
    floor = f'material="{names[shown]}"' if shown is not None else 'rgba=".6 .6 .6 1"'
    fov = 2 * math.degrees(math.atan(math.tan(CAMERA_FOV / 2) * height / width))
    xml = f"""
<mujoco>
  <visual><global offwidth="{width}" offheight="{height}"/>{visual}</visual>
  <asset>{"".join(assets)}</asset>
  <worldbody>
    {"".join(f'<light pos="{x} {y} 2.4" dir="0 0 -1" cutoff="80"/>' for x, y in lamps)}
    <geom type="plane" size="100 100 1" {floor}/>
    {"".join(_geom(block, names) for block in blocks)}
    <body name="robot" mocap="true">
      <geom type="cylinder" size="{ROBOT[0]} {ROBOT[1]}" pos="0 0 {ROBOT[1]}" contype="0" conaffinity="0"/>
      <camera name="front" pos="{_text(CAMERA_AT)}" xyaxes="0 -1 0 0 0 1" fovy="{fov}"/>
    </body>
  </worldbody>
</mujoco>"""
    return mujoco.MjModel.from_xml_string(
        xml, {f"{names[file]}.png": encode_png(each) for file, each in pictures.items()}
    )


def _geom(block: Block, names: dict[str, str]) -> str:
    kind = "box" if len(block.half) == 3 else "cylinder"
    look = f'material="{names[block.picture]}"' if block.picture is not None else 'rgba=".9 .88 .85 1"'
    c, s = math.cos(block.heading / 2), math.sin(block.heading / 2)
    return f'<geom type="{kind}" size="{_text(block.half)}" pos="{_text(block.at)}" quat="{c} 0 0 {s}" {look}/>'


def _text(numbers: Sequence[float]) -> str:
    return " ".join(str(number) for number in numbers)


def put(model: mujoco.MjModel, data: mujoco.MjData, place: Pose) -> None:
    """Put what stands for the robot to a place."""
    data.mocap_pos[0] = [place.x, place.y, 0.0]
    data.mocap_quat[0] = [math.cos(place.heading / 2), 0.0, 0.0, math.sin(place.heading / 2)]
    mujoco.mj_kinematics(model, data)
    mujoco.mj_camlight(model, data)


@contextmanager
def stock_renderer(model: mujoco.MjModel, *, width: int, height: int) -> Iterator[mujoco.Renderer]:
    """Give MuJoCo's own renderer, in an OpenGL context of the backend that works here."""
    known = getattr(gl_context, "GLContext", None)
    # Which class of contexts it uses is settled by MUJOCO_GL when MuJoCo is imported, and that may be one for screens.
    gl_context.GLContext = make_context
    try:
        renderer = mujoco.Renderer(model, height, width)
    finally:
        gl_context.GLContext = known
    try:
        yield renderer
    finally:
        renderer.close()
