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
BODY = "body: {radius: 0.1, height: 0.1, mass: 1e-6}"
TINY = {
    "scout/wheel_left": ROBOT.replace(
        "KEYS", f"drive: {{type: differential, wheel_radius: 1e-4, track: 0.33}}, {BODY}"
    ),
    "scout/wheel_front_left": ROBOT.replace(
        "KEYS", f"drive: {{type: mecanum, wheel_radius: 1e-4, track: 0.4, wheelbase: 0.4}}, {BODY}"
    ),
    "scout/base": ROBOT.replace("KEYS", "body: {radius: 1e-5, height: 1e-5, mass: 1e-6}"),
    "obstacle/1": "mjsim: 1\nobstacles: [{ramp: [1.1e-5, 1.1e-5, 1.1e-5], at: [0, 0]}]\n",
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
