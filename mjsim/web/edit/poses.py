"""Requests of the page while a mechanism or a person is posed: the new outlines, and the changes of its text."""

from collections.abc import Sequence
from typing import Annotated, Literal, NamedTuple

import numpy as np
from pydantic import Field

from mjsim.geometry import Array
from mjsim.people import silhouettes
from mjsim.posture import poses_of
from mjsim.sentences import Sentence
from mjsim.video import body_outlines, posed
from mjsim.web.server import Ask, RefusedError
from mjsim.web.worlds import Json, KeyChange, Look, look_at, mechanism_poses, moving_items, person_poses
from mjsim.world import Mechanism, Person, World

Metres = Annotated[float, Field(ge=-1e4, le=1e4, allow_inf_nan=False)]
Value = Annotated[float, Field(ge=-1e6, le=1e6, allow_inf_nan=False)]
HANDS = ("left", "right")


class PullAsk(Ask):
    """The part dragged in a drawing, with start and end points [m]."""

    look: Look
    part: str
    """A joint of a mechanism; 'left' or 'right' for the hand of a person."""
    start: tuple[Metres, Metres]
    end: tuple[Metres, Metres]


class PoseAsk(Ask):
    """A mechanism or a person, its side view, and the change: the first of these that is given."""

    path: str
    text: str
    item: tuple[Literal["mechanisms", "people"], int]
    look: Literal["side", "front"] = "side"
    values: dict[str, Value] = Field(default_factory=dict)
    """Values of joints by name [deg, m]."""
    hands: dict[Literal["left", "right"], tuple[Metres, Metres, Metres]] = Field(default_factory=dict)
    """Target positions of hands, world frame [m]."""
    pull: PullAsk | None = None


class _Posed(NamedTuple):
    thing: Mechanism | Person
    changes: Sequence[KeyChange] = ()
    note: str = ""


def pose_json(world: World, ask: PoseAsk) -> Json:
    """Return a mechanism or a person after a change.

    Returns:
        `items`: its items on the plan, each with path, polygons [m], at [m] and heading_deg; `parts`: its outlines in
        the side view [m], each with its name and the part by which to drag it, if any; `values`: of its joints, each
        with name, value, low, high, unit and free; `hands`: their positions by side [m]; `changes`: of the text;
        `note`: what deviates from the request.

    Raises:
        RefusedError: It does not exist, or the change is impossible.
    """
    kind, index = ask.item
    things: Sequence[Mechanism | Person] = getattr(world, kind)
    if not 0 <= index < len(things):
        raise RefusedError(
            404, Sentence("no {kind}[{index}] in this text; there are {count}", kind, index, len(things))
        )
    try:
        found = _posed(things[index], ask)
    except ValueError as error:
        raise RefusedError(409, str(error)) from None
    thing, path = found.thing, (kind, index)
    own = _mechanism_json(thing, ask.look) if isinstance(thing, Mechanism) else _person_json(world, thing, ask.look)
    changes = [{"op": "set", "path": [*path, *keys], "value": value} for keys, value in found.changes]
    return {"items": list(moving_items(world, thing, path)), "changes": changes, "note": found.note, **own}


def _posed(thing: Mechanism | Person, ask: PoseAsk) -> _Posed:
    if isinstance(thing, Person):
        return _person_posed(thing, ask)
    if ask.hands:
        raise ValueError("a mechanism has no hands; give values, or pull a joint")
    if ask.values:
        return _Posed(*mechanism_poses.moved(thing, ask.values))
    if ask.pull is None:
        return _Posed(thing)
    start, end = np.array(ask.pull.start), np.array(ask.pull.end)
    return _Posed(*mechanism_poses.pulled(thing, ask.pull.part, _view_of(thing, ask.pull.look), start, end))


def _person_posed(person: Person, ask: PoseAsk) -> _Posed:
    if ask.values:
        return _Posed(*person_poses.turned(person, ask.values))
    if ask.hands:
        return _Posed(*person_poses.led(person, {side: np.array(at) for side, at in ask.hands.items()}))
    if ask.pull is None:
        return _Posed(person)
    if ask.pull.part not in HANDS:
        raise ValueError(Sentence("'{part}' is not a hand; pull 'left' or 'right'", ask.pull.part))
    view = _view_of(person, ask.pull.look)
    # At its current depth towards the viewer.
    by = view[:2, :3].T @ (np.array(ask.pull.end) - ask.pull.start)
    return _Posed(*person_poses.led(person, {ask.pull.part: person_poses.hands(person)[ask.pull.part] + by}))


def _view_of(thing: Mechanism | Person, direction: Look) -> Array:
    heading = np.radians(thing.heading_deg)
    if isinstance(thing, Person) and thing.seat is not None:
        place = thing.place()
        return look_at(direction, (place.x, place.y), place.heading)
    return look_at(direction, (thing.at[0], thing.at[1]), heading)


def _mechanism_json(mechanism: Mechanism, look: Look) -> Json:
    seen = _view_of(mechanism, look)
    pulls = {body: mechanism.joints[number].name for number, body, _ in mechanism_poses.grips(mechanism, seen)}
    drawn = body_outlines(posed(mechanism, mechanism.assembly.start, seen))
    parts = [{"name": name, "outline": _short(outline), "pull": pulls.get(name)} for name, outline in drawn]
    return {"parts": parts, "values": list(mechanism_poses.sliders(mechanism)), "hands": {}}


def _person_json(world: World, person: Person, look: Look) -> Json:
    outlines = silhouettes(person.skins, poses_of(world, person), _view_of(person, look))
    pulls = {f"{side}_hand": side for side in HANDS if person.seat is None}
    parts = [{"name": name, "outline": _short(each), "pull": pulls.get(name)} for name, each in outlines]
    hands = {side: _short(at) for side, at in person_poses.hands(person).items()} if person.seat is None else {}
    return {"parts": parts, "values": list(person_poses.sliders(person)), "hands": hands}


def _short(points: Array) -> list[object]:
    return (np.round(points, 4) + 0.0).tolist()  # type: ignore[no-any-return]
