"""The run over a WebSocket: real servers, real sockets; orders, news, pictures, and who is slow."""

import numpy as np
import pytest
from browser import PATIENCE, browser

from mjsim.web.folder import Folder
from mjsim.web.run_api import RunApi
from mjsim.web.server import Server
from mjsim.web.trust import Trust

ROOM = """
mjsim: 1
name: room
walls: [{points: [[-2, -2], [2, -2], [2, 2], [-2, 2]], closed: true}]
beacons: [{name: lion, image: posters/lion.jpg, at: [1.9, 0], heading_deg: 180, center: 0.5}]
robots:
  - name: scout
    preset: pioneer3dx
    at: [0, 0]
    drive: {noise: {speed: 0.02, turn: 0.02}}
    odometry: {noise: {distance: 0.01, turn: 0.02}}
    sensors: [{camera: front, width: 160, height: 120, rate_hz: 25}]
run:
  seconds: 1000
  drivers:
    scout:
      observer: {use: "mjsim.algorithms.beacon_vision:BeaconVision", camera: front}
      navigator: {use: "mjsim.algorithms.waypoints:Waypoints", points: [[1, 0], [1, 1], [0, 0]], laps: 100}
"""


def scene(world):
    return {"items": [], "bounds": [-2.0, -2.0, 2.0, 2.0]}


@pytest.fixture
def page(tmp_path):
    """The address of a page, and the folder that it is of."""
    api = RunApi(Folder(tmp_path), Trust(), scene=scene)
    with Server(api.routes, closing=[api.close]) as server:
        server.api = api
        yield server


def start(page, text=ROOM, **keys):
    keys = {"path": "room.yaml", "text": text, "speed": None, **keys}
    return keys


def test_a_page_without_a_run_says_so(page):
    with browser(page.url) as seen:
        assert seen.until("run")["state"] == "idle"
        for do in ("pause", "go", "tick", "restart", "stop"):
            seen.say(do)
            assert seen.until("refused", do=do)["error"] == "no run has begun; start one"


def test_a_run_is_started_paused_ticked_restarted_and_stopped(page):
    with browser(page.url) as seen:
        seen.say("start", **start(page, seed=3, speed=1.0, seconds=50.0))
        run = seen.until("run", state="running")
        assert (run["name"], run["path"], run["seed"], run["seconds"], run["dt"]) == (
            "room",
            "room.yaml",
            3,
            50.0,
            0.04,
        )
        assert run["robots"][0]["cameras"] == [{"name": "front", "width": 160, "height": 120}]
        assert run["controllable"]
        seen.until("tick")
        assert seen.news["scene"]["bounds"] == [-2.0, -2.0, 2.0, 2.0]
        seen.say("pause")
        at = seen.until("run", state="paused")["time"]
        seen.say("tick")
        # What was on its way comes first.
        while seen.until("tick")["time"] < at + 0.04 - 1e-6:
            pass
        seen.say("speed", value=4.0)
        assert seen.until("run", speed=4.0)["state"] == "paused"
        seen.say("restart")
        assert seen.until("past")["robots"] in ({}, seen.news["past"]["robots"])
        assert seen.until("tick")["time"] == 0.0
        seen.say("stop")
        assert seen.until("run", state="ended")["error"] is None
