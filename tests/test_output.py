"""No file that exists is lost without a word, and none is there in half: the one rule for all that mjsim writes."""

import os
import stat
import sys
import threading
from hashlib import sha256
from pathlib import Path

import pytest

from mjsim.closing import join
from mjsim.errors import UsageError
from mjsim.output import (
    LIST,
    NewFile,
    free_path,
    new_file,
    next_free,
    require_free,
    temporary_file,
    write_files,
    write_set,
)
from tests.children import child

HELD = """
import sys, time
from mjsim.output import NewFile
file = NewFile(sys.argv[1], overwrite=True)
if sys.argv[2] == "published":
    file.publish()
print("held", flush=True)
time.sleep(60)
"""


def write(path: Path, text: str, *, overwrite: bool = False) -> None:
    with new_file(path, overwrite=overwrite) as part:
        part.write_text(text)


def fill(file: NewFile, data: bytes) -> None:
    with file.opened() as part:
        part.write(data)
    file.publish()


def contents(folder: Path) -> dict[str, str]:
    return {str(file.relative_to(folder)): file.read_text() for file in folder.rglob("*") if file.is_file()}


def test_a_file_that_exists_is_refused_in_one_line_that_says_overwrite(tmp_path: Path):
    write(tmp_path / "a", "old")
    with pytest.raises(UsageError) as refused:
        write(tmp_path / "a", "new")
    assert str(refused.value) == (
        f"'{tmp_path / 'a'}' exists; name another file, or add --overwrite (in Python: overwrite=True)"
    )
    assert contents(tmp_path) == {"a": "old"}
    write(tmp_path / "a", "new", overwrite=True)
    assert contents(tmp_path) == {"a": "new"}


def test_what_fails_leaves_the_old_file_and_no_trace_even_of_folders(tmp_path: Path):
    write(tmp_path / "a", "old")

    def fail(path: Path) -> None:
        with new_file(path, overwrite=True) as part:
            part.write_text("half")
            raise ZeroDivisionError

    for path in (tmp_path / "a", tmp_path / "deep" / "deeper" / "b"):
        with pytest.raises(ZeroDivisionError):
            fail(path)
    assert contents(tmp_path) == {"a": "old"}
    assert [file.name for file in tmp_path.iterdir()] == ["a"]


def test_a_file_that_appears_while_another_is_written_is_not_lost(tmp_path: Path):
    with NewFile(tmp_path / "a") as file:
        (tmp_path / "a").write_text("from elsewhere")
        with pytest.raises(UsageError, match="exists; name another file, or add --overwrite"):
            file.publish()
    assert contents(tmp_path) == {"a": "from elsewhere"}


def test_of_many_writers_at_once_one_wins_and_the_others_are_told(tmp_path: Path):
    barrier, told = threading.Barrier(20), []

    def work(number: int) -> None:
        barrier.wait(60.0)
        try:
            write(tmp_path / "a", str(number))
        except UsageError as error:
            told.append(str(error))

    threads = [threading.Thread(target=work, args=(number,)) for number in range(20)]
    for thread in threads:
        thread.start()
    for thread in threads:
        join(thread)
    assert len(told) == 19
    assert all("exists; " in line or "is being written; " in line for line in told)
    assert list(contents(tmp_path)) == ["a"]


@pytest.mark.parametrize("state", ["begun", "published"])
def test_a_file_that_another_process_writes_is_refused_even_to_overwrite_until_that_is_killed(
    tmp_path: Path, state: str
):
    path = tmp_path / "a"
    path.write_text("old")
    with child([sys.executable, "-c", HELD, path, state]) as process:
        assert process.line() == "held\n"
        with pytest.raises(UsageError, match=r"'.*a' is being written; wait for that to end, or name another file"):
            write(path, "new", overwrite=True)
    write(path, "new", overwrite=True)
    assert contents(tmp_path) == {"a": "new"}


def test_numbered_names_pass_over_what_exists_and_what_is_being_written(tmp_path: Path):
    path = tmp_path / "run.mcap"
    with next_free(path) as first, next_free(path) as second:
        assert (first.path, second.path) == (path, tmp_path / "run-2.mcap")
        first.publish()
        second.publish()
    assert free_path(path) == tmp_path / "run-3.mcap"
    with next_free(path) as third:
        assert third.path == tmp_path / "run-3.mcap"
    assert free_path(path) == tmp_path / "run-3.mcap"


def test_only_regular_files_are_replaced(tmp_path: Path):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(UsageError, match="'/dev/null' is a device or a pipe; name a file"):
        require_free(Path("/dev/null"), overwrite=True)
    with pytest.raises(UsageError, match="is a device or a pipe"):
        write(tmp_path / "pipe", "new", overwrite=True)
    with pytest.raises(UsageError, match="is a folder; name a file"):
        write(tmp_path, "new", overwrite=True)


def test_a_link_leads_to_the_file_that_is_refused_or_replaced(tmp_path: Path):
    (tmp_path / "real").write_text("old")
    (tmp_path / "link").symlink_to("real")
    with pytest.raises(UsageError, match="exists"):
        write(tmp_path / "link", "new")
    write(tmp_path / "link", "new", overwrite=True)
    assert (tmp_path / "link").is_symlink()
    assert contents(tmp_path) == {"real": "new", "link": "new"}


