"""Unsaved texts on disk: private, of one tab each, bounded; asked without a server."""

import stat
import time

import pytest

from mjsim.web.server.answers import RefusedError
from mjsim.web.worlds import drafts as kept
from mjsim.web.worlds.drafts import Drafts, drafts_folder
from mjsim.web.worlds.folder import Folder
from mjsim.web.worlds.watch import DiskWatch, named_in, signs_of

ONE, TWO = "1" * 16, "2" * 16


@pytest.fixture(autouse=True)
def state(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    return tmp_path / "state" / "mjsim" / "drafts"


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "studio").mkdir()
    (tmp_path / "studio" / "room.yaml").write_text("mjsim: 1\n")
    return Folder(tmp_path / "studio")


def keep(drafts, tab=ONE, number=1, path="room.yaml", text="mjsim: 1 # mine\n", *, fresh=False, **more):
    drafts.keep(tab, number, path=path, fresh=fresh, stamp="s", text=text, past={"steps": [1]}, **more)


def test_a_draft_is_private_and_comes_back_with_its_past(folder, state):
    drafts = Drafts(folder)
    keep(drafts)
    (told,) = drafts.listed()
    assert {key: told[key] for key in ("tab", "path", "fresh", "open")} == {
        "tab": ONE,
        "path": "room.yaml",
        "fresh": False,
        "open": False,
    }
    assert abs(told["when"] - time.time()) < 60.0
    read = drafts.read(told["id"])
    assert (read["text"], read["past"], read["stamp"], read["there"]) == (
        "mjsim: 1 # mine\n",
        {"steps": [1]},
        "s",
        True,
    )
    for place in (state, state.parent):
        assert stat.S_IMODE(place.stat().st_mode) == 0o700
    assert stat.S_IMODE((state / told["id"]).stat().st_mode) == 0o600
    (folder.root / "room.yaml").unlink()
    assert not drafts.read(told["id"])["there"]


def test_a_folder_of_drafts_that_others_may_read_is_made_private(folder, state):
    state.mkdir(parents=True, mode=0o777)
    state.chmod(0o777)
    keep(Drafts(folder))
    assert stat.S_IMODE(state.stat().st_mode) == 0o700


def test_a_link_in_the_place_of_the_folder_is_not_followed(folder, state, tmp_path):
    (tmp_path / "elsewhere").mkdir()
    state.parent.mkdir(parents=True)
    state.symlink_to(tmp_path / "elsewhere")
    with pytest.raises(RefusedError, match="is not a folder of your own; save often"):
        keep(Drafts(folder))
    assert not any((tmp_path / "elsewhere").iterdir())


def test_a_request_that_comes_late_changes_nothing(folder):
    drafts = Drafts(folder)
    keep(drafts, number=5, text="new")
    keep(drafts, number=4, text="old")
    drafts.forget(ONE, 3)
    assert drafts.read(drafts.listed()[0]["id"])["text"] == "new"
    drafts.forget(ONE, 6)
    assert drafts.listed() == []
    keep(drafts, number=5)
    assert drafts.listed() == []


def test_each_tab_has_one_draft_and_a_restored_one_gives_its_place(folder):
    drafts = Drafts(folder)
    keep(drafts, ONE, 1, text="one")
    keep(drafts, ONE, 2, path="other.yaml", text="other")
    assert [told["path"] for told in drafts.listed()] == ["other.yaml"]
    (old,) = drafts.listed()
    drafts.hold(ONE)
    keep(drafts, TWO, 1, text="two", restored=old["id"])
    assert len(drafts.listed()) == 2, "its page is open"
    drafts.release(ONE)
    keep(drafts, TWO, 2, text="two", restored=old["id"])
    assert [told["tab"] for told in drafts.listed()] == [TWO]


def test_an_open_tab_is_known_to_other_studios_until_the_last_release(folder, state):
    drafts, other = Drafts(folder), Drafts(folder)
    keep(drafts)
    (told,) = other.listed()
    drafts.hold(ONE)
    drafts.hold(ONE)
    assert other.listed()[0]["open"]
    with pytest.raises(RefusedError, match="open in another tab") as caught:
        other.drop(told["id"])
    assert caught.value.status == 409
    drafts.release(ONE)
    assert other.listed()[0]["open"]
    drafts.release(ONE)
    assert not other.listed()[0]["open"]
    assert not list(state.glob("*.open"))
    other.drop(told["id"])
    assert drafts.listed() == []


