"""A ROS 2 robot seen from outside: rosless, which is RustDDS, listens to `mjsim bridge` and drives the robot.

    python -m tests.bridge.peer FOLDER [DOMAIN]

In a network namespace of its own (`unshare -Urn`), loopback is brought up first; elsewhere a domain is given. All that
was received is written into FOLDER/heard.json, what was noticed into FOLDER/noticed.json.
"""

import json
import os
import signal
import sys
import time
from pathlib import Path

import rosless

from mjsim.bridge import Bus, bring_loopback_up, call_name
from mjsim.ros import Outgoing, typestore
from tests.children import child

PATIENCE = 150.0
TOPICS = {
    "/clock": "rosgraph_msgs/msg/Clock",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/tf_static": "tf2_msgs/msg/TFMessage",
    "/map": "nav_msgs/msg/OccupancyGrid",
    "/scout/scan": "sensor_msgs/msg/LaserScan",
    "/scout/imu": "sensor_msgs/msg/Imu",
    "/scout/odom": "nav_msgs/msg/Odometry",
    "/scout/truth": "geometry_msgs/msg/PoseStamped",
    "/scout/estimate": "geometry_msgs/msg/PoseWithCovarianceStamped",
    "/scout/front/image_raw": "sensor_msgs/msg/Image",
    "/scout/front/depth/image_raw": "sensor_msgs/msg/Image",
    "/scout/front/camera_info": "sensor_msgs/msg/CameraInfo",
    "/crank/joint_states": "sensor_msgs/msg/JointState",
}
SERVICES = {
    "pause": "std_srvs/srv/SetBool",
    "step": "std_srvs/srv/Trigger",
    "reset": "std_srvs/srv/Trigger",
    "get_simulator_features": "simulation_interfaces/srv/GetSimulatorFeatures",
    "step_simulation": "simulation_interfaces/srv/StepSimulation",
    "get_entity_state": "simulation_interfaces/srv/GetEntityState",
}
LATCHED = {"/tf_static", "/map"}


class Services:
    """A client of services, as rmw_cyclonedds has it."""

    def __init__(self, domain: int) -> None:
        self._bus, self._number, self._answers = Bus(domain=domain), 0, {}
        self._topics = {}
        for name, kind in SERVICES.items():
            request, response = call_name(f"/mjsim/{name}", kind)
            self._topics[name] = request
            self._bus.announce(request, space="rq")
            self._bus.receive(response, self._take, space="rr")
        self._bus.start()

    def _take(self, response) -> None:
        self._answers[response.guid, response.number] = response

    def call(self, name: str, value: object) -> str:
        """Call a service of std_srvs; return its sentence."""
        answer = self.ask(name, value)
        assert answer.success, answer.message
        return answer.message

    def ask(self, name: str, *values: object):
        """Call a service until it answers: a request before discovery is lost."""
        request = self._topics[name]
        until = time.monotonic() + PATIENCE
        while time.monotonic() < until:
            self._number += 1
            message = typestore().types[request.type](4711, self._number, *values)
            self._bus.send(Outgoing(request, message), space="rq")
            later = time.monotonic() + 1.0
            while time.monotonic() < later:
                if (answer := self._answers.get((4711, self._number))) is not None:
                    return answer
                time.sleep(0.001)
        raise AssertionError(f"service {name} never answered")


class Heard:
    """All that rosless heard, by topic."""

    def __init__(self, node: rosless.Node) -> None:
        self._subscriptions = {
            topic: node.subscribe(
                topic,
                kind,
                reliability="reliable" if topic in LATCHED else "best_effort",
                durability="transient_local" if topic in LATCHED else "volatile",
                depth=1000,
            )
            for topic, kind in TOPICS.items()
        }
        self.messages = {topic: [] for topic in TOPICS}

    def take(self) -> None:
        for topic, subscription in self._subscriptions.items():
            while (message := subscription.read(timeout=0.0)) is not None:
                self.messages[topic].append(message)

    def wait_for(self, what: str, condition) -> float:
        """Take messages until a condition holds; return how long that took [s]."""
        began = time.monotonic()
        while not condition():
            assert time.monotonic() < began + PATIENCE, f"never came: {what}"
            self.take()
            time.sleep(0.005)
        return time.monotonic() - began


def clock_of(message) -> float:
    return message.clock.sec + message.clock.nanosec * 1e-9


def place_of(message) -> tuple[float, float]:
    return message.pose.position.x, message.pose.position.y


def hear_what_is_on_its_way(heard: "Heard") -> None:
    for _ in range(50):
        heard.take()
        time.sleep(0.002)


def step(services: Services, heard: Heard, count: int) -> None:
    """Take ticks while the run is paused, and hear them."""
    before = len(heard.messages["/clock"])
    assert services.ask("step_simulation", count).result.result == 1
    heard.wait_for("ticks", lambda: len(heard.messages["/clock"]) >= before + count)
    hear_what_is_on_its_way(heard)


