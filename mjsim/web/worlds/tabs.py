"""Browser tabs that show the studio: keeps their unsaved texts, and informs them of changes by others."""

import asyncio
import contextlib
import threading
from collections.abc import Sequence
from typing import Annotated, Literal

from pydantic import Field, ValidationError, model_validator
from starlette.requests import Request
from starlette.routing import BaseRoute, Route, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect

from mjsim.errors import MjsimError
from mjsim.sentences import Sentence
from mjsim.web.server import Ask, RefusedError, answer_get, posted
from mjsim.web.worlds.drafts import ID, TAB, Drafts
from mjsim.web.worlds.folder import MAX_PATH_LENGTH, Folder
from mjsim.web.worlds.items import Json
from mjsim.web.worlds.shipped_parts import SHIPPED
from mjsim.web.worlds.watch import MAX_FILES, DiskWatch
from mjsim.web.worlds.world_files import read_world

POLL_SECONDS = 0.5
"""Interval between checks of the disk while a page is open [s]."""

MAX_STEPS, MAX_LETTERS = 1000, 400_000
"""Limits of the history kept beside a draft: steps, and characters of all steps together."""
Name = Annotated[str, Field(max_length=MAX_PATH_LENGTH)]


class StepAsk(Ask):
    """One step of a text's history: `fresh` replaced `old`."""

    begin: Annotated[int, Field(ge=0, alias="from")]
    old: Annotated[str, Field(max_length=MAX_LETTERS)]
    fresh: Annotated[str, Field(max_length=MAX_LETTERS)]
    what: Annotated[str, Field(max_length=100)] = "Change"
    """What the step did, for the list of undo steps."""


class PastAsk(Ask):
    """The undo history of a text: `at` steps lead to it, the others can be redone."""

    steps: Annotated[tuple[StepAsk, ...], Field(max_length=MAX_STEPS)] = ()
    at: Annotated[int, Field(ge=0)] = 0

    @model_validator(mode="after")
    def _within(self) -> "PastAsk":
        if self.at > len(self.steps):
            raise ValueError(
                Sentence("at is {at}; it must be at most {count}, the number of steps", self.at, len(self.steps))
            )
        if sum(len(step.old) + len(step.fresh) for step in self.steps) > MAX_LETTERS:
            raise ValueError(Sentence("the steps have more than {max_letters} characters", MAX_LETTERS))
        return self


class KeepAsk(Ask):
    """Keeps the text of a tab until it is saved."""

    tab: str
    number: Annotated[int, Field(ge=0)]
    path: Name
    fresh: bool
    stamp: str | None
    text: str
    past: PastAsk = PastAsk()
    restored: Annotated[str, Field(pattern=f"^{ID.pattern}$")] | None = None


class ForgetAsk(Ask):
    """A tab whose text is saved."""

    tab: str
    number: Annotated[int, Field(ge=0)]


class DraftAsk(Ask):
    """Identifies a draft."""

    id: str


class ShowAsk(Ask):
    """What a tab shows now."""

    do: Literal["show"]
    path: Name
    stamp: str | None
    files: Annotated[dict[Name, Annotated[str, Field(max_length=100)]], Field(max_length=MAX_FILES)]


