"""The run, over a WebSocket: requests of browsers, and messages to them."""

import asyncio
import contextlib
import math
from collections.abc import Mapping, Sequence
from functools import partial

from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import BaseRoute, Route, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect

from mjsim.errors import MjsimError, OutOfReachError, UsageError, WorldError, did_you_mean
from mjsim.interface import Command
from mjsim.modules import missing_modules
from mjsim.output import NewFile
from mjsim.progress import say
from mjsim.record import is_mcap, reserve_next
from mjsim.sentences import Sentence
from mjsim.session import Session
from mjsim.web.run.current_run import Scene, Stage
from mjsim.web.run.news import ShortNews, TouchedNews
from mjsim.web.run.requests import (
    DriveByHand,
    FrameShown,
    RunRequest,
    SetNoise,
    SetSpeed,
    Simple,
    Start,
    Touch,
    Watch,
    read_request,
    with_drivers,
)
from mjsim.web.run.scene_3d import Scene3dShelf
from mjsim.web.run.viewer import Viewer
from mjsim.web.server import RefusedError, answer_get
from mjsim.web.worlds import Code, Folder, Trust, source_of
from mjsim.world import ReachEvent, World, check_world, parse_world


class RunApi:
    """One run at a time, watched and controlled by all browsers; each may start a new one."""

    def __init__(self, folder: Folder | None, trust: Trust, *, scene: Scene) -> None:
        """Initialise.

        Args:
            folder: Folder whose worlds may be run; None if the run is given and there can be no other.
            trust: The code that may run.
            scene: Returns the items of a world's plan and its bounds.
        """
        self._folder, self._trust = folder, trust
        self.stage = Stage(scene)
        self._starting = asyncio.Lock()
        self._code: Mapping[str, Code] | None = None
        self._shelf = Scene3dShelf()
        self.routes: Sequence[BaseRoute] = [
            WebSocketRoute("/api/run", self._serve),
            Route("/api/run/scene", answer_get(self._scene), methods=["GET"]),
        ]

    def close(self) -> None:
        """End the run, inform viewers, and disconnect them; not from the server's thread."""
        self.stage.close()

    def _scene(self, _: Request) -> Response:
        """Return the response with the 3-D scene of the run's world."""
        if self.stage.world is None:
            raise RefusedError(409, "no run has begun; start one")
        return self._shelf.of(self.stage.world).surfaces()

    async def _serve(self, socket: WebSocket) -> None:
        """Serve a browser until it disconnects."""
        await socket.accept()
        viewer = Viewer(socket, self.stage, solids=self._shelf)
        self.stage.join(viewer)
        telling = asyncio.create_task(viewer.serve())
        try:
            while (message := await socket.receive())["type"] != "websocket.disconnect":
                await self._take(viewer, message.get("text") or "")
        except WebSocketDisconnect:
            return
        finally:
            self.stage.leave(viewer)
            telling.cancel()
            # It disconnected while something was being sent, or because it was told that this is the end.
            with contextlib.suppress(asyncio.CancelledError, WebSocketDisconnect, RuntimeError):
                await telling

    async def _take(self, viewer: Viewer, text: str) -> None:
        """Carry out a request, or answer why not."""
        do = "request"
        try:
            request = read_request(text)
            do = request.do
            await self._obey(viewer, request)
        except RefusedError as refused:
            await viewer.send({"kind": "refused", "do": do, "error": refused.message, **refused.more})
        except MjsimError as error:
            await viewer.send({"kind": "refused", "do": do, "error": _one_line(error)})

    async def _obey(self, viewer: Viewer, request: RunRequest) -> None:
        match request:
            case Watch():
                viewer.watch(request)
            case FrameShown():
                viewer.shown(request)
            case Start():
                async with self._starting:
                    await asyncio.to_thread(self._start, request)
            case Simple():
                if request.do == "restart":
                    await asyncio.to_thread(self._check_code)
                getattr(self._session(), request.do)()
            case SetSpeed():
                self._session().speed = request.value
            case SetNoise():
                await asyncio.to_thread(self._session().set_noise, request.key, request.value)
            case Touch():
                await viewer.send(await asyncio.to_thread(self._touch, request))
                if request.drag == "next":
                    self.stage.changed_later()
            case DriveByHand():
                self._drive(request)

    def _session(self) -> Session:
        if self.stage.world is None:
            raise UsageError("no run has begun; start one")
        if self.stage.session is None:
            raise UsageError("this run is controlled by another program; steer it from there")
        return self.stage.session

    def _start(self, request: Start) -> None:
        """Start a run that replaces the current one."""
        if self._folder is None:
            raise UsageError("this page shows only one run; start others with 'mjsim studio'")
        world = self._world(request, self._folder)
        from mjsim.toolbox import figures_told

        code = self._trust.check(world)
        record = None if request.record is None else _reserved(self._folder, request.record)
        if self.stage.session is not None:
            self.stage.session.close()
        session = Session(
            world,
            seed=request.seed,
            seconds=request.seconds,
            speed=request.speed,
            record=record,
            on_tick=self.stage.take,
            on_change=self.stage.changed,
            around=partial(figures_told, world.run, overwrite=False, tell=say),
        )
        self._code = code
        self.stage.put_on(world, session, path=request.path, root=self._folder.root)
        session.start()

    def _check_code(self) -> None:
        """Raise UsageError if a run started here does not have its world's current code."""
        if self._code is not None and self._trust.code_of(self._session().world) != self._code:
            raise UsageError("the code of this world has changed since the run began; press Start to run the new code")

    def _world(self, request: Start, folder: Folder) -> World:
        """Return the world of a text, with the chosen modules.

        Raises:
            WorldError: It is invalid or implausible.
            UsageError: A robot does not exist, or a module is not valid for it.
            RefusedError: The path is outside the folder.
        """
        world = parse_world(request.text, source=self._trust.guarded(source_of(folder, request.path or "")))
        world = with_drivers(world, request.drivers)
        if problems := [*check_world(world), *missing_modules(world)]:
            raise WorldError(problems)
        return world

    def _touch(self, request: Touch) -> ShortNews | TouchedNews:
        """Apply an event to the run; return a message on whether a hand or tool reaches its target."""
        session, follows = self._session(), request.drag == "next"
        try:
            event = session.touch(request.event, follows=follows)
        except OutOfReachError as miss:
            if not round(miss.short, 3):  # Only its orientation is wrong.
                raise
            if request.drag is not None and miss.nearest is not None:
                # At the edge of its reach, the nearest place may be just beyond it.
                with contextlib.suppress(OutOfReachError):
                    session.touch({**request.event, "tool": miss.nearest}, follows=follows)
            arm = str(request.event.get("arm", "arm"))
            return {"kind": "short", "of": str(request.event["reach"]), "part": arm, "metres": round(miss.short, 3)}
        if session.state == "paused" and request.drag is None:
            session.tick()
        if not isinstance(event, ReachEvent) or event.hand is None or not event.short:
            return {"kind": "touched"}
        return {"kind": "short", "of": event.reach, "part": event.hand, "metres": round(event.short, 3)}

    def _drive(self, request: DriveByHand) -> None:
        session = self._session()
        if request.forward is request.left is request.turn is None:
            session.drive(request.robot, None)
            return
        robot = next((each for each in session.world.robots if each.name == request.robot), None)
        if robot is None:
            names = [each.name for each in session.world.robots]
            raise UsageError(
                Sentence(
                    "no robot '{robot}' to drive in this world{meant}",
                    request.robot,
                    did_you_mean(request.robot, names),
                )
            )
        drive = robot.drive
        forward = (request.forward or 0.0) * drive.max_speed
        left = (request.left or 0.0) * drive.sideways
        session.drive(request.robot, Command(forward, left, (request.turn or 0.0) * math.radians(drive.max_turn_deg)))


def _reserved(folder: Folder, name: str) -> NewFile:
    """Return the file for recording a run: the next unused name if a recording exists already.

    Raises:
        UsageError: The name is not one of a recording, or the existing file is not a recording.
        RefusedError: The path is outside the folder.
        RecordingError: It cannot be written.
    """
    path = folder.path(name)
    if path.suffix != ".mcap" or any(part.startswith(".") for part in path.relative_to(folder.root).parts):
        raise UsageError(Sentence("cannot record as '{name}'; name it .mcap, without a dot in front", name))
    if path.exists() and not is_mcap(path):
        raise UsageError(Sentence("'{name}' exists and is not a recording; name another file", name))
    return reserve_next(path)


def _one_line(error: MjsimError) -> str:
    if isinstance(error, WorldError):
        first, *rest = error.problems
        return Sentence("{first} (and {more} more)", first, len(rest)) if rest else str(first)
    return str(error) or type(error).__name__
