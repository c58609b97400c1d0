"""Pictures of the studio over HTTP: brought in, shown small, seen by a camera, and portraits of single things."""

from pathlib import Path

import cv2
import numpy as np
import pytest

import mjsim
from mjsim.bench.entering import client_of
from mjsim.bench.odd_pictures import odd_pictures
from mjsim.models import read_picture
from mjsim.video import take_picture
from mjsim.web import Studio
from mjsim.web.worlds.uploaded_pictures import encoded
from tests.asking import told
from tests.web.test_studio_edit import ROOM


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("studio")
    (place / "room.yaml").write_text(ROOM)
    (place / "deep").mkdir()
    (place / "deep" / "hall.yaml").write_text("mjsim: 1\n")
    return place


@pytest.fixture(scope="module")
def client(folder):
    with Studio(folder) as page, client_of(page.url) as browser:
        yield browser


def test_pictures_are_imported_beside_the_world_and_shown_as_thumbnails(client, folder):
    lion = Path(mjsim.__file__).parent.parent / "assets" / "posters" / "lion.jpg"
    brought = client.post("/api/upload?name=Our Lion.jpg&path=deep/hall.yaml", content=lion.read_bytes()).json()
    assert brought == {"path": "Our-Lion.jpg", "file": "deep/Our-Lion.jpg"}
    told_so = told(
        client, "parse", path="deep/hall.yaml", text="mjsim: 1\nbeacons: [{name: l, image: Our-Lion.jpg, at: [1, 1]}]\n"
    )
    assert told_so["problems"] == []
    for query in ("path=deep/Our-Lion.jpg", "path=Our-Lion.jpg&world=deep/hall.yaml", "path=posters/lion.jpg"):
        answer = client.get(f"/api/picture?{query}&size=64")
        assert answer.headers["content-type"] == "image/jpeg"
        small = cv2.imdecode(np.frombuffer(answer.content, np.uint8), cv2.IMREAD_COLOR)
        assert max(small.shape[:2]) == 64
    (folder / "deep" / "Our-Lion.jpg").unlink()


@pytest.mark.parametrize("name", ["turned.jpg", "alpha.png"])
def test_a_photo_of_a_telephone_is_imported_and_shown_upright(client, folder, name):
    data = odd_pictures()[name]
    brought = client.post(f"/api/upload?name={name}&path=deep/hall.yaml", content=data).json()
    kept = folder / brought["file"]
    upright, shown = read_picture(data), client.get(f"/api/picture?path={brought['file']}&size=64").content
    for picture in (read_picture(kept.read_bytes()), pixels(shown)[..., ::-1]):
        small = [
            cv2.resize(each.astype(np.float32), (16, 16), interpolation=cv2.INTER_AREA) for each in (upright, picture)
        ]
        # JPEG loses a few gray values; lying on its side it differs by dozens.
        assert np.abs(small[0] - small[1]).mean() < 8.0
    kept.unlink()


def pixels(jpeg):
    return cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR).astype(int)


@pytest.mark.slow
def test_the_preview_shows_what_the_camera_would_see_from_there(client):
    room = ROOM.replace("height: 120", "height: 120, noise: 0")
    asked = {"path": "room.yaml", "text": room, "robot": "scout", "camera": "front", "width": 160}
    for at, heading in (([1.0, 2.0], 0.0), ([4.5, 2.0], 0.0), ([2.0, 3.0], -90.0)):
        answer = client.post("/api/preview", json={**asked, "at": at, "heading_deg": heading})
        moved = mjsim.parse_world(room.replace("at: [1, 2], sensors", f"at: {at}, heading_deg: {heading}, sensors"))
        wanted = encoded(np.ascontiguousarray(take_picture(moved, "scout/front")[..., ::-1]), ".jpg")
        # From a place 10 cm away it differs by more than 4.
        assert np.abs(pixels(answer.content) - pixels(wanted)).mean() < 0.5
        assert float(answer.headers["server-timing"].partition("dur=")[2]) > 0.0
    other = client.post("/api/preview", json={**asked, "at": [1, 2], "text": ROOM.replace("[5.94, 2]", "[5.94, 2.4]")})
    assert other.status_code == 200
    assert client.post("/api/preview", json={**asked, "camera": "back", "at": [1, 2]}).status_code == 404
    wrong = client.post("/api/preview", json={**asked, "text": ROOM + "wals: 1\n", "at": [1, 2]})
    assert (wrong.status_code, wrong.json()["error"][:27]) == (409, "line 18: unknown key 'wals'")


@pytest.mark.slow
def test_models_robots_and_arms_are_portrayed_by_themselves_and_anew_when_their_file_changes(folder, client):
    stool = '<mujoco><worldbody><geom type="cylinder" size="0.2 0.25" pos="0 0 0.25" rgba="{} 1"/></worldbody></mujoco>'
    for colour in ("1 0 0", "0 0 1"):
        (folder / "stool.xml").write_text(stool.format(colour))
        answer = client.get("/api/portrait?kind=model&name=stool.xml&world=room.yaml")
        assert answer.headers["content-type"] == "image/jpeg"
        picture = cv2.imdecode(np.frombuffer(answer.content, np.uint8), cv2.IMREAD_COLOR_RGB).astype(int)
        assert picture.shape == (180, 240, 3)
        first, last = picture[..., 0] - picture[..., 2], 100
        middle = first[60:120, 90:150]
        assert (middle > last if colour == "1 0 0" else middle < -last).mean() > 0.8
        assert (np.abs(first[:, :20]) < last).all()  # whole: nothing of it reaches the edge
    for query in ("kind=robot&name=create3", "kind=arm&name=puma560"):
        assert client.get(f"/api/portrait?{query}").status_code == 200
    (folder / "stool.xml").unlink()
    for query, status, said in (
        ("kind=lamp&name=x", 400, "no pictures of kind 'lamp'; there are model, robot, arm"),
        ("kind=model&name=gone.xml", 409, "gone.xml"),
        ("kind=model&name=../secret.xml", 409, "../secret.xml"),
        ("kind=robot&name=create", 409, "did you mean 'create3'"),
    ):
        answer = client.get(f"/api/portrait?{query}")
        assert answer.status_code == status
        assert said in answer.json()["error"]