def test_drafts_of_another_folder_are_neither_listed_nor_read(folder, tmp_path):
    (tmp_path / "else").mkdir()
    drafts, other = Drafts(folder), Drafts(Folder(tmp_path / "else"))
    keep(drafts)
    keep(drafts, TWO, path="shipped:room", fresh=True)
    names = [told["id"] for told in drafts.listed()]
    assert len(names) == 2
    assert other.listed() == []
    for name in names:
        with pytest.raises(RefusedError, match="no longer there"):
            other.read(name)
    for name in ("../secret", "x", f"{'0' * 24}-{ONE}/.."):
        with pytest.raises(RefusedError) as caught:
            drafts.read(name)
        assert caught.value.status == 400
    with pytest.raises(RefusedError, match="is not the name of a tab"):
        keep(drafts, "../x")


def test_the_oldest_and_largest_drafts_make_room(folder, monkeypatch):
    drafts = Drafts(folder)
    clock = [1e9]
    monkeypatch.setattr(kept.time, "time", lambda: clock[0])
    monkeypatch.setattr(kept, "MAX_DRAFTS", 5)
    for number in range(7):
        clock[0] += 1.0
        keep(drafts, f"{number:016x}")
    tabs = [int(told["tab"], 16) for told in drafts.listed()]
    assert tabs == list(range(6, 1, -1))
    monkeypatch.setattr(kept, "MAX_TOTAL", 3000)
    clock[0] += 1.0
    keep(drafts, "f" * 16, text="x" * 2000)
    assert drafts.listed()[0]["tab"] == "f" * 16
    assert len(drafts.listed()) < 6
    clock[0] += kept.MAX_AGE + 1.0
    keep(drafts, "e" * 16, text="")
    assert [told["tab"] for told in drafts.listed()] == ["e" * 16]
    monkeypatch.setattr(kept, "MAX_BYTES", 10)
    with pytest.raises(RefusedError) as caught:
        keep(drafts, "e" * 16, 2, text="x" * 11)
    assert caught.value.status == 413


def test_what_is_no_draft_is_passed_over(folder, state):
    drafts = Drafts(folder)
    keep(drafts)
    (state / f"{'0' * 24}-{TWO}").write_text("no json\n")
    (state / f"{'a' * 24}-{TWO}").write_bytes((state / drafts.listed()[0]["id"]).read_bytes())
    assert len(drafts.listed()) == 1


def test_the_folder_of_drafts_is_that_of_the_state_of_the_user(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_STATE_HOME", "relative")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert drafts_folder() == tmp_path / ".local" / "state" / "mjsim" / "drafts"


def test_files_that_a_text_names_are_those_that_look_like_files():
    text = {"a": "x.yaml", "b": ["y.PNG", {"c": "mine.py:Mine"}], "d": 3, "e": "plain", "f": "z.txt"}
    assert sorted(named_in(text)) == ["mine.py", "x.yaml", "y.PNG"]


def test_a_change_on_disk_is_told_once_it_has_settled_and_once_only(folder, tmp_path):
    from mjsim.web.worlds.world_files import stamp_of

    world, code = folder.root / "room.yaml", folder.root / "go.py"
    code.write_text("x = 1\n")
    watch = DiskWatch(folder)
    signs = signs_of(folder, "room.yaml", ["go.py", "none.py", "../outside.py", "/etc/passwd"])
    (tmp_path / "outside.py").write_text("")
    assert {name for name, sign in signs.items() if sign} == {"go.py"}
    watch.show("room.yaml", stamp=stamp_of(world), files=signs)
    assert list(watch.news()) == []
    world.write_text("mjsim: 1 # changed\n")
    assert list(watch.news()) == [], "it may still be written"
    (told,) = watch.news()
    assert told == {"kind": "disk", "path": "room.yaml", "stamp": stamp_of(world)}
    assert list(watch.news()) == []
    code.write_text("x = 12\n")
    assert list(watch.news()) == []
    assert list(watch.news()) == [{"kind": "files", "files": ["go.py"]}]
    assert list(watch.news()) == []
    world.unlink()
    assert list(watch.news()) == []
    assert list(watch.news()) == [{"kind": "disk", "path": "room.yaml", "stamp": None}]
    with pytest.raises(RefusedError):
        watch.show("../outside.yaml", stamp=None, files={})
