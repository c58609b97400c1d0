"""Every estimator, navigator and the avoidance that come with mjsim work on a base that balances."""

from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

import mjsim
import mjsim.algorithms
from mjsim.geometry import roll_and_pitch
from mjsim.modules import offers_in

ROOM = """
mjsim: 1
walls: [{points: [[0, 0], [7, 0], [7, 5], [0, 5]], closed: true, height: 1.4}]
obstacles: [{name: crate, box: [0.9, 0.6, 1.0], at: [3.5, 2.5]}]
beacons:
  - {name: a, at: [0.2, 0.3]}
  - {name: b, at: [6.7, 0.2]}
  - {name: c, at: [6.8, 4.8]}
  - {name: d, at: [0.3, 4.6]}
  - {name: e, at: [3.4, 4.8]}
robots:
  - name: joe
    preset: balancer
    at: [1.2, 1.2]
    drive: {noise: {speed: 0.02, turn: 0.02}}
    odometry: {noise: {distance: 0.02, turn: 0.02}}
    sensors:
      - {beacons: ring, range: [0.2, 10], fov_deg: 360, rate_hz: 5, noise: {range: 0.05, bearing_deg: 1}}
      - {lidar: scan, at: [0, 0, 0.72], beams: 90, fov_deg: 360, range: [0.05, 8], rate_hz: 5, noise: {range: 0.01}}
run: {map: known, drivers: {joe: {DRIVER}}}
"""
SECONDS = 3.0
FOLDER = Path(mjsim.algorithms.__path__[0])
PLACES = {place: place.stem for place in FOLDER.glob("*.py")} | {
    place: place.parent.name for place in FOLDER.glob("*/*.py")
}
FOUND = list(offers_in([(place, f"mjsim.algorithms.{name}") for place, name in PLACES.items()]))
OFFERS = {role: sorted(offer.use for offer in FOUND if offer.role == role) for role in ("estimator", "navigator")}
TOUR = (
    'navigator: {use: "mjsim.algorithms.waypoints:Waypoints", points: [[5.8, 1.2], [5.8, 3.8], [1.2, 3.8], [1.2, 1.2]]}'
)
ELSEWHERE = {"Crab", "Teleop", "JointPath", "ToolPath", "PickUp", "VisualSlam"}
"""For robots that go sideways, for people at a keyboard, for arms, and for a camera on a robot that stands level."""
KEYS = {
    "GoToGoal": "goals: [[5.8, 1.2], [5.8, 3.8]]",
    "ConstantCommand": "forward: 0.2, turn: 0.2",
    "SpeedLoop": "num: [0.2, 1], den: [1, 0], reference: {constant: {value: 0.2}}",
    "Signal": "forward: {sine: {amplitude: 0.3, frequency_hz: 0.2}}",
}


def run(driver: str, seconds: float = SECONDS, record: Path | None = None, x: float = 1.2) -> mjsim.Recording:
    world = mjsim.parse_world(ROOM.replace("DRIVER", driver).replace("at: [1.2, 1.2]", f"at: [{x}, 1.2]"))
    with mjsim.Simulation(world) as sim:
        return mjsim.run(sim, seconds=seconds, record=record)


@pytest.fixture(scope="module")
def toured(tmp_path_factory: pytest.TempPathFactory) -> mjsim.Recording:
    """A tour that all estimators are told of."""
    path = tmp_path_factory.mktemp("tour") / "run.mcap"
    return run(f'estimator: {{use: "mjsim.algorithms.ekf_slam:EkfSlam"}}, {TOUR}', 5.0, path)


def largest_lean(recording: mjsim.Recording) -> float:
    return float(np.abs(roll_and_pitch(recording.robots["joe"].truth_pose[:, 3:])).max())


def test_there_are_as_many_as_the_page_of_algorithms_has():
    assert len(OFFERS["estimator"]) >= 11
    assert len(OFFERS["navigator"]) >= 10


@pytest.mark.slow
@pytest.mark.parametrize("use", [use for use in OFFERS["estimator"] if use.rpartition(":")[2] not in ELSEWHERE])
def test_an_estimator_knows_where_it_is(use, toured):
    module, _, name = use.partition(":")
    joe = mjsim.replay(toured, robot="joe", estimator=getattr(import_module(module), name)()).robots["joe"]
    error = np.hypot(*(joe.estimate - joe.truth)[:, :2].T)
    assert largest_lean(toured) < 0.25
    assert error.mean() < 0.15


@pytest.mark.slow
@pytest.mark.parametrize("use", [use for use in OFFERS["navigator"] if use.rpartition(":")[2] not in ELSEWHERE])
def test_a_navigator_drives_it(use):
    name = use.rpartition(":")[2]
    keys = KEYS.get(name, "points: [[5.8, 1.2], [5.8, 3.8], [1.2, 3.8]]" if "Way" in name or "Path" in name else "")
    recording = run(f'navigator: {{use: "{use}"{", " + keys if keys else ""}}}, avoidance: true')
    truth = recording.robots["joe"].truth
    assert largest_lean(recording) < 0.25
    way = float(np.hypot(*np.diff(truth[:, :2], axis=0).T).sum())
    assert way > 0.15 * SECONDS


@pytest.mark.slow
def test_the_avoidance_keeps_it_from_the_walls():
    told = 'navigator: {use: "mjsim.algorithms.constant:ConstantCommand", forward: 0.4}'
    blind, recording = run(told, 5.0, x=5.4), run(f"{told}, avoidance: true", 5.0, x=5.4)
    assert any(event.kind == "bump" for event in blind.robots["joe"].events)
    assert not recording.robots["joe"].events
    assert largest_lean(blind) < 0.4
    assert largest_lean(recording) < 0.25
