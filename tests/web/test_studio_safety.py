"""The studio serves its own page alone, and nothing outside of its folder."""

import json
import os
import socket
import struct
import zlib

import cv2
import httpx
import numpy as np
import pytest
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from mjsim.bench.entering import client_of, cookie_of, socket_of
from mjsim.cli import main
from mjsim.errors import UsageError
from mjsim.web import Studio
from mjsim.web.server.answers import MAX_JSON
from mjsim.web.server.local import HEADERS
from mjsim.web.worlds.folder import Folder
from mjsim.web.worlds.uploaded_pictures import MAX_BYTES, MAX_SIDE

pytestmark = pytest.mark.slow  # Each starts a server.

PATIENCE = 60.0
"""No answer takes this long [s], on however loaded a machine."""
ROOM = "mjsim: 1\nwalls: [{points: [[0, 0], [4, 0], [4, 4], [0, 4]], closed: true}]\n"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with a world, beside one with a secret, and links that lead there."""
    base = tmp_path_factory.mktemp("safety")
    (base / "secret").mkdir()
    (base / "secret" / "room.yaml").write_text("mjsim: 1\nname: secret\n")
    (base / "secret" / "lion.jpg").write_bytes(picture(20, 20))
    place = base / "open"
    place.mkdir()
    (place / "room.yaml").write_text(ROOM)
    (place / "link.yaml").symlink_to(base / "secret" / "room.yaml")
    (place / "out.jpg").symlink_to(base / "secret" / "lion.jpg")
    (place / "away").symlink_to(base / "secret", target_is_directory=True)
    return place


@pytest.fixture(scope="module")
def studio(folder):
    with Studio(folder) as page:
        yield page


@pytest.fixture(scope="module")
def client(studio):
    with client_of(studio.url) as browser:
        yield browser


def picture(width, height, kind=".jpg"):
    pixels = np.full((height, width, 3), 200, np.uint8)
    return cv2.imencode(kind, pixels)[1].tobytes()


def bomb(side):
    """Return a PNG of a few bytes that says it has so many pixels to a side."""

    def part(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", side, side, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + part(b"IHDR", head) + part(b"IDAT", zlib.compress(b"\0" * 100)) + part(b"IEND", b"")


def files(folder):
    return {path.name for path in folder.iterdir()}


def asks(client, address, **keys):
    return client.post(address, json=keys)


@pytest.mark.slow
def test_who_asks_in_the_name_of_another_page_or_host_is_refused(studio, client):
    port = client.base_url.port
    for headers in (
        {"Origin": "http://evil.example"},
        {"Origin": "null"},
        {"Origin": f"http://127.0.0.1:{port + 1}"},
        {"Origin": f"https://127.0.0.1:{port}"},
        {"Host": f"evil.example:{port}"},
        {"Host": "127.0.0.1"},
        {"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "no-cors"},
        {"Sec-Fetch-Site": "same-site", "Sec-Fetch-Mode": "cors"},
    ):
        for answer in (
            client.get("/api/folder", headers=headers),
            client.post("/api/open", json={"path": "room.yaml"}, headers=headers),
            client.get("/api/picture?path=posters/lion.jpg", headers=headers),
        ):
            assert answer.status_code == 403
            assert answer.json()["error"].startswith("refused: this page is for its own address only")
        with pytest.raises(InvalidStatus) as refused:
            connect(socket_of(client), additional_headers={**cookie_of(client), **headers})
        # A second Host is no HTTP at all.
        assert refused.value.response.status_code == (400 if "Host" in headers else 403)
    own = {"Origin": studio.address.rstrip("/"), "Sec-Fetch-Site": "same-origin"}
    assert client.get("/api/folder", headers=own).status_code == 200
    # A link leads to the page, which is all that it does.
    visit = {"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "navigate"}
    assert client.get("/", headers=visit).status_code == 200
    assert client.get("/api/folder", headers=visit).status_code == 403


def test_no_other_page_may_frame_read_or_feed_this_one(client):
    headers = client.get("/").headers
    policy = headers["content-security-policy"]
    assert "default-src 'self'" in policy
    assert "frame-ancestors 'none'" in policy
    assert "script-src" not in policy.replace("default-src", "")
    assert headers["cross-origin-resource-policy"] == "same-origin"
    assert headers["x-content-type-options"] == "nosniff"
    answer = client.options("/api/open", headers={"Access-Control-Request-Method": "POST"})
    assert not any(name.startswith("access-control") for name in answer.headers)
    assert client.post("/api/open", content='{"path": "room.yaml"}').status_code == 415


OUTSIDE = ("../secret/room.yaml", "/etc/room.yaml", "away/room.yaml", "link.yaml", "a/../../secret/room.yaml")
NO_NAMES = ("", "..\\secret\\room.yaml", "room.yaml\0", "a" * 500, ".", "room\n.yaml")


@pytest.mark.parametrize("path", [*OUTSIDE, *NO_NAMES, "C:/room.yaml", "//etc/room.yaml", "~/../secret/room.yaml"])
def test_no_path_leads_out_of_the_folder(client, folder, path):
    for address, keys in (
        ("/api/open", {}),
        ("/api/save", {"text": ROOM}),
        ("/api/new", {}),
        ("/api/parse", {"text": ROOM}),
        ("/api/edit", {"text": ROOM, "changes": []}),
        ("/api/trust", {"text": ROOM, "code": {}}),
    ):
        if path == "" and address not in ("/api/open", "/api/save"):
            continue  # a text that is not saved yet
        answer = asks(client, address, path=path, **keys)
        assert answer.status_code in (400, 403), address
    assert client.get("/api/modules", params={"path": path or "/"}).status_code in (400, 403)
    assert files(folder.parent) == {"open", "secret"}
    assert (folder.parent / "secret" / "room.yaml").read_text() == "mjsim: 1\nname: secret\n"


def test_nothing_outside_is_listed_or_seen_through_a_link(client):
    told = client.get("/api/folder").json()
    assert told["worlds"] == ["room.yaml"]
    assert "out.jpg" not in told["pictures"]
    for path in ("../secret/lion.jpg", "/etc/passwd", "away/lion.jpg", "out.jpg"):
        answer = client.get("/api/picture", params={"path": path})
        assert answer.status_code == 404
    world = f"{ROOM}beacons: [{{name: lion, image: away/lion.jpg, at: [1, 1]}}]\n"
    (problem,) = asks(client, "/api/parse", path="room.yaml", text=world).json()["problems"]
    assert "is outside its folder" in problem["message"]


def test_only_worlds_are_written_and_none_that_are_hidden(client, folder):
    before = files(folder)
    for path in ("still.py", "room.txt", ".hidden.yaml", ".git/config.yaml", "room.yaml/x.yaml"):
        assert asks(client, "/api/save", path=path, text=ROOM, overwrite=True).status_code in (400, 403, 409)
    assert files(folder) == before


@pytest.mark.slow
def test_what_is_brought_is_bounded_and_a_picture(client, folder):
    before = files(folder)
    for data, status in (
        (b"x" * (MAX_BYTES + 1), 413),
        (b"<html><script>alert(1)</script>", 415),
        (b"", 415),
        (picture(40, 30)[:200], 415),
        (picture(40, 30, ".png")[:60], 415),
        (b"\xff\xd8\xff" + b"\0" * 1000, 415),
        (b"GIF89a" + b"\0" * 100, 415),
        (bomb(60_000), 415),
        (bomb(5000), 415),
        (bomb(0), 415),
    ):
        answer = client.post("/api/upload?name=x.jpg", content=data)
        assert answer.status_code == status
        assert answer.json()["error"]
    # Of a stream without a length no more is read than is allowed.
    endless = (b"x" * 1_000_000 for _ in range(MAX_BYTES // 1_000_000 + 2))
    assert client.post("/api/upload?name=x.jpg", content=endless).status_code == 413
    assert client.post("/api/open", content=b" " * (MAX_JSON + 1), headers=JSON).status_code == 413
    assert files(folder) == before


JSON = {"Content-Type": "application/json"}


def test_an_imported_picture_is_encoded_again_under_a_free_name(client, folder):
    data = picture(400, 300) + b"<script>alert(1)</script>"
    names = ["../../evil.py", "my poster.jpg", "my poster.jpg", "..", "ü/ö.jpeg", ".hidden.jpg"]
    got = [client.post("/api/upload", params={"name": name}, content=data).json()["path"] for name in names]
    assert got == ["evil.jpg", "my-poster.jpg", "my-poster-2.jpg", "picture.jpg", "ö.jpg", "hidden.jpg"]
    for name in got:
        written = (folder / name).read_bytes()
        assert b"script" not in written
        assert cv2.imdecode(np.frombuffer(written, np.uint8), cv2.IMREAD_COLOR).shape == (300, 400, 3)
        (folder / name).unlink()
    clear = np.zeros((10, MAX_SIDE * 2, 4), np.uint8)
    told = client.post("/api/upload?name=wide.png", content=cv2.imencode(".png", clear)[1].tobytes()).json()
    pixels = cv2.imread(str(folder / told["path"]), cv2.IMREAD_UNCHANGED)
    assert pixels.shape == (5, MAX_SIDE, 3)
    assert pixels.min() == 255
    (folder / told["path"]).unlink()


def test_what_is_no_request_of_the_page_is_refused_in_a_line(client):
    for body in ("", "{", "[]", '{"path": 3}', '{"path": "room.yaml", "more": 1}', '{"path": "room.yaml", "text": 1}'):
        answer = client.post("/api/parse", content=body, headers=JSON)
        assert answer.status_code == 400
        assert "\n" not in answer.json()["error"]
    for changes in ([{"op": "drop", "path": ["walls"]}], [{"op": "set", "path": [1.5], "value": 1}], [{}], 3):
        assert asks(client, "/api/edit", path="room.yaml", text=ROOM, changes=changes).status_code == 400
    for value in ("NaN", "Infinity", "1e999"):
        change = f'{{"op": "set", "path": ["light"], "value": {value}}}'
        body = f'{{"path": "room.yaml", "text": {json.dumps(ROOM)}, "changes": [{change}]}}'
        assert client.post("/api/edit", content=body, headers=JSON).status_code in (400, 409)
    assert client.get("/api/picture?path=posters/lion.jpg&size=huge").status_code == 400
    assert client.get("/api/open").status_code == 405


def test_a_folder_is_needed_and_a_world_in_it(tmp_path):
    with pytest.raises(UsageError, match=r"no folder '.*nowhere'; name an existing one"):
        Folder(tmp_path / "nowhere")
    with pytest.raises(UsageError, match=r"no file 'room\.yaml' in"):
        Studio(tmp_path, world="room.yaml")


def test_an_upload_that_is_cut_short_leaves_nothing(client, studio, folder):
    before = files(folder)
    port = httpx.URL(studio.url).port
    cookie = cookie_of(client)["Cookie"]
    with socket.create_connection(("127.0.0.1", port), PATIENCE) as raw:
        head = f"POST /api/upload?name=x.jpg HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nCookie: {cookie}\r\n"
        raw.sendall(f"{head}Content-Length: 5000\r\n\r\n".encode() + picture(40, 30)[:100])
    assert client.get("/").status_code == 200
    assert files(folder) == before


def test_the_command_says_in_a_line_what_is_wrong(tmp_path, capsys):
    for arguments, said in (
        ([str(tmp_path / "nowhere.yaml")], "nowhere.yaml'; name a world file or a folder"),
        (
            [str(tmp_path), "--host", "203.0.113.7"],
            "cannot serve at '203.0.113.7': it is not an address of this machine",
        ),
    ):
        with pytest.raises(SystemExit) as ended:
            main(["studio", *arguments])
        assert ended.value.code == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert said in line


def test_links_in_a_circle_and_pipes_in_the_folder_do_no_harm(folder, client):
    odd = [folder / "circle.yaml", folder / "circle", folder / "pipe.yaml", folder / "pipe.mcap"]
    for link in odd[:2]:
        link.symlink_to(link.name)
    for pipe in odd[2:]:
        os.mkfifo(pipe)
    try:
        told = client.get("/api/folder", timeout=PATIENCE)
        assert told.status_code == 200, told.text
        assert "room.yaml" in told.json()["worlds"]
        assert not {"circle.yaml", "pipe.yaml"} & set(told.json()["worlds"])
        assert client.get("/api/modules", timeout=PATIENCE).status_code == 200
        answer = client.get("/api/recording", params={"path": "pipe.mcap"}, timeout=PATIENCE)
        assert 400 <= answer.status_code < 500, answer.text
        assert "is a pipe or a device; name a file" in answer.json()["error"]
    finally:
        for path in odd:
            path.unlink()


@pytest.mark.parametrize(
    ("method", "path", "status"),
    [
        ("GET", "/api/nothing", 404),
        ("GET", "/favicon.ico", 404),
        ("PUT", "/api/folder", 405),
        ("TRACE", "/", 405),
        ("GET", "/api/folder/", 307),
        ("POST", "/api/save", 415),
        ("GET", "/login", 303),
    ],
)
def test_every_answer_has_the_headers_that_keep_other_pages_out(client, method, path, status):
    answer = client.request(method, path, follow_redirects=False)
    assert answer.status_code == status
    assert {name: answer.headers.get(name) for name in HEADERS} == HEADERS
