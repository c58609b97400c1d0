"""mjsim: a simulator for navigation and SLAM of indoor wheeled robots, with real camera pictures.

Everything public is here: `import mjsim`, then `mjsim.load_world`, `mjsim.Simulation`, `mjsim.run` and so on.
"""

from typing import TYPE_CHECKING, Any

from mjsim.errors import (
    MjsimError,
    ModuleFault,
    OpenGLError,
    PhysicsFault,
    RecordingError,
    UsageError,
    WorldError,
)
from mjsim.geometry import Pose
from mjsim.gl_request import hide_request_from_mujoco
from mjsim.interface import (
    Avoidance,
    BeaconInfo,
    CameraFrame,
    Command,
    Detection,
    DriveModel,
    Estimate,
    Estimator,
    ImuReading,
    Intrinsics,
    MarkerInfo,
    Message,
    Navigator,
    Observation,
    Observer,
    Odometry,
    RobotInfo,
    Scan,
    SensorInfo,
    Sighting,
    TakesMap,
    WheelCommand,
    WorldMap,
    sightings_from,
)
from mjsim.run import Driver, run, ticks
from mjsim.sweep import sweep
from mjsim.world import World, format_world, load_world, parse_world

hide_request_from_mujoco()  # Before anything imports mujoco, which nothing above does.

if TYPE_CHECKING:
    from mjsim.compile import compile_world
    from mjsim.exchange import (
        maze_world,
        world_from_dxf,
        world_from_map,
        world_from_svg,
        write_map,
        write_sdf,
        write_svg,
    )
    from mjsim.logs import import_mrclam, import_victoria_park
    from mjsim.record import Recording, Tick, read_recording
    from mjsim.report import compare, statistics
    from mjsim.run.replay import replay
    from mjsim.session import Session, Watcher
    from mjsim.sim import Simulation
    from mjsim.web.studio import Studio

# What needs MuJoCo or reads files is brought in when it is first asked for, so that `import mjsim` stays quick.
_LATER = {
    "Recording": "mjsim.record",
    "Session": "mjsim.session",
    "Simulation": "mjsim.sim",
    "Studio": "mjsim.web.studio",
    "Tick": "mjsim.record",
    "Watcher": "mjsim.session",
    "compare": "mjsim.report",
    "compile_world": "mjsim.compile",
    "import_mrclam": "mjsim.logs",
    "import_victoria_park": "mjsim.logs",
    "maze_world": "mjsim.exchange",
    "read_recording": "mjsim.record",
    "replay": "mjsim.run.replay",
    "statistics": "mjsim.report",
    "world_from_dxf": "mjsim.exchange",
    "world_from_map": "mjsim.exchange",
    "world_from_svg": "mjsim.exchange",
    "write_map": "mjsim.exchange",
    "write_sdf": "mjsim.exchange",
    "write_svg": "mjsim.exchange",
}

__all__ = [
    "Avoidance",
    "BeaconInfo",
    "CameraFrame",
    "Command",
    "Detection",
    "DriveModel",
    "Driver",
    "Estimate",
    "Estimator",
    "ImuReading",
    "Intrinsics",
    "MarkerInfo",
    "Message",
    "MjsimError",
    "ModuleFault",
    "Navigator",
    "Observation",
    "Observer",
    "Odometry",
    "OpenGLError",
    "PhysicsFault",
    "Pose",
    "Recording",
    "RecordingError",
    "RobotInfo",
    "Scan",
    "SensorInfo",
    "Session",
    "Sighting",
    "Simulation",
    "Studio",
    "TakesMap",
    "Tick",
    "UsageError",
    "Watcher",
    "WheelCommand",
    "World",
    "WorldError",
    "WorldMap",
    "compare",
    "compile_world",
    "format_world",
    "import_mrclam",
    "import_victoria_park",
    "load_world",
    "maze_world",
    "parse_world",
    "read_recording",
    "replay",
    "run",
    "sightings_from",
    "statistics",
    "sweep",
    "ticks",
    "world_from_dxf",
    "world_from_map",
    "world_from_svg",
    "write_map",
    "write_sdf",
    "write_svg",
]


def __getattr__(name: str) -> Any:
    if name in _LATER:
        import importlib

        return getattr(importlib.import_module(_LATER[name]), name)
    raise AttributeError(f"module 'mjsim' has no attribute '{name}'")
