"""JSON Schemas of the topics that are written as JSON.

Foxglove reads JSON Schema without unions and without arrays in arrays, so a matrix is a flat list, row by row, and
what is not there is left out. Where a topic's schema carries the name of one of Foxglove's own, its messages hold
that schema's fields and exact numbers beside them.
"""

from typing import Any

Schema = dict[str, Any]

EXACT = "Numbers are IEEE doubles, written so that they read back exactly; null stands for +infinity."


def _number(description: str) -> Schema:
    return {"type": "number", "description": description}


def _numbers(description: str) -> Schema:
    return {"type": "array", "items": {"type": "number"}, "description": description}


def _text(description: str) -> Schema:
    return {"type": "string", "description": description}


def _packed(rows: str) -> Schema:
    description = f"Little-endian doubles, row by row: {rows}"
    return {"type": "string", "contentEncoding": "base64", "description": description}


def _object(properties: Schema, description: str = "") -> Schema:
    return {"type": "object", "description": description, "properties": properties}


def _list(item: Schema, description: str) -> Schema:
    return {"type": "array", "items": item, "description": description}


def _topic(title: str, description: str, properties: Schema) -> Schema:
    return {"title": title} | _object({"time": TIME} | properties, f"{description} {EXACT}")


TIME = _number("Simulated time [s]")
_STAMP = _object({"sec": {"type": "integer"}, "nsec": {"type": "integer"}}, "Simulated time, rounded to 1 ns")
_XYZ: Schema = {axis: {"type": "number"} for axis in "xyz"}
_POSE = _object({"position": _object(_XYZ, "[m]"), "orientation": _object(_XYZ | {"w": {"type": "number"}})})
_FRAME = {"timestamp": _STAMP, "frame_id": _text("Frame of the poses")}
_NUMBERED: Schema = {"type": "boolean", "description": "Whether the name is a whole number"}
_SIGHTING = _object(
    {
        "stamp": _number("[s]"),
        "name": _text("Left out when the sensor cannot tell"),
        "range": _number("Horizontal, from the robot's origin [m]"),
        "bearing": _number("From the robot's x axis, left positive [rad]"),
        "covariance": _numbers("Of (range, bearing), 2 x 2"),
        "corners": _numbers("u, v of 4 corners from the picture's own top left clockwise [px]; left out without"),
    }
)
_SCAN = _object(
    {
        "name": _text("Of the lidar"),
        "stamp": _number("[s]"),
        "angle_min": _number("Of the first beam, left positive [rad]"),
        "angle_increment": _number("From beam to beam [rad]"),
        "range_min": _number("[m]"),
        "range_max": _number("[m]"),
        "ranges": _packed("one a beam [m]; infinite as ROS REP 117 has it"),
        "intensities": _packed("one a beam; left out unless the lidar tells"),
    }
)
_SIGHTINGS = _list(_SIGHTING, "Beacons seen")
_COMMAND = _object(
    {
        "messages": _list({"type": "string"}, "Sent to other robots, as JSON; left out without"),
        "forward": _number("[m/s]"),
        "left": _number("[m/s]"),
        "turn": _number("Counter-clockwise [rad/s]"),
        "wheels": _numbers("[rad/s], instead of the others"),
    }
)

