"""Measure the Run view: pictures per second and the real-time factor, and what a session costs over a plain run.

    scripts/measure/studio.py [SECONDS]

The server runs in a process of its own, as for a browser; this one is the browser's side of the WebSocket, which
confirms each picture at once. CPU time is that of all threads of the server's process for each simulated second; unlike
the rates, it hardly depends on other work of the machine.
"""

import json
import multiprocessing
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np
from websockets.sync.client import connect

import mjsim
from mjsim.bench.entering import client_of, cookie_of, socket_of
from mjsim.run import drivers_of, one_blas_thread
from mjsim.web import Studio
from mjsim.web.review.open_recordings import Opened

GALLERY = Path(mjsim.__file__).parent.parent / "worlds" / "gallery.yaml"
FAST = GALLERY.read_text().replace("rate_hz: 12.5}", "rate_hz: 25}")
ORBIT = {"azimuth_deg": 60, "elevation_deg": -45, "distance": 14, "at": [7, 5]}
FRONT = {"cameras": ["scout/front"]}
CASES = (
    ("camera at 25 Hz, watched", FAST, FRONT),
    ("camera at 12.5 Hz and the view from outside, watched", GALLERY.read_text(), {**FRONT, "outside": ORBIT}),
    ("camera at 12.5 Hz, nothing watched but ticks", GALLERY.read_text(), {"cameras": []}),
)
LIGHT = """
mjsim: 1
walls: [{points: [[0, 0], [8, 0], [8, 6], [0, 6]], closed: true}]
beacons: [{name: a, at: [7, 1]}, {name: b, at: [1, 5]}]
robots:
  - {name: scout, preset: pioneer3dx, at: [2, 2], sensors: [{beacons: ring, noise: {range: 0.05, bearing_deg: 1}}]}
run:
  drivers: {scout: {
    estimator: {use: "mjsim.algorithms.ekf_slam:EkfSlam"},
    navigator: {use: "mjsim.algorithms.waypoints:Waypoints", points: [[6, 2], [6, 4], [2, 4], [2, 2]], laps: 1000}}}
"""


def main(seconds: float) -> None:
    """Print the results of all cases, each over a simulated duration [s]."""
    print(f"{'the gallery with its estimator, real time':54} pictures/s   real time   CPU s/s     longest gap [s]")
    for name, text, watch in CASES:
        print(f"{name:54}", watched(text, watch, seconds), flush=True)
    plainly, sessions = zip(*((plain(60.0), in_session(60.0)) for _ in range(5)), strict=True)
    print("\nCPU time of 60 simulated seconds without a camera, not recorded, least of five [s]")
    print(f"plain ticks {min(plainly):6.2f}   session, nobody watching {min(sessions):6.2f}", flush=True)
    print("\na recording of 20 s of the gallery, opened, then drawn again at 40 random times [ms]")
    for line in scrubbed(20.0):
        print(line, flush=True)


def watched(text: str, watch: dict[str, object], seconds: float) -> str:
    """Return the results of one case."""
    ours, theirs = multiprocessing.Pipe()
    server = multiprocessing.get_context("spawn").Process(target=serve, args=[theirs])
    server.start()
    with client_of(ours.recv()) as client:
        address, cookie = socket_of(client), cookie_of(client)
    counts: Counter[str] = Counter()
    gap = last = ended = 0.0
    with connect(address, additional_headers=cookie, max_size=None) as socket:
        socket.send(json.dumps({"do": "watch", **watch}))
        socket.send(json.dumps({"do": "start", "path": None, "text": text, "speed": 1.0, "seconds": seconds + 2.0}))
        tick = {"time": 0.0}
        began = cpu = 0.0
        while tick["time"] < seconds + 1.0:
            message = socket.recv(120.0)
            now = time.perf_counter()
            if isinstance(message, str):
                news = json.loads(message)
                assert news["kind"] != "refused", news
                if news["kind"] == "tick":
                    tick, ended = news, now
                    # The first second is for compiling the view from outside, and for modules that start.
                    if not began and news["time"] >= 1.0:
                        ours.send("cpu")
                        began, first, cpu = now, news["time"], ours.recv()
                        counts.clear()
                        last = now
                continue
            size = int.from_bytes(message[:4], "little")
            head = json.loads(message[4 : 4 + size])
            socket.send(json.dumps({"do": "shown", "number": head["number"]}))
            if began:
                counts[head["view"]] += 1
                gap, last = max(gap, now - last), now
        ours.send("cpu")
        spent = ours.recv() - cpu
    ours.send("end")
    server.join()
    took = ended - began
    rates = ", ".join(f"{view} {count / took:.1f}" for view, count in sorted(counts.items())) or "none"
    return f"{rates:>24}   {(tick['time'] - first) / took:6.3f}   {spent / (tick['time'] - first):6.2f}   {gap:6.2f}"


def serve(told: Connection) -> None:
    """Serve a studio until it is told to end."""
    with tempfile.TemporaryDirectory() as folder, Studio(folder) as studio:
        told.send(studio.url)
        while told.recv() == "cpu":
            told.send(time.process_time())


def plain(seconds: float) -> float:
    """Return the CPU time of the ticks of a run."""
    world = mjsim.parse_world(LIGHT)
    with mjsim.Simulation(world) as sim:
        loop, began = mjsim.ticks(sim, drivers_of(world)), time.process_time()
        with one_blas_thread():
            for _ in range(round(seconds / sim.dt)):
                next(loop)
        return time.process_time() - began


def in_session(seconds: float) -> float:
    """Return the CPU time of the same ticks in a session."""
    session = mjsim.Session(mjsim.parse_world(LIGHT), seconds=seconds)
    session.start(paused=True)
    session.wait("paused")
    began = time.process_time()
    session.go()
    session.result()
    spent = time.process_time() - began
    session.close()
    return spent


def scrubbed(seconds: float) -> Iterator[str]:
    """Yield how long it takes to open a recording, and to draw views of it."""
    world = mjsim.load_world(GALLERY)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "run.mcap"
        with mjsim.Simulation(world) as sim:
            mjsim.run(sim, seconds=seconds, record=file)
        began = time.perf_counter()
        opened = Opened(mjsim.read_recording(file))
        yield f"{'opening':24} {1e3 * (time.perf_counter() - began):7.1f}"
        times = np.random.default_rng(0).uniform(0.0, seconds, 40)
        for view in ("scout/front", "scout/front:depth", "scout/front:segmentation", "outside", "chase"):
            opened.picture(0.0, view)
            took = []
            for moment in times.tolist():
                began = time.perf_counter()
                opened.picture(moment, view)
                took.append(1e3 * (time.perf_counter() - began))
            yield f"{view:24} median {np.median(took):6.1f}   slowest {np.max(took):6.1f}"
        opened.close()


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 60.0)
