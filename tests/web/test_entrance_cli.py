"""The token and the addresses of the command `studio`: where the token comes from, and what is refused or said."""

import os
import re
import signal
import sys
from contextlib import contextmanager

import httpx
import pytest

from mjsim.bench.entering import client_of
from mjsim.cli import main
from mjsim.cli.page_access import read_token
from mjsim.errors import UsageError
from mjsim.web.studio import Studio
from tests.children import child
from tests.cli.shell import typed

PATIENCE = 90.0
"""No answer takes this long [s], on however loaded a machine."""
TOKEN = "a token of some length"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("entrance")
    (place / "room.yaml").write_text("mjsim: 1\n")
    return place


def test_without_a_token_only_loopback_is_served(folder):
    with Studio(folder, without_token=True) as page:
        assert page.url == page.address
        assert httpx.get(f"{page.url}api/folder", trust_env=False).status_code == 200
        foreign = {"Origin": "http://evil.example"}
        assert httpx.get(f"{page.url}api/folder", headers=foreign, trust_env=False).status_code == 403
    for keys in ({"host": "0.0.0.0"}, {"token": TOKEN}):
        with pytest.raises(UsageError, match="serving without a token works only on the loopback"):
            Studio(folder, without_token=True, **keys)


def test_a_token_that_can_be_guessed_is_refused(folder):
    with pytest.raises(UsageError, match="the token has 6 characters; use at least 16, chosen at random"):
        Studio(folder, token="s3cret")


def test_the_token_comes_from_a_file_or_the_environment(tmp_path, monkeypatch):
    file = tmp_path / "token"
    file.write_text(f"{TOKEN}\n")
    file.chmod(0o600)
    assert read_token(f"file:{file}") == TOKEN
    monkeypatch.setenv("MJSIM_TOKEN", TOKEN)
    assert read_token("env:MJSIM_TOKEN") == TOKEN
    # Browsers and workers that are started would inherit it.
    assert "MJSIM_TOKEN" not in os.environ
    (tmp_path / "open").write_text(TOKEN)
    (tmp_path / "open").chmod(0o644)
    (tmp_path / "empty").touch(0o600)
    for source, said in (
        ("s3cret-s3cret-s3cret", "all users of this machine can read a token on the command line"),
        ("file:", "can read a token on the command line"),
        ("word:s3cret", "can read a token on the command line"),
        (f"file:{tmp_path}/none", "cannot read the token from"),
        (f"file:{tmp_path}/open", "(mode 0644); run 'chmod 600"),
        (f"file:{tmp_path}/empty", "holds no token"),
        ("env:MJSIM_TOKEN", "environment variable MJSIM_TOKEN holds no token"),
    ):
        with pytest.raises(UsageError) as refused:
            read_token(source)
        assert said in str(refused.value)
        assert "\n" not in str(refused.value)
        assert "s3cret" not in str(refused.value)


def test_the_command_refuses_in_a_line_what_is_not_safe(tmp_path, capsys):
    for arguments, said in (
        (["--token", "s3cret-s3cret-s3cret"], "write --token file:PATH or --token env:NAME"),
        (["--no-token", "--host", "0.0.0.0"], "serving without a token works only on the loopback"),
    ):
        with pytest.raises(SystemExit) as ended:
            main(["studio", str(tmp_path), *arguments])
        assert ended.value.code == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert said in line


@contextmanager
def command(*words, **environment):
    """Run `mjsim studio` as a shell does; its lines of stderr can be read."""
    environment = os.environ | {"PYTHONUNBUFFERED": "1", **environment}
    with child([sys.executable, "-m", "mjsim.cli", "studio", *words], env=environment) as process:
        yield process


def address_in(line):
    return re.search(r"http://127\.0\.0\.1:\S+", line)[0]


@pytest.mark.slow
def test_the_command_prints_addresses_that_work_once_and_serves_until_ctrl_c(folder):
    with command(str(folder / "room.yaml"), "--no-browser") as running:
        url = address_in(running.line("stderr"))
        assert f"kill -USR1 {running.pid}" in running.line("stderr")
        with client_of(url) as browser:
            assert browser.get("/api/folder").json()["world"] == "room.yaml"
        running.send(signal.SIGUSR1)
        with client_of(address_in(running.line("stderr"))) as browser:
            assert browser.get("/api/folder").status_code == 200
        running.send(signal.SIGINT)
        assert running.ended() == 0
        assert running.rest("stderr") == ""


def test_the_command_warns_when_all_are_let_in(folder, capsys, monkeypatch):
    def look(studio):
        assert httpx.get(f"{studio.address}api/folder", trust_env=False).status_code == 200

    monkeypatch.setattr(Studio, "wait", look)
    code, _, err = typed("studio", str(folder), "--no-browser", "--no-token", capsys=capsys)
    assert code == 0, err
    assert "warning: without a token, every user" in err
    assert "token=" not in err
