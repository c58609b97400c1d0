"""Code that came with a world runs once somebody allowed it, with the content that they were asked about."""

import importlib.util
import os
import py_compile
import time
from itertools import count

import pytest

import mjsim
from mjsim.bench.entering import client_of
from mjsim.errors import UsageError
from mjsim.run import drivers_of
from mjsim.web import Studio
from mjsim.web.server.answers import RefusedError
from mjsim.web.worlds.trust import Trust
from mjsim.world import load_world
from tests.browser import browser
from tests.rover import ROVER, TANK
from tests.rover import WORLD as ROOM

pytestmark = pytest.mark.slow  # Each starts a server.

CODE = """
import helper, mjsim
class Go:
    def start(self, *told): helper.ran(__file__)
    def command(self, seen, belief): return mjsim.Command()
"""
HELPER = "from pathlib import Path\ndef ran(file): Path(file).with_name('ran').write_text('one')\n"
WORLD = """
mjsim: 1
name: driven
robots: [{name: scout, preset: pioneer3dx, at: [1, 1]}]
run: {drivers: {scout: {navigator: {use: "go.py:Go"}}}}
"""
PLAIN = WORLD.replace('{navigator: {use: "go.py:Go"}}', "{}")
DRIVEN_ROVER = ROOM + 'run: {drivers: {rover: {navigator: {use: "go.py:Go"}}}}\n'
LENGTHS = count(5)
EVIL = "from pathlib import Path\nPath(__file__).with_name('ran').write_text('evil')\n"
"""Code that leaves a trace as soon as it is imported."""


@pytest.fixture
def folder(tmp_path):
    for name, text in (("driven.yaml", WORLD), ("go.py", CODE), ("helper.py", HELPER)):
        (tmp_path / name).write_text(text)
    return tmp_path


@pytest.fixture
def studio(folder):
    with Studio(folder) as page, client_of(page.url) as client:
        client.page, client.folder = page, folder
        yield client


def asks(client, address, text=WORLD, **keys):
    return client.post(address, json={"path": "driven.yaml", "text": text, **keys})


def needs(client, text=WORLD):
    return asks(client, "/api/parse", text).json()["needs_trust"]


def allow(client, text=WORLD, **keys):
    answer = asks(client, "/api/trust", text, **{"code": needs(client, text), **keys})
    assert answer.status_code == 200, answer.text


def begun(client, text=WORLD, **keys):
    """Ask for a run, and return how it ended, or why it was refused."""
    seconds = round(0.04 * next(LENGTHS), 2)  # tells it from the run before
    with browser(client.page.url) as seen:
        seen.say("start", path="driven.yaml", text=text, speed=None, seconds=seconds, **keys)
        while True:
            kind = seen.take()
            if kind == "refused":
                return seen.news[kind]
            if kind == "run" and (run := seen.news[kind])["seconds"] == seconds and run["state"] in ("ended", "failed"):
                return run


def ran(folder):
    """Return what the code left, and take it away."""
    file = folder / "ran"
    if not file.exists():
        return None
    text = file.read_text()
    file.unlink()
    return text


def test_nothing_of_a_world_runs_before_somebody_allowed_what_they_were_shown(studio):
    shown = studio.post("/api/open", json={"path": "driven.yaml"}).json()["needs_trust"]
    assert list(shown) == ["go.py", "helper.py"]
    refused = begun(studio)
    assert refused["needs_trust"] == shown
    assert "go.py, helper.py" in refused["error"]
    assert asks(studio, "/api/trust").status_code == 400
    assert asks(studio, "/api/trust", code={}).status_code == 409
    assert asks(studio, "/api/trust", code={**shown, "go.py": shown["helper.py"]}).status_code == 409
    assert begun(studio)["kind"] == "refused"
    assert ran(studio.folder) is None
    assert asks(studio, "/api/trust", code=shown).json() == {"needs_trust": {}}
    assert ran(studio.folder) is None
    assert needs(studio) == {}
    assert begun(studio)["state"] == "ended"
    assert ran(studio.folder) == "one"


