"""Sizes of the shapes of SDF."""

from collections.abc import Mapping, Sequence
from xml.etree.ElementTree import Element

from mjsim.models.sdf.sdf_frames import floats

_ROUND: Mapping[str, Sequence[str]] = {
    "sphere": ("radius",),
    **dict.fromkeys(("cylinder", "capsule", "cone"), ("radius", "length")),
}
"""Round shape -> its elements with sizes."""


def sizes_of(shape: Element, where: str) -> list[float]:
    """Return the sizes of a shape [m]: x, y, z of a box or half an ellipsoid, else radius and length; none for others.

    Raises:
        UsageError: A size is missing or no number.
    """
    if shape.tag == "box":
        return floats(shape.findtext("size"), 3, f"{where}: size of a box")
    if shape.tag == "ellipsoid":
        return floats(shape.findtext("radii"), 3, f"{where}: radii of an ellipsoid")
    keys = _ROUND.get(shape.tag, ())
    return [floats(shape.findtext(key), 1, f"{where}: {key} of a {shape.tag}")[0] for key in keys]


def mesh_of(shape: Element, where: str) -> tuple[str, list[float]]:
    """Return the name of the file of a `<mesh>`, and its scale along x, y and z.

    Raises:
        UsageError: The scale is not three numbers.
    """
    return (shape.findtext("uri") or "").strip(), floats(shape.findtext("scale", "1 1 1"), 3, f"{where}: scale")
