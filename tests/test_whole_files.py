"""Files that are replaced as a whole, locks on folders, and names that are free."""

import os
import stat
import time
from pathlib import Path

import pytest

from mjsim.errors import UsageError
from mjsim.output import free_path, require_free
from mjsim.output.atomic import remove_leftovers, replace_file, write_new, write_whole
from mjsim.output.file_locks import is_at, is_locked, locked_folder, try_lock
from mjsim.output.output_places import create, free_paths, made_folders, numbered
from mjsim.output.reserved import NewFile, move_to_free


def mode(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


def test_a_file_is_replaced_as_a_whole_and_keeps_its_mode(tmp_path):
    place = tmp_path / "w.yaml"
    write_whole(place, b"one")
    assert place.read_bytes() == b"one"
    place.chmod(0o640)
    number = place.stat().st_ino
    write_whole(place, b"two")
    assert (place.read_bytes(), mode(place), place.stat().st_ino == number) == (b"two", 0o640, False)
    assert list(tmp_path.iterdir()) == [place]


def test_a_write_protected_file_stays(tmp_path, monkeypatch):
    place = tmp_path / "w.yaml"
    place.write_bytes(b"one")
    place.chmod(0o444)
    monkeypatch.setattr(os, "access", lambda path, how: not (path == place and how == os.W_OK))
    with pytest.raises(PermissionError, match="write-protected"):
        write_whole(place, b"two")
    assert place.read_bytes() == b"one"


def test_the_owner_of_a_replaced_file_is_kept_as_far_as_permitted(tmp_path, monkeypatch):
    place, asked = tmp_path / "w.yaml", []
    place.write_bytes(b"one")

    def chown(path: Path, owner: int, group: int) -> None:
        asked.append((owner, group))
        if owner < 0:
            raise PermissionError

    monkeypatch.setattr(os, "chown", chown)
    write_whole(place, b"two")
    assert asked == [(-1, place.stat().st_gid), (place.stat().st_uid, -1)]
    assert place.read_bytes() == b"two"


def test_a_new_file_never_replaces_one(tmp_path, monkeypatch):
    place = tmp_path / "a"
    write_new(place, b"one")
    with pytest.raises(FileExistsError):
        write_new(place, b"two")

    def no_links(*_: object) -> None:
        raise OSError(1, "no links here")

    monkeypatch.setattr(os, "link", no_links)
    with pytest.raises(FileExistsError):
        write_new(place, b"two")
    write_new(tmp_path / "b", b"three")
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {"a": b"one", "b": b"three"}


def test_a_file_of_our_own_has_the_mode_that_is_asked(tmp_path):
    replace_file(tmp_path / "key", b"1", mode=0o600)
    replace_file(tmp_path / "key", b"2", mode=0o600)
    assert ((tmp_path / "key").read_bytes(), mode(tmp_path / "key")) == (b"2", 0o600)


def test_a_write_that_fails_leaves_the_old_content_and_nothing_else(tmp_path, monkeypatch):
    place = tmp_path / "a"
    place.write_bytes(b"one")

    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    for write in (write_whole, replace_file, lambda path, data: write_new(path.with_name("b"), data)):
        with pytest.raises(OSError, match="No space"):
            write(place, b"two")
    assert [(path.name, path.read_bytes()) for path in tmp_path.iterdir()] == [("a", b"one")]


def test_only_old_leftovers_are_removed(tmp_path):
    names = [".mjsim-0011.new", ".mjsim-0022.new", "mjsim-0033.new"]
    for name in names:
        (tmp_path / name).touch()
    for name in names[::2]:
        os.utime(tmp_path / name, (time.time() - 61.0,) * 2)
    os.utime(tmp_path / names[1], (time.time() - 50.0,) * 2)
    remove_leftovers(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(names[1:])
    remove_leftovers(tmp_path / "none")


def test_a_folder_is_locked_for_the_block_alone(tmp_path):
    for _ in range(2):
        with locked_folder(tmp_path) as first, locked_folder(tmp_path) as second:
            assert (first, second) == (True, False)
    with pytest.raises(FileNotFoundError), locked_folder(tmp_path / "none"):
        pass


def test_locks_are_told_and_file_systems_without_them_are_not_noticed(tmp_path, monkeypatch):
    import filelock

    place = tmp_path / "a"
    assert not is_locked(place)
    with NewFile(place) as file:
        assert is_locked(file.part)
        assert is_at(file.fileno(), file.part)
        assert not is_at(file.fileno(), place)
        assert not is_at(file.fileno(), Path(__file__))
        file.publish()
    assert not is_locked(place)

    def failing(number: int) -> None:
        def lock(*_: object, **__: object) -> bool:
            raise OSError(number, os.strerror(number))

        monkeypatch.setattr(filelock, "lock_descriptor", lock)

    import errno

    failing(errno.ENOLCK)
    assert try_lock(0)
    failing(errno.EIO)
    with pytest.raises(OSError, match="Input/output"):
        try_lock(0)


def test_the_first_free_number_is_taken(tmp_path):
    names = numbered(tmp_path / "run.mcap")
    assert [next(names).name for _ in range(3)] == ["run.mcap", "run-2.mcap", "run-3.mcap"]
    create(tmp_path / "run.mcap")
    with pytest.raises(FileExistsError):
        create(tmp_path / "run.mcap")
    assert free_path(tmp_path / "run.mcap").name == "run-2.mcap"
    assert free_path(tmp_path / "run.mcap", taken=[tmp_path / "run-2.mcap"]).name == "run-3.mcap"
    (tmp_path / "part").write_bytes(b"whole")
    assert move_to_free(tmp_path / "part", tmp_path / "run.mcap") == tmp_path / "run-2.mcap"
    assert (tmp_path / "run-2.mcap").read_bytes() == b"whole"
    assert (tmp_path / "run.mcap").read_bytes() == b""
    assert not (tmp_path / "part").exists()


def test_made_folders_are_told_deepest_first(tmp_path):
    assert made_folders(tmp_path / "a" / "b") == [tmp_path / "a" / "b", tmp_path / "a"]
    assert made_folders(tmp_path / "a" / "b") == []


def test_paths_that_may_not_be_written_are_told(tmp_path):
    (tmp_path / "file").write_bytes(b"1")
    (tmp_path / "folder").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "file")
    require_free(tmp_path / "none", tmp_path / "none" / "too")
    require_free(tmp_path / "file", overwrite=True, source=tmp_path / "none")
    cases = {
        "is the recording itself": (tmp_path / "link", tmp_path / "file"),
        "is a folder; name a file": (tmp_path / "folder", None),
        "is a device or a pipe": (Path(os.devnull), None),
        f"'{tmp_path / 'file'}' exists and is not a folder": (tmp_path / "file" / "a" / "b", None),
    }
    for said, (path, source) in cases.items():
        with pytest.raises(UsageError, match=said):
            require_free(path, overwrite=True, source=source)


@pytest.mark.parametrize("name", ["/etc/a", "../a", "a/../../b", "a\nb"])
def test_names_that_lead_out_of_a_folder_are_refused(tmp_path, name):
    with pytest.raises(UsageError, match="is not a valid file name in"):
        free_paths(tmp_path, ["good", name])
    assert free_paths(tmp_path, ["good", "in/too"]) == [tmp_path / "good", tmp_path / "in" / "too"]
