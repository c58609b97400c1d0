"""The scene over HTTP: what a text looks like in 3-D, and what is refused."""

from tests.asking import told
from tests.solids import document_of, names_of

WORLD = """
mjsim: 1
obstacles: [{name: chest, box: [1, 1, 1], at: [2, 3]}]
robots: [{name: scout, at: [4, 2], sensors: [{camera: front}]}]
"""


def test_a_text_is_given_as_a_scene_with_the_names_of_its_things(client):
    answer = client.post("/api/scene", json={"path": "room.yaml", "text": WORLD})
    assert (answer.status_code, answer.headers["content-type"]) == (200, "model/gltf-binary")
    scene = document_of(answer.content)
    assert {"world", "scout/base", "scout/wheel_left"} <= set(names_of(answer.content))
    assert "scout/front" in {node["name"] for node in scene["nodes"]}
    things = {name for part in scene["meshes"][0]["primitives"] for name, _ in part["extras"]["things"]}
    assert things == {"floor", "obstacle/chest"}
    assert client.post("/api/scene", json={"path": "room.yaml", "text": WORLD}).content == answer.content


def test_a_text_with_a_mistake_and_a_run_that_has_not_begun_have_no_scene(client):
    wrong = told(client, "scene", status=409, path="room.yaml", text="mjsim: 1\nwals: []\n")
    assert wrong["error"].startswith("line 2: unknown key 'wals'")
    answer = client.get("/api/run/scene")
    assert (answer.status_code, answer.json()["error"]) == (409, "no run has begun; start one")