def test_code_can_be_read_before_it_is_allowed_and_nothing_else_can(studio):
    read = asks(studio, "/api/source", use="go.py:Go").json()
    assert (read["name"], read["text"]) == ("go.py", (studio.folder / "go.py").read_text())
    assert read["text"].splitlines()[read["line"] - 1].startswith("class Go")
    shipped = asks(studio, "/api/source", use="mjsim.algorithms.waypoints:Waypoints").json()
    assert shipped["text"].splitlines()[shipped["line"] - 1].startswith("class Waypoints")
    for use in (
        "driven.yaml:x",
        "../go.py:Go",
        "/etc/passwd:x",
        "mjsim.algorithms.none:X",
        "mjsim.algorithms./x:X",
        "os:path",
        "",
    ):
        assert asks(studio, "/api/source", use=use).status_code == 404
    assert ran(studio.folder) is None


def test_what_changed_since_the_dialog_was_shown_is_not_allowed_and_asked_again(studio):
    shown = needs(studio)
    (studio.folder / "helper.py").write_text(HELPER.replace("one", "evil"))
    answer = asks(studio, "/api/trust", code=shown)
    assert answer.status_code == 409
    assert answer.json()["error"] == "this code has changed since you were asked: helper.py; look at it again"
    now = answer.json()["needs_trust"]
    assert (now["go.py"], now["helper.py"] == shown["helper.py"]) == (shown["go.py"], False)
    assert begun(studio)["kind"] == "refused"
    assert ran(studio.folder) is None
    assert asks(studio, "/api/trust", code=now).status_code == 200


@pytest.mark.slow
def test_a_changed_helper_is_asked_for_and_then_the_changed_one_runs(studio):
    allow(studio)
    assert begun(studio)["state"] == "ended"
    assert ran(studio.folder) == "one"
    (studio.folder / "helper.py").write_text(HELPER.replace("one", "two"))
    assert list(begun(studio)["needs_trust"]) == ["helper.py"]
    assert ran(studio.folder) is None
    allow(studio)
    assert begun(studio)["state"] == "ended"
    assert ran(studio.folder) == "two"
    # What was allowed once may come back.
    (studio.folder / "helper.py").write_text(HELPER)
    assert begun(studio)["state"] == "ended"
    assert ran(studio.folder) == "one"


def test_bytecode_that_says_otherwise_than_its_source_does_not_run(studio):
    allow(studio)
    (studio.folder / "evil.txt").write_text(HELPER.replace("one", "evil"))
    cached = importlib.util.cache_from_source(studio.folder / "helper.py")
    mode = py_compile.PycInvalidationMode.UNCHECKED_HASH
    py_compile.compile(str(studio.folder / "evil.txt"), cached, invalidation_mode=mode)
    assert begun(studio)["state"] == "ended"
    assert ran(studio.folder) == "one"


def test_a_restart_does_not_run_what_has_changed(studio):
    allow(studio)
    with browser(studio.page.url) as seen:
        seen.say("start", path="driven.yaml", text=WORLD, speed=1, seconds=1000)
        seen.until("tick")
        assert ran(studio.folder) == "one"
        (studio.folder / "helper.py").write_text(HELPER.replace("one", "evil"))
        seen.say("restart")
        assert "the code of this world has changed since the run began" in seen.until("refused")["error"]
    assert ran(studio.folder) is None


@pytest.mark.parametrize("file", ["go.py", "helper.py"])
def test_a_file_that_is_swapped_between_the_check_and_the_import_does_not_run(folder, file):
    trust = Trust()
    plain = load_world(folder / "driven.yaml")
    world = mjsim.parse_world(WORLD, source=trust.guarded(plain.source))
    trust.allow(world, trust.asks_for(world))
    trust.check(world)
    drivers_of(world)
    (folder / file).write_text(f"open({str(folder / 'ran')!r}, 'w').write('evil')\n")
    with pytest.raises(
        UsageError, match=rf"'{file}' is code that you have not allowed in its present form; start again"
    ):
        drivers_of(world)
    assert ran(folder) is None
    with pytest.raises(RefusedError, match=rf"has changed: {file}"):
        trust.check(world)


