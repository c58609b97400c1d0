"""A model of Gazebo (SDF) as MJCF: its collision shapes as one rigid object, in the colours of its visible shapes."""

from xml.etree.ElementTree import Element, SubElement

import numpy as np

from mjsim.errors import UsageError
from mjsim.geometry import Array
from mjsim.models.colours import color_of
from mjsim.models.rotations import pose_keys
from mjsim.models.sdf.sdf_frames import SdfFrames, floats
from mjsim.models.sdf.sdf_shapes import mesh_of, sizes_of
from mjsim.sentences import Sentence

SCENE = "import it as a world: mjsim new --from"
"""Advice for SDF that is more than a model."""
USUAL = "#808080"
"""Colour of a link without one."""
_HALVES = {
    "box": (0.5, 0.5, 0.5),
    "ellipsoid": (1.0, 1.0, 1.0),
    "sphere": (1.0,),
    "cylinder": (1.0, 0.5),
    "capsule": (1.0, 0.5),
}
"""Shape of SDF that is a geom -> factors on its sizes, since MuJoCo has half of those across the middle."""
DRIVEN = ("drive", "skid", "steer", "planar_move", "mecanum", "omni", "controller")
"""Parts of the names of plug-ins that move a robot."""


def mjcf_of_sdf(root: Element, path: str) -> Element:
    """Return the MJCF of the model in an SDF file; meshes have the names that the file gives them.

    Raises:
        ValueError: It has no model, or one with included models; or a number is wrong.
    """
    models = root.findall("model")
    if len(models) != 1 or root.find("world") is not None:
        raise ValueError(
            Sentence(
                "'{path}' has {count} models beside its worlds; an object has one, else {scene}",
                path,
                len(models),
                SCENE,
            )
        )
    if models[0].find("include") is not None or models[0].find("model") is not None:
        raise ValueError(Sentence("'{path}' has models inside its model; {scene}", path, SCENE))
    made = Element("mujoco")
    SubElement(made, "compiler", angle="radian")
    asset, body = SubElement(made, "asset"), SubElement(SubElement(made, "worldbody"), "body")
    try:
        _add_links(models[0], body, asset, path)
    except UsageError as error:
        raise ValueError(str(error)) from None
    return made


def _add_links(model: Element, body: Element, asset: Element, path: str) -> None:
    frames = SdfFrames(model, path, lambda _: None)
    for link in model.findall("link"):
        color = next(filter(None, map(color_of, link.findall("visual"))), USUAL)
        rgba = " ".join([*(repr(int(color[k : k + 2], 16) / 255) for k in (1, 3, 5)), "1"])
        mass = link.findtext("inertial/mass")
        shapes = [(part, shape) for part in link.findall("collision") for shape in part.findall("geometry/*")]
        for part, shape in shapes:
            if (keys := _geom_keys(shape, asset, path)) is None:
                continue
            geom = SubElement(body, "geom", {**keys, **_placed(frames.pose_in(link, part, path)), "rgba": rgba})
            if mass is not None:
                geom.set("mass", repr(floats(mass, 1, f"{path}: mass")[0] / len(shapes)))


def is_robot(model: Element) -> bool:
    """Return whether a model drives: it has a plug-in for that, or at least two endless hinges and a sensor."""
    plugins = [f"{plugin.get('name', '')} {plugin.get('filename', '')}".lower() for plugin in model.iter("plugin")]
    if any(word in plugin for plugin in plugins for word in DRIVEN):
        return True
    hinges = sum(joint.get("type") in ("revolute", "continuous") for joint in model.iter("joint"))
    return hinges >= 2 and model.find(".//sensor") is not None


def sdf_named_in(config: Element) -> list[str]:
    """Return the SDF files that a model.config names, that of the newest version first."""
    named = [
        ([int(part) if part.isdecimal() else 0 for part in (each.get("version") or "0").split(".")], each.text or "")
        for each in config.iter("sdf")
    ]
    newest = sorted(named, key=lambda entry: entry[0], reverse=True)
    return [name.strip() for _, name in newest if name.strip()]


def _placed(pose: Array) -> dict[str, str]:
    """Return the pose of a geom as attributes of MJCF."""
    return {key: " ".join(f"{value:.9g}" for value in values) for key, values in pose_keys(pose).items()}


def _geom_keys(shape: Element, asset: Element, path: str) -> dict[str, str] | None:
    """Return type and sizes of a geom; None for a plane, which no object has."""
    if shape.tag in _HALVES:
        sizes = np.array(sizes_of(shape, path)) * _HALVES[shape.tag]
        return {"type": shape.tag, "size": " ".join(map(repr, sizes.tolist()))}
    if shape.tag == "mesh":
        name = f"mesh{len(asset)}"
        uri, scale = mesh_of(shape, path)
        if not uri:
            raise ValueError(Sentence("'{path}' has a <mesh> that names no file; give it a <uri>", path))
        file = uri.replace("model://", "package://", 1)
        SubElement(asset, "mesh", name=name, file=file, scale=" ".join(map(repr, scale)))
        return {"type": "mesh", "mesh": name}
    if shape.tag in ("plane", "empty"):
        return None
    raise ValueError(
        Sentence(
            "'{path}' has the shape <{tag}>; make it of boxes, cylinders, spheres and meshes", path, shape.tag[:40]
        )
    )
