"""Keeps unsaved texts of worlds on disk, so that they survive a crash of the page, the server or the machine."""

import contextlib
import hashlib
import json
import os
import re
import stat
import threading
import time
from collections import OrderedDict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from mjsim.output import LEFT_BEHIND, is_locked, remove_leftovers, replace_file, try_lock
from mjsim.sentences import Sentence
from mjsim.web.server import RefusedError
from mjsim.web.worlds.folder import Folder
from mjsim.web.worlds.items import Json
from mjsim.web.worlds.shipped_parts import SHIPPED
from mjsim.world import MAX_BYTES, too_large

TAB = re.compile(r"[0-9a-f]{16}")
"""Id of a browser tab: random, and new each time its page is loaded."""
ID = re.compile(r"[0-9a-f]{24}-[0-9a-f]{16}")
"""Id of a draft: a hash of the world's path, and the tab."""
MAX_DRAFTS, MAX_TOTAL, MAX_AGE = 50, 100_000_000, 90 * 86_400.0
"""Limits on kept drafts: number, total size [bytes], and age [s]."""
_OPEN = ".open"
"""Suffix of a file that is locked while a page is open."""
_MAX_HEAD_BYTES = 32_768
"""Maximum length of a file's first line [bytes]; the text follows it."""
_MAX_TABS = 1000
"""Number of tabs whose latest request number is remembered."""


def drafts_folder() -> Path:
    """Return the folder of a user's drafts, in the state folder of the XDG Base Directory Specification.

    Raises:
        RefusedError: The user has no home folder.
    """
    base = Path(os.environ.get("XDG_STATE_HOME") or "")
    try:
        return (base if base.is_absolute() else Path.home() / ".local" / "state") / "mjsim" / "drafts"
    except RuntimeError as error:
        raise _unkept(str(error)) from None


@dataclass(frozen=True, slots=True, kw_only=True)
class Draft:
    """An unsaved text of a world, its tab, and the version that it is based on."""

    tab: str
    folder: str
    """Folder of the studio."""
    path: str
    """Path of the world on the page of that studio."""
    file: str
    """Absolute path of the world."""
    fresh: bool
    """Whether it was never saved; its path is then only a proposal."""
    stamp: str | None
    """Stamp of the content that the text is based on."""
    when: float
    """Time of the last change [s since 1970]."""

    @property
    def id(self) -> str:
        """Return the name of its file, made from its world and tab."""
        owner = self.file if not self.fresh and not self.path.startswith(SHIPPED) else f"{self.folder}\n{self.path}"
        return f"{hashlib.sha256(owner.encode('utf-8', 'surrogateescape')).hexdigest()[:24]}-{self.tab}"

    def path_in(self, folder: Folder) -> str | None:
        """Return its path on the page of a studio; None if it belongs to another folder."""
        if self.fresh or self.path.startswith(SHIPPED):
            return self.path if self.folder == str(folder.root) else None
        return folder.name(Path(self.file)) if Path(self.file).is_relative_to(folder.root) else None


