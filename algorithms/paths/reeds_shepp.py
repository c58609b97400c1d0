"""Shortest curves between poses for a car that drives forwards and backwards, with a largest curvature."""

import math
from collections.abc import Iterator

import numpy as np

from mjsim.geometry import Array, Pose

Curve = tuple[tuple[int, float], ...]
"""Pieces: steering 1 to the left, 0 straight or -1 to the right, and length in radii, negative backwards."""

SAME = 1e-6
"""Poses that differ by less are equal [radii, rad]."""


def curves(start: Pose, end: Pose, *, radius: float) -> Iterator[Curve]:
    """Yield curves of at most five pieces from a pose to another, the shortest first.

    Args:
        start: [m, rad]
        end: [m, rad]
        radius: Radius of the tightest turn [m].

    References:
        Reeds, Shepp, Optimal Paths for a Car That Goes Both Forwards and Backwards, Pacific Journal of Mathematics
        145(2), 1990, section 8: one of these curves is the shortest.
    """
    apart = start.inverse() @ end
    x, y, phi = apart.x / radius, apart.y / radius, apart.heading
    # From the end to the start, driven in reverse order.
    back_x, back_y = x * math.cos(phi) + y * math.sin(phi), x * math.sin(phi) - y * math.cos(phi)
    found = []
    for u, v, is_back in ((x, y, False), (back_x, back_y, True)):
        for drive in (1, -1):
            for side in (1, -1):
                for word in _words(drive * u, side * v, drive * side * phi):
                    curve = tuple((side * steer, drive * length) for steer, length in word)
                    found.append(curve[::-1] if is_back else curve)
    for curve in sorted(found, key=length_of):
        ends = poses_on(Pose(0.0, 0.0, 0.0), curve, radius=1.0, spacing=math.inf)[0][-1]
        turned = math.remainder(float(ends[2]) - phi, 2.0 * math.pi)
        if abs(ends[0] - x) < SAME and abs(ends[1] - y) < SAME and abs(turned) < SAME:
            yield curve


def length_of(curve: Curve) -> float:
    """Return the length of a curve [radii]."""
    return sum(abs(length) for _, length in curve)


def poses_on(start: Pose, curve: Curve, *, radius: float, spacing: float) -> tuple[Array, Array, Array]:
    """Return points of a curve.

    Args:
        start: Pose at its beginning.
        curve: Its pieces.
        radius: [m]
        spacing: Distance between points, at most [m].

    Returns:
        poses: Shape (n, 3) [m, m, rad].
        curvature: Curvature on the way to each of them, shape (n,) [1/m].
        direction: 1 forwards, -1 backwards, on the way to each of them, shape (n,).
    """
    x, y, heading = start.x, start.y, start.heading
    poses, bends, ways = [np.array([[x, y, heading]])], [0.0], [1.0]
    for steer, length in curve:
        count = max(1, math.ceil(radius * abs(length) / spacing))
        along = length * np.arange(1, count + 1) / count
        turned = heading + steer * along
        if steer:
            ahead = steer * radius * (np.sin(turned) - math.sin(heading))
            left = steer * radius * (math.cos(heading) - np.cos(turned))
        else:
            ahead, left = radius * along * math.cos(heading), radius * along * math.sin(heading)
        poses.append(np.stack([x + ahead, y + left, turned], axis=-1))
        x, y, heading = poses[-1][-1].tolist()
        bends += [steer / radius] * count
        ways += [math.copysign(1.0, length)] * count
    bends[0], ways[0] = bends[min(1, len(bends) - 1)], ways[min(1, len(ways) - 1)]
    return np.concatenate(poses), np.array(bends), np.array(ways)


def _words(x: float, y: float, phi: float) -> Iterator[Curve]:
    """Yield curves to (x, y, phi) [radii, rad] that begin forwards to the left; formulas of section 8 of the paper."""
    c, s = math.cos(phi), math.sin(phi)
    right = math.pi / 2.0
    # To the centres of the last turn: to the left, and to the right.
    (a, b), (p, q) = (x - s, y - 1.0 + c), (x + s, y - 1.0 - c)
    near, bearing = math.hypot(a, b), math.atan2(b, a)
    far, toward = math.hypot(p, q), math.atan2(q, p)
    yield (1, _turn(bearing)), (0, near), (1, _turn(phi - bearing))  # 8.1
    if far >= 2.0:  # 8.2
        u = math.sqrt(far * far - 4.0)
        t = _turn(toward + math.atan2(2.0, u))
        yield (1, t), (0, u), (-1, _turn(t - phi))
    if near <= 4.0:  # 8.3, 8.4
        u = -2.0 * math.asin(near / 4.0)
        t = _turn(bearing + u / 2.0 + math.pi)
        yield (1, t), (-1, u), (1, _turn(phi - t + u))
    if (rho := 0.25 * (2.0 + far)) <= 1.0:  # 8.7
        u = math.acos(rho)
        t, v = _outer(u, -u, p, q, phi)
        yield (1, t), (-1, u), (1, -u), (-1, v)
    if 0.0 <= (rho := (20.0 - far * far) / 16.0) <= 1.0:  # 8.8
        u = -math.acos(rho)
        t, v = _outer(u, u, p, q, phi)
        yield (1, t), (-1, u), (1, u), (-1, v)
    if near >= 2.0:  # 8.9
        r = math.sqrt(near * near - 4.0)
        t = _turn(bearing + math.atan2(r, -2.0))
        yield (1, t), (-1, -right), (0, 2.0 - r), (1, _turn(phi - right - t))
    if far >= 2.0:  # 8.10, 8.11
        t = _turn(math.atan2(p, -q))
        yield (1, t), (-1, -right), (0, 2.0 - far), (-1, _turn(t + right - phi))
        if (u := 4.0 - math.sqrt(far * far - 4.0)) <= 0.0:
            t = _turn(math.atan2((4.0 - u) * p - 2.0 * q, -2.0 * p + (u - 4.0) * q))
            yield (1, t), (-1, -right), (0, u), (1, -right), (-1, _turn(t - phi))


def _turn(angle: float) -> float:
    return math.remainder(angle, 2.0 * math.pi)


def _outer(u: float, v: float, p: float, q: float, phi: float) -> tuple[float, float]:
    """Return the first and last turns around two inner ones u and v [rad]; equation (8.6) of the paper."""
    inner = _turn(u - v)
    a, b = math.sin(u) - math.sin(inner), math.cos(u) - math.cos(inner) - 1.0
    t = math.atan2(q * a - p * b, p * a + q * b)
    if 2.0 * (math.cos(inner) - math.cos(v) - math.cos(u)) + 3.0 < 0.0:
        t += math.pi
    return _turn(t), _turn(t - u + v - phi)
