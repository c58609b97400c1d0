"""Descriptions of robots that differ in what makers do differently."""

import math
from collections.abc import Sequence


def box(size: str, *, mass: float = 5.0, at: str = "0 0 0", inertia: str | None = None) -> str:
    """Return what a link of URDF has that is a box."""
    inertia = inertia or 'ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"'
    return f"""<inertial><origin xyz="{at}"/><mass value="{mass}"/><inertia {inertia}/></inertial>
      <collision><origin xyz="{at}"/><geometry><box size="{size}"/></geometry></collision>"""


def tyre(radius: float, width: float, *, rpy: str = "1.5707963 0 0") -> str:
    """Return what a link of URDF has that is a wheel."""
    inertia = '<inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/>'
    return f"""<inertial><mass value="0.5"/>{inertia}</inertial>
      <collision><origin rpy="{rpy}"/><geometry><cylinder radius="{radius}" length="{width}"/></geometry></collision>"""


def hubbed(radius: float, width: float, *, inwards: float, seen: bool = True) -> str:
    """Return a link whose motor stands out from its wheel towards the robot; what it touches with is a box around both.

    Args:
        radius: Of the wheel [m].
        width: Of its tyre, whose middle is the joint's [m].
        inwards: How far the motor stands out; its sign says to which side (of y) [m].
        seen: Whether there are pictures of tyre and motor, too.
    """
    reach = abs(inwards) + width
    shapes = {
        "visual": {0.0: f'<cylinder radius="{radius}" length="{width}"/>'}
        | {inwards / 2: f'<cylinder radius="{radius / 3}" length="{abs(inwards)}"/>'},
        "collision": {inwards / 2: f'<box size="{2 * radius} {2 * radius} {reach}"/>'},
    }
    parts = "".join(
        f'<{kind}><origin xyz="0 {y} 0" rpy="1.5707963 0 0"/><geometry>{shape}</geometry></{kind}>'
        for kind, placed in shapes.items()
        for y, shape in placed.items()
        if seen or kind == "collision"
    )
    inertia = '<inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/>'
    return f'<inertial><mass value="0.5"/>{inertia}</inertial>{parts}'


def joint(
    name: str, parent: str, child: str, at: str, *, kind: str = "continuous", axis: str = "0 1 0", more: str = ""
) -> str:
    """Return a joint of URDF."""
    return f"""<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>
      <origin {at}/><axis xyz="{axis}"/>{more}</joint>"""


def robot(links: dict[str, str], joints: Sequence[str]) -> str:
    """Return a URDF."""
    parts = "".join(f'<link name="{name}">{has}</link>' for name, has in links.items())
    return f'<?xml version="1.0"?><robot name="odd">{parts}{"".join(joints)}</robot>'


def rover(rows: Sequence[float], *, track: float = 0.4, radius: float = 0.1) -> str:
    """Return a robot with axles at some places ahead of its middle, standing high above z = 0, its axes mirrored."""
    links, joints = {"chassis": box("0.6 0.3 0.15", mass=20.0)}, []
    for number, x in enumerate(rows):
        for side, y in (("l", track / 2), ("r", -track / 2)):
            name = f"{side}{number}"
            links[name] = tyre(radius, 0.06)
            axis = "0 1 0" if side == "l" else "0 -1 0"
            joints.append(joint(f"{name}_hinge", "chassis", name, f'xyz="{x} {y} -0.05"', axis=axis))
    return robot(links, joints)


def on_casters() -> str:
    """Return a robot along y of its file, a wheel deep in a chain, two casters of joints, an arm and a mast."""
    lay = "0 1.5707963 0"
    links = {
        "base_footprint": "",
        "base": box("0.3 0.4 0.1", at="0 0 0.05"),
        "suspension": box("0.02 0.02 0.02", mass=0.1),
        "left": tyre(0.08, 0.03, rpy=lay),
        "right": tyre(0.08, 0.03, rpy=lay),
        "front_plate": box("0.1 0.01 0.05", mass=0.1),
        "rear_plate": box("0.1 0.01 0.05", mass=0.1),
        "arm": box("0.04 0.04 0.3", mass=0.7, at="0 0 0.15"),
        "mast": box("0.03 0.03 0.4", mass=0.3, at="0 0 0.2"),
        "laser_link": box("0.06 0.06 0.04", mass=0.1),
    }
    joints = [
        joint("root", "base_footprint", "base", 'xyz="0 0 0.08"', kind="fixed"),
        joint("lift", "base", "suspension", 'xyz="-0.2 0.02 0"', kind="fixed"),
        joint("drive_a", "suspension", "left", 'xyz="0 -0.02 0"', axis="-1 0 0"),
        joint("drive_b", "base", "right", 'xyz="0.2 0 0" rpy="0 0 3.14159265"', axis="1 0 0"),
        joint("plate_1", "base", "front_plate", 'xyz="0 0.21 0.05"', kind="fixed"),
        joint("plate_2", "base", "rear_plate", 'xyz="0 -0.21 0.05"', kind="fixed"),
        joint("shoulder", "base", "arm", 'xyz="0 0.1 0.1"', kind="revolute", axis="1 0 0", more=LIMITS),
        joint("slide", "base", "mast", 'xyz="0 -0.1 0.1"', kind="prismatic", axis="0 0 1", more=LIMITS),
        joint("laser_joint", "mast", "laser_link", 'xyz="0 0 0.42" rpy="0 0 1.5707963"', kind="fixed"),
    ]
    for name, y in (("caster_front", 0.15), ("caster_back", -0.15)):
        links[f"{name}_fork"] = box("0.02 0.02 0.02", mass=0.1)
        links[name] = tyre(0.03, 0.02, rpy=lay)
        joints += [
            joint(f"{name}_swivel", "base", f"{name}_fork", f'xyz="0 {y} -0.03"', axis="0 0 1"),
            joint(f"{name}_roll", f"{name}_fork", name, 'xyz="0 -0.02 -0.02"', axis="1 0 0"),
        ]
    return robot(links, joints)


