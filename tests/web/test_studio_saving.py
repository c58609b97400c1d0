"""A save is whole or not done, whatever happens meanwhile; pages are told what changes on disk."""

import os
import stat
import sys
import tempfile
import textwrap
import threading
import time
from pathlib import Path

import cv2
import numpy as np
import pytest
from websockets.exceptions import ConnectionClosed

from mjsim.closing import join
from mjsim.output.atomic import LEFT_BEHIND, write_new, write_whole
from mjsim.web.server.answers import RefusedError
from mjsim.web.worlds.folder import Folder
from mjsim.web.worlds.world_files import read_world, save_world
from tests.asking import ROOM, told
from tests.browser import browser
from tests.children import completed
from tests.strangers import as_stranger

pytestmark = pytest.mark.slow  # Each starts a server.

PATIENCE = 60.0
"""No answer takes this long [s], on however loaded a machine."""
TAB = "/api/tab?tab=" + "1" * 16


def save(client, text, *, path="room.yaml", status=200, stamp=None):
    stamp = stamp or told(client, "open", path="room.yaml")["stamp"]
    return told(client, "save", status=status, path=path, text=text, stamp=stamp)


def run(code, *arguments, **options):
    return completed([sys.executable, "-c", textwrap.dedent(code), *arguments], check=False, **options)


def names(folder):
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.parametrize("mode", [0o600, 0o644, 0o664, 0o755])
def test_a_save_keeps_the_mode_and_the_owner_of_the_file(client, folder, mode):
    place = folder / "room.yaml"
    place.chmod(mode)
    if os.geteuid() == 0:
        os.chown(place, 1234, 2345)
    before = place.stat()
    save(client, ROOM + "# new\n")
    after = place.stat()
    assert place.read_text() == ROOM + "# new\n"
    assert stat.S_IMODE(after.st_mode) == mode
    assert (after.st_uid, after.st_gid) == (before.st_uid, before.st_gid)


def test_a_link_stays_a_link_and_its_target_is_written(client, folder):
    (folder / "deep").mkdir()
    (folder / "room.yaml").rename(folder / "deep" / "hall.yaml")
    (folder / "room.yaml").symlink_to("deep/hall.yaml")
    save(client, ROOM + "# new\n")
    assert (folder / "room.yaml").is_symlink()
    assert (folder / "deep" / "hall.yaml").read_text() == ROOM + "# new\n"
    assert names(folder / "deep") == ["hall.yaml"]


KILLED = """
    import os, signal, sys
    from pathlib import Path
    from mjsim.output import write_whole

    # The process dies once the new text is written, and before it is in its place.
    os.fsync = lambda file: os.kill(os.getpid(), signal.SIGKILL)
    write_whole(Path(sys.argv[1]), b"lost")
"""


def test_a_writer_that_is_killed_leaves_the_old_text_and_what_it_left_is_removed_later(client, folder):
    assert run(KILLED, folder / "room.yaml").returncode == -9
    assert (folder / "room.yaml").read_text() == ROOM
    (left,) = set(names(folder)) - {"room.yaml"}
    assert client.get("/api/folder").json()["worlds"] == ["room.yaml"]
    save(client, ROOM + "# while another may still be writing\n")
    assert left in names(folder)
    old = time.time() - LEFT_BEHIND - 1
    os.utime(folder / left, (old, old))
    save(client, ROOM + "# new\n")
    assert names(folder) == ["room.yaml"]


def refusals(folder):
    """Return what is said to who saves a world in place, and one that is new."""
    folder = Folder(folder)
    stamp, said = read_world(folder, "room.yaml")[1], []
    for path, before in (("room.yaml", stamp), ("new.yaml", None)):
        try:
            save_world(folder, path, text="lost", stamp=before, overwrite=False)
        except RefusedError as refused:
            said.append(f"{refused.status} {refused.message}")
    return said


@pytest.fixture
def shared():
    """A folder that other users may enter, which those of pytest are not."""
    with tempfile.TemporaryDirectory() as name:
        place = Path(name)
        (place / "room.yaml").write_text(ROOM)
        yield place
        place.chmod(0o700)


@pytest.mark.slow
def test_where_nobody_may_write_a_save_is_refused_in_a_line(shared):
    folder = shared
    (folder / "room.yaml").chmod(0o666)
    folder.chmod(0o555)
    in_place = "cannot be written: Permission denied; choose another place"
    said = as_stranger(lambda: refusals(folder), other=os.geteuid() == 0)
    assert said == [f"409 '{name}.yaml' {in_place}" for name in ("room", "new")]
    folder.chmod(0o777)
    (folder / "room.yaml").chmod(0o444)
    first, *_ = as_stranger(lambda: refusals(folder), other=os.geteuid() == 0)
    assert first == "409 'room.yaml' cannot be written: the file is write-protected; choose another place"
    assert (folder / "room.yaml").read_text() == ROOM


