"""Tabs of the studio, their drafts and their histories, without a server."""

import time
from functools import partial

import pytest

from mjsim.web.worlds.tabs import Tabs
from mjsim.web.worlds.world_files import read_world
from tests.loops import in_a_loop
from tests.web.in_process import OTHER, ROOM, TAB, Page, asked, folder_in


@pytest.fixture
def folder(tmp_path):
    return folder_in(tmp_path)


@pytest.fixture
def tabs(folder):
    tabs = Tabs(folder)
    yield tabs
    tabs.close()


def keep(tabs, tab=TAB, number=1, text="mjsim: 1\n", path="room.yaml", **more):
    asks = {"tab": tab, "number": number, "path": path, "fresh": False, "stamp": None, "text": text, **more}
    return asked(tabs.routes, "POST", "/api/draft/keep", json=asks)


def test_a_draft_is_kept_read_and_dropped_and_others_are_told(tabs, folder, state):
    async def talk():
        async with Page(tabs.routes, f"/api/tab?tab={OTHER}") as page:
            assert (await page.until("drafts"))["drafts"] == []
            past = {"steps": [{"from": 0, "old": "a", "fresh": "b"}], "at": 1}
            assert (await keep(tabs, past=past)).json() == {}
            (draft,) = (await page.until("drafts"))["drafts"]
            assert (draft["path"], draft["tab"], draft["open"]) == ("room.yaml", TAB, False)
            read = (await asked(tabs.routes, "POST", "/api/draft/read", json={"id": draft["id"]})).json()
            assert read["text"] == "mjsim: 1\n"
            assert read["past"]["steps"][0]["what"] == "Change"
            listed = (await asked(tabs.routes, "GET", "/api/drafts")).json()["drafts"]
            assert [each["id"] for each in listed] == [draft["id"]]
            await asked(tabs.routes, "POST", "/api/draft/drop", json={"id": draft["id"]})
            assert (await page.until("drafts"))["drafts"] == []
            await keep(tabs, number=2)
            await page.until("drafts", lambda news: news["drafts"])
            await asked(tabs.routes, "POST", "/api/draft/forget", json={"tab": TAB, "number": 3})
            assert (await page.until("drafts"))["drafts"] == []
            await keep(tabs, number=4, text=ROOM)  # As it is on disk.
            assert (await asked(tabs.routes, "GET", "/api/drafts")).json()["drafts"] == []

    in_a_loop(talk)


def test_a_tab_is_told_of_changes_on_disk_and_its_drafts_are_open(tabs, folder, state):
    async def talk():
        async with (
            Page(tabs.routes, f"/api/tab?tab={TAB}") as page,
            Page(tabs.routes, f"/api/tab?tab={OTHER}") as other,
        ):
            await other.until("drafts")
            await keep(tabs)
            assert (await other.until("drafts", lambda news: news["drafts"]))["drafts"][0]["open"]
            page.say("show", path="room.yaml", stamp="old", files={})
            tabs.wake()
            assert (await page.until("disk"))["stamp"] == read_world(folder, "room.yaml")[1]
            page.leave()
            assert not (await other.until("drafts", lambda news: not news["drafts"][0]["open"]))["drafts"][0]["open"]

    in_a_loop(talk)


def test_pages_without_a_tab_and_news_of_no_form_are_shown_out(tabs):
    async def talk():
        async with Page(tabs.routes, "/api/tab?tab=") as page:
            assert await page.next() == {"type": "websocket.close", "code": 1008, "reason": ""}
        async with Page(tabs.routes, f"/api/tab?tab={TAB}") as page:
            page.say("dance")
            while (message := await page.next())["type"] != "websocket.close":
                pass
            assert message["code"] == 1008
        async with Page(tabs.routes, f"/api/tab?tab={TAB}") as page:
            await page.next()
            tabs.close()
            began = time.monotonic()
            while (message := await page.next())["type"] != "websocket.close":
                pass
            assert message["code"] == 1000
            assert time.monotonic() - began < 0.4

    in_a_loop(talk)


def test_a_history_is_as_long_as_its_steps_and_bounded(tabs):
    step = {"from": 0, "old": "", "fresh": "x" * 300_000}
    for past, status in (
        ({"steps": [step], "at": 2}, 400),
        ({"steps": [step, step], "at": 2}, 400),
        ({"steps": [step], "at": 1}, 200),
    ):
        assert in_a_loop(partial(keep, tabs, past=past)).status_code == status
