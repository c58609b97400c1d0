"""Checks that the sensors of a mechanism measure parts that exist, each only once."""

from mjsim.errors import did_you_mean
from mjsim.sentences import Sentence
from mjsim.world.ground import fault
from mjsim.world.items.mechanisms.assembly import Assembly
from mjsim.world.items.mechanisms.measurements import SENSORS, ActuatorSensor, BodySensor, JointSensor, ReactionSensor
from mjsim.world.items.mechanisms.mechanism_items import MechanismParts
from mjsim.world.items.mechanisms.points import GROUND, place_of
from mjsim.world.items.mechanisms.tree import Points


def check_sensors(mechanism: MechanismParts, found: Assembly, points: Points) -> None:
    """Raise an error for a sensor of a missing part, and for a duplicate sensor."""
    taken = dict[tuple[str, str], int]()
    for number, sensor in enumerate(mechanism.sensors):
        kind = next(key for key, model in SENSORS.items() if isinstance(sensor, model))
        called = sensor.called if isinstance(sensor, BodySensor) else str(getattr(sensor, kind))
        if (kind, called) in taken:
            remedy = "give this one a name, or leave it out" if kind == "body" else "leave one out"
            other = taken[kind, called]
            raise fault(
                Sentence("'{called}' has this sensor already, sensors[{other}]; {remedy}", called, other, remedy),
                "sensors",
                number,
                kind,
            )
        taken[kind, called] = number
    for number, sensor in enumerate(mechanism.sensors):
        path = ("sensors", number)
        match sensor:
            case JointSensor(joint=name) if name not in found.columns:
                try:
                    found.column(name)
                except ValueError as error:
                    raise fault(str(error), *path, "joint") from None
            case ReactionSensor(reaction=name) if name not in found.columns:
                meant = did_you_mean(name, found.columns)
                raise fault(Sentence("no joint '{name}' in this mechanism{meant}", name, meant), *path, "reaction")
            case ActuatorSensor(actuator=name):
                _check_actuator(mechanism, found, name, path)
            case BodySensor(body=end):
                _check_body(end, points, path)
            case _:
                pass


def _check_actuator(mechanism: MechanismParts, found: Assembly, name: str, path: tuple[str | int, ...]) -> None:
    targets = [actuator.target for actuator in mechanism.actuators]
    if name not in targets:
        raise fault(
            Sentence("no actuator on '{name}' in this mechanism{meant}", name, did_you_mean(name, targets)),
            *path,
            "actuator",
        )
    if name not in found.names and name not in [drive.name for drive in found.drives]:
        raise fault(
            Sentence("the load on body '{name}' is given by its signal; leave this sensor out", name), *path, "actuator"
        )


def _check_body(end: object, points: Points, path: tuple[str | int, ...]) -> None:
    try:
        place = place_of(end, points)  # type: ignore[arg-type]
    except ValueError as error:
        raise fault(str(error), *path, "body") from None
    if place.body == GROUND:
        raise fault("the ground does not move; name a point of a body", *path, "body")
