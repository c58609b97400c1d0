"""The list at the end of an import of a log: what was kept, guessed, mended and left out."""

from collections.abc import Iterator, Mapping

from mjsim.inventory import Fate, FileItem, fate_of, inventory
from mjsim.record import Recording
from mjsim.world import name_of

_OF_THE_RUN = ("command", "log", "log folder", "log source", "log start", "logged cameras", "modules", "seconds")


def listed(recording: Recording) -> list[str]:
    """Return what became of the contents of a log, from the recording that was made of it."""
    return inventory([*_sensors(recording), *_notes(recording.metadata)])


def listed_notes(notes: Mapping[str, str]) -> list[str]:
    """Return what became of the contents of a file, from facts as in the metadata of a recording."""
    return inventory(_notes(notes))


def _sensors(recording: Recording) -> Iterator[FileItem]:
    for robot in recording.world.robots:
        prefix = f"{robot.name}/" if len(recording.world.robots) > 1 else ""
        for sensor in robot.sensors:
            yield FileItem(Fate.KEPT, sensor.kind, f"{prefix}{name_of(sensor)}")


def _notes(metadata: Mapping[str, str]) -> Iterator[FileItem]:
    for fact, value in metadata.items():
        if value != "0" and fact not in _OF_THE_RUN and not fact.endswith(" version"):
            fate, why = fate_of(fact, value)
            yield FileItem(fate, fact.removesuffix(f" {Fate.LEFT_OUT}").removesuffix(","), why=why)