@pytest.mark.slow
def test_what_a_text_imports_by_a_name_that_it_computes_is_asked_for_at_the_next_start(studio):
    (studio.folder / "go.py").write_text(
        CODE.replace("import helper", "import mjsim\nhelper = __import__('hel' + 'per') #")
    )
    allow(studio)
    assert "'helper.py' is code that you have not allowed" in begun(studio)["error"]
    assert ran(studio.folder) is None
    assert list(needs(studio)) == ["helper.py"]
    allow(studio)
    assert begun(studio)["state"] == "ended"
    assert ran(studio.folder) == "one"


@pytest.mark.slow
def test_modules_that_are_chosen_for_a_run_are_asked_for_like_those_of_its_world(studio):
    chosen = {"scout": {"navigator": {"use": "go.py:Go"}}}
    assert needs(studio, PLAIN) == {}
    refused = begun(studio, PLAIN, drivers=chosen)
    assert list(refused["needs_trust"]) == ["go.py", "helper.py"]
    allow(studio, PLAIN, code=refused["needs_trust"], drivers=chosen)
    assert begun(studio, PLAIN, drivers=chosen)["state"] == "ended"
    assert ran(studio.folder) == "one"


def test_a_drive_is_code_too_and_previews_ask_for_it(studio):
    (studio.folder / "rover.xml").write_text(ROVER)
    (studio.folder / "tank.py").write_text(EVIL + TANK)
    text = ROOM.replace("drive:", "sensors: [{camera: front, width: 32, height: 24}], drive:")
    shown = asks(studio, "/api/preview", text, robot="rover", camera="front", at=[0, 0])
    assert shown.status_code == 403
    assert list(shown.json()["needs_trust"]) == ["tank.py"]
    assert asks(studio, "/api/scene", text).json() == shown.json()
    assert ran(studio.folder) is None
    allow(studio, text)
    assert asks(studio, "/api/preview", text, robot="rover", camera="front", at=[0, 0]).status_code == 200
    assert ran(studio.folder) == "evil"


def test_a_preview_and_the_scene_need_no_permission_for_modules_that_drive(studio):
    text = WORLD.replace("at: [1, 1]", "at: [1, 1], sensors: [{camera: front, width: 32, height: 24}]")
    (studio.folder / "go.py").write_text(EVIL + CODE)
    assert list(needs(studio, text)) == ["go.py", "helper.py"]
    assert asks(studio, "/api/preview", text, robot="scout", camera="front", at=[0, 0]).status_code == 200
    assert asks(studio, "/api/scene", text).status_code == 200
    assert ran(studio.folder) is None


@pytest.mark.slow
def test_looking_at_a_recording_runs_no_code_that_its_world_names(studio, monkeypatch):
    folder = studio.folder
    for name, text in (("rover.xml", ROVER), ("tank.py", TANK), ("room.yaml", DRIVEN_ROVER)):
        (folder / name).write_text(text)
    with mjsim.Simulation(load_world(folder / "room.yaml")) as sim:
        mjsim.run(sim, seconds=0.4, record=folder / "out" / "run.mcap")
    assert ran(folder) == "one"
    # In whichever folder the code of a recording is looked for.
    for place in (folder, folder / "out"):
        for name in ("tank.py", "go.py", "helper.py"):
            (place / name).write_text(EVIL + (TANK if name == "tank.py" else CODE))
    monkeypatch.chdir(folder)
    for what in ("", "/tick", "/statistics", "/picture"):
        query = {"path": "out/run.mcap", "time": "0.2", "view": "overview"}
        assert studio.get(f"/api/recording{what}", params=query).status_code == 200, what
    film = studio.post("/api/recording/video", json={"path": "out/run.mcap", "from": 0.0, "to": 0.2})
    job = film.json()["job"]
    while (told := studio.get("/api/job", params={"id": job}).json())["path"] is None:
        assert told["error"] is None
        time.sleep(0.05)
    assert (ran(folder), ran(folder / "out")) == (None, None)


