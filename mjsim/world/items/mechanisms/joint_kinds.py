"""All kinds of joints of mechanisms."""

from typing import Annotated

from mjsim.sentences import Sentence
from mjsim.world.ground import OneOf
from mjsim.world.items.mechanisms import joints, many_joints
from mjsim.world.items.mechanisms.joints import MechanismJoint

JOINTS: dict[str, type[MechanismJoint]] = {
    "weld": joints.WeldJoint,
    "revolute": joints.RevoluteJoint,
    "prismatic": joints.PrismaticJoint,
    "cylindrical": joints.CylindricalJoint,
    "planar": joints.PlanarJoint,
    "in_plane": joints.InPlaneJoint,
    "universal": many_joints.UniversalJoint,
    "gimbal": many_joints.GimbalJoint,
    "spherical": joints.SphericalJoint,
    "bearing": many_joints.BearingJoint,
    "telescoping": many_joints.TelescopingJoint,
    "bushing": many_joints.BushingJoint,
    "screw": many_joints.ScrewJoint,
    "six_dof": many_joints.SixDofJoint,
    "custom": many_joints.CustomJoint,
}
"""Joints by the key that names their kind."""


Jointed = Annotated[
    joints.WeldJoint
    | joints.RevoluteJoint
    | joints.PrismaticJoint
    | joints.CylindricalJoint
    | joints.PlanarJoint
    | joints.InPlaneJoint
    | many_joints.UniversalJoint
    | many_joints.GimbalJoint
    | joints.SphericalJoint
    | many_joints.BearingJoint
    | many_joints.TelescopingJoint
    | many_joints.BushingJoint
    | many_joints.ScrewJoint
    | many_joints.SixDofJoint
    | many_joints.CustomJoint,
    OneOf(JOINTS, Sentence("a joint needs a kind as a key: {joints}; such as revolute: NAME", ", ".join(JOINTS))),
]