FULL = """
    import os, sys
    from pathlib import Path
    from mjsim.web.server.answers import RefusedError
    from mjsim.web.worlds.world_files import save_world, stamp_of
    from mjsim.web.worlds.folder import Folder

    place = Path(sys.argv[1])
    (place / "room.yaml").write_text("mjsim: 1")
    try:
        (place / "rest").write_bytes(bytes(1_000_000))
    except OSError:
        pass
    try:
        save_world(
            Folder(place), "room.yaml", text="#" * 50_000, stamp=stamp_of(place / "room.yaml"), overwrite=False
        )
    except RefusedError as refused:
        print(refused.message)
    print((place / "room.yaml").read_text(), sorted(os.listdir(place)))
"""


@pytest.mark.slow
def test_on_a_full_disk_a_save_is_refused_in_a_line_and_the_old_text_stays(tmp_path):
    """A small disk of its own is mounted for it, in a namespace that nobody else sees."""
    mount = 'mount -t tmpfs -o size=128k none "$1" && exec "$2" -c "$3" "$1"'
    command = ["unshare", "--map-root-user", "--mount", "sh", "-c", mount, "sh"]
    done = completed([*command, tmp_path, sys.executable, textwrap.dedent(FULL)], check=False)
    if "unshare" in done.stderr or "mount" in done.stderr:
        pytest.skip("no disk can be mounted here: " + done.stderr.strip())
    assert done.stdout.splitlines() == [
        "'room.yaml' cannot be written: No space left on device; choose another place",
        "mjsim: 1 ['rest', 'room.yaml']",
    ]


@pytest.mark.slow
def test_of_pages_that_save_at_once_one_is_first_and_all_others_are_told(client, folder):
    stamp = told(client, "open", path="room.yaml")["stamp"]
    for path, before in (("room.yaml", stamp), ("new.yaml", None)):
        statuses = {}

        def write(number, path=path, before=before, statuses=statuses):
            asked = {"path": path, "text": f"{ROOM}# {number}\n", "stamp": before}
            statuses[number] = client.post("/api/save", json=asked).status_code

        threads = [threading.Thread(target=write, args=[number]) for number in range(8)]
        for thread in threads:
            thread.start()
        for thread in threads:
            join(thread)
        (first,) = [number for number, status in statuses.items() if status == 200]
        assert set(statuses.values()) == {200, 409}
        assert (folder / path).read_text() == f"{ROOM}# {first}\n"


def test_a_new_file_never_replaces_one_that_came_meanwhile(tmp_path):
    write_new(tmp_path / "room.yaml", b"first")
    with pytest.raises(FileExistsError):
        write_new(tmp_path / "room.yaml", b"second")
    write_whole(tmp_path / "room.yaml", b"third")
    assert (tmp_path / "room.yaml").read_bytes() == b"third"
    assert names(tmp_path) == ["room.yaml"]


def test_names_that_no_file_system_takes_are_refused(client):
    for name in ("a" * 256 + ".yaml", "é" * 128 + ".yaml", f"{'b' * 300}/room.yaml"):
        for address, more in (("open", {}), ("save", {"text": ROOM}), ("new", {}), ("parse", {"text": ROOM})):
            error = told(client, address, status=400, path=name, **more)["error"]
            assert error.endswith("has a name of more than 255 bytes; shorten it")
    error = told(client, "open", status=400, path="a/" * 3000 + "room.yaml")["error"]
    assert error == f"path '{'a/' * 30}' is not a file name; write for example 'worlds/room.yaml'"
    longest = "é" * 125 + ".yaml"
    told(client, "save", path=longest, text=ROOM)
    assert told(client, "open", path=longest)["text"] == ROOM


def test_no_file_behind_a_link_is_named_by_did_you_mean(client, folder):
    secret = folder.parent / "secret"
    secret.mkdir()
    (secret / "lion.jpg").write_bytes(b"")
    (folder / "away").symlink_to(secret)
    (folder / "lions.jpg").symlink_to(secret / "lion.jpg")
    (folder / "tiger.jpg").write_bytes(b"")
    for name, said in (("away/lions.jpg", ""), ("lionz.jpg", ""), ("tigers.jpg", "; did you mean 'tiger.jpg'?")):
        text = f"{ROOM}beacons: [{{name: a, image: {name}, at: [1, 1]}}]\n"
        (problem,) = told(client, "parse", path="room.yaml", text=text)["problems"]
        assert problem["message"].endswith(f"no file '{name}' beside the world file or in assets{said}")


def show(page, opened):
    page.say("show", path=opened["path"], stamp=opened["stamp"], files=opened["files"])


@pytest.mark.slow
def test_a_page_is_told_when_its_file_changes_goes_and_comes_back(studio, client, folder):
    with browser(studio.url, TAB) as page:
        opened = told(client, "open", path="room.yaml")
        show(page, opened)
        (folder / "room.yaml").write_text(ROOM + "# theirs\n")
        theirs = page.until("disk")
        assert theirs == {
            "kind": "disk",
            "path": "room.yaml",
            "stamp": told(client, "open", path="room.yaml")["stamp"],
        }
        mine = save(client, ROOM + "# mine\n")["stamp"]
        assert page.until("disk")["stamp"] == mine != theirs["stamp"]
        (folder / "room.yaml").unlink()
        assert page.until("disk")["stamp"] is None
        (folder / "room.yaml").write_text(ROOM)
        assert page.until("disk")["stamp"] == opened["stamp"]


