"""The run, over a WebSocket: what browsers ask of it, and what they are told."""

import asyncio
import contextlib
import math
from collections.abc import Sequence
from typing import Any

from starlette.routing import BaseRoute, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect

from mjsim.errors import MjsimError, UsageError, WorldError, did_you_mean
from mjsim.interface import Command
from mjsim.session import Session
from mjsim.web.answers import RefusedError
from mjsim.web.files import source_of
from mjsim.web.folder import Folder
from mjsim.web.orders import Drive, Order, SetNoise, Shown, Simple, Speed, Start, Watch, read_order
from mjsim.web.stage import Scene, Stage
from mjsim.web.trust import Trust
from mjsim.web.viewer import Viewer
from mjsim.world import World, parse_world
from mjsim.world.check import check_world
from mjsim.world.settings import with_values


class RunApi:
    """One run at a time, seen and steered by all browsers; each may ask for a new one."""

    def __init__(self, folder: Folder | None, trust: Trust, *, scene: Scene) -> None:
        """Get ready.

        Args:
            folder: Whose worlds may be run; None when the run comes from elsewhere and there is no other.
            trust: Whose code may run.
            scene: Gives the items of a world's plan and its bounds.
        """
        self._folder, self._trust = folder, trust
        self.stage = Stage(scene)
        self._starting = asyncio.Lock()
        self.routes: Sequence[BaseRoute] = [WebSocketRoute("/api/run", self._serve)]

    def close(self) -> None:
        """End the run, tell who watches, and let them go; from another thread than the server's."""
        self.stage.close()

    async def _serve(self, socket: WebSocket) -> None:
        """Serve a browser until it goes."""
        await socket.accept()
        viewer = Viewer(socket, self.stage)
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
            # It went while something was on its way to it, or because it was told that this is the end.
            with contextlib.suppress(asyncio.CancelledError, WebSocketDisconnect, RuntimeError):
                await telling

    async def _take(self, viewer: Viewer, text: str) -> None:
        """Do what a browser asks, or tell it why not."""
        do = "order"
        try:
            order = read_order(text)
            do = order.do
            await self._obey(viewer, order)
        except RefusedError as refused:
            await viewer.tell({"kind": "refused", "do": do, "error": refused.message, **refused.more})
        except MjsimError as error:
            await viewer.tell({"kind": "refused", "do": do, "error": _one_line(error)})

    async def _obey(self, viewer: Viewer, order: Order) -> None:
        match order:
            case Watch():
                viewer.watch(order)
            case Shown():
                viewer.shown(order)
            case Start():
                async with self._starting:
                    await asyncio.to_thread(self._start, order)
            case Simple():
                getattr(self._session(), order.do)()
            case Speed():
                self._session().speed = order.value
            case SetNoise():
                await asyncio.to_thread(self._session().set_noise, order.key, order.value)
            case Drive():
                self._drive(order)

    def _session(self) -> Session:
        if self.stage.world is None:
            raise UsageError("no run has begun; start one")
        if self.stage.session is None:
            raise UsageError("this run goes on elsewhere; steer it from there")
        return self.stage.session

    def _start(self, order: Start) -> None:
        """Begin a run in place of the one that there is."""
        if self._folder is None:
            raise UsageError("this page shows one run alone; start others with 'mjsim studio'")
        world = self._world(order, self._folder)
        self._trust.check(world)
        record = None if order.record is None else self._folder.path(order.record)
        if record is not None and record.suffix != ".mcap":
            raise UsageError(f"cannot record as '{order.record}'; name it .mcap")
        if self.stage.session is not None:
            self.stage.session.close()
        session = Session(
            world,
            seed=order.seed,
            seconds=order.seconds,
            speed=order.speed,
            record=record,
            on_tick=self.stage.take,
            on_change=self.stage.changed,
        )
        shown = record.relative_to(self._folder.root) if record is not None else None
        self.stage.put_on(world, session, path=order.path, recording=shown)
        session.start()

    def _world(self, order: Start, folder: Folder) -> World:
        """Return the world of a text, with the modules that were chosen.

        Raises:
            WorldError: It is wrong, or cannot be meant.
            UsageError: Modules were chosen for a robot that is not there, or cannot be.
            RefusedError: The path leaves the folder.
        """
        world = parse_world(order.text, source=source_of(folder, order.path or ""))
        if order.drivers:
            world = _with_drivers(world, order.drivers)
        if problems := check_world(world):
            raise WorldError(problems)
        return world

    def _drive(self, order: Drive) -> None:
        session = self._session()
        if order.forward is order.left is order.turn is None:
            session.drive(order.robot, None)
            return
        robot = next((each for each in session.world.robots if each.name == order.robot), None)
        if robot is None:
            names = [each.name for each in session.world.robots]
            raise UsageError(f"no robot '{order.robot}' to drive in this world{did_you_mean(order.robot, names)}")
        drive = robot.drive
        forward = (order.forward or 0.0) * drive.max_speed
        left = (order.left or 0.0) * float(getattr(drive, "max_left", 0.0))
        session.drive(order.robot, Command(forward, left, (order.turn or 0.0) * math.radians(drive.max_turn_deg)))


def _with_drivers(world: World, chosen: dict[str, dict[Any, Any]]) -> World:
    """Return the world with modules in place of those that it names."""
    names = [robot.name for robot in world.robots]
    drivers = {name: modules.model_dump(exclude_unset=True) for name, modules in world.run.drivers.items()}
    for name, modules in chosen.items():
        if name not in names:
            raise UsageError(f"no robot '{name}' to drive in this world{did_you_mean(name, names)}")
        drivers[name] = {**drivers.get(name, {}), **modules}
    return with_values(world, {"run.drivers": drivers})


def _one_line(error: MjsimError) -> str:
    first, *rest = str(error).splitlines() or [type(error).__name__]
    return f"{first} (and {len(rest)} more)" if rest else first
