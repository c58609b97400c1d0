"""A client of the studio without a server: requests and sockets go to the routes as a server would call them."""

import asyncio
import json

import httpx
from starlette.applications import Starlette

from mjsim.web.server.connections import Connections, Limits
from mjsim.web.worlds.folder import Folder

PATIENCE = 10.0
ROOM = """mjsim: 1
name: room
walls: [{points: [[-2, -2], [2, -2], [2, 2], [-2, 2]], closed: true}]
lamps: [{name: sun, at: [0, 0]}]
robots:
  - {name: scout, preset: pioneer3dx, at: [0, 0], odometry: {noise: {distance: 0.01}}}
run: {seconds: 1000}
"""
TAB, OTHER = "a" * 16, "b" * 16


def folder_in(tmp_path):
    """Return a folder of the studio with a world and a module."""
    (tmp_path / "room.yaml").write_text(ROOM)
    (tmp_path / "own.py").write_text('"""Own."""\n\n\nclass Mine:\n    """Estimates."""\n')
    return Folder(tmp_path)


class Page:
    """A socket of a page: what it says, and what it is told."""

    def __init__(self, routes, address):
        self._routes, (self._path, _, self._query) = routes, address.partition("?")
        self._in, self._out = asyncio.Queue(), asyncio.Queue()
        self.told = []

    async def __aenter__(self):
        self._in.put_nowait({"type": "websocket.connect"})
        scope = {"type": "websocket", "path": self._path, "query_string": self._query.encode(), "headers": []}
        self._task = asyncio.create_task(Starlette(routes=self._routes)(scope, self._in.get, self._out.put))
        return self

    async def __aexit__(self, *_):
        self.leave()
        await asyncio.wait_for(self._task, PATIENCE)

    def leave(self):
        self._in.put_nowait({"type": "websocket.disconnect", "code": 1000})

    def say(self, do, **more):
        self._in.put_nowait({"type": "websocket.receive", "text": json.dumps({"do": do, **more})})

    async def next(self):
        return await asyncio.wait_for(self._out.get(), PATIENCE)

    async def until(self, kind, holds=lambda _: True):
        """Return the next message of a kind for which something holds, or the next bytes for 'bytes'."""
        while True:
            message = await self.next()
            if "bytes" in message and message["bytes"] is not None:
                if kind == "bytes":
                    return message["bytes"]
            elif message["type"] == "websocket.send":
                news = json.loads(message["text"])
                self.told.append(news)
                if news["kind"] == kind and holds(news):
                    return news

    async def refused(self, do, **more):
        self.say(do, **more)
        return (await self.until("refused"))["error"]


async def asked(routes, method, address, **more):
    app, connections = Starlette(routes=routes), Connections(Limits())

    def served(scope, receive, send):
        return app({**scope, "state": {"connections": connections}}, receive, send)

    transport = httpx.ASGITransport(app=served)
    async with httpx.AsyncClient(transport=transport, base_url="http://page") as client:
        return await client.request(method, address, **more)