LIMITS = '<limit lower="0.1" upper="0.5" effort="1" velocity="1"/>'

STRETCHED = """
<mujoco model="tall">
  <compiler angle="radian" assetdir="assets" autolimits="true"/>
  <option integrator="implicitfast" timestep="0.001"/>
  <default>
    <default class="tall">
      <geom mass="0" solref="0.005 1"/>
      <default class="wheel"><joint axis="0 0 -1" damping=".3"/><motor gear="3"/></default>
      <default class="visual"><geom group="2" type="mesh" contype="0" conaffinity="0"/></default>
      <default class="collision">
        <geom group="3" type="mesh"/>
        <default class="caster"><geom type="sphere" size=".02" pos="-0.24 0 .02" condim="1" priority="1"/></default>
      </default>
    </default>
  </default>
  <asset>
    <texture type="2d" file="sticker.png"/>
    <material name="sticker" texture="sticker"/>
    <material name="black" rgba="0.1 0.1 0.1 1"/>
    <mesh file="base.obj"/>
    <mesh name="base_collision" file="base.stl"/>
    <mesh file="wheel.obj"/>
    <mesh file="mast.dae"/>
  </asset>
  <worldbody>
    <light pos="0 0 3"/>
    <geom name="floor" type="plane" size="5 5 0.1"/>
    <body name="base_link" childclass="tall">
      <freejoint/>
      <geom mesh="base" material="sticker" class="visual"/>
      <geom class="collision" mesh="base_collision" mass="15"/>
      <geom class="collision" type="box" size="0.16 0.16 0.05" pos="-0.1 0 0.1"/>
      <geom class="caster"/>
      <body name="laser" pos="0.004 0 0.1664" quat="0 0 0 1">
        <geom type="cylinder" size="0.03 0.02" contype="0" conaffinity="0" mass="0.2"/>
      </body>
      <body name="link_right_wheel" pos="0 -0.17035 0.0508" quat="1 -1 0 0">
        <joint name="joint_right_wheel" class="wheel"/>
        <geom mesh="wheel" material="black" class="visual" mass="0.15"/>
        <geom class="collision" type="cylinder" size=".05 .0125" pos="0 0 0.0125"/>
      </body>
      <body name="link_left_wheel" pos="0 0.17035 0.0508" quat="1 -1 0 0">
        <joint name="joint_left_wheel" class="wheel"/>
        <geom mesh="wheel" class="visual" mass="0.15"/>
        <geom class="collision" type="cylinder" size=".05 .0125" pos="0 0 -0.0125"/>
      </body>
      <body name="mast" pos="-0.067 0.135 0.03">
        <geom mesh="mast" class="visual"/>
        <geom class="collision" type="box" size="0.03 0.03 0.6" pos="0 0 0.6" mass="1.8"/>
      </body>
      <body name="lift" pos="-0.1 0.13 0.7" gravcomp="1">
        <joint name="joint_lift" type="slide" axis="0 0 1" range="-0.5 0.6" damping="5"/>
        <geom class="collision" type="box" size="0.05 0.05 0.1" mass="3"/>
        <body name="arm" pos="0 -0.2 0">
          <joint name="joint_arm" type="slide" axis="0 -1 0" range="0 0.5"/>
          <geom class="collision" type="capsule" size="0.03 0.1" euler="1.57 0 0" mass="0.7"/>
          <body name="finger" pos="0 -0.2 0">
            <joint name="rubber_x" axis="1 0 0" stiffness="0.05"/>
            <joint name="rubber_y" axis="0 1 0" stiffness="0.05"/>
            <geom type="cylinder" size="0.02 0.005" mass="0.005"/>
          </body>
        </body>
      </body>
      <body name="head" pos="0 0 1.35">
        <joint name="joint_head" axis="0 0 1" range="-3.9 1.5"/>
        <geom class="collision" type="box" size="0.04 0.1 0.03" mass="0.3"/>
        <camera name="camera_rgb" pos="0.05 0 0" quat=".5 .5 -.5 -.5"/>
      </body>
    </body>
  </worldbody>
  <contact><exclude body1="link_left_wheel" body2="base_link"/></contact>
  <tendon>
    <fixed name="forward">
      <joint joint="joint_left_wheel" coef=".5"/>
      <joint joint="joint_right_wheel" coef=".5"/>
    </fixed>
  </tendon>
  <equality><joint joint1="rubber_x" joint2="rubber_y"/></equality>
  <actuator>
    <motor name="forward" tendon="forward" class="wheel"/>
    <position name="lift" joint="joint_lift" kp="500"/>
  </actuator>
  <keyframe><key name="home" qpos="0 0 0 1 0 0 0 0 0 0.2 0 0 0 0"/></keyframe>
</mujoco>
"""
"""Like a mobile manipulator of a public collection: classes, tendons, keyframes, no mesh there, wheels lying down."""


