"""The rigid parts of a model, and the chain of joints that forms an arm."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from mjsim.geometry import Array
from mjsim.models.rigid import SINGLE
from mjsim.models.rotations import frame_at


@dataclass(frozen=True, slots=True, eq=False)
class ArmTree:
    """The moving bodies of a model, with all joints at their reference positions."""

    model: mujoco.MjModel
    data: mujoco.MjData
    root_of: tuple[int, ...]
    """For each body the moving body to which it is rigidly attached; 0 for the fixed base."""

    @property
    def moving(self) -> tuple[int, ...]:
        """Bodies that joints move, parents first."""
        return tuple(sorted(set(self.root_of) - {0}))

    def parent_of(self, body: int) -> int:
        """Return the moving body that carries another one; 0 for the base."""
        return self.root_of[int(self.model.body_parentid[body])] if body else 0

    def children_of(self, body: int) -> list[int]:
        """Return the moving bodies that a body carries."""
        return [other for other in self.moving if self.parent_of(other) == body]

    def joints_of(self, body: int) -> list[int]:
        """Return the joints between a moving body and its carrier."""
        first, count = int(self.model.body_jntadr[body]), int(self.model.body_jntnum[body])
        return [joint for joint in range(first, first + count) if int(self.model.jnt_type[joint]) in SINGLE]

    def bodies_of(self, body: int) -> list[int]:
        """Return the bodies rigidly attached to a moving body, including itself."""
        return [number for number, root in enumerate(self.root_of) if root == body]

    def frame(self, body: int) -> Array:
        """Return the frame of a body in the file frame, shape (4, 4) [m]; the identity for 0."""
        return frame_at(self.data.xpos[body], self.data.xmat[body])

    def path_to(self, body: int) -> list[int]:
        """Return the moving bodies on the path from the base, exclusive, to a body, inclusive."""
        path = [body]
        while path[0] and self.parent_of(path[0]):
            path.insert(0, self.parent_of(path[0]))
        return path

    def depth(self, body: int) -> int:
        """Return the number of joints on the longest path from a moving body on, including its own."""
        return len(self.joints_of(body)) + max(map(self.depth, self.children_of(body)), default=0)

    def with_rigid(self, bodies: Collection[int]) -> "ArmTree":
        """Return the tree with the joints of some bodies made rigid, each at rest within its limits."""
        model, data = self.model, mujoco.MjData(self.model)
        for joint in (joint for body in bodies for joint in self.joints_of(body)):
            if model.jnt_limited[joint]:
                address = model.jnt_qposadr[joint]
                data.qpos[address] = np.clip(data.qpos[address], *model.jnt_range[joint])
        _place(model, data)
        return replace(self, data=data, root_of=_roots(model, {*self.moving} - {*bodies}))


def tree_of(model: mujoco.MjModel) -> ArmTree:
    """Return the moving bodies of a model."""
    data = mujoco.MjData(model)
    _place(model, data)
    moving = {int(model.jnt_bodyid[joint]) for joint in range(model.njnt) if int(model.jnt_type[joint]) in SINGLE}
    return ArmTree(model, data, _roots(model, moving))


def _place(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)


def _roots(model: mujoco.MjModel, moving: Collection[int]) -> tuple[int, ...]:
    roots = [0]
    for body in range(1, model.nbody):
        roots.append(body if body in moving else roots[int(model.body_parentid[body])])
    return tuple(roots)


def chain_to(tree: ArmTree) -> tuple[int, Sequence[int]]:
    """Return the body at the end of the only chain, and the candidates if there is no unique chain.

    A chain ends before branches that have no more joints than itself: these are fingers.
    """
    body, joints = 0, 0
    while True:
        children = tree.children_of(body)
        if not children:
            return body, ()
        if len(children) > 1:
            deepest = max(map(tree.depth, children))
            return body, () if 0 < deepest <= joints else [_tip(tree, child) for child in children]
        body = children[0]
        joints += len(tree.joints_of(body))


def _tip(tree: ArmTree, body: int) -> int:
    """Return the moving body at the end of the longest path from a body."""
    while children := tree.children_of(body):
        body = max(children, key=tree.depth)
    return body


def carried_by(tree: ArmTree, body: int) -> list[int]:
    """Return all moving bodies carried by a body, parents first."""
    return [other for other in tree.moving if other != body and body in tree.path_to(other)]