def driven(services: Services, heard: Heard, wheel, message: dict) -> float:
    """Drive while the run is paused, a command each 0.2 s; return the speed that is reached [m/s].

    Time stands still until a command is there: how soon it is heard does not matter.
    """

    def command(ticks: int) -> None:
        wheel.send(message)
        time.sleep(0.02)
        step(services, heard, ticks)

    at = place_of(heard.messages["/scout/truth"][-1])
    while abs(place_of(heard.messages["/scout/truth"][-1])[0] - at[0]) < 0.05:  # until the bridge knows who commands
        command(5)
    began, at = clock_of(heard.messages["/clock"][-1]), place_of(heard.messages["/scout/truth"][-1])
    for _ in range(4):
        command(5)
    wheel.send(message)
    time.sleep(0.1)
    return (place_of(heard.messages["/scout/truth"][-1])[0] - at[0]) / (clock_of(heard.messages["/clock"][-1]) - began)


def listen(domain: int) -> tuple[dict, dict]:
    """Pause, step, drive, let go and reset a robot; return what was heard and noticed."""
    services, node = Services(domain), rosless.Node(domain=domain)
    heard, noticed = Heard(node), {}
    wheel = node.advertise("/scout/cmd_vel", "geometry_msgs/msg/Twist")
    noticed["paused"] = services.call("pause", True)
    # Nothing flows while it is paused; each step sends a tick, until all topics have been discovered.
    heard.wait_for("subscribers of cmd_vel", lambda: wheel.subscriber_count > 0)
    while not all(heard.messages.values()):
        noticed["stepped"] = services.call("step", 0)
        heard.take()
    noticed["features"] = services.ask("get_simulator_features", 0).features.features.tolist()
    step(services, heard, 3)
    state = services.ask("get_entity_state", "scout").state
    hear_what_is_on_its_way(heard)
    noticed["states"] = [
        [each.pose.position.x, each.pose.position.y] for each in (state, heard.messages["/scout/truth"][-1])
    ]
    delays = []
    for _ in range(10):
        count = len(heard.messages["/clock"])
        began = time.monotonic()
        services.call("step", 0)
        heard.wait_for("the tick of a step", lambda count=count: len(heard.messages["/clock"]) > count)
        delays.append(time.monotonic() - began)
    noticed["step_to_clock_s"] = sorted(delays)[len(delays) // 2]
    twist = {"linear": {"x": 0.3, "y": 0.0, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": 0.0}}
    noticed["twist"] = driven(services, heard, wheel, twist)
    moved = place_of(heard.messages["/scout/truth"][-1])
    step(services, heard, 30)
    halted = place_of(heard.messages["/scout/truth"][-1])
    step(services, heard, 10)
    noticed["places"] = [moved, halted, place_of(heard.messages["/scout/truth"][-1])]
    stamped = node.advertise("/scout/cmd_vel", "geometry_msgs/msg/TwistStamped")
    stamp = {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": "base_link"}
    back = {**twist, "linear": {"x": -0.3, "y": 0.0, "z": 0.0}}
    noticed["stamped"] = driven(services, heard, stamped, {"header": stamp, "twist": back})
    at = place_of(heard.messages["/scout/truth"][-1])
    services.call("pause", False)
    goal = node.advertise("/scout/goal_pose", "geometry_msgs/msg/PoseStamped")
    heard.wait_for("subscribers of goals", lambda: goal.subscriber_count > 0)
    pose = {"position": {"x": 5.0, "y": 2.0, "z": 0.0}, "orientation": {"x": 0.0, "y": 0.0, "z": 1.0, "w": 0.0}}

    def goes() -> bool:
        # Again and again: the bridge may not know this publisher yet, though this knows the bridge.
        for frame in ("laser", "map"):
            goal.send({"header": {**stamp, "frame_id": frame}, "pose": pose})
        time.sleep(0.1)
        return place_of(heard.messages["/scout/truth"][-1])[0] > at[0] + 0.3

    heard.wait_for("a start towards the goal", goes)
    services.call("pause", True)
    hear_what_is_on_its_way(heard)
    noticed["graph"] = sorted(topic.name for topic in node.graph().topics)
    told = {topic: [message.to_dict() for message in messages] for topic, messages in heard.messages.items()}
    count = len(heard.messages["/clock"])
    noticed["reset"] = services.call("reset", 0)
    heard.wait_for(
        "the first tick again", lambda: any(clock_of(each) == 0.0 for each in heard.messages["/clock"][count:])
    )
    services.call("pause", False)
    noticed["reset_running"] = services.call("reset", 0)
    heard.wait_for("a robot at its start", lambda: clock_of(heard.messages["/clock"][-1]) < 2.0)
    again = place_of(heard.messages["/scout/truth"][-1])

    def drives() -> bool:
        wheel.send(twist)
        time.sleep(0.02)
        return place_of(heard.messages["/scout/truth"][-1])[0] > again[0] + 0.3

    heard.wait_for("driving after a reset", drives)
    return told, noticed


def main(folder: Path, domain: int | None) -> None:
    if domain is None:
        bring_loopback_up()
    domain = domain or 0
    words = [sys.executable, "-m", "mjsim.cli", "bridge", str(folder / "world.yaml"), "-o", str(folder / "run.mcap")]
    environment = {**os.environ, "ROS_DOMAIN_ID": str(domain)}
    with child([*words, "--modules", "--speed", "4"], stdout=None, stderr=None, env=environment) as bridge:
        told, noticed = listen(domain)
        assert bridge.runs()
        bridge.send(signal.SIGINT)
        noticed["code"] = bridge.ended()
    plain = {"default": lambda value: value.tolist() if hasattr(value, "tolist") else list(value)}
    (folder / "heard.json").write_text(json.dumps(told, **plain))
    (folder / "noticed.json").write_text(json.dumps(noticed))


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else None)
