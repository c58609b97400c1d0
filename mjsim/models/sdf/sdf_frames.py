"""Poses of SDF: numbers of `<pose>`, and the frames that they are relative to."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from xml.etree.ElementTree import Element

import numpy as np

from mjsim.errors import UsageError
from mjsim.geometry import Array
from mjsim.sentences import Sentence

FRAMED = ("link", "frame", "model", "joint", "include")
"""Elements whose names are frames."""


def pose_matrix(numbers: list[float], *, degrees: bool = False, quaternion: bool = False) -> Array:
    """Return the transform of a pose, shape (4, 4).

    Args:
        numbers: x, y, z [m], and roll, pitch, yaw about fixed axes [rad], or a quaternion x, y, z, w.
        degrees: Whether angles are in degrees.
        quaternion: Whether the rotation is a quaternion.

    Raises:
        ValueError: The count of numbers is wrong, or the quaternion is zero.

    References:
        SDFormat specification, Pose Frame Semantics.
    """
    from scipy.spatial.transform import Rotation

    if len(numbers) != (7 if quaternion else 6):
        raise ValueError(Sentence("a pose has {count} numbers", len(numbers)))
    turned = numbers[3:]
    turn = Rotation.from_quat(turned) if quaternion else Rotation.from_euler("xyz", turned, degrees=degrees)
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = turn.as_matrix(), numbers[:3]
    return pose


def floats(text: str | None, count: int, where: str) -> list[float]:
    """Return the finite numbers of a text.

    Raises:
        UsageError: It has another count of numbers, or something else.
    """
    words = (text or "").split()
    try:
        numbers = [float(word) for word in words]
    except ValueError:
        numbers = []
    if len(numbers) != count or not all(map(math.isfinite, numbers)):
        asked = "a finite number" if count == 1 else f"{count} finite numbers"
        raise UsageError(Sentence("{where}: '{text:.40}' is not {asked}", where, (text or "").strip(), asked))
    return numbers


def own_pose(element: Element, where: str) -> tuple[Array, str]:
    """Return the transform in the `<pose>` of an element, and the frame that it names; '' for the usual one."""
    pose = element.find("pose")
    if pose is None:
        return np.eye(4), ""
    # SDF 1.5 and 1.6 have an attribute 'frame', which Gazebo ignored.
    frame = pose.get("relative_to") or ""
    if not (pose.text or "").strip():
        return np.eye(4), frame
    quaternion = pose.get("rotation_format") == "quat_xyzw"
    numbers = floats(pose.text, 7 if quaternion else 6, f"{where}: pose")
    try:
        return pose_matrix(numbers, degrees=pose.get("degrees") in ("true", "1"), quaternion=quaternion), frame
    except ValueError as error:
        raise UsageError(Sentence("{where}: {error}", where, error)) from None


@dataclass(slots=True)
class SdfFrames:
    """The frames of one model, or of the world, by name; poses are in the frame of the model."""

    element: Element
    where: str
    inner: Callable[[Element], "SdfFrames | None"]
    """Returns the frames of a nested model or include."""
    _named: Mapping[str, Element] = field(init=False)
    _poses: dict[str, Array] = field(default_factory=dict)
    _open: set[str] = field(default_factory=set)

    def __post_init__(self) -> None:
        """Find the named elements."""
        # Before SDF 1.7, a joint could have the name of a link; then the link is meant.
        ordered = sorted(self.element, key=lambda child: child.tag != "joint")
        self._named = {
            name: child
            for child in ordered
            if child.tag in FRAMED and (name := child.get("name") or (child.findtext("name") or "").strip())
        }

    def _included(self, name: str) -> Element | None:
        """Return the include without a name of its own whose model has a name."""
        for child in self.element.findall("include"):
            inner = self.inner(child) if child.find("name") is None else None
            if inner is not None and inner.element.get("name") == name:
                return child
        return None

    def pose_of(self, element: Element) -> Array:
        """Return the pose of a child, such as a link or a nested model, in the frame of the model."""
        where = f"{self.where}: <{element.tag} '{element.get('name', '')}'>"
        pose, frame = own_pose(element, where)
        if not frame and element.tag == "frame":
            frame = element.get("attached_to", "")
        if not frame and element.tag == "joint":
            frame = (element.findtext("child") or "").strip()
        pose = self.frame(frame) @ pose if frame else pose
        held = element.get("placement_frame") or (element.findtext("placement_frame") or "").strip()
        inner = self.inner(element) if held else None
        return pose if inner is None else pose @ np.linalg.inv(inner.frame(held))

    def pose_in(self, link: Element, part: Element, where: str) -> Array:
        """Return the pose of a part of a link, such as a collision, in the frame of the model."""
        pose, frame = own_pose(part, where)
        return np.asarray((self.frame(frame) if frame else self.pose_of(link)) @ pose)

    def frame(self, name: str) -> Array:
        """Return the pose of a frame.

        Raises:
            UsageError: There is no such frame, or it is relative to itself.
        """
        if name in ("", "__model__", "world", "__root__"):
            return np.eye(4)
        if name in self._poses:
            return self._poses[name]
        if name in self._open:
            raise UsageError(Sentence("{where}: the frame '{name:.40}' is relative to itself", self.where, name))
        self._open.add(name)
        head, _, rest = name.partition("::")
        element = self._named[head] if head in self._named else self._included(head)
        if element is None:
            raise UsageError(
                Sentence(
                    "{where}: no frame '{name:.40}'; frames are {names}",
                    self.where,
                    name,
                    ", ".join(sorted(self._named)[:10]),
                )
            )
        pose = self.pose_of(element)
        if rest:
            inner = self.inner(element)
            pose = pose if inner is None else pose @ inner.frame(rest)
        self._open.discard(name)
        self._poses[name] = pose
        return pose
