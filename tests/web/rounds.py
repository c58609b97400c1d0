"""A world whose robot goes its rounds, and how a page asks for a run of it."""

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


def start(seen, text=ROOM, **keys):
    """Ask for a run of a world."""
    seen.say("start", **{"path": "room.yaml", "text": text, "speed": None, **keys})
