"""Sizes of the shapes of SDF."""

from collections.abc import Mapping
from xml.etree.ElementTree import Element

from mjsim.errors import UsageError
from mjsim.models.sdf.sdf_frames import floats
from mjsim.sentences import Sentence

MAX_SIZE = 1e4
"""Maximum size of a shape [m]."""
_SIZES: Mapping[str, Mapping[str, int]] = {
    "box": {"size": 3},
    "ellipsoid": {"radii": 3},
    "sphere": {"radius": 1},
    **{shape: {"radius": 1, "length": 1} for shape in ("cylinder", "capsule", "cone")},
}
"""Shape -> its elements with sizes, and how many numbers each has."""


def sizes_of(shape: Element, where: str) -> list[float]:
    """Return the sizes of a shape [m]: x, y, z of a box or half an ellipsoid, else radius and length; none for others.

    Raises:
        UsageError: A size is missing, no number, negative, or too large.
    """
    sizes = []
    for key, count in _SIZES.get(shape.tag, {}).items():
        text = (shape.findtext(key) or "").strip()
        if not text:
            raise UsageError(
                Sentence("{where}: its <{tag}> has no <{key}>; give it one, or remove the shape", where, shape.tag, key)
            )
        found = floats(text, count, f"{where}: {key} of a {shape.tag}")
        if not all(0.0 <= size <= MAX_SIZE for size in found):
            raise UsageError(
                Sentence(
                    "{where}: {key} of a {tag}: '{text:.40}' must be above 0, up to {max_size:g} m",
                    where,
                    key,
                    shape.tag,
                    text,
                    MAX_SIZE,
                )
            )
        sizes += found
    return sizes


def mesh_of(shape: Element, where: str) -> tuple[str, list[float]]:
    """Return the name of the file of a `<mesh>`, and its scale along x, y and z.

    Raises:
        UsageError: The scale is not three numbers.
    """
    return (shape.findtext("uri") or "").strip(), floats(shape.findtext("scale", "1 1 1"), 3, f"{where}: scale")
