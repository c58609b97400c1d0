"""`mjsim bridge` against Debian's Fast DDS, a third implementation of DDS: scans out, field by field, and commands in.

    python scripts/measure/fastdds.py

Needs g++ and Debian's headers and libraries of Fast DDS: apt-get install libfastrtps-dev. Without root, unpack the
packages (apt-get download, dpkg -x) and name their folder in FASTDDS_ROOT. Run it in a network namespace, if that is
allowed, so that nobody else is on the bus: unshare -Urn sh -c 'ip link set lo up; python scripts/measure/fastdds.py'.
"""

import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import mjsim
from mjsim.datasets import export_rosbag2

PEER = Path(__file__).with_name("fastdds_peer.cpp")
SECONDS = 10.0
DOMAIN = 88
WORLD = """mjsim: 1
name: live
walls: [{points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true}]
robots:
  - {name: scout, preset: pioneer3dx, at: [1, 2], sensors: [{lidar: scan, rate_hz: 25, noise: {range: 0.01}}]}
run: {rate_hz: 25}
"""
HOW = (
    "Fast DDS is not here; type: apt-get install g++ libfastrtps-dev, or name a folder of its packages in FASTDDS_ROOT"
)


def peer(folder: Path) -> list[str] | None:
    """Return how the peer is called, compiled; None where its compiler or its libraries are missing."""
    root = Path(os.environ.get("FASTDDS_ROOT", "/"))
    machine = subprocess.run(["gcc", "-dumpmachine"], capture_output=True, text=True, check=False).stdout.strip()
    libraries, headers = root / "usr" / "lib" / machine, root / "usr" / "include"
    if shutil.which("g++") is None or not (headers / "fastdds").exists():
        return None
    program = folder / "peer"
    search = [f"-I{headers}", f"-I{headers}/{machine}", f"-L{libraries}", f"-Wl,-rpath-link,{libraries}"]
    subprocess.run(["g++", "-O1", *search, "-o", program, PEER, "-lfastrtps", "-lfastcdr"], check=True)
    return ["env", f"LD_LIBRARY_PATH={libraries}", str(program), str(DOMAIN), str(SECONDS)]


def sent(folder: Path) -> list[dict[str, object]]:
    """Return the scans of the run as the bag of it holds them, numbers as single floats are written."""
    from rosbags.highlevel import AnyReader

    scans = []
    bag = export_rosbag2(mjsim.read_recording(folder / "run.mcap"), folder / "bag")
    with AnyReader([bag]) as reader:
        for connection, _, raw in reader.messages():
            if connection.topic == "/scout/scan":
                scans.append(plain(reader.deserialize(raw, connection.msgtype)))
    return scans


def plain(scan: object) -> dict[str, object]:
    """Return a scan as the peer prints it."""
    header = scan.header
    told: dict[str, object] = {
        "sec": header.stamp.sec,
        "nanosec": header.stamp.nanosec,
        "frame_id": header.frame_id,
    }
    for name in ("angle_min", "angle_max", "angle_increment", "time_increment", "scan_time", "range_min", "range_max"):
        told[name] = f"{np.float32(getattr(scan, name)):.9g}"
    for name in ("ranges", "intensities"):
        told[name] = [f"{value:.9g}" for value in getattr(scan, name)]
    return told


def main() -> int:
    """Run both, and print what came through."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        if (words := peer(folder)) is None:
            print(HOW)
            return 2
        (folder / "world.yaml").write_text(WORLD)
        command = [
            sys.executable,
            "-m",
            "mjsim.cli",
            "bridge",
            str(folder / "world.yaml"),
            "-o",
            str(folder / "run.mcap"),
        ]
        bridge = subprocess.Popen(command, env={**os.environ, "ROS_DOMAIN_ID": str(DOMAIN)})
        try:
            while not (folder / "run.mcap").exists():
                time.sleep(0.1)
            lines = subprocess.run(words, capture_output=True, text=True, check=True).stdout.splitlines()
        finally:
            bridge.send_signal(signal.SIGINT)
            bridge.wait(timeout=60)
        heard = [json.loads(line) for line in lines]
        given = sent(folder)
        truth = mjsim.read_recording(folder / "run.mcap").robots["scout"].truth
    if not heard:
        print("no scan came through")
        return 1
    first = given.index(heard[0])
    expected = given[first : first + len(heard)]
    equal = sum(a == b for a, b in zip(heard, expected, strict=True))
    print(f"Fast DDS received {len(heard)} scans in a row; {equal} of them equal in every field")
    print(f"cmd_vel of Fast DDS moved the robot by {truth[-1, 0] - truth[0, 0]:.2f} m")
    return 0 if equal == len(heard) and truth[-1, 0] - truth[0, 0] > 0.5 else 1


if __name__ == "__main__":
    sys.exit(main())
