"""Checks for implausible values: events that move arms out of reach."""

from collections.abc import Iterator

from mjsim.errors import did_you_mean
from mjsim.geometry import Array
from mjsim.sentences import Sentence
from mjsim.world.check.overlaps import Finding
from mjsim.world.items import ReachEvent, ReleaseEvent, RobotArm, World, reached_joints, single_targets


def beyond_reach(world: World) -> Iterator[Finding]:
    """Yield the problems of events that move arms; inverse kinematics of tool poses starts at the arms' start."""
    for index, event in enumerate(world.run.events):
        if isinstance(event, ReachEvent) or (isinstance(event, ReleaseEvent) and event.joint is None):
            path = ("run", "events", index)
            if event.hand is not None:
                if (unknown := unknown_person(world, getattr(event, event_key(event)))) is not None:
                    yield unknown, (*path, event_key(event))
                continue
            try:
                item = arm_of_event(world, event)
            except ValueError as error:
                yield str(error), (*path, "arm" if "arm" in event.model_fields_set else event_key(event))
                continue
            if isinstance(event, ReachEvent):
                yield from ((wrong, (*path, *place)) for wrong, place in _beyond(item, event))


def _beyond(item: RobotArm, event: ReachEvent) -> Iterator[Finding]:
    """Yield which targets of an event an arm does not reach; inverse kinematics starts at the target before."""
    now: Array | tuple[float, ...] = item.start()
    first = "tool" if event.joints_deg is None else "joints_deg"
    for number, target in enumerate(single_targets(event)):
        assert isinstance(target, ReachEvent), "it is a part of one"
        now, wrong = reached_joints(item, target, now)
        if wrong is not None:
            yield str(wrong), ("then", number - 1) if number else (first,)


def unknown_person(world: World, name: str) -> str | None:
    """Return what is wrong with the name of a person whose hand moves; None if it is valid."""
    people = [person.name for person in world.people]
    return (
        None
        if name in people
        else Sentence("no person '{name}' in this world{meant}", name, did_you_mean(name, people))
    )


def event_key(event: ReachEvent | ReleaseEvent) -> str:
    """Return the key that names the robot."""
    return "reach" if isinstance(event, ReachEvent) else "release"


def arm_of_event(world: World, event: ReachEvent | ReleaseEvent) -> RobotArm:
    """Return the arm to which an event refers.

    Raises:
        ValueError: The robot does not exist, or has no such arm.
    """
    name: str = getattr(event, event_key(event))
    arms = {robot.name: {item.name: item for item in robot.arms} for robot in world.robots}
    if name not in arms and any(person.name == name for person in world.people):
        raise ValueError(Sentence("'{name}' is a person; name the hand: left or right", name))
    if name not in arms and any(each.name == name for each in world.mechanisms):
        raise ValueError(Sentence("'{name}' is a mechanism; name the joint", name))
    if name not in arms:
        raise ValueError(Sentence("no robot '{name}' in this world{meant}", name, did_you_mean(name, arms)))
    if event.arm not in arms[name]:
        raise ValueError(
            Sentence("robot '{name}' has no arm '{arm}'{meant}", name, event.arm, did_you_mean(event.arm, arms[name]))
        )
    return arms[name][event.arm]
