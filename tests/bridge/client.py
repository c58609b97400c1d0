"""A client of `simulation_interfaces` that shares nothing with mjsim: types by its definitions, CDR by cyclonedds.

    python -m tests.bridge.client WORLD [DOMAIN]

It starts `mjsim bridge WORLD`, calls its services, and prints the answers as JSON.
"""

import json
import os
import signal
import sys
import time
from dataclasses import dataclass, field

from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import int32, int64, sequence, uint8, uint16, uint32, uint64
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

from tests.children import child

PATIENCE = 60.0
SERVICE = "simulation_interfaces::srv::dds_::"
RELIABLE = Qos(Policy.Reliability.Reliable(10**9), Policy.Durability.Volatile, Policy.History.KeepLast(10))


@dataclass
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    sec: int32 = 0
    nanosec: uint32 = 0


@dataclass
class Header(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    stamp: Time = field(default_factory=Time)
    frame_id: str = ""


@dataclass
class Vector3(IdlStruct, typename="geometry_msgs::msg::dds_::Vector3_"):
    x: float = 0.0
    y: float = 0.0
    z: float = 0.0


@dataclass
class Quaternion(IdlStruct, typename="geometry_msgs::msg::dds_::Quaternion_"):
    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    w: float = 1.0


@dataclass
class Pose(IdlStruct, typename="geometry_msgs::msg::dds_::Pose_"):
    position: Vector3 = field(default_factory=Vector3)
    orientation: Quaternion = field(default_factory=Quaternion)


@dataclass
class Twist(IdlStruct, typename="geometry_msgs::msg::dds_::Twist_"):
    linear: Vector3 = field(default_factory=Vector3)
    angular: Vector3 = field(default_factory=Vector3)


@dataclass
class EntityState(IdlStruct, typename="simulation_interfaces::msg::dds_::EntityState_"):
    header: Header = field(default_factory=Header)
    pose: Pose = field(default_factory=Pose)
    twist: Twist = field(default_factory=Twist)
    acceleration: Twist = field(default_factory=Twist)


@dataclass
class Result(IdlStruct, typename="simulation_interfaces::msg::dds_::Result_"):
    result: uint8
    error_message: str


@dataclass
class Features(IdlStruct, typename="simulation_interfaces::msg::dds_::SimulatorFeatures_"):
    features: sequence[uint16]
    spawn_formats: sequence[str]
    custom_info: str


@dataclass
class Resource(IdlStruct, typename="simulation_interfaces::msg::dds_::Resource_"):
    uri: str = ""
    resource_string: str = ""


@dataclass
class PoseStamped(IdlStruct, typename="geometry_msgs::msg::dds_::PoseStamped_"):
    header: Header = field(default_factory=Header)
    pose: Pose = field(default_factory=Pose)


@dataclass
class FeaturesRequest(IdlStruct, typename=f"{SERVICE}GetSimulatorFeatures_Request_"):
    guid: uint64
    number: int64
    structure_needs_at_least_one_member: uint8 = 0


@dataclass
class FeaturesResponse(IdlStruct, typename=f"{SERVICE}GetSimulatorFeatures_Response_"):
    guid: uint64
    number: int64
    features: Features


@dataclass
class SpawnRequest(IdlStruct, typename=f"{SERVICE}SpawnEntity_Request_"):
    guid: uint64
    number: int64
    name: str
    allow_renaming: bool
    entity_resource: Resource
    entity_namespace: str
    initial_pose: PoseStamped


@dataclass
class SpawnResponse(IdlStruct, typename=f"{SERVICE}SpawnEntity_Response_"):
    guid: uint64
    number: int64
    result: Result
    entity_name: str


@dataclass
class Bounds(IdlStruct, typename="simulation_interfaces::msg::dds_::Bounds_"):
    type: uint8
    points: sequence[Vector3]


@dataclass
class Spawnable(IdlStruct, typename="simulation_interfaces::msg::dds_::Spawnable_"):
    entity_resource: Resource
    description: str
    spawn_bounds: Bounds


@dataclass
class SpawnablesRequest(IdlStruct, typename=f"{SERVICE}GetSpawnables_Request_"):
    guid: uint64
    number: int64
    sources: sequence[str]


@dataclass
class SpawnablesResponse(IdlStruct, typename=f"{SERVICE}GetSpawnables_Response_"):
    guid: uint64
    number: int64
    result: Result
    spawnables: sequence[Spawnable]


@dataclass
class DeleteRequest(IdlStruct, typename=f"{SERVICE}DeleteEntity_Request_"):
    guid: uint64
    number: int64
    entity: str


@dataclass
class DeleteResponse(IdlStruct, typename=f"{SERVICE}DeleteEntity_Response_"):
    guid: uint64
    number: int64
    result: Result


@dataclass
class GetRequest(IdlStruct, typename=f"{SERVICE}GetEntityState_Request_"):
    guid: uint64
    number: int64
    entity: str


@dataclass
class GetResponse(IdlStruct, typename=f"{SERVICE}GetEntityState_Response_"):
    guid: uint64
    number: int64
    result: Result
    state: EntityState


@dataclass
class SetRequest(IdlStruct, typename=f"{SERVICE}SetEntityState_Request_"):
    guid: uint64
    number: int64
    entity: str
    state: EntityState
    set_pose: bool
    set_twist: bool
    set_acceleration: bool


@dataclass
class SetResponse(IdlStruct, typename=f"{SERVICE}SetEntityState_Response_"):
    guid: uint64
    number: int64
    result: Result


@dataclass
class StepRequest(IdlStruct, typename=f"{SERVICE}StepSimulation_Request_"):
    guid: uint64
    number: int64
    steps: uint64


@dataclass
class StepResponse(IdlStruct, typename=f"{SERVICE}StepSimulation_Response_"):
    guid: uint64
    number: int64
    result: Result


@dataclass
class ResetRequest(IdlStruct, typename=f"{SERVICE}ResetSimulation_Request_"):
    guid: uint64
    number: int64
    scope: uint8


@dataclass
class ResetResponse(IdlStruct, typename=f"{SERVICE}ResetSimulation_Response_"):
    guid: uint64
    number: int64
    result: Result


class Client:
    """Calls one service; a request is sent again until it is answered, as discovery takes its time."""

    def __init__(self, participant, name, request, response):
        self._request, self._number = request, 0
        self._writer = DataWriter(participant, Topic(participant, f"rq/mjsim/{name}Request", request), qos=RELIABLE)
        self._reader = DataReader(participant, Topic(participant, f"rr/mjsim/{name}Reply", response), qos=RELIABLE)

    def __call__(self, *fields):
        end = time.monotonic() + PATIENCE
        while not self._writer.get_matched_subscriptions() or not self._reader.get_matched_publications():
            assert time.monotonic() < end, "nobody offers the service"
            time.sleep(0.05)
        self._number += 1
        self._writer.write(self._request(4711, self._number, *fields))
        while time.monotonic() < end:
            for answer in self._reader.take(N=10):
                if (answer.guid, answer.number) == (4711, self._number):
                    return answer
            time.sleep(0.01)
        raise AssertionError("no answer")


def called(participant):
    """Return what the services answer, by what was asked."""
    spawn = Client(participant, "spawn_entity", SpawnRequest, SpawnResponse)
    spawnables = Client(participant, "get_spawnables", SpawnablesRequest, SpawnablesResponse)
    delete = Client(participant, "delete_entity", DeleteRequest, DeleteResponse)
    get = Client(participant, "get_entity_state", GetRequest, GetResponse)
    put = Client(participant, "set_entity_state", SetRequest, SetResponse)
    step = Client(participant, "step_simulation", StepRequest, StepResponse)
    reset = Client(participant, "reset_simulation", ResetRequest, ResetResponse)
    features = Client(participant, "get_simulator_features", FeaturesRequest, FeaturesResponse)().features
    answers = {"features": [*features.features], "formats": [*features.spawn_formats], "info": features.custom_info}
    text = Resource(resource_string="<sdf version='1.9'><model name='m'/></sdf>")
    answers["text"] = vars(spawn("crate-2", True, text, "", PoseStamped()).result)
    answers["file"] = vars(spawn("crate-2", True, Resource("file:///box.sdf"), "", PoseStamped()).result)
    there = EntityState(Header(frame_id="map"), Pose(Vector3(3.0, 1.0, 0.0)))
    answers["set"] = vars(put("crate", there, True, False, False).result)
    answers["stepped"] = vars(step(3).result)
    moved = get("crate").state
    answers["crate"] = [moved.pose.position.x, moved.pose.position.y, moved.header.frame_id, moved.header.stamp.nanosec]
    answers["unknown"] = vars(get("crat").result)
    answers["deleted"] = vars(delete("crate").result)
    answers["stepped again"] = vars(step(1).result)
    answers["gone"] = vars(get("crate").result)
    answers["spawnable"] = [[each.entity_resource.uri, each.description] for each in spawnables([]).spawnables]
    here = PoseStamped(Header(frame_id="world"), Pose(Vector3(1.0, -1.0, 0.0), Quaternion(0.0, 0.0, 0.6, 0.8)))
    spawned = spawn("", False, Resource("crate"), "", here)
    answers["spawned"] = {**vars(spawned.result), "name": spawned.entity_name}
    answers["stepped thrice"] = vars(step(1).result)
    pose = get("crate").state.pose
    answers["there"] = [pose.position.x, pose.position.y, pose.orientation.z, pose.orientation.w]
    answers["left"] = len(spawnables([]).spawnables)
    answers["reset"] = vars(reset(0).result)
    back = get("crate").state.pose.position
    answers["back"] = [back.x, back.y]
    return answers


def main(world: str, *domain: str) -> None:
    """Start the bridge, and print the answers of its services."""
    if domain:
        os.environ["ROS_DOMAIN_ID"] = domain[0]
    else:
        from mjsim.bridge import bring_loopback_up

        bring_loopback_up()
    os.environ["CYCLONEDDS_URI"] = (
        "<CycloneDDS><Domain><General><Interfaces><NetworkInterface address='127.0.0.1' multicast='true'/></Interfaces>"
        "</General><Discovery><ParticipantIndex>auto</ParticipantIndex><Peers><Peer address='127.0.0.1'/></Peers>"
        "</Discovery></Domain></CycloneDDS>"
    )
    with child([sys.executable, "-m", "mjsim.cli", "bridge", world, "--paused"]) as bridge:
        sys.stdout.write(json.dumps(called(DomainParticipant(int(os.environ.get("ROS_DOMAIN_ID", "0"))))))
        bridge.send(signal.SIGINT)
        assert bridge.ended() == 130


if __name__ == "__main__":
    main(*sys.argv[1:])