class Drafts:
    """The drafts of a user, for the studio of one folder. Several studios may run at once."""

    def __init__(self, folder: Folder) -> None:
        """Use the folder of the studio."""
        self._folder = folder
        self._lock = threading.Lock()
        self._numbers: OrderedDict[str, int] = OrderedDict()
        self._held: dict[str, tuple[int | None, int]] = {}
        self._known: dict[str, tuple[tuple[int, int], Draft | None]] = {}

    def keep(
        self,
        tab: str,
        number: int,
        *,
        path: str,
        fresh: bool,
        stamp: str | None,
        text: str,
        past: Json,
        restored: str | None = None,
    ) -> None:
        """Replace the kept text of a tab.

        Args:
            tab: Tab that contains the text.
            number: Number of the request; a request older than the latest is ignored.
            path: Path of the world on the page.
            fresh: Whether it was never saved.
            stamp: Stamp of the content that the text is based on.
            text: Current text.
            past: Its undo history.
            restored: Id of the draft of a closed tab that this one continues; that draft is removed at the same time.

        Raises:
            RefusedError: It is too large, or cannot be written.
        """
        data = text.encode("utf-8", "surrogatepass")
        if len(data) > MAX_BYTES:
            raise RefusedError(413, Sentence("unsaved changes cannot be kept: {reason}", too_large(len(data))))
        steps = json.dumps(past).encode()
        file = path if path.startswith(SHIPPED) else str(self._folder.path(path))
        root = str(self._folder.root)
        draft = Draft(tab=tab, folder=root, path=path, file=file, fresh=fresh, stamp=stamp, when=time.time())
        head = json.dumps({name: getattr(draft, name) for name in Draft.__slots__}).encode()
        with self._in_order(tab, number) as newest, self._writing() as place:
            if newest:
                replace_file(place / draft.id, b"\n".join((head, steps, data)), mode=0o600)
                self._remove(place.glob(f"*-{tab}"), but=draft.id)
                if restored is not None and not self._is_open(restored.partition("-")[2]):
                    self._remove([self._place(restored)], but=draft.id)
                self._prune(place)

    def forget(self, tab: str, number: int) -> None:
        """Remove the draft of a tab: its text is saved, or no longer wanted."""
        with self._in_order(tab, number) as newest:
            if newest:
                self._remove(drafts_folder().glob(f"*-{tab}"))

    def listed(self) -> list[Json]:
        """Return the drafts of the folder, newest first: id, tab, path, fresh, when, and open (in some page)."""
        with contextlib.suppress(OSError, RefusedError):
            drafts = sorted(self._all(drafts_folder()), key=lambda draft: -draft.when)
            paths = ((draft, draft.path_in(self._folder)) for draft in drafts)
            return [self._draft_json(draft, path) for draft, path in paths if path is not None]
        return []

    def read(self, name: str) -> Json:
        """Return a draft with text, `past`, `stamp`, and `there`: whether the version that it is based on still exists.

        Raises:
            RefusedError: There is no draft with this id in the folder.
        """
        place = self._place(name)
        draft, path = self._draft_of(place), None
        if draft is not None and (path := draft.path_in(self._folder)) is not None:
            with contextlib.suppress(OSError, ValueError):
                _, past, data = place.read_bytes().split(b"\n", 2)
                text = data.decode("utf-8", "surrogatepass")
                exists = path.startswith(SHIPPED) or Path(draft.file).is_file()
                more = {"stamp": draft.stamp, "text": text, "past": json.loads(past)}
                return {**self._draft_json(draft, path), **more, "there": exists and not draft.fresh}
        raise RefusedError(404, "these unsaved changes are no longer there; they were restored or discarded elsewhere")

    def drop(self, name: str) -> None:
        """Remove a draft that no page has open.

        Raises:
            RefusedError: There is no draft with this id in the folder, or a page has it open.
        """
        if self.read(name)["open"]:
            raise RefusedError(409, "these changes are open in another tab; discard them there")
        self._remove([self._place(name)])

    def hold(self, tab: str) -> None:
        """Mark a tab as open until `release`, also for other studios; call both from the same thread."""
        file, count = self._held.get(tab, (None, 0))
        if count == 0:
            # Without file locks, as on some network file systems, a draft is offered even if it is open.
            with contextlib.suppress(OSError, RefusedError), self._writing() as place:
                file = os.open(place / f"{tab}{_OPEN}", os.O_RDWR | os.O_CREAT, 0o600)
                try_lock(file)
        self._held[tab] = file, count + 1

    def release(self, tab: str) -> None:
        """Mark a tab as closed; call from the thread of `hold`."""
        file, count = self._held.pop(tab, (None, 0))
        if count > 1:
            self._held[tab] = file, count - 1
        elif file is not None:
            self._remove([drafts_folder() / f"{tab}{_OPEN}"])
            os.close(file)

    def _draft_json(self, draft: Draft, path: str) -> Json:
        known = {"id": draft.id, "tab": draft.tab, "path": path, "fresh": draft.fresh, "when": draft.when}
        return {**known, "open": self._is_open(draft.tab)}

    def _is_open(self, tab: str) -> bool:
        return tab in self._held or is_locked(drafts_folder() / f"{tab}{_OPEN}")

    def _place(self, name: str) -> Path:
        if not ID.fullmatch(name):
            raise RefusedError(400, Sentence("'{name:.60}' is not the id of a draft; see the list", name))
        return drafts_folder() / name

    def _all(self, place: Path) -> Iterator[Draft]:
        """Yield all drafts of the user; headers of unchanged files are not read again."""
        for entry in os.scandir(place):
            if ID.fullmatch(entry.name) and (draft := self._draft_of(place / entry.name)) is not None:
                yield draft

    def _draft_of(self, place: Path) -> Draft | None:
        """Return the header of a draft; None if the file is not a draft."""
        try:
            found = place.stat()
            stamp = found.st_ino, found.st_mtime_ns
            held = self._known.get(place.name)
            if held is None or held[0] != stamp:
                held = self._known[place.name] = stamp, _read_head(place)
            return held[1]
        except OSError:
            self._known.pop(place.name, None)
            return None

    @contextlib.contextmanager
    def _in_order(self, tab: str, number: int) -> Iterator[bool]:
        """Yield whether a request of a tab is newer than all before; requests arrive over several connections."""
        if not TAB.fullmatch(tab):
            raise RefusedError(400, Sentence("'{tab:.60}' is not the name of a tab; it has 16 digits, 0 to f", tab))
        with self._lock:
            newest = number > self._numbers.get(tab, -1)
            if newest:
                self._numbers[tab] = number
                self._numbers.move_to_end(tab)
            while len(self._numbers) > _MAX_TABS:
                self._numbers.popitem(last=False)
            yield newest

    @contextlib.contextmanager
    def _writing(self) -> Iterator[Path]:
        """Yield the folder of the drafts, which exists and is private; write errors raise RefusedError."""
        try:
            place = drafts_folder()
            place.parent.parent.mkdir(parents=True, exist_ok=True)
            for folder in (place.parent, place):
                _make_private(folder)
            yield place
        except OSError as error:
            raise _unkept(error.strerror or str(error)) from None

    def _remove(self, places: Iterable[Path], *, but: str = "") -> None:
        for place in places:
            if place.name != but:
                with contextlib.suppress(OSError):
                    place.unlink(missing_ok=True)

    def _prune(self, place: Path) -> None:
        """Remove the oldest drafts beyond the limits, starting with those that no page has open."""
        remove_leftovers(place)
        closed = (path for path in place.glob(f"*{_OPEN}") if not is_locked(path) and _age(path) > LEFT_BEHIND)
        self._remove(closed)
        order = sorted(
            self._all(place), key=lambda draft: (self._draft_json(draft, "")["open"], draft.when), reverse=True
        )
        size = 0
        for count, draft in enumerate(order):
            size += (place / draft.id).stat().st_size
            if count >= MAX_DRAFTS or size > MAX_TOTAL or draft.when < time.time() - MAX_AGE:
                self._remove([place / draft.id])


def _make_private(folder: Path) -> None:
    """Create a folder that only its owner may access.

    Raises:
        OSError: It cannot be created, or belongs to another user.
    """
    folder.mkdir(mode=0o700, exist_ok=True)
    found = folder.lstat()
    if not stat.S_ISDIR(found.st_mode) or (hasattr(os, "geteuid") and found.st_uid != os.geteuid()):
        raise PermissionError(13, Sentence("'{folder}' is not a folder of your own", folder))
    if stat.S_IMODE(found.st_mode) != 0o700:
        folder.chmod(0o700)


def _read_head(place: Path) -> Draft | None:
    with place.open("rb") as file:
        line = file.readline(_MAX_HEAD_BYTES)
    try:
        draft = Draft(**json.loads(line))
    except (ValueError, TypeError):
        return None
    return draft if draft.id == place.name else None


def _age(place: Path) -> float:
    try:
        return time.time() - place.stat().st_mtime
    except OSError:
        return 0.0


def _unkept(reason: str) -> RefusedError:
    return RefusedError(409, Sentence("unsaved changes cannot be kept: {reason}; save often", reason))