def test_the_same_code_in_another_folder_asks_as_well(folder, tmp_path_factory):
    trust, other = Trust(), tmp_path_factory.mktemp("other")
    world = load_world(folder / "driven.yaml")
    trust.allow(world, trust.asks_for(world))
    assert trust.asks_for(world) == {}
    for name in ("driven.yaml", "go.py", "helper.py"):
        (other / name).write_text((folder / name).read_text())
    assert list(trust.asks_for(load_world(other / "driven.yaml"))) == ["go.py", "helper.py"]


def test_a_file_that_is_imported_anew_asks_as_well(folder):
    world, trust = load_world(folder / "driven.yaml"), Trust()
    trust.allow(world, trust.asks_for(world))
    trust.check(world)
    (folder / "go.py").write_text("import other\n" + CODE)
    (folder / "other.py").write_text("")
    with pytest.raises(RefusedError, match=r"has changed: go\.py, other\.py"):
        trust.check(world)


def test_a_class_that_is_installed_asks_by_its_name_also_within_the_keys_of_others(tmp_path):
    def needed(use):
        (tmp_path / "room.yaml").write_text(WORLD.replace('{use: "go.py:Go"}', use))
        return Trust().asks_for(load_world(tmp_path / "room.yaml"))

    assert needed('{use: "subprocess:Popen", args: [ls]}') == {"subprocess:Popen": ""}
    assert needed('{use: "mjsim.algorithms.wander:Wander", inner: {use: "subprocess:Popen"}}') == {
        "subprocess:Popen": ""
    }
    assert needed('{use: "mjsim.algorithms.wander:Wander"}') == {}
    assert needed('{use: "mjsim.algorithmsx:Wander"}') == {"mjsim.algorithmsx:Wander": ""}


def test_a_program_that_is_swapped_between_the_check_and_its_start_does_not_run(tmp_path):
    program = tmp_path / "go.sh"
    program.write_text("#!/bin/sh\ntouch ran\n")
    program.chmod(0o755)
    (tmp_path / "driven.yaml").write_text(WORLD.replace("go.py:Go", "exec:./go.sh"))
    trust = Trust()
    source = trust.guarded(load_world(tmp_path / "driven.yaml").source)
    world = mjsim.parse_world((tmp_path / "driven.yaml").read_text(), source=source)
    assert list(trust.asks_for(world)) == ["go.sh"]
    trust.allow(world, trust.asks_for(world))
    drivers_of(world)
    program.write_text("#!/bin/sh\ntouch evil\n")
    with pytest.raises(UsageError, match=r"'go\.sh' is code that you have not allowed in its present form"):
        drivers_of(world)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["driven.yaml", "go.sh"]


def test_no_name_shows_a_file_outside_the_folder_or_stops_the_server(studio):
    outside = studio.folder.parent / "outside"
    outside.mkdir()
    (outside / "m.py").write_text(f"SECRET = 1\n{CODE}")
    (studio.folder / "link.py").symlink_to(outside / "m.py")
    (studio.folder / "away").symlink_to(outside)
    os.mkfifo(studio.folder / "pipe.py")
    (studio.folder / "x.yaml").write_text(WORLD)
    for place in (f"{outside}/m.py", "../outside/m.py", "link.py", "away/m.py", "pipe.py", "../x.yaml", ".", ".."):
        text = WORLD.replace("go.py:Go", f"{place}:Go")
        shown = asks(studio, "/api/parse", text).json()
        assert len(shown["problems"]) == 1
        refused = asks(studio, "/api/source", text, use=f"{place}:Go")
        assert (refused.status_code, "SECRET" in refused.text) == (404, False)
        assert begun(studio, text)["kind"] == "refused"


def test_a_program_elsewhere_on_a_command_line_runs_as_it_was_allowed_and_is_asked_for_when_it_changes(studio):
    outside = studio.folder.parent / "program.py"
    outside.write_text("one")
    text = WORLD.replace("go.py:Go", f"exec:python3 {outside}")
    allow(studio, text)
    assert needs(studio, text) == {}
    outside.write_text("other")
    assert list(begun(studio, text)["needs_trust"]) == [str(outside)]
