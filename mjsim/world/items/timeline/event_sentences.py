"""Descriptions of events, for people."""

import math

from mjsim.sentences import Sentence
from mjsim.world.items.timeline.events import (
    CloseEvent,
    GoalEvent,
    LampEvent,
    LeadEvent,
    LightEvent,
    MoveEvent,
    NoiseEvent,
    OpenEvent,
    PushEvent,
    ReachEvent,
    ReleaseEvent,
    RemoveEvent,
    RestoreEvent,
    ShoveEvent,
    WorldEvent,
)


def event_text(event: WorldEvent) -> str:
    """Return a description of an event."""
    match event:
        case MoveEvent():
            return Sentence("{move} is placed at [{x:g}, {y:g}]{heading}", event.move, *event.to, _heading_text(event))
        case OpenEvent():
            return Sentence("door {open} swings open to {angle_deg:g} deg", event.open, event.angle_deg)
        case CloseEvent():
            return Sentence("door {close} swings shut", event.close)
        case LightEvent():
            return Sentence("the ambient light is set to {light:g}", event.light)
        case LampEvent():
            return Sentence("lamp {lamp} is set to {brightness:g}", event.lamp, event.brightness)
        case NoiseEvent():
            return Sentence("{noise} becomes {value:g}", event.noise, event.value)
        case RemoveEvent():
            return Sentence("{remove} is removed", event.remove)
        case RestoreEvent():
            if event.to is None:
                return Sentence("{restore} is restored", event.restore)
            return Sentence(
                "{restore} is restored at [{x:g}, {y:g}]{heading}", event.restore, *event.to, _heading_text(event)
            )
        case ShoveEvent():
            return Sentence("{shove} is shoved by {impulse:g} N s", event.shove, math.hypot(*event.impulse))
        case PushEvent():
            duration = "" if event.seconds is None else Sentence(" for {seconds:g} s", event.seconds)
            return Sentence(
                "{push} is pushed; its force is a {kind} signal{duration}", event.push, event.signal.kind, duration
            )
        case ReachEvent() | LeadEvent():
            return _motion_text(event)
        case ReleaseEvent(hand=str(hand)):
            return Sentence("the {hand} hand of {whose} returns to its initial position", hand, event.release)
        case ReleaseEvent(joint=str(joint)):
            return Sentence("joint {joint} of {whose} is released", joint, event.release)
        case ReleaseEvent():
            return Sentence("{arm} of {whose} returns to its navigator", event.arm, event.release)
        case GoalEvent():
            return Sentence("{goal} is sent to [{x:g}, {y:g}]{heading}", event.goal, *event.to, _heading_text(event))


def _heading_text(event: MoveEvent | GoalEvent | RestoreEvent) -> str:
    return "" if event.heading_deg is None else Sentence(", heading {heading:g} deg", event.heading_deg)


def _motion_text(event: ReachEvent | LeadEvent) -> str:
    """Return a description of a motion to a target, or through several to the last."""
    last = event.then[-1][1:] if event.then else None
    over = ""
    if event.then:
        over = Sentence(", through {targets} targets in {seconds:g} s", 1 + len(event.then), event.then[-1][0])
    if isinstance(event, LeadEvent):
        values = last or event.rotation_deg or (event.to_deg or 0.0,)
        value = f"{values[0]:g}" if len(values) == 1 else _listed(values)
        return Sentence("joint {joint} of {mechanism} goes to {value}{over}", event.joint, event.lead, value, over)
    if event.to is not None:
        short = Sentence(", which is {short:.2g} m out of reach", event.short) if event.short else ""
        to = _listed(last or event.to)
        return Sentence(
            "the {hand} hand of {person} reaches for {to}{short}{over}", event.hand, event.reach, to, short, over
        )
    listed = _listed(last or event.tool or event.joints_deg or ())
    goal = Sentence("joints {values}" if event.tool is None else "{values} with its tool", listed)
    return Sentence("{arm} of {robot} goes to {goal}{over}", event.arm, event.reach, goal, over)


def _listed(values: tuple[float, ...]) -> str:
    return f"[{', '.join(f'{value:g}' for value in values)}]"
