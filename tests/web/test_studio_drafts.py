"""Unsaved changes outlive the page and the server; they are private, bounded, and each tab has its own."""

import json
import os
import stat
import time

import pytest
from websockets.exceptions import InvalidStatus

from mjsim.bench.entering import client_of
from mjsim.output.atomic import LEFT_BEHIND, NEW
from mjsim.web.studio import Studio
from mjsim.web.worlds.drafts import MAX_AGE, MAX_DRAFTS, Drafts, drafts_folder
from mjsim.web.worlds.folder import Folder
from tests.asking import ROOM, told
from tests.browser import browser

pytestmark = pytest.mark.slow  # Each starts a server.

PATIENCE = 60.0
"""No answer takes this long [s], on however loaded a machine."""
ONE, OTHER = "1" * 16, "2" * 16
"""Names of tabs."""


@pytest.fixture(autouse=True)
def state(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    return tmp_path / "state"


def ask(client, address, **keys):
    return told(client, f"draft/{address}", **keys)


def keep(client, text, *, tab=ONE, number=1, path="room.yaml", fresh=False, stamp=None, status=200, **more):
    return ask(
        client, "keep", status=status, tab=tab, number=number, path=path, fresh=fresh, stamp=stamp, text=text, **more
    )


def drafts(client):
    return client.get("/api/drafts").json()["drafts"]


def texts(client):
    return {draft["path"]: ask(client, "read", id=draft["id"])["text"] for draft in drafts(client)}


def test_drafts_are_private_and_lie_in_the_state_folder_alone(client, folder, state):
    state.mkdir(mode=0o755)
    keep(client, ROOM + "# new\n")
    place = state / "mjsim" / "drafts"
    assert place == drafts_folder()
    assert [stat.S_IMODE(each.stat().st_mode) for each in (state / "mjsim", place)] == [0o700, 0o700]
    (file,) = place.iterdir()
    assert stat.S_IMODE(file.stat().st_mode) == 0o600
    # A person can read it, too: what it is stands in the first line, its history in the second, then comes the text.
    head, past, text = file.read_text().split("\n", 2)
    assert json.loads(head)["file"] == str(folder / "room.yaml")
    assert json.loads(past) == {"steps": [], "at": 0}
    assert text == ROOM + "# new\n"
    assert [path.name for path in folder.iterdir()] == ["room.yaml"]
    place.chmod(0o755)
    keep(client, ROOM, number=2, path="new.yaml", fresh=True)
    assert stat.S_IMODE(place.stat().st_mode) == 0o700
    assert len(list(place.iterdir())) == 1  # a tab has one text


def test_a_relative_state_folder_is_ignored(monkeypatch, tmp_path):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("XDG_STATE_HOME", "state")
    assert drafts_folder() == tmp_path / ".local" / "state" / "mjsim" / "drafts"


@pytest.mark.slow
def test_a_server_that_is_started_anew_at_another_port_has_them(folder):
    kept = {"room.yaml": ROOM + "# mine\n", "room-2.yaml": "mjsim: 1\n# new\n", "shipped:gallery": "# from afar\n"}
    for number, (path, text) in enumerate(kept.items()):
        with Studio(folder) as page, client_of(page.url) as client:
            keep(client, text, tab=f"{number:016x}", path=path, fresh=path == "room-2.yaml", stamp="s")
    with Studio(folder) as page, client_of(page.url) as client:
        assert texts(client) == kept
        assert [draft["path"] for draft in drafts(client)] == ["shipped:gallery", "room-2.yaml", "room.yaml"]
        assert [draft["fresh"] for draft in drafts(client)] == [False, True, False]
        assert ask(client, "read", id=drafts(client)[2]["id"])["stamp"] == "s"
        assert abs(drafts(client)[0]["when"] - time.time()) < PATIENCE


@pytest.mark.slow
def test_a_file_has_its_drafts_by_whatever_name_and_from_whatever_folder(folder, client):
    (folder / "link.yaml").symlink_to(folder / "room.yaml")
    keep(client, "# by a link\n", path="link.yaml")
    assert texts(client) == {"room.yaml": "# by a link\n"}
    with Studio(folder.parent) as page, client_of(page.url) as above:
        assert texts(above) == {"worlds/room.yaml": "# by a link\n"}
    beside = folder.parent / "beside"
    beside.mkdir()
    (draft,) = drafts(client)
    with Studio(beside) as page, client_of(page.url) as elsewhere:
        assert drafts(elsewhere) == []
        for address in ("read", "drop"):
            ask(elsewhere, address, status=404, id=draft["id"])
    assert len(drafts(client)) == 1


@pytest.mark.slow
def test_each_tab_has_its_own_and_who_has_it_open_keeps_it(studio, client):
    keep(client, "# one\n", tab=ONE)
    keep(client, "# other\n", tab=OTHER)
    with browser(studio.url, f"/api/tab?tab={ONE}") as page:
        page.until("drafts")
        found = {draft["tab"]: draft for draft in drafts(client)}
        assert {tab: draft["open"] for tab, draft in found.items()} == {ONE: True, OTHER: False}
        refused = ask(client, "drop", status=409, id=found[ONE]["id"])
        assert refused["error"] == "these changes are open in another tab; discard them there"
        ask(client, "drop", id=found[OTHER]["id"])
        ask(client, "read", status=404, id=found[OTHER]["id"])
    with browser(studio.url, f"/api/tab?tab={OTHER}") as page:
        while page.until("drafts")["drafts"][0]["open"]:
            pass
    ask(client, "drop", id=found[ONE]["id"])
    assert drafts(client) == []


def test_a_draft_that_is_restored_gives_its_place_to_that_of_the_tab_that_goes_on(studio, client):
    keep(client, ROOM + "# left\n")
    (left,) = drafts(client)
    keep(client, ROOM + "# left\n", tab=OTHER, restored=left["id"])
    assert [draft["tab"] for draft in drafts(client)] == [OTHER]
    (now,) = drafts(client)
    with browser(studio.url, f"/api/tab?tab={OTHER}") as page:
        page.until("drafts")
        keep(client, ROOM + "# other\n", number=2, restored=now["id"])
        assert {draft["tab"] for draft in drafts(client)} == {ONE, OTHER}  # what is open stays
    keep(client, ROOM, number=3, restored="../" + now["id"], status=400)


@pytest.mark.slow
def test_a_tab_is_told_of_the_drafts_of_others_and_when_they_are_left(studio, client):
    with browser(studio.url, f"/api/tab?tab={ONE}") as one:
        assert one.until("drafts")["drafts"] == []
        keep(client, "# mine\n", tab=ONE)  # of which it is not told
        with browser(studio.url, f"/api/tab?tab={OTHER}"):
            keep(client, "# other\n", tab=OTHER)
            (draft,) = one.until("drafts")["drafts"]
            assert (draft["tab"], draft["path"], draft["open"]) == (OTHER, "room.yaml", True)
        (draft,) = one.until("drafts")["drafts"]
        assert (draft["tab"], draft["open"]) == (OTHER, False)
        ask(client, "forget", tab=OTHER, number=2)
        assert one.until("drafts")["drafts"] == []


@pytest.mark.slow
def test_two_studios_of_a_folder_know_each_others_tabs(folder, studio, client):
    with Studio(folder) as second, browser(second.url, f"/api/tab?tab={OTHER}") as page:
        keep(client, "# open at the first\n")
        with browser(studio.url, f"/api/tab?tab={ONE}"):
            while not page.until("drafts")["drafts"]:
                pass
            while not page.news["drafts"]["drafts"][0]["open"]:
                page.until("drafts")
        while page.news["drafts"]["drafts"][0]["open"]:
            page.until("drafts")


@pytest.mark.slow
def test_a_server_that_ends_leaves_the_drafts_of_the_pages_that_were_open(folder):
    with Studio(folder) as page, client_of(page.url) as client:
        opened = browser(page.url, f"/api/tab?tab={ONE}")
        opened.__enter__().until("drafts")
        keep(client, "# mine\n")
        assert drafts(client)[0]["open"]
    with Studio(folder) as page, client_of(page.url) as client:
        assert not drafts(client)[0]["open"]
    opened.__exit__(None, None, None)


def test_an_order_that_comes_late_does_not_undo_a_newer_one(client):
    keep(client, "# second\n", number=2)
    keep(client, "# first\n", number=1)
    assert texts(client) == {"room.yaml": "# second\n"}
    ask(client, "forget", tab=ONE, number=4)
    keep(client, "# third\n", number=3)
    assert drafts(client) == []


def test_what_is_on_disk_as_it_is_is_not_offered(client, folder):
    keep(client, ROOM + "# saved\n")
    (folder / "room.yaml").write_text(ROOM + "# saved\n")
    assert drafts(client) == []
    assert list(drafts_folder().iterdir()) == []


@pytest.mark.slow
def test_their_number_their_size_and_their_age_are_bounded(client, folder):
    refused = keep(client, "#" * 6_000_000, status=413)
    assert refused["error"].startswith("unsaved changes cannot be kept: the file has 6")
    store = Drafts(Folder(folder))
    for number in range(MAX_DRAFTS + 3):
        store.keep(f"{number:016x}", 1, path=f"{number}.yaml", fresh=True, stamp=None, text="#", past={})
    assert [draft["path"] for draft in drafts(client)] == [f"{number}.yaml" for number in range(MAX_DRAFTS + 2, 2, -1)]
    (file,) = drafts_folder().glob(f"*-{MAX_DRAFTS:016x}")
    head, _, rest = file.read_text().partition("\n")
    file.write_text(json.dumps({**json.loads(head), "when": time.time() - MAX_AGE - 1}) + "\n" + rest)
    keep(client, "#")
    assert not file.exists()


@pytest.mark.slow
def test_large_ones_make_room_for_new_ones(client, folder):
    store, text = Drafts(Folder(folder)), "#" * 4_900_000
    for number in range(22):
        store.keep(f"{number:016x}", 1, path="room.yaml", fresh=False, stamp=None, text=text, past={})
    assert len(drafts(client)) == 20
    assert sum(file.stat().st_size for file in drafts_folder().iterdir()) < 1e8


def test_what_was_left_behind_by_a_kill_is_removed(client, state):
    keep(client, "# mine\n")
    place = drafts_folder()
    old = time.time() - LEFT_BEHIND - 1
    for name in (NEW.format("0" * 16), f"{OTHER}.open"):
        (place / name).write_text("")
        os.utime(place / name, (old, old))
    keep(client, "# mine\n", number=2)
    assert len(list(place.iterdir())) == 1


@pytest.mark.parametrize("name", ["", "..", "../room.yaml", "/etc/passwd", "0" * 41, f"{'0' * 24}-{ONE}/x", "é" * 9])
def test_what_is_no_draft_is_refused(client, name):
    for address in ("read", "drop"):
        assert ask(client, address, status=400, id=name)["error"].endswith("is not the id of a draft; see the list")
    keep(client, "#", tab=name, status=400)
    ask(client, "forget", status=400, tab=name, number=1)
    keep(client, "#", path="../room.yaml", status=403)
    assert drafts(client) == []


def test_a_broken_draft_is_passed_over(client):
    keep(client, "# whole\n")
    (whole,) = drafts_folder().iterdir()
    for number, data in enumerate((b"", b"{}", b"[]\n{}\n#", b"\xff\xff\n\n#", whole.read_bytes())):
        (drafts_folder() / f"{number:024x}-{OTHER}").write_bytes(data)
    assert texts(client) == {"room.yaml": "# whole\n"}


def test_where_they_cannot_be_kept_a_line_says_so(client, state):
    state.mkdir()
    (state / "mjsim").write_text("in the way")
    refused = keep(client, "# mine\n", status=409)
    assert refused["error"] == "unsaved changes cannot be kept: File exists; save often"
    (state / "mjsim").unlink()
    (state / "mjsim").symlink_to(state.parent)
    assert "unsaved changes cannot be kept: " in keep(client, "# mine\n", number=2, status=409)["error"]
    assert drafts(client) == []


def test_the_steps_that_led_to_a_text_are_kept_with_it_within_bounds(client):
    past = {"steps": [{"from": 0, "old": "é\n", "fresh": "\U0001f916\u2028", "what": "Move crate"}] * 3, "at": 2}
    keep(client, "# mine\n", past=past)
    (draft,) = drafts(client)
    assert ask(client, "read", id=draft["id"])["past"] == past
    step = {"from": 0, "old": "", "fresh": "a"}
    for wrong in (
        {"steps": [step] * 1001},
        {"steps": [{**step, "fresh": "a" * 400_001}]},
        {"steps": [{**step, "fresh": "a" * 300_000}] * 2},
        {"steps": [{**step, "from": -1}]},
        {"steps": [{**step, "what": "a" * 101}]},
        {"steps": [step], "at": 2},
        {"steps": [{"from": 0}]},
    ):
        keep(client, "# wrong\n", number=2, past=wrong, status=400)


def test_odd_texts_come_back_as_they_were(client):
    for number, text in enumerate(("", "\r\n\n", "\ufeffmjsim: 1\n", "é\U0001f916\0", "a" * 70_000)):
        keep(client, text, number=number, path="odd.yaml", fresh=True)
        assert texts(client) == {"odd.yaml": text}


def test_the_tab_of_a_page_has_a_name(studio):
    for name in ("", "x", ONE + "0"):
        with pytest.raises(InvalidStatus), browser(studio.url, f"/api/tab?tab={name}"):
            pass
