"""The `<state>` of a world that Gazebo saved: it puts models and links where they were then."""

from collections.abc import Callable
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from mjsim.exchange.scenes.scene_solids import Scene
from mjsim.inventory import Fate
from mjsim.mechanics import rpy_of
from mjsim.models import SdfFrames, link_named, own_pose

SAVED = "the state which Gazebo saved"
TOLERANCE = 0.01
"""Differences of links from their poses in a model that are ignored, as from settling [m, or of a direction]."""


def restore(world: Element, scene: Scene, model_of: Callable[[Element], tuple[Element, SdfFrames] | None]) -> None:
    """Put the models and links of a world where its first state has them, and report those that stay elsewhere.

    Args:
        world: The `<world>`; poses in it are replaced.
        scene: Notes what became of the state.
        model_of: Returns the model in an element, which may include a file, and its frames; None if there is none.
    """
    saved = {each.get("name"): each for each in world.findall("state[1]/model")}
    for placed in world.findall("model") + world.findall("include"):
        name = placed.get("name") or (placed.findtext("name") or "").strip()
        state = saved.get(name)
        pose = None if state is None else state.find("pose")
        if state is None or pose is None:
            continue
        found = model_of(placed)
        if found is not None:
            _restore_links(*found, state, name, scene, is_shared=placed.tag == "include")
        for old in placed.findall("pose"):
            if (old.text or "").split() != (pose.text or "").split():
                scene.tell(Fate.KEPT, "place", name, f"that in {SAVED}")
            placed.remove(old)
        placed.append(pose)
        if any(word.strip("0") not in ("1.", "1") for word in (state.findtext("scale") or "").split()):
            scene.tell(Fate.LEFT_OUT, "scale", name, f"{SAVED}; it has the size of its model")
    for kind in ("insertions", "deletions"):
        for each in world.findall(f"state[1]/{kind}/*"):
            scene.tell(Fate.LEFT_OUT, f"state of Gazebo: {kind}", each.get("name") or each.text or "", "not applied")


def _restore_links(
    model: Element, frames: SdfFrames, state: Element, name: str, scene: Scene, *, is_shared: bool
) -> None:
    """Move the links of a model; their poses in a state are those in the world."""
    where = f"{frames.where}: state of {name}"
    model_from_world = np.linalg.inv(own_pose(state, where)[0])
    links = {link.get("name"): link for link in model.findall("link")}
    ends = [joint.findtext(end) or "" for joint in model.findall("joint") for end in ("parent", "child")]
    jointed = {link_named(model, end) for end in ends}
    moved = []
    for saved in state.findall("link"):
        link = links.get(saved.get("name"))
        if link is None or saved.find("pose") is None:
            continue
        pose = model_from_world @ own_pose(saved, where)[0]
        if np.abs(pose - frames.pose_of(link)).max() <= TOLERANCE:
            continue
        label = f"{name}::{link.get('name')}"
        if is_shared or link.get("name") in jointed:
            why = "an included model" if is_shared else "on a joint"
            scene.tell(Fate.LEFT_OUT, "place of a link", label, f"that in {SAVED}: it is {why}; it stays")
        else:
            scene.tell(Fate.KEPT, "place of a link", label, f"that in {SAVED}")
            moved.append((link, pose))
    # All are compared before one is moved, as links may be placed relative to each other.
    for link, pose in moved:
        for old in link.findall("pose"):
            link.remove(old)
        SubElement(link, "pose").text = " ".join(map(repr, [*pose[:3, 3].tolist(), *rpy_of(pose).tolist()]))
