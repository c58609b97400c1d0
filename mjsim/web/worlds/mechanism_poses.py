"""Mechanisms on the page: their outlines at the start, and their start values after a joint is dragged."""

import math
from collections.abc import Iterator, Mapping

from mjsim.geometry import Array, Pose
from mjsim.sentences import Sentence
from mjsim.video import body_outlines, posed
from mjsim.web.worlds.viewpoints import ABOVE, KeyChange
from mjsim.world import Mechanism, carried_body, free_columns, pulled_values, restarted, shows_motion

Json = dict[str, object]
FREE_TURN, FREE_SLIDE = 180.0, 1.0
"""Range of sliders for joints without limits, to either side of 0 or of the value [deg, m]."""


def outlines(mechanism: Mechanism) -> list[tuple[str, Array]]:
    """Return each body with its outline from above at the start, world frame, shape (n, 2) [m]."""
    return list(body_outlines(posed(mechanism, mechanism.assembly.start)))


def plan_joints(mechanism: Mechanism) -> Iterator[tuple[int, str, Array, Pose]]:
    """Yield the joints that can be dragged on the plan: those with a free start whose motion is visible there.

    Yields:
        Index of the joint, the body that it carries, its outline, world frame, shape (n, 2) [m], and the pose at the
        joint, with the heading of that body.
    """
    drawn = posed(mechanism, mechanism.assembly.start)
    for number, body, outline in grips(mechanism, ABOVE):
        x, y, _ = drawn.joint(mechanism.joints[number]).tolist()
        along = drawn.poses[body][:2, 0]
        yield number, body, outline, Pose(x, y, math.atan2(along[1], along[0]))


def grips(mechanism: Mechanism, look: Array) -> Iterator[tuple[int, str, Array]]:
    """Yield the joints that can be dragged in a drawing: index, body, and its outline in the drawing, shape (n, 2) [m].

    Args:
        mechanism: The mechanism, at its start.
        look: drawing_from_world, shape (3, 4) [m].
    """
    found = mechanism.assembly
    seen = dict(body_outlines(posed(mechanism, found.start, look)))
    free = free_columns(mechanism)
    for number, joint in enumerate(mechanism.joints):
        body = found.bodies[carried_body(found, joint)]
        if body in seen and free & set(found.columns[joint.name]) and shows_motion(mechanism, joint, look):
            yield number, body, seen[body]


def start_values(mechanism: Mechanism, number: int) -> Json:
    """Return the start values of a joint by key, whether written or computed [m, deg]."""
    found, joint = mechanism.assembly, mechanism.joints[number]
    values: dict[str, list[float]] = {}
    for column in found.columns[joint.name]:
        key, value = _shown(mechanism, column)
        values.setdefault(key, []).append(value)
    return {key: each[0] if len(each) == 1 else each for key, each in values.items()}


def sliders(mechanism: Mechanism) -> Iterator[Json]:
    """Yield each joint value: name, value, low, high, unit, and whether its start is free."""
    found, free = mechanism.assembly, free_columns(mechanism)
    for joint in mechanism.joints:
        for column in found.columns[joint.name]:
            slides = found.slides[column]
            _, value = _shown(mechanism, column)
            far = FREE_SLIDE if slides else FREE_TURN
            low, high = (joint.range if slides else joint.range_deg) or (min(-far, value), max(far, value))
            unit = "m" if slides else "°"
            yield {
                "name": found.names[column],
                "value": value,
                "low": low,
                "high": high,
                "unit": unit,
                "free": column in free,
            }


def moved(mechanism: Mechanism, values: Mapping[str, float]) -> tuple[Mechanism, list[KeyChange]]:
    """Return a mechanism with other joint values [deg, m], and the changes of its text, as relative paths.

    Raises:
        ValueError: The value does not exist, or the mechanism cannot start there.
    """
    found = mechanism.assembly
    targets = {}
    for name, value in values.items():
        column = found.column(name)
        targets[column] = value if found.slides[column] else math.radians(value)
    return _restarted(mechanism, targets)


def pulled(mechanism: Mechanism, name: str, look: Array, start: Array, end: Array) -> tuple[Mechanism, list[KeyChange]]:
    """Return a mechanism after a body was dragged in a drawing by the joint that carries it, as `moved` does.

    Raises:
        ValueError: The joint does not exist or carries nothing, or the mechanism cannot start there.
    """
    joint, found = mechanism.joint(name), mechanism.assembly
    if found.bodies[carried_body(found, joint)] not in [body.name for body in mechanism.bodies]:
        raise ValueError(Sentence("joint '{name}' closes a loop; drag another joint in it", name))
    free = free_columns(mechanism)
    values = pulled_values(mechanism, joint, look=look, start=start, end=end)
    return _restarted(mechanism, {column: value for column, value in values.items() if column in free})


def _restarted(mechanism: Mechanism, targets: Mapping[int, float]) -> tuple[Mechanism, list[KeyChange]]:
    begun = restarted(mechanism, targets)
    return begun.mechanism, [(("joints", *place), value) for place, value in begun.keys.items()]


def _shown(mechanism: Mechanism, column: int) -> tuple[str, float]:
    """Return key and start value of a column, as in the text [m, deg]."""
    found = mechanism.assembly
    value = float(found.start[column])
    if found.slides[column]:
        return "start", round(value, 4) + 0.0
    return "start_deg", round(math.degrees(value), 2) + 0.0