class Tabs:
    """Keeps the drafts of all tabs, and informs each of news: on disk, and about the drafts of others."""

    def __init__(self, folder: Folder) -> None:
        """Use the folder of the studio."""
        self._folder, self._drafts = folder, Drafts(folder)
        self._pages: set[_Page] = set()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._closing = False
        self.routes: Sequence[BaseRoute] = [
            WebSocketRoute("/api/tab", self._serve),
            Route("/api/drafts", answer_get(self._list), methods=["GET"]),
            Route("/api/draft/keep", posted(KeepAsk, self._keep), methods=["POST"]),
            Route("/api/draft/forget", posted(ForgetAsk, self._forget), methods=["POST"]),
            Route("/api/draft/read", posted(DraftAsk, lambda ask: self._drafts.read(ask.id)), methods=["POST"]),
            Route("/api/draft/drop", posted(DraftAsk, self._drop), methods=["POST"]),
        ]

    def wake(self) -> None:
        """Check the disk now; from any thread."""
        if self._loop is not None:
            with contextlib.suppress(RuntimeError):  # the server has ended
                self._loop.call_soon_threadsafe(self._wake)

    def close(self) -> None:
        """Disconnect all pages; not from the server's thread."""
        self._closing = True
        self.wake()

    def _wake(self) -> None:
        for page in self._pages:
            page.due.set()

    async def _serve(self, socket: WebSocket) -> None:
        """Serve a tab while its page is open."""
        tab = socket.query_params.get("tab", "")
        if not TAB.fullmatch(tab):
            await socket.close(1008)
            return
        await socket.accept()
        self._loop = asyncio.get_running_loop()
        page = _Page(socket, tab, DiskWatch(self._folder))
        self._drafts.hold(tab)
        self._pages.add(page)
        self._wake()
        telling = asyncio.create_task(self._notify(page))
        try:
            while (message := await socket.receive())["type"] != "websocket.disconnect":
                await self._take(page, message.get("text") or "")
        finally:
            self._pages.discard(page)
            self._drafts.release(tab)
            self._wake()
            telling.cancel()
            with contextlib.suppress(asyncio.CancelledError, WebSocketDisconnect, RuntimeError):
                await telling

    async def _take(self, page: "_Page", text: str) -> None:
        """Store what a page shows."""
        try:
            show = ShowAsk.model_validate_json(text)
            await asyncio.to_thread(page.show, show)
        except (ValidationError, RefusedError):
            await page.socket.close(1008)
        page.due.set()

    async def _notify(self, page: "_Page") -> None:
        """Send a page its updates until it disconnects or the server ends."""
        while not self._closing:
            page.due.clear()
            for news in await asyncio.to_thread(page.news, self._drafts):
                await page.socket.send_json(news)
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(page.due.wait(), POLL_SECONDS)
        await page.socket.close(1000, "ended")

    def _list(self, _: Request) -> Json:
        """Return the drafts of the folder, without those equal to the files on disk."""
        drafts = self._drafts.listed()
        for draft in drafts:
            if not draft["open"] and not draft["fresh"] and self._is_on_disk(draft):
                self._drafts.drop(draft["id"])
        return {"drafts": self._drafts.listed()}

    def _is_on_disk(self, draft: Json) -> bool:
        path: str = draft["path"]
        with contextlib.suppress(RefusedError, MjsimError):
            return (
                not path.startswith(SHIPPED)
                and read_world(self._folder, path)[0] == self._drafts.read(draft["id"])["text"]
            )
        return False

    def _keep(self, ask: KeepAsk) -> Json:
        past = ask.past.model_dump(by_alias=True)
        self._drafts.keep(
            ask.tab,
            ask.number,
            path=ask.path,
            fresh=ask.fresh,
            stamp=ask.stamp,
            text=ask.text,
            past=past,
            restored=ask.restored,
        )
        self.wake()
        return {}

    def _forget(self, ask: ForgetAsk) -> Json:
        self._drafts.forget(ask.tab, ask.number)
        self.wake()
        return {}

    def _drop(self, ask: DraftAsk) -> Json:
        self._drafts.drop(ask.id)
        self.wake()
        return {}


class _Page:
    """An open page, and what was last sent to it."""

    def __init__(self, socket: WebSocket, tab: str, watch: DiskWatch) -> None:
        self.socket, self.tab = socket, tab
        self.due = asyncio.Event()
        self._watch = watch
        self._lock = threading.Lock()
        self._sent: list[tuple[str, bool]] | None = None

    def show(self, show: ShowAsk) -> None:
        """Store what it shows now."""
        with self._lock:
            self._watch.show(show.path, stamp=show.stamp, files=show.files)

    def news(self, drafts: Drafts) -> list[Json]:
        """Return what must be sent to it."""
        with self._lock:
            news = list(self._watch.news())
        others = [draft for draft in drafts.listed() if draft["tab"] != self.tab]
        current = [(draft["id"], draft["open"]) for draft in others]
        if current != self._sent:
            self._sent = current
            news.append({"kind": "drafts", "drafts": others})
        return news