def test_a_link_in_place_of_the_part_is_not_followed(tmp_path: Path):
    (tmp_path / "victim").write_text("precious")
    (tmp_path / ".a.part").symlink_to("victim")
    with pytest.raises(UsageError, match=r"cannot write '.*a': "):
        write(tmp_path / "a", "new")
    assert (tmp_path / "victim").read_text() == "precious"


def test_a_replaced_file_keeps_its_permissions_and_a_new_one_follows_the_umask(tmp_path: Path):
    (tmp_path / "old").write_text("old")
    (tmp_path / "old").chmod(0o640)
    write(tmp_path / "old", "new", overwrite=True)
    before = os.umask(0o027)
    try:
        write(tmp_path / "new", "new")
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "old").stat().st_mode) == 0o640
    assert stat.S_IMODE((tmp_path / "new").stat().st_mode) == 0o640


def test_of_several_files_none_is_written_when_one_exists_and_others_in_the_folder_stay(tmp_path: Path):
    (tmp_path / "notes.txt").write_text("mine")
    (tmp_path / "b").write_text("old")
    files = {"a": b"1", "b": b"2", "in/c": b"3"}
    with pytest.raises(UsageError, match=r"'.*b' exists"):
        write_files(tmp_path, files)
    assert contents(tmp_path) == {"notes.txt": "mine", "b": "old"}
    write_files(tmp_path, files, overwrite=True)
    assert contents(tmp_path) == {"notes.txt": "mine", "a": "1", "b": "2", "in/c": "3"}


def test_a_folder_that_cannot_be_written_is_one_line(tmp_path: Path):
    (tmp_path / "file").write_text("")
    with pytest.raises(UsageError, match=r"'.*file' exists and is not a folder; name another one"):
        write(tmp_path / "file" / "a", "new")


def test_a_set_of_files_replaces_the_previous_set_and_keeps_files_of_the_user(tmp_path: Path):
    write_set(tmp_path, {"a.png": b"1", "b.png": b"2", "c.png": b"3", "d.png": b"4"}, of="report")
    write_set(tmp_path, {"x.png": b"5"}, of="comparison")
    (tmp_path / "b.png").write_text("a person's own")
    (tmp_path / "c.png").unlink()
    (tmp_path / "c.png").symlink_to(tmp_path / "e.png")
    (tmp_path / "e.png").write_bytes(b"3")
    with pytest.raises(UsageError, match="exists"):
        write_set(tmp_path, {"a.png": b"6"}, of="report")
    write_set(tmp_path, {"a.png": b"6"}, of="report", overwrite=True)
    assert sorted(path.name for path in tmp_path.iterdir()) == [LIST, "a.png", "b.png", "c.png", "e.png", "x.png"]


@pytest.mark.parametrize("listed", ["", "[]", '{"report": 3}', "[" * 100_000, '{"report": {"../out": "DIGEST"}}'])
def test_a_list_that_is_not_ours_removes_nothing(tmp_path: Path, listed: str):
    (tmp_path / "out").write_bytes(b"1")
    place = tmp_path / "folder"
    place.mkdir()
    (place / LIST).write_text(listed.replace("DIGEST", sha256(b"1").hexdigest()))
    write_set(place, {"a": b"2"}, of="report")
    assert (tmp_path / "out").exists()


def test_a_file_without_a_place_leaves_no_folder_when_it_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))

    def fail() -> None:
        with temporary_file("a") as path:
            path.write_text("half")
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()
    assert list(tmp_path.iterdir()) == []
    with temporary_file("a") as path:
        path.write_text("whole")
    assert contents(tmp_path) == {f"{path.parent.name}/a": "whole"}


@pytest.mark.parametrize("end", ["published", "given up"])
@pytest.mark.parametrize("overwrite", [True, False])
def test_a_part_whose_writer_ends_between_its_opening_and_its_lock_is_not_taken(tmp_path, monkeypatch, end, overwrite):
    path, opened = tmp_path / "run.mcap", os.open
    first = NewFile(path)

    def opening(place, *flags, **more):
        descriptor = opened(place, *flags, **more)
        if Path(place) == first.part and not first._closed:
            if end == "published":
                fill(first, b"first")
            first.close()
        return descriptor

    monkeypatch.setattr(os, "open", opening)
    if end == "published" and not overwrite:
        with pytest.raises(UsageError, match="exists"):
            NewFile(path)
        assert contents(tmp_path) == {"run.mcap": "first"}
        return
    second = NewFile(path, overwrite=overwrite)
    assert second.part.samefile(f"/proc/self/fd/{second.fileno()}"), "the file that it has locked"
    with pytest.raises(UsageError, match="is being written"):
        NewFile(path, overwrite=True)
    fill(second, b"second")
    second.close()
    assert contents(tmp_path) == {"run.mcap": "second"}


def test_a_file_that_is_replaced_between_its_opening_and_its_lock_is_looked_at_again(tmp_path, monkeypatch):
    path, opened, moved = tmp_path / "run.mcap", os.open, []
    path.write_text("old")

    def opening(place, *flags, **more):
        descriptor = opened(place, *flags, **more)
        if Path(place) == path and not moved:
            moved.append(path.rename(tmp_path / "moved"))
            path.write_text("newer")
            path.chmod(0o640)
        return descriptor

    monkeypatch.setattr(os, "open", opening)
    with NewFile(path, overwrite=True) as file:
        fill(file, b"newest")
    assert contents(tmp_path) == {"moved": "old", "run.mcap": "newest"}
    assert stat.S_IMODE(path.stat().st_mode) == 0o640
