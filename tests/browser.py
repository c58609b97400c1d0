"""A browser's side of the WebSocket of a run, for tests and measurements."""

import json
from collections.abc import Iterator
from contextlib import contextmanager

import cv2
import numpy as np
from websockets.sync.client import ClientConnection, connect

from mjsim.bench.entering import client_of, cookie_of, socket_of

PATIENCE = 40.0
"""No answer takes this long [s], on however loaded a machine: less than the limit of a test with a browser."""


class Browser:
    """Sends orders, and keeps the newest news of each kind."""

    def __init__(self, socket: ClientConnection) -> None:
        self.socket = socket
        self.news: dict[str, dict] = {}
        self.events: list[dict] = []
        self.pictures: list[tuple[dict, np.ndarray]] = []
        """Headers, and pictures in RGB; of where bodies are the bytes."""

    def say(self, do: str, **more) -> None:
        self.socket.send(json.dumps({"do": do, **more}))

    def take(self, timeout: float = PATIENCE) -> str:
        """Wait for a message, keep it, and return of what kind it is; 'picture' for a picture."""
        message = self.socket.recv(timeout)
        if isinstance(message, bytes):
            size = int.from_bytes(message[:4], "little")
            head = json.loads(message[4 : 4 + size])
            picture = np.frombuffer(message[4 + size :], np.uint8)
            if head["view"] != "bodies":
                picture = cv2.imdecode(picture, cv2.IMREAD_COLOR_RGB)
            self.pictures.append((head, picture))
            return "picture"
        news = json.loads(message)
        self.news[news["kind"]] = news
        if news["kind"] == "event":
            self.events.append(news)
        return news["kind"]

    def until(self, kind: str, **values) -> dict:
        """Take messages until one of a kind has these values, and return it."""
        while True:
            if self.take() == kind and all(self.news[kind].get(key) == value for key, value in values.items()):
                return self.news[kind]

    def picture(self, view: str) -> tuple[dict, np.ndarray]:
        """Take messages until a picture of a view comes, say that it was shown, and return it."""
        while True:
            if self.take() == "picture" and self.pictures[-1][0]["view"] == view:
                self.say("shown", number=self.pictures[-1][0]["number"])
                return self.pictures[-1]


@contextmanager
def browser(url: str, at: str = "/api/run", **headers: str) -> Iterator[Browser]:
    """Open a WebSocket of a page by a one-time address, that of the run unless told otherwise."""
    with client_of(url) as client:
        address, headers = socket_of(client, at), {**cookie_of(client), **headers}
    with connect(address, additional_headers=headers, open_timeout=PATIENCE, max_size=None) as socket:
        yield Browser(socket)
