"""The way into the page in a real browser: from a file, through the form, from another browser."""

import re
import threading

import pytest
from playwright.sync_api import expect

from mjsim.web.server.browser import BrowserOpener
from mjsim.web.studio import Studio
from tests.windows import PATIENCE, page_at

pytestmark = pytest.mark.slow
TOKEN = "a token of some length"


@pytest.fixture(scope="module")
def studio(tmp_path_factory):
    folder = tmp_path_factory.mktemp("studio")
    (folder / "room.yaml").write_text("mjsim: 1\nname: room\n")
    with Studio(folder, world="room.yaml", token=TOKEN) as page:
        yield page


def is_in(page):
    expect(page.locator(".world .name")).to_have_text("room.yaml", timeout=PATIENCE)


def test_a_file_that_redirects_leads_in_and_reloading_does_too(browser, studio, tmp_path, monkeypatch):
    opened = []
    monkeypatch.setattr("webbrowser.open", lambda url: opened.append(url) or True)
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    with BrowserOpener() as opening:
        opening.open_privately(studio.url, threading.Event(), failed=lambda: None)
        while not opened:
            pass
        with page_at(browser, opened[0], outside=True) as page:
            is_in(page)
            assert page.evaluate("document.referrer") == ""
            assert "token" not in page.evaluate("location.href + document.cookie")
            page.reload()
            is_in(page)
            with page.expect_request("**/api/schema") as asked:
                page.reload()
            assert "token" not in str(asked.value.all_headers().get("referer"))


def test_the_form_takes_the_token_and_says_what_is_wrong(browser, studio):
    with page_at(browser, studio.address) as page:
        page.get_by_label("Token or one-time address").fill("wrong")
        page.get_by_role("button", name="Open").click()
        expect(page.get_by_role("alert")).to_contain_text("neither the token nor an address", timeout=PATIENCE)
        page.get_by_label("Token or one-time address").fill(TOKEN)
        page.get_by_role("button", name="Open").click()
        is_in(page)


def test_a_browser_that_is_in_gives_an_address_for_another_and_comes_back_by_links(browser, studio, tmp_path):
    (tmp_path / "links.html").write_text(f'<a href="{studio.address}">the studio</a>')
    with page_at(browser, studio.url) as page:
        page.get_by_role("button", name="Open in another browser").click()
        address = page.get_by_role("dialog").get_by_label("Address")
        expect(address).to_have_value(re.compile(r"\?token="), timeout=PATIENCE)
        with page_at(browser, address.input_value()) as other:
            is_in(other)
        page.goto((tmp_path / "links.html").as_uri())
        page.get_by_role("link").click()
        is_in(page)
