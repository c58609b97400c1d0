"""A run in a thread of its own; all that others do to it is said here, and done there between two ticks."""

import threading
from collections import deque
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from contextlib import nullcontext
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Literal, Self

from mjsim.errors import ModuleFault, UsageError
from mjsim.interface import Command
from mjsim.record.tick import Event
from mjsim.run.loop import drivers_of, one_blas_thread, recorder_of, tick_count, ticks
from mjsim.run.pilot import Driver
from mjsim.session.helm import Helm
from mjsim.session.pace import Pace
from mjsim.session.watcher import Watcher
from mjsim.world import World
from mjsim.world.settings import with_values

if TYPE_CHECKING:
    from mjsim.record import Recorder, Tick
    from mjsim.sim import Simulation

State = Literal["loading", "running", "paused", "ended", "failed"]
"""loading: compiling, and modules getting ready; ended: all ticks are done, or it was stopped; failed: see `error`."""
HOLD = 0.5
"""How long a command given by hand is held [s]."""


class Session:
    """A world at work in a thread of its own, which owns its OpenGL context.

    Every method may be called from any thread, and returns at once unless it says otherwise. The ticks are those of
    `mjsim.run`: pausing, single ticks, speed and watchers change when they come, never what they hold.
    """

    def __init__(
        self,
        world: World,
        *,
        seed: int | None = None,
        seconds: float | None = None,
        drivers: Mapping[str, Driver] | None = None,
        record: str | Path | None = None,
        speed: float | None = None,
        on_tick: "Callable[[Tick], None] | None" = None,
        on_change: Callable[[], None] | None = None,
    ) -> None:
        """Get ready; `start` begins.

        Args:
            world: What is simulated.
            seed: Of all chance; that of the world unless given.
            seconds: How long, simulated [s]; as the world says unless given.
            drivers: The modules of each robot; those of the world unless given, made anew at each start.
            record: The MCAP file to write, anew at each start; none unless given.
            speed: Simulated seconds a second; as fast as it goes unless given.
            on_tick: Called in the session's thread with each tick; the run waits for it.
            on_change: Called from any thread when state, speed or noise have changed.

        Raises:
            UsageError: The speed is not above 0.
        """
        self.world = world
        """What is simulated; noise that was changed is in it."""
        self.seed = world.run.seed if seed is None else seed
        """Of all chance in the run."""
        self.seconds = world.run.seconds if seconds is None else seconds
        """How long it lasts, simulated [s]."""
        self.record = Path(record) if record is not None else None
        """The file that is written."""
        self.error: BaseException | None = None
        """Why the run failed; None unless it did."""
        self._drivers, self._on_tick, self._on_change = drivers, on_tick, on_change
        self._helm = Helm(robot.name for robot in world.robots)
        self._pace = Pace(_checked_speed(speed))
        # All that follows is guarded by this.
        lock = threading.RLock()
        self._changed = threading.Condition(lock)
        # Who waits for the end is not woken by every tick.
        self._ticked = threading.Condition(lock)
        self._state: State = "loading"
        self._held = self._owed = False
        self._leaving: Literal["restart", "stop", "close"] | None = None
        self._asked: deque[tuple[Callable[[Simulation], None], Future[None]]] = deque()
        self._newest: Tick | None = None
        self._number = 0
        self._recorder: Recorder | None = None
        self._thread = threading.Thread(target=self._work, name="mjsim-session", daemon=True)

    def start(self, *, paused: bool = False) -> None:
        """Begin; when paused, stop after the first tick, which shows the start."""
        self._held = paused
        self._thread.start()

    def pause(self) -> None:
        """Stop before the next tick."""
        self._say(held=True)

    def go(self) -> None:
        """Go on."""
        self._say(held=False)

    def tick(self) -> None:
        """Take one tick more, and pause."""
        self._say(held=True, owed=True)

    def restart(self, *, seed: int | None = None) -> None:
        """Go back to the start, with the same seed unless another is given; paused stays paused, noise as it is."""
        self.seed = self.seed if seed is None else seed
        self._leave("restart")

    def stop(self) -> None:
        """End the run here; what was recorded is closed properly."""
        self._leave("stop")

    @property
    def state(self) -> State:
        """What it does."""
        return self._state

    @property
    def speed(self) -> float | None:
        """Simulated seconds a second that are wanted; None for as fast as it goes."""
        return self._pace.factor

    @speed.setter
    def speed(self, factor: float | None) -> None:
        checked = _checked_speed(factor)
        with self._changed:
            self._pace.factor = checked
            self._pace.forget()
            self._changed.notify_all()
        self._tell()

    @property
    def newest(self) -> "Tick | None":
        """The newest tick; None before the first."""
        return self._newest

    def watch(self) -> Watcher:
        """Return what gives the newest tick to who asks, and never holds the run up."""
        return Watcher(self._newer)

    def drive(self, robot: str, command: Command | None, *, hold: float = HOLD) -> None:
        """Drive a robot by hand; its avoidance, if it has one, still has its say.

        Args:
            robot: Its name.
            command: Takes the place of the navigator's; None lets the navigator decide again.
            hold: How long, simulated, unless it is said again [s].

        Raises:
            UsageError: There is no such robot, or the command is not finite.
        """
        self._helm.take(robot, command, hold=hold)

    def set_noise(self, key: str, value: object) -> None:
        """Change how much a sensor, a drive or its odometry errs, from the next tick on; waits until that is done.

        Args:
            key: As `mjsim run --set` has it: 'robots.scout.odometry.noise.turn'.
            value: The new one.

        Raises:
            UsageError: There is no such key, the value does not fit it, or it cannot change while the run goes on.
        """
        self._do(lambda sim: self._retune(sim, key, value))

    def wait(self, *states: State, timeout: float | None = None) -> State:
        """Wait until it is in one of these states, 'ended' or 'failed' unless named, and return the one it is in."""
        wanted = states or ("ended", "failed")
        with self._changed:
            self._changed.wait_for(lambda: self._state in wanted, timeout)
            return self._state

    def result(self) -> None:
        """Wait until the run has ended.

        Raises:
            MjsimError: It failed.
        """
        self.wait()
        if self.error is not None:
            raise self.error

    def close(self) -> None:
        """End the run and its thread, and wait for it; a second call does nothing."""
        if self._thread.is_alive():
            self._leave("close")
            self._thread.join()

    def __enter__(self) -> Self:
        """Start."""
        self.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close."""
        self.close()

    def _say(self, *, held: bool, owed: bool = False) -> None:
        with self._changed:
            self._held, self._owed = held, owed
            if self._state == "paused" and (owed or not held):
                self._state = "running"
            self._changed.notify_all()
        self._tell()

    def _leave(self, why: Literal["restart", "stop", "close"]) -> None:
        with self._changed:
            if self._leaving != "close":
                self._leaving = why
            if why == "restart":
                self._state = "loading"
            self._changed.notify_all()
        self._tell()

    def _do(self, work: "Callable[[Simulation], None]") -> None:
        """Have something done in the session's thread between two ticks, and wait for it."""
        done: Future[None] = Future()
        with self._changed:
            if not self._thread.is_alive() or self._leaving == "close":
                raise UsageError("the session is not running; start it first")
            self._asked.append((work, done))
            self._changed.notify_all()
        done.result()
        self._tell()

    def _newer(self, number: int, timeout: float | None) -> "tuple[int, Tick] | None":
        with self._changed:
            there = self._ticked.wait_for(lambda: self._number > number or self._over(), timeout)
            if self._newest is not None and self._number > number:
                return self._number, self._newest
            if not there:
                raise TimeoutError(f"no tick came within {timeout:g} s")
            if self.error is not None:
                raise self.error
            return None

    def _over(self) -> bool:
        return self._state in ("ended", "failed")

    def _tell(self) -> None:
        if self._on_change is not None:
            self._on_change()

    # What follows runs in the session's thread.

    def _work(self) -> None:
        sim: Simulation | None = None
        try:
            while self._leaving != "close":
                try:
                    sim = self._ready(sim)
                    self._run(sim)
                # Whatever it is, it is raised again in the thread that waits for the run.
                except BaseException as error:
                    self._become("failed", error)
                else:
                    self._become("ended")
                self._rest(sim)
        finally:
            if sim is not None:
                sim.close()
            self._become("ended" if self.error is None else "failed", self.error)
            self._refuse()

    def _ready(self, sim: "Simulation | None") -> "Simulation":
        """Return the simulation at its start."""
        from mjsim.sim import Simulation

        with self._changed:
            if self._leaving == "restart":
                self._leaving = None
            self.error = None
        self._helm.let_go()
        if sim is None:
            return Simulation(self.world, seed=self.seed)
        sim.reset(self.seed)
        return sim

    def _run(self, sim: "Simulation") -> None:
        """Take all ticks of a run, or those until it is to be left."""
        drivers = drivers_of(sim.world) if self._drivers is None else self._drivers
        count = tick_count(sim, self.seconds)
        recording = nullcontext() if self.record is None else recorder_of(sim, drivers, count, self.record)
        with one_blas_thread(), recording as recorder:
            self._recorder = recorder
            self._pace.forget()
            loop = ticks(sim, drivers, steer=self._helm.command)
            try:
                for number in range(count):
                    if not self._may_go_on(sim, number):
                        return
                    self._show(next(loop), recorder)
            except ModuleFault as fault:
                if recorder is not None and fault.robot is not None:
                    recorder.event(fault.robot, Event(sim.time, "fault", str(fault)))
                raise

    def _may_go_on(self, sim: "Simulation", number: int) -> bool:
        """Wait until a tick is due, and do what is asked meanwhile; false when the run is to be left."""
        while True:
            self._answer(sim)
            with self._changed:
                if self._leaving is not None:
                    return False
                wait = self._until_due(number * sim.dt, first=number == 0)
                # Until the first tick is there, modules are getting ready.
                state: State = "loading" if number == 0 else "paused" if wait is None else "running"
                changed, self._state = state != self._state, state
                if wait == 0.0:
                    self._owed = False
                elif changed:
                    self._changed.notify_all()
                elif not self._asked:
                    self._changed.wait(wait)
            if changed:
                self._tell()
            if wait == 0.0:
                return True

    def _until_due(self, simulated: float, *, first: bool) -> float | None:
        """Return how long to wait for the tick of a simulated time [s]; None for as long as it is held."""
        if first or self._owed:
            return 0.0
        if self._held:
            self._pace.forget()
            return None
        return self._pace.left(simulated)

    def _show(self, tick: "Tick", recorder: "Recorder | None") -> None:
        if recorder is not None:
            recorder.write(tick)
        with self._changed:
            self._newest = tick
            self._number += 1
            self._ticked.notify_all()
        if self._on_tick is not None:
            self._on_tick(tick)

    def _rest(self, sim: "Simulation | None") -> None:
        """Wait for a restart or the end, and do what is asked meanwhile."""
        while True:
            self._answer(sim)
            with self._changed:
                if self._leaving == "stop":
                    self._leaving = None
                if self._leaving is not None:
                    return
                if not self._asked:
                    self._changed.wait()

    def _become(self, state: State, error: BaseException | None = None) -> None:
        with self._changed:
            if self._leaving == "restart":
                state = "loading"
            self._state, self.error = state, error
            self._changed.notify_all()
            self._ticked.notify_all()
        self._tell()

    def _answer(self, sim: "Simulation | None") -> None:
        """Do what others asked for."""
        while self._asked:
            work, done = self._asked.popleft()
            if sim is None:
                done.set_exception(UsageError("the world is not there yet; wait until the run has begun"))
                continue
            try:
                work(sim)
            # Whatever it is, it is raised again in the thread that asked.
            except BaseException as error:
                done.set_exception(error)
            else:
                done.set_result(None)

    def _refuse(self) -> None:
        with self._changed:
            while self._asked:
                self._asked.popleft()[1].set_exception(UsageError("the session was closed; begin another"))

    def _retune(self, sim: "Simulation", key: str, value: object) -> None:
        changed = with_values(sim.world, {key: value})
        sim.retune(changed)
        self.world = changed
        robot = key.split(".")[1]
        if self._recorder is not None and self._state in ("running", "paused"):
            self._recorder.event(robot, Event(sim.time, "changed", f"{key} is {value}"))


def _checked_speed(speed: float | None) -> float | None:
    if speed is not None and not speed > 0.0:
        raise UsageError(f"speed is {speed:g}; it must be above 0, or None for as fast as it goes")
    return speed
