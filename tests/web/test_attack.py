"""The attack: another user of the machine, and one without a session, against `mjsim studio` as a shell starts it."""

import json
import os
import re
import signal
import stat
import sys
import tempfile
import threading
import time
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import httpx
import pytest
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from mjsim.bench.entering import client_of
from tests.children import child
from tests.python_script import HEAD
from tests.strangers import as_stranger

pytestmark = pytest.mark.slow
PATIENCE = 60.0
"""Nothing takes this long [s], on however loaded a machine."""
ROOM = "mjsim: 1\nrobots: [{name: scout, preset: pioneer3dx, at: [1, 1]}]\n"
EVIL = f'{ROOM}run: {{drivers: {{scout: {{estimator: {{use: "subprocess:Popen", args: [touch, "EVIL"]}}}}}}}}\n'
BROWSER = """
import json, os, pathlib, stat, sys, time, urllib.parse

def readable(name):
    for path in pathlib.Path("/proc").glob(f"[0-9]*/{{name}}"):
        try:
            yield path.read_bytes().decode("utf-8", "replace")
        except OSError:
            pass

page = pathlib.Path(urllib.parse.unquote(urllib.parse.urlsplit(sys.argv[1]).path))
seen = {{
    "arguments": sys.argv[1:],
    "file": str(page),
    "text": page.read_text(),
    "mode": stat.S_IMODE(page.stat().st_mode),
    "folder_mode": stat.S_IMODE(page.parent.stat().st_mode),
    "commands": list(readable("cmdline")),
    "environments": list(readable("environ")),
}}
part = pathlib.Path({told!r} + ".part")
part.write_text(json.dumps(seen))
part.rename({told!r})
# As some browsers do, it goes on until it is closed.
time.sleep({stays})
"""


@pytest.fixture
def place():
    """A folder that every user may look into, as a home often is; other runs of pytest would shut theirs."""
    with tempfile.TemporaryDirectory() as name:
        place = Path(name)
        place.chmod(0o755)
        (place / "room.yaml").write_text(ROOM)
        yield place


@contextmanager
def studio(place, *, stays=0.0):
    """Run `mjsim studio` with a browser that notes what it sees; yield address, notes, log and temporary folder."""
    told, log, temporary = place / "told.json", place / "log", place / "tmp"
    temporary.mkdir(mode=0o777)
    script = place / "browser"
    script.write_text(HEAD + BROWSER.format(told=str(told), stays=stays))
    script.chmod(0o755)
    environment = os.environ | {"BROWSER": str(script), "DISPLAY": ":7", "TMPDIR": str(temporary)}
    command = [sys.executable, "-m", "mjsim.cli", "studio", "room.yaml"]
    with log.open("w") as out, child(command, cwd=place, env=environment, stdout=out, stderr=out) as process:
        wait_for(lambda: told.exists(), process)
        notes = json.loads(told.read_text())
        yield re.search(r"http://127\.0\.0\.1:\d+/", log.read_text())[0], notes, log, temporary
        process.send(signal.SIGTERM)
        process.ended()


def wait_for(there, process=None):
    until = time.monotonic() + PATIENCE
    while not there():
        assert time.monotonic() < until
        assert process is None or process.runs()
        threading.Event().wait(0.05)


def url_of(notes):
    return re.search(r"url=(http://[^\"]+)\"", notes["text"])[1]


def test_the_browser_gets_in_by_a_file_of_the_user_alone_that_goes_at_once(place):
    with studio(place, stays=30.0) as (address, notes, log, temporary):
        url = url_of(notes)
        word = httpx.URL(url).params["token"]
        assert url.startswith(address)
        assert len(word) >= 22
        assert (notes["mode"], notes["folder_mode"]) == (0o600, 0o700)
        assert stat.S_ISDIR(os.stat(Path(notes["file"]).parent).st_mode)
        # Neither the browser nor any other program was told the word.
        assert notes["arguments"] == [Path(notes["file"]).as_uri()]
        assert any(notes["arguments"][0] in command for command in notes["commands"])
        for text in (*notes["commands"], *notes["environments"], log.read_text()):
            assert word not in text
        with client_of(url) as browser:
            assert browser.get("/api/folder").status_code == 200
            # It goes at once, also while the browser runs on.
            wait_for(lambda: not Path(notes["file"]).parent.exists())
        assert list(temporary.iterdir()) == []
        assert word not in log.read_text()


def attack(address, place, redirect, *, log, temporary):
    """Try everything; return what worked."""
    worked = []

    def ask(method, path, **keys):
        with httpx.Client(base_url=address, timeout=PATIENCE, trust_env=False, verify=False) as browser:
            answer = browser.request(method, path, **keys)
        if answer.status_code not in (401, 403, 429):
            worked.append((method, path, answer.status_code))
        return answer.text + str(answer.headers)

    text = {"path": "room.yaml", "text": EVIL.replace("EVIL", str(place / "ran"))}
    told = ask("GET", "/") + ask("GET", "/api/folder") + ask("GET", "/studio.js")
    told += ask("POST", "/api/trust", json=text) + ask("POST", "/api/preview", json={**text, "robot": "scout"})
    told += ask("POST", "/api/save", json={**text, "overwrite": True}) + ask("POST", "/api/invite")
    told += ask("POST", "/api/upload?name=x.png", content=b"x") + ask("GET", "/?token=guess")
    told += ask("POST", "/login", data={"token": "guess"})
    told += ask("GET", "/api/folder", headers={"X-Forwarded-For": "127.0.0.1", "Cookie": "mjsim-session=x"})
    try:
        run = f"{address.replace('http:', 'ws:')}api/run"
        with connect(run, open_timeout=PATIENCE, origin=address.rstrip("/")) as socket:
            socket.send(json.dumps({"do": "start", "speed": 1, **text}))
            worked.append("a WebSocket")
    except InvalidStatus:
        pass
    processes = [*Path("/proc").glob("[0-9]*/cmdline"), *Path("/proc").glob("[0-9]*/environ")]
    for file in [redirect, log, *Path(temporary).rglob("*"), *processes]:
        try:
            told += Path(file).read_bytes().decode("latin-1")
        except OSError:
            continue
    return {"worked": worked, "told": told}


def test_other_users_cannot_read_the_one_time_address_or_run_code(place):
    with studio(place) as (address, notes, log, temporary):
        word = httpx.URL(url_of(notes)).params["token"]
        # The same user can read every file; without a cookie the page stays closed all the same.
        hidden = place / "none"
        for other, redirect, folder in ((True, notes["file"], temporary), (False, hidden, hidden)):
            attacking = partial(attack, address, place, redirect, log=log, temporary=folder)
            seen = as_stranger(attacking, other=other)
            assert seen["worked"] == []
            assert word not in seen["told"]
            assert not (place / "ran").exists()
            assert (place / "room.yaml").read_text() == ROOM
        # The way in was not used up by all this.
        with client_of(url_of(notes)) as browser:
            assert browser.get("/api/folder").status_code == 200
