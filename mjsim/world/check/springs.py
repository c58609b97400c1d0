"""Checks for springs and dampers too stiff for the masses they act on: the physics would diverge within a few steps."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from mjsim.geometry import Array
from mjsim.mechanics import Apart, Linear, Rows, jacobian
from mjsim.sentences import Sentence
from mjsim.world.check.overlaps import Finding
from mjsim.world.items import Assembly, Mechanism, World, mass_matrix

MAX_GROWTH = 1.001
"""Growth of a motion in a step of the physics above which it diverges within seconds."""
NO_RANK = 1e-9
"""Singular values below this, relative to the largest, count as zero."""
SHORTER_MS = (2, 1)
"""Shorter steps that a run may have [ms]."""


def diverging_springs(world: World) -> Iterator[Finding]:
    """Yield a spring of each mechanism that needs a shorter step of the physics, or more mass."""
    for number, mechanism in enumerate(world.mechanisms):
        parts = _parts(mechanism)
        if not parts or mechanism.mode in ("inverse", "kinematics"):
            continue
        swing = _Swing(mechanism, parts)
        if swing.growth(world.run.step) <= MAX_GROWTH:
            continue
        worst = swing.stiffest(world.run.step)
        good = [ms for ms in SHORTER_MS if ms < 1e3 * world.run.step and swing.growth(ms / 1e3) <= MAX_GROWTH]
        remedy = Sentence("use run: {{step_ms: {good}}}, or make it", good[0]) if good else "make it"
        yield (
            Sentence(
                "{name} is too stiff for the mass that it moves in steps of {step:g} ms, and the physics"
                " would fail; {remedy} softer or what it moves heavier",
                *(worst.name, 1e3 * world.run.step, remedy),
            ),
            ("mechanisms", number, *worst.path),
        )


@dataclass(frozen=True, slots=True, eq=False)
class _Part:
    """A spring with a damper, between two points or along one value of a joint."""

    name: str
    path: tuple[str | int, ...]
    slope: Array
    """Derivative of its length by the values at the start, shape (values,)."""
    stiffness: float
    damping: float
    of_joint: bool


def _parts(mechanism: Mechanism) -> list[_Part]:
    found, parts = mechanism.assembly, list[_Part]()
    units = np.eye(found.linkage.size)
    for number, joint in enumerate(mechanism.all_joints):
        path = ("joints", number) if number < len(mechanism.joints) else mechanism.written(number)
        figures = zip(found.columns[joint.name], joint.figures("stiffness"), joint.figures("damping"), strict=True)
        parts += [
            _Part(Sentence("joint '{name}'", joint.name), path, units[c], k, d, of_joint=True)
            for c, k, d in figures
            if k or d
        ]
    placed = found.linkage.place(found.start)
    for number, item in enumerate(mechanism.constraints):
        for spring in found.springs:
            if spring.name == item.called(number):
                slope = Apart(spring.ends, 0.0).jacobian(found.linkage, placed, found.start)[0]
                path = ("constraints", number)
                parts.append(
                    _Part(
                        Sentence("spring '{name}'", spring.name),
                        path,
                        slope,
                        spring.stiffness,
                        spring.damping,
                        of_joint=False,
                    )
                )
    return parts


class _Swing:
    """Small motions of a mechanism about its start that its constraints allow."""

    def __init__(self, mechanism: Mechanism, parts: list[_Part]) -> None:
        found = mechanism.assembly
        allowed = _allowed(found)
        self._parts = parts
        self._mass = allowed.T @ mass_matrix(mechanism, found, found.start) @ allowed
        self._slopes = np.array([part.slope for part in parts]) @ allowed
        self._stiffness = np.array([part.stiffness for part in parts])
        self._damping = np.array([part.damping for part in parts])
        self._of_joint = np.array([part.of_joint for part in parts])

    def growth(self, step: float) -> float:
        """Return the largest ratio by which a motion grows in a step [s].

        Euler's method of MuJoCo: v' = v - h (M + h D)^-1 (C v + K x), x' = x + h v', where D is the damping of the
        joints, and C that of the springs as well.
        """
        count = len(self._mass)
        if not count:
            return 0.0
        by = np.linalg.inv(self._effective(step)) * step
        pull, drag = by @ self._summed(self._stiffness), by @ self._summed(self._damping)
        speed = np.hstack([np.eye(count) - drag, -pull])
        place = np.hstack([step * speed[:, :count], np.eye(count) + step * speed[:, count:]])
        return float(np.abs(np.linalg.eigvals(np.vstack([speed, place]))).max())

    def stiffest(self, step: float) -> _Part:
        """Return the spring that changes a speed most in a step [s]."""
        eased = np.einsum("ij,jk,ik->i", self._slopes, np.linalg.inv(self._effective(step)), self._slopes)
        changes = eased * (step**2 * self._stiffness + step * self._damping)
        return self._parts[int(np.argmax(changes))]

    def _effective(self, step: float) -> Array:
        return np.asarray(self._mass + step * self._summed(self._damping * self._of_joint))

    def _summed(self, figures: Array) -> Array:
        return np.asarray((self._slopes.T * figures) @ self._slopes)


def _allowed(found: Assembly) -> Array:
    """Return a basis of the motions that constraints and motors allow, shape (values, freedoms)."""
    rows: list[Rows] = [*found.rows]
    for drive in found.drives:
        rows.append(Apart(drive.ends, 0.0) if drive.ends is not None else Linear({drive.column: 1.0}, 0.0))
    matrix = jacobian(found.linkage, rows, found.start)
    if not len(matrix):
        return np.eye(found.linkage.size)
    _, sizes, vectors = np.linalg.svd(matrix)
    rank = int((sizes > NO_RANK * sizes[0]).sum()) if len(sizes) else 0
    return np.asarray(vectors[rank:].T)
