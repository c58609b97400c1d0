"""Scales of meshes in URDF that MuJoCo does not take as people write them."""

from collections.abc import Iterator
from xml.etree.ElementTree import Element

AXES = 3


def mend_scales(root: Element) -> Iterator[str]:
    """Write three numbers for each scale of a mesh, one standing for all axes; yield a sentence of what was done."""
    count = 0
    for mesh in root.iter("mesh"):
        numbers = mesh.get("scale", "").replace(",", " ").split()
        if numbers and (len(numbers) != AXES or "," in mesh.get("scale", "")) and len(numbers) in (1, AXES, AXES + 1):
            mesh.set("scale", " ".join(numbers * AXES if len(numbers) == 1 else numbers[:AXES]))
            count += 1
    if count:
        yield f"the scale of {count} mesh{'es' * (count != 1)}, which had other than three numbers"
