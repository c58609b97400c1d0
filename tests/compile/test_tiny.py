"""Parts that are too small for MuJoCo: the world is refused in a line that names them, wherever it is compiled."""

import pytest

import mjsim
from mjsim.bench.entering import client_of
from mjsim.compile import export_scene
from mjsim.errors import UsageError
from mjsim.sim import StillScene
from mjsim.web import Studio
from tests.browser import browser

ROBOT = "mjsim: 1\nrobots: [{name: scout, at: [0, 0], KEYS}]\n"
TINY = {
    "scout/wheel_left": ROBOT.replace("KEYS", "drive: {type: differential, wheel_radius: 1e-9, track: 0.33}"),
    "scout/wheel_front_left": ROBOT.replace(
        "KEYS", "drive: {type: mecanum, wheel_radius: 1e-9, track: 0.4, wheelbase: 0.4}"
    ),
    "scout/base": ROBOT.replace("KEYS", "body: {radius: 1e-9, height: 1e-9, mass: 0.001}"),
    "beacon:backs": "mjsim: 1\nbeacons: [{name: lion, image: posters/lion.jpg, at: [0, 0], width: 1e-9}]\n",
    "obstacle/1": "mjsim: 1\nobstacles: [{ramp: [1e-9, 1e-9, 1e-9], at: [0, 0]}]\n",
}


@pytest.mark.parametrize(("name", "text"), TINY.items(), ids=TINY)
def test_a_part_that_is_too_small_is_named_in_one_line(tmp_path, name, text):
    world = mjsim.parse_world(text)
    for compile_it in (mjsim.Simulation, StillScene, lambda world: export_scene(world, tmp_path)):
        with pytest.raises(UsageError) as caught:
            compile_it(world)
        said = str(caught.value)
        assert said.startswith(f"MuJoCo cannot compile '{name}': m")
        assert said.endswith("; make sizes and masses larger")
        assert "\n" not in said
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_the_studio_refuses_it_and_goes_on(tmp_path):
    text = TINY["scout/wheel_left"]
    with Studio(tmp_path) as studio, client_of(studio.url) as client, browser(studio.url) as seen:
        seen.say("start", path="room.yaml", text=text)
        assert seen.until("run", state="failed")["error"].startswith("MuJoCo cannot compile 'scout/wheel_left'")
        answer = client.post("/api/scene", json={"path": "room.yaml", "text": text})
        assert (answer.status_code, answer.json()["error"][:14]) == (400, "MuJoCo cannot ")