POSE = _topic(
    "foxglove.PoseInFrame",
    "A pose in the plane.",
    _FRAME
    | {
        "pose": _POSE,
        "heading": _number("Counter-clockwise from x [rad]"),
        "covariance": _numbers("Of (x, y, heading), 3 x 3; left out for the truth"),
    },
)
LANDMARKS = _topic(
    "foxglove.PosesInFrame",
    "The estimated map, whole, whenever it has changed.",
    _FRAME
    | {
        "poses": _list(_POSE, "Position of each landmark"),
        "names": _list({"type": "string"}, "Of each landmark"),
        "numbered": _list({"type": "boolean"}, "Whether a name is a whole number"),
        "covariances": _numbers("Of (x, y), 2 x 2, one after the other [m^2]"),
    },
)
OBSERVATION = _topic(
    "mjsim.Observation",
    "Every number that a robot's modules were given.",
    {
        "dt": _number("Since the last tick [s]"),
        "odometry": _object(
            {
                "forward": _number("[m]"),
                "left": _number("[m]"),
                "turn": _number("[rad]"),
                "covariance": _numbers("3 x 3"),
            },
            "Motion since the last tick as the wheels tell it",
        ),
        "sightings": _SIGHTINGS,
        "proximity": _numbers("Ring of ranges, first ahead, then counter-clockwise [m]"),
        "bump": _numbers("Bearings of contacts, left positive [rad]"),
        "cameras": _list(_object({"name": _text("Of the camera"), "stamp": _number("[s]")}), "Pictures given"),
        "scans": _list(_SCAN, "Of lidars, where due"),
        "imu": _list(
            _object({"name": _text("Of the sensor"), "readings": _packed("stamp, acceleration x y z, turn x y z")}),
            "Since the last tick",
        ),
        "messages": _list(
            _object({"sender": _text("Robot"), "stamp": _number("[s]"), "text": _text("Content as JSON")}),
            "What the radio brought",
        ),
    },
)
IMU = _topic(
    "mjsim.Imu",
    "Readings of inertial sensors since the last tick.",
    {
        "readings": _list(
            _object(
                {
                    "name": _text("Of the sensor"),
                    "stamp": _number("[s]"),
                    "acceleration": _object(_XYZ, "Specific force in the sensor's frame [m/s^2]"),
                    "turn": _object(_XYZ, "Angular velocity in the sensor's frame [rad/s]"),
                }
            ),
            "In time, one sensor after the other",
        )
    },
)
IDENTITIES = _topic(
    "mjsim.Identities",
    "Which beacons the sensors truly saw; no module is told.",
    {"names": _list({"type": "string"}, "Of each of the first sightings of the tick; empty for one of nothing")},
)
SIGHTINGS = _topic("mjsim.Sightings", "All sightings of a tick, of sensors and observer.", {"sightings": _SIGHTINGS})
INNOVATIONS = _topic(
    "mjsim.Innovations",
    "What the estimator was surprised by.",
    {
        "innovations": _list(
            _object(
                {
                    "name": _text("Of the landmark"),
                    "numbered": _NUMBERED,
                    "nu": _numbers("[m, rad]"),
                    "S": _numbers("Covariance of nu, 2 x 2"),
                }
            ),
            "One a sighting used",
        )
    },
)
COVARIANCE = _topic(
    "mjsim.JointCovariance",
    "Of the pose, then of each landmark.",
    {
        "names": _list({"type": "string"}, "Of each landmark"),
        "numbered": _list({"type": "boolean"}, "Whether a name is a whole number"),
        "size": {"type": "integer", "description": "Rows of the matrix"},
        "lower": _packed("the lower triangle"),
    },
)
COMMAND = _topic(
    "mjsim.Command", "What the drive is told, and what the navigator wanted.", {"command": _COMMAND, "wanted": _COMMAND}
)
EVENT = _topic(
    "foxglove.Log",
    "Something that happened to a robot.",
    {
        "timestamp": _STAMP,
        "level": {"type": "integer", "description": "2 information, 3 warning, 4 error"},
        "message": _text("For people"),
        "name": _text("Of the robot"),
        "file": _text("Empty"),
        "line": {"type": "integer", "description": "0"},
        "kind": _text("bump, blocked, fault or changed"),
        "bearing": _number("Where it was touched, left positive [rad]; left out otherwise"),
    },
)
WORLD_EVENT = _topic(
    "foxglove.Log",
    "Something that happened to the world.",
    {
        "timestamp": _STAMP,
        "level": {"type": "integer", "description": "2, information"},
        "message": _text("For people"),
        "name": _text("world"),
        "file": _text("Empty"),
        "line": {"type": "integer", "description": "0"},
        "event": _object(
            {
                "move": _text("What was put down elsewhere"),
                "to": _numbers("x, y [m]"),
                "heading_deg": _number("Left out when it stayed as it was"),
                "open": _text("Door"),
                "angle_deg": _number("Positive to the left side of the wall"),
                "close": _text("Door"),
                "light": _number("General light"),
                "lamp": _text("Name"),
                "brightness": _number("Of the lamp"),
                "remove": _text("What was taken away"),
            },
            "With the keys of `run: events:` in a world file",
        ),
    },
)
THINGS = _topic(
    "mjsim.Things",
    "Where everything is that can move but robots; of a door its hinge, and the heading of its leaf.",
    {
        "things": _list(
            _object(
                {
                    "name": _text("'obstacle/NAME' or 'door/NAME'"),
                    "x": _number("World frame [m]"),
                    "y": _number("World frame [m]"),
                    "heading": _number("Counter-clockwise from x [rad]"),
                }
            ),
            "Without what was taken away",
        )
    },
)
STATE = _topic(
    "mjsim.State",
    "State of MuJoCo; the last message of each tick.",
    {"qpos": _numbers("qpos"), "qvel": _numbers("qvel")},
)
TIMING = _topic(
    "mjsim.Timing",
    "Wall-clock time; the one topic that differs between equal runs.",
    {
        "clock": _number("Since the recording began [s]"),
        "parts": _list(
            _object({"part": _text("'ROBOT/module' or 'loop/part'"), "seconds": _number("[s]")}), "Cost of this tick"
        ),
    },
)

ROBOT_TOPICS = {
    "observation": OBSERVATION,
    "truth": POSE,
    "odometry": POSE,
    "estimate": POSE,
    "landmarks": LANDMARKS,
    "covariance": COVARIANCE,
    "sightings": SIGHTINGS,
    "innovations": INNOVATIONS,
    "command": COMMAND,
    "events": EVENT,
}
"""Topics of robot R are '/R/' and one of these names; its pictures are '/R/CAMERA/image', its scans '/R/scan'."""
SENSOR_TOPICS = {"beacons": ("identities", IDENTITIES), "imu": ("imu", IMU)}
"""Topics that only a robot with a sensor of a kind has."""

WORLD_TOPICS = {"/events": WORLD_EVENT, "/things": THINGS, "/state": STATE, "/timing": TIMING}
"""Topics of the world, and of the run."""
