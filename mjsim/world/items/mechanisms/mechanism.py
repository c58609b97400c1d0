"""A mechanism: its bodies, joints, actuators and sensors."""

import math
from collections.abc import Iterator
from functools import cached_property
from typing import TYPE_CHECKING, Self

from pydantic import PrivateAttr, ValidationInfo, model_validator

from mjsim.errors import did_you_mean
from mjsim.sentences import Sentence
from mjsim.world.files import BUILT, Source, read_asset
from mjsim.world.ground import Degrees, Metres, Name, Point, TakenNames, fault, reserved_fault
from mjsim.world.items.mechanisms.joint_kinds import Jointed
from mjsim.world.items.mechanisms.mechanism_items import MechanismParts
from mjsim.world.items.mechanisms.mechanism_links import MechanismBody
from mjsim.world.items.mechanisms.points import GROUND

if TYPE_CHECKING:  # Imported where it is used: worlds without mechanisms load faster.
    from mjsim.geometry import Array
    from mjsim.mechanics import TreeJoint
    from mjsim.world.items.mechanisms.assembly import Assembly

DRAWN = 64
"""Number of segments of a curve, to find its extent."""


class Mechanism(MechanismParts):
    """Bodies connected by joints to the ground and to each other, with or without closed loops."""

    name: Name
    """Name; in the scene, bodies are `NAME/BODY` and joints `NAME/JOINT`."""
    at: Point = (0.0, 0.0)
    """Position of its frame, [x, y] [m]."""
    heading_deg: Degrees = 0.0
    """Direction of the x axis of its frame, counter-clockwise from x."""
    elevation: Metres = 0.0
    """Height of its frame above the floor [m]."""
    collide: bool = False
    """Whether its bodies collide with each other."""
    group: Name | None = None
    """Group that the studio selects, moves and rotates together; no effect on runs."""
    _source: Source = PrivateAttr(default=BUILT)

    @model_validator(mode="after")
    def _holds_together(self, info: ValidationInfo) -> Self:
        source = (info.context or {}).get("source")
        if isinstance(source, Source):
            self._source = source
        if message := reserved_fault(self.name):
            raise fault(message, "name")
        for message, path in self._taken():
            raise fault(message, *path)
        _ = self.assembly
        return self

    def _taken(self) -> Iterator[tuple[str, tuple[str | int, ...]]]:
        taken = TakenNames()
        lists = {"bodies": [item.name for item in self.bodies], "joints": [item.name for item in self.joints]}
        lists["constraints"] = [item.called(number) for number, item in enumerate(self.constraints)]
        for kind, names in lists.items():
            for number, name in enumerate(names):
                if message := taken.fault(name, f"{kind}[{number}]"):
                    yield message, (kind, number)
                if name == GROUND:
                    yield Sentence("'{ground}' is the fixed frame; give another name", GROUND), (kind, number)

    @cached_property
    def assembly(self) -> "Assembly":
        """Its assembly, and how it starts."""
        from mjsim.world.items.mechanisms.beginning import assemble

        return assemble(self, lambda name: read_asset(name, self._source))

    @cached_property
    def held(self) -> frozenset[str]:
        """Names of the single values that a hand can hold by force: no motion prescribes them."""
        undriven, _ = self._movable
        return frozenset(self._single(undriven).union(*self.balls.values()))

    @cached_property
    def driven(self) -> frozenset[str]:
        """Names of the single values that motions move: their own, or others and distances through loops."""
        found, (_, driven) = self.assembly, self._movable
        columns = {drive.column for drive in found.drives if drive.column >= 0}
        return frozenset(self._single(driven | columns, balls=True) - self.held)

    @cached_property
    def balls(self) -> dict[str, tuple[str, ...]]:
        """By joint with a ball that a hand can hold: the names of the three values of its rotation vector."""
        found, (undriven, _), balls = self.assembly, self._movable, {}
        for tree in self._trees():
            kinds = [primitive.kind for primitive in tree.primitives]
            if "ball" in kinds:
                first = tree.columns()[kinds.index("ball")]
                if not undriven.isdisjoint(range(first, first + 3)):
                    balls[tree.name] = found.names[first : first + 3]
        return balls

    @cached_property
    def _movable(self) -> tuple[frozenset[int], frozenset[int]]:
        return self.assembly.movable()

    def _trees(self) -> "list[TreeJoint]":
        """Return the joints, and the positions of points along curves."""
        return [tree for tree in self.assembly.linkage.joints if tree.name in self.assembly.columns]

    def _single(self, columns: frozenset[int] | set[int], *, balls: bool = False) -> set[str]:
        """Return the names of the values in some columns, those of ball joints if requested."""
        return {
            self.assembly.names[column + number]
            for tree in self._trees()
            for primitive, column in zip(tree.primitives, tree.columns(), strict=True)
            for number in range(primitive.width)
            if column + number in columns and (balls or primitive.kind != "ball")
        }

    @cached_property
    def world_from_ground(self) -> "Array":
        """Pose of its frame, world_from_mechanism, shape (4, 4) [m]."""
        from mjsim.mechanics import placed

        return placed((*self.at, self.elevation), (0.0, 0.0, math.radians(self.heading_deg)))

    def poses(self, values: "Array | None" = None) -> dict[str, "Array"]:
        """Return world_from_body of each body by its name, shape (4, 4) [m].

        Args:
            values: Joint values, shape (values,) [rad, m]; by default those at the start.
        """
        found = self.assembly
        placed = found.linkage.place(found.start if values is None else values).poses
        return {body.name: self.world_from_ground @ placed[found.number(body.name)] for body in self.bodies}

    def spanned(self, values: "Array | None" = None) -> "Array":
        """Return the corners of a bounding box of its bodies and curves for joint values, shape (2, 3) [m]."""
        import numpy as np

        lows, highs = [], []
        for name, pose in self.poses(values).items():
            points, radius = self.body(name).hull()
            placed = points @ pose[:3, :3].T + pose[:3, 3]
            lows.append(placed.min(axis=0) - radius)
            highs.append(placed.max(axis=0) + radius)
        for points in self._curves(values):
            lows.append(points.min(axis=0))
            highs.append(points.max(axis=0))
        return np.array([np.min(lows, axis=0), np.max(highs, axis=0)])

    def _curves(self, values: "Array | None") -> "Iterator[Array]":
        """Yield points of its curves, world frame, shape (n, 3) [m]."""
        found = self.assembly
        placed = found.linkage.place(found.start if values is None else values) if found.tracks else None
        for track in found.tracks:
            joint = found.linkage.joints[track.ghost - 1]
            curve = joint.primitives[0].curve
            if placed is not None and curve is not None:
                pose = self.world_from_ground @ placed.poses[joint.parent] @ joint.before
                yield curve.sampled(DRAWN) @ pose[:3, :3].T + pose[:3, 3]

    def body(self, name: str) -> MechanismBody:
        """Return a body by its name."""
        return next(body for body in self.bodies if body.name == name)

    def joint(self, name: str) -> Jointed:
        """Return a joint by its name.

        Raises:
            ValueError: It does not exist.
        """
        for joint in self.joints:
            if joint.name == name:
                return joint
        raise ValueError(
            Sentence(
                "no joint '{name}' in this mechanism{meant}",
                name,
                did_you_mean(name, [each.name for each in self.joints]),
            )
        )
