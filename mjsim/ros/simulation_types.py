"""Messages and services of the ROS package `simulation_interfaces` 2.1, as far as the bridge uses them."""

_PACKAGE = "simulation_interfaces"
RESULT, STATE, FEATURES, ENTITY_STATE, SPAWNABLE = (
    f"{_PACKAGE}/msg/{name}" for name in ("Result", "SimulationState", "SimulatorFeatures", "EntityState", "Spawnable")
)
RESOURCE, BOUNDS = f"{_PACKAGE}/msg/Resource", f"{_PACKAGE}/msg/Bounds"
_MESSAGES = {
    RESULT: "uint8 result\nstring error_message",
    STATE: "uint8 state",
    FEATURES: "uint16[] features\nstring[] spawn_formats\nstring custom_info",
    ENTITY_STATE: (
        "std_msgs/Header header\ngeometry_msgs/Pose pose\ngeometry_msgs/Twist twist\ngeometry_msgs/Accel acceleration"
    ),
    RESOURCE: "string uri\nstring resource_string",
    f"{_PACKAGE}/msg/EntityCategory": "uint8 category",
    f"{_PACKAGE}/msg/TagsFilter": "string[] tags\nuint8 filter_mode",
    BOUNDS: "uint8 type\ngeometry_msgs/Vector3[] points",
    SPAWNABLE: f"{_PACKAGE}/Resource entity_resource\nstring description\n{_PACKAGE}/Bounds spawn_bounds",
    f"{_PACKAGE}/msg/EntityFilters": (
        f"string filter\n{_PACKAGE}/EntityCategory[] categories\n{_PACKAGE}/TagsFilter tags\n{_PACKAGE}/Bounds bounds"
    ),
}
_NOTHING = "uint8 structure_needs_at_least_one_member"
_RESULT = f"{_PACKAGE}/Result result"
_STATE = f"{_PACKAGE}/SimulationState state"
_SERVICES = {
    "GetSimulatorFeatures": (_NOTHING, f"{_PACKAGE}/SimulatorFeatures features"),
    "SpawnEntity": (
        f"string name\nbool allow_renaming\n{_PACKAGE}/Resource entity_resource\nstring entity_namespace\n"
        "geometry_msgs/PoseStamped initial_pose",
        f"{_RESULT}\nstring entity_name",
    ),
    "GetSpawnables": ("string[] sources", f"{_RESULT}\n{_PACKAGE}/Spawnable[] spawnables"),
    "DeleteEntity": ("string entity", _RESULT),
    "GetEntities": (f"{_PACKAGE}/EntityFilters filters", f"{_RESULT}\nstring[] entities"),
    "GetEntityState": ("string entity", f"{_RESULT}\n{_PACKAGE}/EntityState state"),
    "SetEntityState": (
        f"string entity\n{_PACKAGE}/EntityState state\nbool set_pose\nbool set_twist\nbool set_acceleration",
        _RESULT,
    ),
    "StepSimulation": ("uint64 steps", _RESULT),
    "ResetSimulation": ("uint8 scope", _RESULT),
    "GetSimulationState": (_NOTHING, f"{_STATE}\n{_RESULT}"),
    "SetSimulationState": (_STATE, _RESULT),
}
"""Fields of request and response by service, without constants, which are part of no message."""


def simulation_types(head: str) -> dict[str, str]:
    """Return the definition of each type by its name in rosbags, services after the messages that they hold.

    Args:
        head: Fields before those of each request and response.
    """
    services = {
        f"{_PACKAGE}/srv/msg/{name}_{part}": f"{head}{fields}"
        for name, both in _SERVICES.items()
        for part, fields in zip(("Request", "Response"), both, strict=True)
    }
    return {**_MESSAGES, **services}
