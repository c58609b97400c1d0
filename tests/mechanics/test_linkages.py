"""Linkages: poses by products of scipy's rotations, Jacobians by differences, loops by the geometry of circles."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mjsim.geometry import Array
from mjsim.mechanics import SpaceCurve
from mjsim.mechanics.linkage import Linkage, Primitive, TreeJoint, left_jacobian
from mjsim.mechanics.loops import (
    Apart,
    BodyPoint,
    Coincide,
    Linear,
    Meet,
    close,
    followed,
    freedoms,
    jacobian,
    rates,
    residual,
    tracked,
    turning,
)

RNG = np.random.default_rng(21)
CIRCLE = SpaceCurve.ellipse(0.7, 0.7, np.array([0.0, 0.0, 1.0]))
STEP = 1e-6


def pose(rotation: Rotation | None = None, place: Array | tuple[float, ...] = (0.0, 0.0, 0.0)) -> Array:
    matrix = np.eye(4)
    matrix[:3, :3] = np.eye(3) if rotation is None else rotation.as_matrix()
    matrix[:3, 3] = place
    return matrix


def any_pose() -> Array:
    return pose(Rotation.random(rng=RNG), RNG.uniform(-1.0, 1.0, 3))


def unit() -> tuple[float, ...]:
    vector = RNG.normal(size=3)
    return tuple((vector / np.linalg.norm(vector)).tolist())


def moved(primitive: Primitive, value: Array) -> Array:
    if primitive.kind == "slide":
        return pose(place=value[0] * np.array(primitive.axis))
    if primitive.kind == "curve":
        turn = value[0] / 0.7
        return pose(place=(0.7 * np.cos(turn), 0.7 * np.sin(turn), 0.0))
    return pose(Rotation.from_rotvec(value if primitive.kind == "ball" else value[0] * np.array(primitive.axis)))


SLIDE, TURN = (Primitive(kind=kind, axis=unit()) for kind in ("slide", "turn"))
BALL, CURVE = Primitive(kind="ball"), Primitive(kind="curve", curve=CIRCLE)


def joint(parent: int, first: int, *primitives: Primitive, sign: float = 1.0, **ends: Array) -> TreeJoint:
    around = {"before": any_pose(), "after": any_pose(), **ends}
    return TreeJoint(name="j", parent=parent, primitives=primitives, first=first, sign=sign, **around)


TREE = Linkage([joint(0, 0, SLIDE, TURN), joint(1, 2, BALL), joint(1, 5, TURN, SLIDE, sign=-1.0), joint(2, 7, CURVE)])
"""Bodies 1 to 4: 1 on the ground, 2 and 3 on it, 4 on 2; eight values."""
VALUES = [RNG.uniform(-1.5, 1.5, 8) for _ in range(5)]


def test_a_body_is_where_the_product_of_its_motions_puts_it():
    for values in VALUES:
        poses = [np.eye(4)]
        for each in TREE.joints:
            count = sum(primitive.width for primitive in each.primitives)
            parts = np.split(
                values[each.first : each.first + count], np.cumsum([p.width for p in each.primitives])[:-1]
            )
            if each.sign > 0:
                motions = [moved(*pair) for pair in zip(each.primitives, parts, strict=True)]
            else:
                # Traversed backwards, its last value belongs to the first primitive.
                motions = [np.linalg.inv(moved(*pair)) for pair in zip(each.primitives, parts[::-1], strict=True)]
            poses.append(np.linalg.multi_dot([poses[each.parent], each.before, *motions, each.after]))
        np.testing.assert_allclose(TREE.place(values).poses, poses, atol=1e-9)


def test_a_joint_traversed_backwards_is_the_inverse_of_the_joint():
    there = Linkage([joint(0, 0, SLIDE, BALL, TURN, before=np.eye(4), after=np.eye(4))])
    back = Linkage([joint(0, 0, TURN, BALL, SLIDE, before=np.eye(4), after=np.eye(4), sign=-1.0)])
    for values in RNG.uniform(-1.5, 1.5, (5, 5)):
        both = there.place(values).poses[1] @ back.place(values).poses[1]
        np.testing.assert_allclose(both, np.eye(4), atol=1e-12)


def test_jacobians_of_points_and_turns_match_central_differences():
    for values in VALUES:
        placed = TREE.place(values)
        for body in range(5):
            local = RNG.uniform(-1.0, 1.0, 3)
            point = placed.poses[body, :3, :3] @ local + placed.poses[body, :3, 3]
            slopes, turns = TREE.point_jacobian(placed, body, point), TREE.turn_jacobian(placed, body)
            for column, offset in enumerate(np.eye(8) * STEP):
                ahead, behind = (TREE.place(values + sign * offset).poses[body] for sign in (1.0, -1.0))
                slope = (ahead - behind) / (2.0 * STEP)
                np.testing.assert_allclose(slopes[:, column], slope[:3, :3] @ local + slope[:3, 3], atol=1e-6)
                spin = Rotation.from_matrix(ahead[:3, :3] @ behind[:3, :3].T).as_rotvec() / (2.0 * STEP)
                np.testing.assert_allclose(turns[:, column], spin, atol=1e-6)


@pytest.mark.parametrize("size", [1.0, 1e-3, 1e-5, 0.0])
def test_the_left_jacobian_turns_rates_of_a_rotation_vector_into_the_angular_velocity(size):
    for vector in RNG.normal(size=(5, 3)) * size:
        J = left_jacobian(vector)
        for column, offset in enumerate(np.eye(3) * STEP):
            ahead, behind = Rotation.from_rotvec(vector + offset), Rotation.from_rotvec(vector - offset)
            np.testing.assert_allclose(J[:, column], (ahead * behind.inv()).as_rotvec() / (2.0 * STEP), atol=1e-8)


ROWS = {
    "linear": Linear({1: 2.0, 6: -0.5}, 0.3),
    "apart": Apart((BodyPoint(2, np.array([0.1, 0.2, 0.3])), BodyPoint(3, np.array([-0.3, 0.1, 0.2]))), 0.4),
    "meet": Meet(4, BodyPoint(3, np.array([0.3, -0.1, 0.2]))),
}


@pytest.mark.parametrize("rows", [*[[row] for row in ROWS.values()], [*ROWS.values()]], ids=[*ROWS, "all"])
def test_the_jacobian_of_constraints_is_the_slope_of_their_residuals(rows):
    for values in VALUES:
        slopes = [
            (residual(TREE, rows, values + offset) - residual(TREE, rows, values - offset)) / (2.0 * STEP)
            for offset in np.eye(8) * STEP
        ]
        np.testing.assert_allclose(jacobian(TREE, rows, values), np.transpose(slopes), atol=1e-6)


def test_residuals_are_distances_and_sums():
    values = VALUES[0]
    poses = TREE.place(values).poses
    (linear,) = residual(TREE, [ROWS["linear"]], values)
    assert linear == pytest.approx(2.0 * values[1] - 0.5 * values[6] - 0.3)
    first, second = (poses[end.body] @ [*end.at, 1.0] for end in ROWS["apart"].ends)
    assert residual(TREE, [ROWS["apart"]], values) == pytest.approx([np.linalg.norm(first - second) - 0.4])
    spot = poses[3] @ [0.3, -0.1, 0.2, 1.0]
    np.testing.assert_allclose(residual(TREE, [ROWS["meet"]], values), spot[:3] - poses[4, :3, 3])


def test_frames_that_coincide_have_no_residual_and_the_slope_of_their_difference():
    for values in VALUES:
        ghost = Linkage([*TREE.joints, joint(0, 8, BALL, SLIDE)])
        start = np.concatenate([values, [0.2, -0.3, 0.1, 0.4]])
        there, found = ghost.place(start).poses[2], ghost.place(start).poses[5]
        last = ghost.joints[4]
        after = last.after @ np.linalg.inv(found) @ there
        ghost = Linkage([*TREE.joints, joint(0, 8, BALL, SLIDE, before=last.before, after=after)])
        rows = [Coincide(ghost=5, body=2)]
        np.testing.assert_allclose(residual(ghost, rows, start), 0.0, atol=1e-9)
        slopes = [
            (residual(ghost, rows, start + offset) - residual(ghost, rows, start - offset)) / (2.0 * STEP)
            for offset in np.eye(12) * STEP
        ]
        np.testing.assert_allclose(jacobian(ghost, rows, start), np.transpose(slopes), atol=1e-6)


CRANK, COUPLER, ROCKER, GROUND = 0.3, 0.9, 0.7, 0.8
Z = Primitive(kind="turn")


def four_bar() -> tuple[Linkage, list[Meet]]:
    """Return crank and coupler, and the rocker, whose ends meet; all turn about z."""

    def bar(parent: int, first: int, x: float) -> TreeJoint:
        return joint(parent, first, Z, before=pose(place=(x, 0.0, 0.0)), after=np.eye(4))

    ends = [bar(0, 0, 0.0), bar(1, 1, CRANK), bar(0, 2, GROUND), bar(3, 3, ROCKER)]
    return Linkage(ends), [Meet(4, BodyPoint(2, np.array([COUPLER, 0.0, 0.0])))]


def rocker_of(crank: float) -> tuple[float, float]:
    """Return coupler (relative to the crank) and rocker, by the circles about their ends [rad]."""
    tip = CRANK * np.exp(1j * crank)
    span = GROUND - tip
    # The upper of both points where the circles meet.
    turn = np.arccos((abs(span) ** 2 + COUPLER**2 - ROCKER**2) / (2.0 * abs(span) * COUPLER))
    coupler = np.angle(span) + turn
    end = tip + COUPLER * np.exp(1j * coupler)
    return float(coupler - crank), float(np.angle(end - GROUND))


def solution(crank: float) -> Array:
    coupler, rocker = rocker_of(crank)
    return np.array([crank, coupler, rocker, 0.0])


@pytest.mark.parametrize("crank", [0.3, 1.4, 2.8, -2.0])
def test_a_four_bar_closes_where_its_circles_meet(crank):
    linkage, rows = four_bar()
    exact = solution(crank)
    start = exact + np.array([0.0, 0.05, -0.04, 0.0])
    for solver in (close, followed):
        found = solver(linkage, rows, start, held=[0, 3])
        assert found.good
        np.testing.assert_allclose(found.values, exact, atol=1e-9)
    np.testing.assert_allclose(tracked(linkage, rows, start, columns=[1, 2]), exact, atol=1e-9)
    # All three values of the loop may change, so one freedom is left beside the idle one of the ghost.
    assert freedoms(linkage, rows, exact) == 2
    assert freedoms(linkage, [*rows, Linear({0: 1.0}, crank)], exact) == 1


def test_rates_and_second_derivatives_of_a_four_bar_are_those_of_its_geometry():
    linkage, rows, crank, speed, h = *four_bar(), 1.1, 0.7, 1e-5
    exact = solution(crank)
    found, missed = rates(linkage, rows, exact, held={0: speed, 3: 0.0}, targets=np.zeros(3))
    slope = (solution(crank + h) - solution(crank - h)) / (2.0 * h)
    np.testing.assert_allclose(found, slope * speed, atol=1e-8)
    assert missed < 1e-12
    # J a + turning = 0 along a motion of constant crank speed.
    bend = (solution(crank + 1e-3) - 2.0 * exact + solution(crank - 1e-3)) / 1e-6 * speed**2
    np.testing.assert_allclose(jacobian(linkage, rows, exact) @ bend, -turning(linkage, rows, exact, found), atol=1e-5)
    np.testing.assert_array_equal(turning(linkage, rows, exact, np.zeros(4)), np.zeros(3))
    _, missed = rates(linkage, rows, exact, held={0: speed, 1: 0.0, 3: 0.0}, targets=np.zeros(3))
    assert missed > 0.01


def test_what_cannot_close_comes_as_near_as_it_can():
    linkage, rows = four_bar()
    far = [Meet(4, BodyPoint(2, np.array([3.0, 0.0, 0.0])))]
    found = close(linkage, far, solution(1.0), held=[0])
    assert not found.good
    # The coupler of 3 m points at the pivot of the rocker, which points the same way.
    gap = 3.0 - abs(GROUND - CRANK * np.exp(1j)) - ROCKER
    assert np.linalg.norm(residual(linkage, far, found.values)) == pytest.approx(gap, abs=1e-6)
    assert found.miss == pytest.approx(np.abs(residual(linkage, far, found.values)).max())
    assert found.values[0] == 1.0
    whole = close(linkage, rows, solution(1.0), held=[0, 1, 2, 3])
    np.testing.assert_array_equal(whole.values, solution(1.0))
