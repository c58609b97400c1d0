"""JSON Schemas of the topics that are written as JSON.

If a topic's schema has the name of one of Foxglove's, its messages have the fields of that schema, and exact numbers
beside them. The schemas of the parts of an observation are beside their codecs, in `readings`.
"""

from typing import get_args

from mjsim.record.drawn import SHOW
from mjsim.record.json_schema import (
    STAMP,
    Schema,
    boolean,
    integer,
    keyed,
    listed,
    number,
    numbers,
    one_of,
    packed,
    text,
    topic,
)
from mjsim.record.readings import CODECS, codec_of
from mjsim.record.tick import EventKind

_XYZ: Schema = {axis: {"type": "number"} for axis in "xyz"}
_POSE = keyed({"position": keyed(_XYZ, "[m]"), "orientation": keyed(_XYZ | {"w": {"type": "number"}})})
_FRAME = {"timestamp": STAMP, "frame_id": text("Frame of the poses")}
_NUMBERED: Schema = boolean("Whether the name is a whole number")
_COMMAND = keyed(
    {
        "messages": listed({"type": "string"}, "Sent to other robots, as JSON; omitted if none"),
        "forward": number("[m/s]"),
        "left": number("[m/s]"),
        "turn": number("Counter-clockwise [rad/s]"),
        "wheels": numbers("[rad/s], instead of the others"),
        "joints": listed(
            keyed(
                {
                    "arm": text("Name"),
                    "positions": numbers("[rad], or [m] of joints that slide"),
                    "velocities": numbers("[rad/s], or [m/s]"),
                    "accelerations": numbers("[rad/s^2], or [m/s^2]"),
                    "torques": numbers("[N m], or [N]"),
                },
                optional=("velocities", "accelerations", "torques"),
            ),
            "Goals of arms; omitted if none",
        ),
    },
    optional=("messages", "forward", "left", "turn", "wheels", "joints"),
)

