"""Which bodies of a model move as one, and the chain of joints that makes an arm."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from mjsim.geometry import Array
from mjsim.models.rigid import SINGLE


@dataclass(frozen=True, slots=True, eq=False)
class ArmTree:
    """The moving bodies of a model, all joints at their reference."""

    model: mujoco.MjModel
    data: mujoco.MjData
    root_of: tuple[int, ...]
    """Of each body the one that carries it rigidly and that joints move; 0 for what no joint moves."""

    @property
    def moving(self) -> tuple[int, ...]:
        """Bodies that joints move, each after the one that carries it."""
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
        """Return the bodies that move as one with a moving body."""
        return [number for number, root in enumerate(self.root_of) if root == body]

    def frame(self, body: int) -> Array:
        """Return the frame of a body in that of the file, shape (4, 4); the file's own for 0."""
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = self.data.xmat[body].reshape(3, 3), self.data.xpos[body]
        return pose

    def path_to(self, body: int) -> list[int]:
        """Return the moving bodies from the base to one, both ends included but the base."""
        path = [body]
        while path[0] and self.parent_of(path[0]):
            path.insert(0, self.parent_of(path[0]))
        return path

    def depth(self, body: int) -> int:
        """Return how many joints there are from a moving body on, those that move it included, on the longest way."""
        return len(self.joints_of(body)) + max(map(self.depth, self.children_of(body)), default=0)

    def with_rigid(self, bodies: Collection[int]) -> "ArmTree":
        """Return it with the joints of some bodies taken as rigid, each at rest within its limits."""
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
    """Return the body at the end of the only chain there is, and the bodies to choose from where there is none.

    A chain that ends in branches that have no more joints than itself ends there: they are fingers.
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
    """Return the moving body at the end of the longest way from one."""
    while children := tree.children_of(body):
        body = max(children, key=tree.depth)
    return body


def carried_by(tree: ArmTree, body: int) -> list[int]:
    """Return all moving bodies that one carries, each after its own carrier."""
    return [other for other in tree.moving if other != body and body in tree.path_to(other)]