def nose_heavy() -> str:
    """Return a skid-steered robot whose mass lies ahead of the middle of its wheels."""
    links, joints = {"chassis": box("0.5 0.28 0.15", mass=15.0, at="0.05 0 0.15")}, []
    for row, x in (("front", 0.15), ("rear", -0.15)):
        for side, y in (("left", 0.2), ("right", -0.2)):
            links[f"{row}_{side}"] = tyre(0.1, 0.05)
            joints.append(joint(f"{row}_{side}_wheel", "chassis", f"{row}_{side}", f'xyz="{x} {y} 0.1"'))
    return robot(links, joints)


def on_mecanum(*, rollers: int = 0) -> str:
    """Return a robot on four wheels called mecanum, or with rollers of which a name tells nothing."""
    links, joints = {"base": box("0.5 0.3 0.12", mass=15.0, at="0 0 0.08")}, []
    for row, x in (("fore", 0.2), ("aft", -0.2)):
        for side, y in (("l", 0.22), ("r", -0.22)):
            name = f"{row}_{side}" if rollers else f"{row}_{side}_mecanum"
            links[name] = tyre(0.04 if rollers else 0.06, 0.05)
            limit = '<limit effort="5" velocity="12"/>'
            joints.append(joint(f"{name}_joint", "base", name, f'xyz="{x} {y} 0.06"', more=limit))
            for number in range(rollers):
                turn = 2.0 * math.pi * number / rollers
                place = f'xyz="{0.048 * math.sin(turn):.5f} 0 {0.048 * math.cos(turn):.5f}" rpy="0 {turn:.5f} 0"'
                links[f"{name}_{number}"] = tyre(0.012, 0.03, rpy="1.5707963 0 0.785")
                joints.append(joint(f"{name}_{number}_joint", name, f"{name}_{number}", place, axis="0.7 0.7 0"))
    return robot(links, joints)


def on_three(*, first: float = 0.0) -> str:
    """Return a robot on three wheels in a ring, one at an angle [rad] from x."""
    links, joints = {"base": box("0.25 0.25 0.1", mass=8.0, at="0 0 0.08")}, []
    for number in range(3):
        turn = first + 2.0 * math.pi * number / 3
        links[f"w{number}"] = tyre(0.05, 0.02)
        place = f'xyz="{0.15 * math.cos(turn):.5f} {0.15 * math.sin(turn):.5f} 0.05" rpy="0 0 {turn - math.pi / 2:.5f}"'
        joints.append(joint(f"j{number}", "base", f"w{number}", place))
    return robot(links, joints)


def tricycle(*, ahead: float = 0.6, limit: str = '<limit lower="-1.0" upper="1.0" effort="9" velocity="2"/>') -> str:
    """Return a robot with a wheel that steers and two behind or before it."""
    links = {
        "base": box("0.8 0.4 0.2", mass=60.0, at=f"{ahead / 3} 0 0.2"),
        "fork": box("0.05 0.05 0.1", mass=1.0),
        "steered": tyre(0.1, 0.06),
        "l": tyre(0.08, 0.04),
        "r": tyre(0.08, 0.04),
    }
    joints = [
        joint("left", "base", "l", 'xyz="0 0.25 0.08"'),
        joint("right", "base", "r", 'xyz="0 -0.25 0.08"'),
        joint("steer", "base", "fork", f'xyz="{ahead} 0 0.25"', kind="revolute", axis="0 0 1", more=limit),
        joint("drive", "fork", "steered", 'xyz="0 0 -0.15"'),
    ]
    return robot(links, joints)


def four_steered() -> str:
    """Return a robot whose four wheels all steer."""
    links, joints = {"base": box("0.8 0.4 0.2", mass=40.0, at="0 0 0.2")}, []
    limit = '<limit lower="-0.6" upper="0.6" effort="9" velocity="2"/>'
    for row, x in (("front", 0.3), ("rear", -0.3)):
        for side, y in (("left", 0.25), ("right", -0.25)):
            name = f"{row}_{side}"
            links |= {f"{name}_knuckle": box("0.05 0.05 0.05", mass=0.5), f"{name}_wheel": tyre(0.1, 0.05)}
            place = f'xyz="{x} {y} 0.1"'
            joints += [
                joint(f"{name}_steer", "base", f"{name}_knuckle", place, kind="revolute", axis="0 0 1", more=limit),
                joint(f"{name}_roll", f"{name}_knuckle", f"{name}_wheel", 'xyz="0 0 0"'),
            ]
    return robot(links, joints)
