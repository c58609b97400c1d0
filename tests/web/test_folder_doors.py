"""What gets past the doors of a folder, asked without a server: paths, links, code."""

import os

import pytest

from mjsim.errors import UsageError
from mjsim.modules import foreign_code
from mjsim.web.server.answers import RefusedError
from mjsim.web.worlds.folder import MAX_PATH_LENGTH, Folder
from mjsim.web.worlds.trust import Trust
from mjsim.world import load_world


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "inside" / "deep").mkdir(parents=True)
    (tmp_path / "outside.yaml").write_text("mjsim: 1\n")
    (tmp_path / "inside" / "room.yaml").write_text("mjsim: 1\n")
    return Folder(tmp_path / "inside")


def refused(folder, name):
    with pytest.raises(RefusedError) as caught:
        folder.path(name)
    return caught.value.status


def test_no_name_and_no_link_leads_out_of_the_folder(folder, tmp_path):
    assert folder.path("room.yaml") == folder.root / "room.yaml"
    assert folder.path("deep/new.yaml") == folder.root / "deep" / "new.yaml"
    assert folder.name(folder.path("deep/new.yaml")) == "deep/new.yaml"
    (folder.root / "out.yaml").symlink_to(tmp_path / "outside.yaml")
    (folder.root / "up").symlink_to(tmp_path)
    (folder.root / "in.yaml").symlink_to(folder.root / "room.yaml")
    for name in ("out.yaml", "up/outside.yaml", "up/new.yaml", "up", ".", "deep/..", "../outside.yaml", "/etc/passwd"):
        assert refused(folder, name) == 403, name
    for name in ("c:/room.yaml", "C:"):
        assert refused(folder, name) == 403, name
    assert folder.path("in.yaml") == folder.root / "room.yaml"


def test_what_is_no_name_of_a_file_is_refused(folder):
    for name in ("", "a\\b", "a" * (MAX_PATH_LENGTH + 1), "a\nb", "x" * 256):
        assert refused(folder, name) == 400, name
    assert folder.path("a/" * (MAX_PATH_LENGTH // 2 - 1) + "b").name == "b"
    os.mkfifo(folder.root / "pipe")
    assert refused(folder, "pipe") == 400


def test_a_studio_needs_a_folder(tmp_path):
    with pytest.raises(UsageError, match="no folder"):
        Folder(tmp_path / "nothing")


@pytest.fixture
def world(tmp_path):
    (tmp_path / "go.py").write_text("import helper\nclass Go: pass\n")
    (tmp_path / "helper.py").write_text("x = 1\n")
    text = 'mjsim: 1\nrobots: [{name: r, at: [1, 1]}]\nrun: {drivers: {r: {navigator: {use: "go.py:Go"}}}}\n'
    (tmp_path / "world.yaml").write_text(text)
    return load_world(tmp_path / "world.yaml")


def test_code_runs_with_the_content_that_was_allowed_and_with_no_other(world, tmp_path):
    trust = Trust()
    files = {path: path.read_bytes() for path in (tmp_path / "go.py", tmp_path / "helper.py")}
    for path, data in files.items():
        with pytest.raises(UsageError, match=f"'{path.name}' is code that you have not allowed in its present form"):
            trust.admit(path, data)
    with pytest.raises(RefusedError) as caught:
        trust.check(world)
    assert caught.value.status == 403
    shown = trust.asks_for(world)
    assert sorted(shown) == ["go.py", "helper.py"]
    trust.allow(world, shown)
    assert trust.asks_for(world) == {}
    assert sorted(trust.check(world)) == ["go.py", "helper.py"]
    for path, data in files.items():
        trust.admit(path, data)
        with pytest.raises(UsageError):
            trust.admit(path, data + b"#")
        with pytest.raises(UsageError):
            trust.admit(path.with_name("other.py"), data)


def test_code_that_changed_since_it_was_shown_is_not_allowed(world, tmp_path):
    trust = Trust()
    shown = trust.asks_for(world)
    (tmp_path / "helper.py").write_text("x = 2\n")
    with pytest.raises(RefusedError, match=r"changed since you were asked: helper\.py; look at it again") as caught:
        trust.allow(world, shown)
    assert caught.value.status == 409
    assert caught.value.more["needs_trust"] != shown
    with pytest.raises(UsageError):
        trust.admit(tmp_path / "go.py", (tmp_path / "go.py").read_bytes())
    trust.allow(world, caught.value.more["needs_trust"])
    (tmp_path / "helper.py").write_text("x = 3\n")
    with pytest.raises(RefusedError) as caught:
        trust.check(world)
    assert sorted(caught.value.more["needs_trust"]) == ["helper.py"]


def test_code_that_was_refused_as_it_was_imported_is_asked_for_from_then_on(world, tmp_path):
    trust = Trust()
    (tmp_path / "late.py").write_text("y = 1\n")
    assert "late.py" not in foreign_code(world).files
    assert "late.py" not in trust.asks_for(world)
    with pytest.raises(UsageError):
        trust.admit(tmp_path / "late.py", b"y = 1\n")
    assert "late.py" in trust.asks_for(world)
