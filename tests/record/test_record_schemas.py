"""What a recording holds is what the schemas in it say: for other tools, and for our own reader."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from mcap.reader import make_reader

from mjsim.record.schemas import ROBOT_TOPICS, SENSOR_TOPICS, WORLD_TOPICS
from mjsim.run import run
from mjsim.sim import Simulation
from mjsim.world import EVENT_KINDS, parse_world
from tests.record_ticks import hand_made_ticks, record

WORLD = """mjsim: 1
name: everything
walls:
  - points: [[0, 0], [6, 0], [6, 4], [0, 4]]
    closed: true
    openings: [{name: gate, segment: 0, at: 2, width: 0.9, door: {}}]
obstacles: [{name: box, box: [0.3, 0.3, 0.3], at: [4, 3], movable: true, mass: 2}]
beacons: [{name: lion, at: [5.9, 2], heading_deg: 180}]
robots:
  - name: scout
    preset: pioneer3dx
    at: [1, 2]
    sensors:
      - {beacons: ring, range: [0.3, 8], fov_deg: 360, rate_hz: 25}
      - {lidar: scan, at: [0.1, 0, 0.3], beams: 9, fov_deg: 180, range: [0.05, 3], rate_hz: 12.5}
      - {imu: inertial, rate_hz: 50}
run:
  drivers:
    scout:
      estimator: {use: "mjsim.algorithms.ekf_slam:EkfSlam"}
      navigator: {use: "mjsim.algorithms.waypoints:Waypoints", points: [[5, 2]]}
  events:
    - {time: 0.2, move: box, to: [3, 3]}
    - {time: 0.3, light: 0.4}
"""
FOXGLOVE_TYPES = ("boolean", "string", "number", "integer", "object", "array")
"""What Foxglove takes as `type`: one word."""


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, ...]:
    """A run of a world with every kind of sensor and an event, and ticks made by hand that hold every kind of value."""
    folder = tmp_path_factory.mktemp("schemas")
    with Simulation(parse_world(WORLD)) as sim:
        run(sim, seconds=1.0, record=folder / "run.mcap")
    return folder / "run.mcap", record(folder / "hand.mcap", hand_made_ticks(10))


def messages(path: Path) -> Iterator[tuple[str, dict[str, Any], dict[str, Any]]]:
    """Yield topic, schema and content of each JSON message of a file."""
    with path.open("rb") as stream:
        for schema, channel, message in make_reader(stream).iter_messages():
            if channel.message_encoding == "json":
                yield channel.topic, json.loads(schema.data), json.loads(message.data)


@pytest.mark.slow
def test_every_recorded_message_fits_the_schema_that_it_is_recorded_with(recordings: tuple[Path, ...]):
    seen, nulls = set(), 0
    validators: dict[str, jsonschema.protocols.Validator] = {}
    for path in recordings:
        for topic, schema, message in messages(path):
            kind = validators.setdefault(json.dumps(schema), jsonschema.validators.validator_for(schema)(schema))
            assert [error.message for error in kind.iter_errors(message)] == [], topic
            seen.add(topic.rpartition("/")[2])
            nulls += message.get("proximity", []).count(None)
    assert nulls, "no ray met nothing; then this shows little"
    # No estimator of these worlds offers a final path; tests/run/test_final_path.py has one that does.
    assert seen >= {
        *ROBOT_TOPICS,
        *(name for name, _ in SENSOR_TOPICS.values()),
        *(name[1:] for name in WORLD_TOPICS),
    } - {"path"}


def test_a_message_that_lacks_something_or_has_null_elsewhere_does_not_fit(recordings: tuple[Path, ...]):
    schema, message = next((schema, message) for topic, schema, message in messages(recordings[0]) if "obs" in topic)
    validator = jsonschema.validators.validator_for(schema)(schema)
    assert not validator.is_valid({**message, "dt": None})
    assert not validator.is_valid({**message, "proximity": ["1"]})
    assert not validator.is_valid({key: value for key, value in message.items() if key != "odometry"})


def test_foxglove_finds_one_known_type_at_each_field(recordings: tuple[Path, ...]):
    for _, schema, _ in messages(recordings[0]):
        _check_types(schema)


def _check_types(schema: dict[str, Any]) -> None:
    """Foxglove's reader knows neither unions nor references, nor arrays in arrays, and refuses the whole topic."""
    assert schema["type"] in FOXGLOVE_TYPES
    for field in schema.get("properties", {}).values():
        _check_types(field)
    if schema["type"] == "array":
        assert schema["items"]["type"] != "array"
        _check_types(schema["items"])


def test_every_key_of_every_event_has_its_place_in_the_topic_of_events():
    said = set(WORLD_TOPICS["/events"]["properties"]["event"]["properties"])
    # Later targets of a motion are recorded as events of their own.
    assert {key for kind in EVENT_KINDS.values() for key in kind.model_fields} - {"then"} == said
