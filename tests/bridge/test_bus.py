"""The bus by itself: where it listens, and that it leaves nothing behind."""

import os
import socket
import stat
import threading
from pathlib import Path

import pytest

from mjsim.errors import UsageError

pytest.importorskip("cyclonedds", reason="no wheel for Python 3.14")

from mjsim.bridge import Bus, call_name
from mjsim.ros import Outgoing, Qos, RosTopic, type_hash, typestore

DOMAIN = 10 + (os.getpid() + 45) % 90
"""One that nobody else is likely to use."""
PATIENCE = 30.0
"""Nothing takes this long [s], on however loaded a machine."""


def sockets() -> list[tuple[str, str]]:
    """Return address and device of each socket for datagrams of IP that this process has."""
    found = []
    for descriptor in map(int, os.listdir("/proc/self/fd")):
        try:
            is_socket = stat.S_ISSOCK(os.fstat(descriptor).st_mode)
        except OSError:
            continue  # that of the listing itself
        if is_socket:
            with socket.socket(fileno=os.dup(descriptor)) as each:
                if each.family == socket.AF_INET and each.type == socket.SOCK_DGRAM:
                    device = each.getsockopt(socket.SOL_SOCKET, socket.SO_BINDTODEVICE, 16)
                    found.append((each.getsockname()[0], device.rstrip(b"\0").decode()))
    return found


@pytest.mark.skipif(not Path("/proc/self/fd").is_dir(), reason="asks Linux")
def test_a_bus_hears_loopback_alone_and_leaves_no_socket_behind(tmp_path):
    before = sockets()
    with (tmp_path / "open").open("w") as held:
        for _ in range(2):
            with Bus(domain=DOMAIN):
                ours = sockets()[len(before) :]
                assert ours
                assert all(address == "127.0.0.1" or device == "lo" for address, device in ours)
                with pytest.raises(UsageError, match=f"this process is in domain {DOMAIN} already"):
                    Bus(domain=DOMAIN)
            assert sockets() == before
        # A descriptor that stays open keeps the locks of files that are being written.
        links = [os.path.realpath(f"/proc/self/fd/{name}") for name in os.listdir("/proc/self/fd")]
        assert links.count(os.path.realpath(held.name)) == 1


@pytest.mark.parametrize("interface", ["eth99", "203.0.113.9", "::1"])
def test_an_interface_that_is_not_there_is_refused(interface):
    with pytest.raises(UsageError, match=f"no network interface or IPv4 address '{interface}'"):
        Bus(domain=DOMAIN, interface=interface)


COMMAND = RosTopic("/scout/cmd_vel", "geometry_msgs/msg/Twist", Qos(reliable=True, depth=100))


def twist(forward: float) -> Outgoing:
    types = typestore().types
    still = types["geometry_msgs/msg/Vector3"](0.0, 0.0, 0.0)
    return Outgoing(COMMAND, types[COMMAND.type](types["geometry_msgs/msg/Vector3"](forward, 0.0, 0.0), still))


def test_a_service_that_takes_long_holds_no_command_up():
    request, _ = call_name("/mjsim/reset", "std_srvs/srv/Trigger")
    called, answered, commanded = threading.Event(), threading.Event(), threading.Event()

    def reset(_) -> None:
        called.set()
        answered.wait(PATIENCE)

    with Bus(domain=DOMAIN) as bus:
        bus.receive(COMMAND, lambda _: commanded.set())
        bus.receive(request, reset, space="rq")
        bus.announce(COMMAND)
        bus.announce(request, space="rq")
        bus.start()
        bus.send(Outgoing(request, typestore().types[request.type](1, 1, 0)), space="rq")
        try:
            assert called.wait(PATIENCE)
            bus.send(twist(0.3))
            assert commanded.wait(PATIENCE / 3)
        finally:
            answered.set()


def test_a_flood_of_invalid_commands_is_counted_in_one_line(capfd):
    heard: list[float] = []
    last = threading.Event()

    def refuse(message) -> None:
        heard.append(message.linear.x)
        if len(heard) == 50:
            last.set()
        raise ValueError("its numbers must be finite")

    with Bus(domain=DOMAIN) as bus:
        bus.receive(COMMAND, refuse)
        bus.announce(COMMAND)
        bus.start()
        for _ in range(50):
            bus.send(twist(float("nan")))
        assert last.wait(PATIENCE)
    told = capfd.readouterr().err
    assert told == f"mjsim: a message of type {COMMAND.type} was ignored: its numbers must be finite\n"


def test_topics_and_services_are_announced_with_the_hash_of_their_type():
    from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsPublication, BuiltinTopicDcpsSubscription
    from cyclonedds.core import Policy

    request, response = call_name("/mjsim/pause", "std_srvs/srv/SetBool")
    with Bus(domain=DOMAIN) as bus:
        bus.announce(COMMAND)
        bus.receive(request, lambda _: None, space="rq")
        bus.announce(response, space="rr")
        kinds = (BuiltinTopicDcpsPublication, BuiltinTopicDcpsSubscription)
        told = {
            each.topic_name: each.qos[Policy.Userdata].data.decode()
            for kind in kinds
            for each in BuiltinDataReader(bus._participant, kind).take(N=100)
            if each.topic_name.startswith(("rt/", "rq/", "rr/"))  # not the readers of these
        }
    service = f"typehash={type_hash(request.type)};"
    assert told == {
        "rt/scout/cmd_vel": f"typehash={type_hash(COMMAND.type)};",
        "rq/mjsim/pauseRequest": service,
        "rr/mjsim/pauseReply": service,
    }


def test_a_bus_that_receives_nothing_has_no_thread_that_would_ask_for_ever():
    before = {*threading.enumerate()}
    with Bus(domain=DOMAIN) as bus:
        bus.start()
        assert {*threading.enumerate()} == before
