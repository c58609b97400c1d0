"""Joints of SDF: their axes, and the links at their ends."""

from xml.etree.ElementTree import Element

import numpy as np

from mjsim.geometry import Array
from mjsim.models.sdf.sdf_frames import SdfFrames, floats

WORLD = "world"
MAX_HINGE_LIMIT = 1e3
"""Limits of a joint beyond this mean none: SDF writes 1e16 [rad or m]."""


def has_joint_frames(root: Element) -> bool:
    """Return whether an axis is in the frame of its joint unless it says otherwise, as from SDF 1.5 on."""
    version = [int(part) for part in root.get("version", "").split(".") if part.isdecimal()]
    return version >= [1, 5]


def axis_of(axis: Element, frames: SdfFrames, pose: Array, where: str, *, in_joint: bool) -> Array:
    """Return an axis in the frame of the model, shape (3,).

    Args:
        axis: The `<axis>`.
        frames: The frames of the model.
        pose: Pose of the joint in the model, shape (4, 4) [m].
        where: For errors.
        in_joint: Whether it is in the frame of its joint unless it says otherwise.
    """
    xyz = axis.find("xyz")
    vector = np.array(floats("0 0 1" if xyz is None else xyz.text, 3, where))
    frame = "" if xyz is None else xyz.get("expressed_in", "")
    said = (axis.findtext("use_parent_model_frame") or ("false" if in_joint else "true")).strip()
    usual = np.eye(4) if said in ("true", "1") else pose
    turned = frames.frame(frame) if frame else usual
    return np.asarray(turned[:3, :3] @ vector)


def link_named(model: Element, name: str) -> str:
    """Return the link that the end of a joint names, itself or by a frame on it; 'world' for the world."""
    links = {link.get("name") for link in model.findall("link")}
    held = {frame.get("name"): frame.get("attached_to", "__model__") for frame in model.findall("frame")}
    name = name.strip()
    for _ in held:
        if name in links or name not in held:
            break
        name = held[name]
    first = model.find("link")
    return first.get("name", "") if name == "__model__" and first is not None else name
