"""What page and server say to each other is what the models in Python say, on both sides."""

import runpy
from pathlib import Path

import pytest
from pydantic import ConfigDict, TypeAdapter, ValidationError

import mjsim
from mjsim.web.run.news import News
from mjsim.web.run.run_api import RunApi
from mjsim.web.server.server import Server
from mjsim.web.worlds.folder import Folder
from mjsim.web.worlds.trust import Trust
from tests.browser import browser
from tests.web.rounds import ROOM, scene, start

PROTOCOL = runpy.run_path(str(Path(mjsim.__file__).parents[1] / "scripts" / "make" / "protocol.py"))
NEWS = TypeAdapter(News, config=ConfigDict(extra="forbid"))


def test_the_page_has_the_types_that_the_models_give():
    assert PROTOCOL["FILE"].read_text(encoding="utf-8") == PROTOCOL["protocol"]()
    assert PROTOCOL["ROLES_FILE"].read_text(encoding="utf-8") == PROTOCOL["roles"]()


def test_every_kind_of_news_of_a_run_is_as_its_type_says(tmp_path):
    api = RunApi(Folder(tmp_path), Trust(), scene=scene)
    with Server(api.routes, closing=[api.close]) as server, browser(server.url) as seen:
        start(seen, text=ROOM, speed=None)
        seen.until("tick")
        with browser(server.url) as late:
            late.until("past")
            news = {**seen.news, **late.news}
    assert set(news) >= {"run", "scene", "past", "tick"}
    for message in news.values():
        NEWS.validate_python(message)


def test_what_is_no_news_is_told_from_it():
    with pytest.raises(ValidationError):
        NEWS.validate_python({"kind": "tick", "number": "one"})
