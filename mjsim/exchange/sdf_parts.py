"""Elements of SDF: single-link models, boxes, prisms, materials."""

from collections.abc import Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from mjsim.geometry import Array

NO_METAL, ROUGH = "0", "1"


@dataclass(frozen=True, slots=True)
class Appearance:
    """Appearance and friction of a surface."""

    color: str
    """'#rrggbb'."""
    friction: float | None = None
    """Coefficient of friction; None for Gazebo's default."""
    picture: str | None = None
    """File name of an image beside the SDF file."""


def numbers(*values: float) -> str:
    """Return numbers as text for SDF."""
    return " ".join(f"{value + 0.0:.9g}" for value in values)


def pose_of(point: Array, frame: Array) -> tuple[float, ...]:
    """Return x, y, z [m], roll, pitch, yaw [rad] of a frame: origin, shape (3,) [m], and axes, shape (3, 3)."""
    from scipy.spatial.transform import Rotation

    # SDF rotates about the fixed axes x, y and z, in this order.
    return tuple(np.concatenate([point, Rotation.from_matrix(frame).as_euler("xyz")]).tolist())


def add_link(
    place: Element,
    name: str,
    *,
    at: Sequence[float] = (),
    mass: float | None = None,
    size: Sequence[float] = (1.0, 1.0, 1.0),
    center: Sequence[float] | None = None,
) -> Element:
    """Add a model with one link, and return the link.

    Args:
        place: The world element.
        name: Name of the model.
        at: x, y, z [m], and roll, pitch, yaw if rotated [rad].
        mass: Mass of a movable model [kg]; None for a static one.
        size: Sizes x, y, z of the box used for the inertia [m].
        center: Centre of mass, in the link's frame [m]; by default the centre of the box standing on the floor.
    """
    model = SubElement(place, "model", name=name)
    if mass is None:
        SubElement(model, "static").text = "true"
    if at:
        SubElement(model, "pose").text = _pose(at)
    link = SubElement(model, "link", name="link")
    if mass is not None:
        inertial = SubElement(link, "inertial")
        SubElement(inertial, "pose").text = _pose(center or (0.0, 0.0, size[2] / 2))
        SubElement(inertial, "mass").text = numbers(mass)
        inertia = SubElement(inertial, "inertia")
        x, y, z = (side**2 for side in size)
        for key, value in (("ixx", y + z), ("iyy", x + z), ("izz", x + y), ("ixy", 0.0), ("ixz", 0.0), ("iyz", 0.0)):
            SubElement(inertia, key).text = numbers(mass * value / 12)
    return link


def add_geometry(
    link: Element,
    name: str,
    shape: str,
    sizes: Sequence[tuple[str, str]],
    *,
    at: Sequence[float] = (),
    appearance: Appearance,
    collides: bool = True,
) -> None:
    """Add a shape to a link as visual, and as collision if it collides.

    Args:
        link: The link.
        name: Unique in the link.
        shape: Name of the SDF element: plane, cylinder, sphere.
        sizes: Child elements of the shape and their texts, in order.
        at: x, y, z [m], and roll, pitch, yaw if rotated [rad], in the link's frame.
        appearance: Surface of the shape.
        collides: Whether to add a collision.
    """
    for kind in ("collision", "visual") if collides else ("visual",):
        part = SubElement(link, kind, name=name)
        if at:
            SubElement(part, "pose").text = _pose(at)
        element = SubElement(SubElement(part, "geometry"), shape)
        for key, value in sizes:
            SubElement(element, key).text = value
        if kind == "visual":
            _add_appearance(part, appearance)
        elif appearance.friction is not None:
            mu = SubElement(SubElement(SubElement(part, "surface"), "friction"), "ode")
            SubElement(mu, "mu").text = SubElement(mu, "mu2").text = numbers(appearance.friction)


def add_box(
    link: Element,
    name: str,
    size: Sequence[float],
    *,
    at: Sequence[float] = (),
    appearance: Appearance,
) -> None:
    """Add a box with full sizes x, y, z [m]; the other arguments are those of `add_geometry`."""
    add_geometry(link, name, "box", [("size", numbers(*size))], at=at, appearance=appearance)


def add_prism(
    link: Element,
    name: str,
    outline: Array,
    height: float,
    *,
    at: Sequence[float] = (),
    appearance: Appearance,
) -> None:
    """Add an outline, shape (n, 2) [m], extruded along z by a height [m]; other arguments as in `add_geometry`."""
    corners = [("point", numbers(x, y)) for x, y in outline.tolist()]
    add_geometry(link, name, "polyline", [*corners, ("height", numbers(height))], at=at, appearance=appearance)


def _add_appearance(visual: Element, appearance: Appearance) -> None:
    material = SubElement(visual, "material")
    tone = numbers(*(int(appearance.color[at : at + 2], 16) / 255 for at in (1, 3, 5)), 1)
    SubElement(material, "ambient").text = SubElement(material, "diffuse").text = tone
    if appearance.picture is not None:
        metal = SubElement(SubElement(material, "pbr"), "metal")
        SubElement(metal, "albedo_map").text = appearance.picture
        SubElement(metal, "metalness").text, SubElement(metal, "roughness").text = NO_METAL, ROUGH


def _pose(at: Sequence[float]) -> str:
    return numbers(*[*at, 0.0, 0.0, 0.0][:6])