POSE = topic(
    "foxglove.PoseInFrame",
    "A pose in the plane.",
    _FRAME
    | {
        "pose": _POSE,
        "heading": number("Counter-clockwise from x [rad]"),
        "covariance": numbers("Of (x, y, heading), 3 x 3; omitted for the truth", count=9),
    },
    optional=("covariance",),
)
PATH = topic(
    "mjsim.Path",
    "The final trajectory, estimated from the complete run; one message, after the last tick.",
    {
        "times": numbers("[s]"),
        "x": numbers("World frame [m]"),
        "y": numbers("World frame [m]"),
        "heading": numbers("Counter-clockwise from x [rad]"),
    },
)
LANDMARKS = topic(
    "foxglove.PosesInFrame",
    "The complete estimated map, whenever it has changed.",
    _FRAME
    | {
        "poses": listed(_POSE, "Position of each landmark"),
        "names": listed({"type": "string"}, "Of each landmark"),
        "numbered": listed({"type": "boolean"}, "Whether a name is a whole number"),
        "covariances": numbers("Of (x, y), 2 x 2, one after the other [m^2]"),
    },
)
OBSERVATION = topic(
    "mjsim.Observation",
    "Every number that a robot's modules were given.",
    {"dt": number("Since the last tick [s]")} | {codec.field: codec.schema for codec in CODECS},
    optional=[codec.field for codec in CODECS if codec.optional],
)
SIGHTINGS = topic(
    "mjsim.Sightings", "All sightings of a tick, of sensors and observer.", {"sightings": codec_of("beacons").schema}
)
INNOVATIONS = topic(
    "mjsim.Innovations",
    "Innovations of the estimator.",
    {
        "innovations": listed(
            keyed(
                {
                    "name": text("Of the landmark"),
                    "numbered": _NUMBERED,
                    "nu": numbers("[m, rad]", count=2),
                    "S": numbers("Covariance of nu, 2 x 2", count=4),
                }
            ),
            "One per sighting used",
        )
    },
)
COVARIANCE = topic(
    "mjsim.JointCovariance",
    "Of the pose, then of each landmark.",
    {
        "names": listed({"type": "string"}, "Of each landmark"),
        "numbered": listed({"type": "boolean"}, "Whether a name is a whole number"),
        "size": integer("Rows of the matrix"),
        "lower": packed("the lower triangle"),
    },
)
JOINTS = topic(
    "mjsim.Joints",
    "Joints of an arm or a mechanism; m and N for sliding joints.",
    {
        "names": listed({"type": "string"}, "Of the joints"),
        "positions": numbers("[rad]"),
        "velocities": numbers("[rad/s]"),
        "accelerations": numbers("In the last step of the physics [rad/s^2]"),
        "torques": numbers("Of the motors, at the joints [N m]"),
        "goal": numbers("Goals of the positions [rad]"),
    },
)
JOINT_STATES = topic(
    "foxglove.JointStates",
    "True state of all joints of a robot or a mechanism; m and N for sliding joints.",
    {
        "timestamp": STAMP,
        "joints": listed(
            keyed(
                {
                    "name": text("'ARM/JOINT' of a robot, else as in the world"),
                    "position": number("[rad]"),
                    "velocity": number("[rad/s]"),
                    "acceleration": number("In the last step of the physics [rad/s^2]"),
                    "effort": number("Of the motor, at the joint [N m]"),
                }
            ),
            "In the order of the world",
        ),
    },
)
READINGS = topic(
    "mjsim.MechanismSensors",
    "Readings of the sensors of a mechanism.",
    {
        "names": listed({"type": "string"}, "Sensor and quantity, such as q4.velocity"),
        "units": listed({"type": "string"}, "Of each number"),
        "values": numbers("The numbers"),
    },
)
COMMAND = topic(
    "mjsim.Command",
    "Command to the drive, and that of the navigator before avoidance.",
    {"command": _COMMAND, "wanted": _COMMAND},
)
EVENT = topic(
    "foxglove.Log",
    "An event of a robot.",
    {
        "timestamp": STAMP,
        "level": integer("2 information, 3 warning, 4 error"),
        "message": text("For people"),
        "name": text("Of the robot"),
        "file": text("Empty"),
        "line": integer("0"),
        "kind": one_of(get_args(EventKind), "What happened"),
        "bearing": number("Where it was touched, left positive [rad]; omitted for other events"),
    },
    optional=("bearing",),
)
WORLD_EVENT = topic(
    "foxglove.Log",
    "An event of the world.",
    {
        "timestamp": STAMP,
        "level": integer("2, information"),
        "message": text("For people"),
        "name": text("world"),
        "file": text("Empty"),
        "line": integer("0"),
        "event": keyed(
            {
                "time": number("First tick not before it [s]"),
                "move": text("What is moved"),
                "to": numbers("x, y, and z of a hand [m]"),
                "heading_deg": number("Omitted if unchanged"),
                "open": text("Door"),
                "angle_deg": number("Positive towards the left side of the wall"),
                "close": text("Door"),
                "light": number("Ambient light"),
                "lamp": text("Name"),
                "brightness": number("Of the lamp"),
                "noise": text("Noise parameter, as `--set` names it"),
                "value": number("Its new value, in its unit"),
                "remove": text("What is removed"),
                "shove": text("Robot or obstacle"),
                "impulse": numbers("x, y, z [N s]"),
                "seconds": number("Duration of the push [s]"),
                "push": text("Robot or obstacle that is pushed"),
                "along": numbers("Direction of the force, x, y, z"),
                "signal": text("JSON: the force over time, as in the world file [N]"),
                "restore": text("What is restored"),
                "reach": text("Robot whose arm is moved, or person"),
                "hand": text("Which hand of a person: left or right"),
                "goal": text("Robot that got a new goal"),
                "release": text("Robot whose arm its navigator moves again, or person"),
                "arm": text("Which of its arms"),
                "joints_deg": numbers("Goals of its joints [deg, m]"),
                "tool": numbers("Goal of its tool, x, y, z in the robot's frame [m]"),
                "lead": text("Mechanism whose joint is moved"),
                "joint": text("Which of its joints"),
                "to_deg": number("Goal of that joint [deg, m]"),
                "rotation_deg": numbers("Goal of a ball joint, as a rotation vector [deg]"),
                "rpy_deg": numbers("Roll, pitch, yaw of its tool in the robot's frame"),
            },
            "With the keys of `run: events:` in a world file",
            optional=(
                *("move", "to", "heading_deg", "open", "angle_deg", "close"),
                *(
                    "light",
                    "lamp",
                    "brightness",
                    "noise",
                    "value",
                    "remove",
                    "shove",
                    "impulse",
                    "seconds",
                    "push",
                    "along",
                    "signal",
                ),
                *("restore", "reach", "release", "arm", "joints_deg", "tool", "rpy_deg", "hand"),
                *("lead", "joint", "to_deg", "rotation_deg", "goal"),
            ),
        ),
        "short": number("Distance by which a hand misses its target [m]; omitted if it reaches it"),
    },
    optional=("short",),
)
THINGS = topic(
    "mjsim.Things",
    "Poses of everything that can move, except robots; of a door, its hinge and the heading of its leaf.",
    {
        "things": listed(
            keyed(
                {
                    "name": text("'obstacle/NAME' or 'door/NAME'"),
                    "x": number("World frame [m]"),
                    "y": number("World frame [m]"),
                    "heading": number("Counter-clockwise from x [rad]"),
                }
            ),
            "Without removed ones",
        )
    },
)
STATE = topic(
    "mjsim.State",
    "State of MuJoCo; the last message of each tick.",
    {"qpos": numbers("qpos"), "qvel": numbers("qvel")},
)
TIMING = topic(
    "mjsim.Timing",
    "Wall-clock time; the one topic that differs between equal runs.",
    {
        "clock": number("Since the recording began [s]"),
        "parts": listed(
            keyed({"part": text("'ROBOT/module' or 'loop/part'"), "seconds": number("[s]")}), "Cost of this tick"
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
    "path": PATH,
    "show": SHOW,
    "command": COMMAND,
    "events": EVENT,
}
"""Topics of robot R are '/R/' and one of these names; its pictures are '/R/CAMERA/image', its scans '/R/scan'."""
JOINTED_TOPICS = {"joint_states": JOINT_STATES}
"""Further topics of a robot with joints."""
ARM_TOPICS = {"joints": JOINTS, "tool": POSE}
"""Topics of an arm are '/R/ARM/' and one of these names."""
MECHANISM_TOPICS = {"joints": JOINTS, "sensors": READINGS, **JOINTED_TOPICS}
"""Topics of a mechanism are '/MECHANISM/' and one of these names."""
SENSOR_TOPICS = {
    codec.sensor: (codec.topic.name, codec.topic.schema) for codec in CODECS if codec.sensor and codec.topic
}
"""Topics of robots with a sensor of a kind."""
STREAMS = {codec.sensor: (codec.stream.name, codec.stream.schema) for codec in CODECS if codec.sensor and codec.stream}
"""Topics of each sensor of a kind, '/R/SENSOR/' and the name."""

WORLD_TOPICS = {"/events": WORLD_EVENT, "/things": THINGS, "/state": STATE, "/timing": TIMING}
"""Topics of the world, and of the run."""
