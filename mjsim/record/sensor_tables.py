"""Readings of sensors as tables and arrays, for `export`."""

from typing import Any

from mjsim.record.parse import FAULTS, unfit
from mjsim.record.readings import CODECS, SensorTable
from mjsim.record.recording import Recording


def sensor_tables(recording: Recording, robot: str) -> list[SensorTable]:
    """Return a table for each sensor of a robot whose kind of reading has one.

    In each, `time` is when modules received a reading, and `stamp` when it was taken [s].

    Raises:
        RecordingError: Readings of one sensor differ in size.
    """
    exported = [(codec.field, codec.tables) for codec in CODECS if codec.tables is not None]
    given: dict[str, list[tuple[float, Any]]] = {field: [] for field, _ in exported}
    for seen in recording.observations(robot):
        for field, values in given.items():
            if value := getattr(seen, field):
                values.append((seen.time, value))
    try:
        return [table for field, tables in exported for table in tables(given[field])]
    except FAULTS as error:
        raise unfit(f"'{recording.path}': what the sensors of robot '{robot}' gave", error) from error