def test_a_change_that_leaves_size_and_time_as_they_were_is_seen_too(studio, client, folder):
    place = folder / "room.yaml"
    with browser(studio.url, TAB) as page:
        show(page, told(client, "open", path="room.yaml"))
        before = place.stat()
        place.write_text(ROOM.replace("room", "hall"))
        os.utime(place, ns=(before.st_atime_ns, before.st_mtime_ns))
        page.until("disk")


def test_a_file_that_is_only_touched_is_no_news(studio, client, folder):
    with browser(studio.url, TAB) as page:
        show(page, told(client, "open", path="room.yaml"))
        os.utime(folder / "room.yaml", (1, 1))
        (folder / "room.yaml").write_text(ROOM)
        told(client, "draft/keep", tab="2" * 16, number=1, path="x.yaml", fresh=True, stamp=None, text="#")
        while not page.until("drafts")["drafts"]:
            pass
        assert "disk" not in page.news


NAMING = """\
mjsim: 1
include: [deep/hall.yaml]
beacons: [{name: a, image: lion.png, at: [1, 1]}]
robots: [{name: scout, preset: pioneer3dx, at: [1, 1]}]
run: {drivers: {scout: {navigator: {use: "still.py:Still"}}}}
"""


def png(value):
    return cv2.imencode(".png", np.full((40, 30, 3), value, np.uint8))[1].tobytes()


@pytest.mark.slow
def test_a_page_is_told_when_files_change_that_its_world_names_or_that_they_name(studio, client, folder):
    (folder / "deep").mkdir()
    hall, near = folder / "deep" / "hall.yaml", folder / "deep" / "near.png"
    hall.write_text("mjsim: 1\nbeacons: [{name: b, image: near.png, at: [2, 1]}]\n")
    near.write_bytes(png(1))
    (folder / "room.yaml").write_text(NAMING)
    opened = told(client, "open", path="room.yaml")
    assert opened["items"] is not None
    assert {"deep/hall.yaml", "deep/near.png", "lion.png", "still.py"} <= set(opened["files"])
    with browser(studio.url, TAB) as page:
        show(page, opened)
        for name, change in {
            "lion.png": lambda: (folder / "lion.png").write_bytes(png(2)),  # which was missing
            "deep/near.png": lambda: near.write_bytes(png(3)),
            "deep/hall.yaml": lambda: hall.write_text("mjsim: 1\n"),
            "still.py": lambda: (folder / "still.py").write_text("class Still: ...\n"),
        }.items():
            change()
            assert page.until("files")["files"] == [name]
        (folder / "lion.png").unlink()
        assert page.until("files")["files"] == ["lion.png"]


@pytest.mark.parametrize(
    "shown",
    [
        {"path": "../room.yaml", "stamp": None, "files": {}},
        {"path": "room.yaml", "stamp": None, "files": {f"{number}.png": "" for number in range(1001)}},
        {"path": "room.yaml", "stamp": None, "files": {"a" * 500: ""}},
        {"path": "room.yaml"},
    ],
)
def test_what_is_no_word_of_the_page_ends_its_connection(studio, shown):
    with browser(studio.url, TAB) as page:
        page.say("show", **shown)
        with pytest.raises(ConnectionClosed):
            page.until("the end")


@pytest.mark.slow
def test_files_outside_of_the_folder_are_not_watched(studio, client, folder):
    secret = folder.parent / "secret.yaml"
    secret.write_text("1")
    with browser(studio.url, TAB) as page:
        opened = told(client, "open", path="room.yaml")
        show(page, {**opened, "files": {"../secret.yaml": "", str(secret): "", "seen.yaml": ""}})
        secret.write_text("2")
        (folder / "seen.yaml").write_text("1")
        assert page.until("files")["files"] == ["seen.yaml"]


@pytest.mark.slow
def test_the_camera_sees_a_picture_that_was_changed_on_disk(client, folder):
    (folder / "lion.png").write_bytes(png(0))
    text = (
        "mjsim: 1\nbeacons: [{name: a, image: lion.png, at: [2, 0], heading_deg: 180, center: 0.3, width: 2}]\n"
        "robots: [{name: scout, preset: pioneer3dx, at: [0, 0], sensors: [{camera: front, width: 64, height: 48}]}]\n"
    )
    asked = {"path": "room.yaml", "text": text, "robot": "scout", "camera": "front", "at": [0, 0]}

    def middle():
        data = client.post("/api/preview", json=asked).content
        return cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)[115:125, 155:165].mean()

    dark = middle()
    (folder / "lion.png").write_bytes(png(255))
    assert middle() > dark + 80
