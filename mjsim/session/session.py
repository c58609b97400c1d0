"""A run in a background thread; requests from other threads are executed between two ticks."""

import threading
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, closing, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, get_args

from mjsim.closing import Closes, awaited, join
from mjsim.errors import ModuleFault, UsageError, did_you_mean
from mjsim.interface import Command
from mjsim.output import NewFile
from mjsim.record import RobotEvent, reserve, reserve_next
from mjsim.run import (
    Driver,
    drivers_of,
    one_blas_thread,
    record_paths,
    recorder_of,
    require_takes_goals,
    ticks,
)
from mjsim.sentences import Sentence
from mjsim.session.by_hand import ByHand
from mjsim.session.gate import Gate, State
from mjsim.session.helm import Helm
from mjsim.session.touches import Touches, noise_kept, touch_of
from mjsim.session.watcher import Watcher
from mjsim.world import GoalEvent, NoiseEvent, World, WorldEvent, with_noise

if TYPE_CHECKING:
    from mjsim.record import Recorder, Tick
    from mjsim.sim import Simulation

TICK_TIMEOUT = 60.0
"""Time limit for a tick, in which modules may compute, and for the start of a run [s]."""
HOLD_SECONDS = 0.5
"""Time for which a manual command is held [s]."""


class Session(ByHand, Closes):
    """A running world in a background thread, which owns its OpenGL context.

    Every method may be called from any thread, and returns at once unless stated otherwise. The ticks are those of
    `mjsim.run`: pauses, single ticks, speed and watchers affect when they happen, never their content.
    """

    def __init__(
        self,
        world: World,
        *,
        seed: int | None = None,
        seconds: float | None = None,
        drivers: Mapping[str, Driver] | None = None,
        record: str | Path | NewFile | None = None,
        overwrite: bool = False,
        speed: float | None = None,
        on_tick: "Callable[[Tick], None] | None" = None,
        on_change: Callable[[], None] | None = None,
        around: Callable[[Path], AbstractContextManager[object]] | None = None,
    ) -> None:
        """Prepare the session; `start` starts the run.

        Args:
            world: The world to simulate.
            seed: Seed of all random numbers; by default that of the world.
            seconds: Simulated duration [s]; by default that of the world.
            drivers: The modules of each robot; by default those of the world, created again at each start.
            record: The MCAP file to write, or its name from `reserve`; by default none. A restart writes another one,
                under the next free name: 'run.mcap', 'run-2.mcap' and so on.
            overwrite: Whether `record` may replace a file; then a restart replaces it as well.
            speed: Simulated seconds per second; by default as fast as possible.
            on_tick: Called in the session's thread with each tick; the run waits for it.
            on_change: Called from any thread when state, speed or noise have changed.
            around: Entered around each run that is recorded, with the path of its recording.

        Raises:
            UsageError: The speed is not above 0, or `record` exists, is being written, or cannot be written.
        """
        self.world = world
        """The simulated world, including changed noise."""
        self.seed = world.run.seed if seed is None else seed
        """Seed of all random numbers."""
        self.seconds = world.run.seconds if seconds is None else seconds
        """Duration, in simulated time [s]."""
        speed = _checked_speed(speed)
        self._place = None if record is None else reserve(record, overwrite=overwrite)
        self._named, self._overwrite = None if self._place is None else self._place.whole_path, overwrite
        self.record = self._named
        """The file being written, or written last."""
        self._drivers, self._on_tick, self._on_change, self._around = drivers, on_tick, on_change, around
        self._helm = Helm(robot.name for robot in world.robots)
        self._gate = Gate(speed, self._notify)
        self._driven: Mapping[str, Driver] = {}
        self._newest: Tick | None = None
        self._number = 0
        self._touches = Touches()
        self._thread = threading.Thread(target=self._work, name="mjsim-session", daemon=True)

    def start(self, *, paused: bool = False) -> None:
        """Start; if paused, stop after the first tick, which shows the initial state."""
        self._gate.hold(paused)
        self._thread.start()

    def pause(self) -> None:
        """Pause before the next tick."""
        self._gate.hold(True)

    def go(self) -> None:
        """Resume."""
        self._gate.hold(False)

    def tick(self) -> None:
        """Take one tick, and pause."""
        self._gate.hold(True, owed=True)

    def restart(self, *, seed: int | None = None) -> None:
        """Restart, with the same seed unless another is given; pause and noise settings are kept."""
        self.seed = self.seed if seed is None else seed
        self._gate.leave("restart")

    def stop(self) -> None:
        """End the run here; the recording is closed properly."""
        self._gate.leave("stop")

    @property
    def state(self) -> State:
        """State of the session."""
        return self._gate.state

    @property
    def shown(self) -> State:
        """State for people: one that is paused stays so during a single tick."""
        return self._gate.shown

    @property
    def error(self) -> BaseException | None:
        """Why the run failed; None unless it did."""
        return self._gate.error

    @property
    def speed(self) -> float | None:
        """Requested simulated seconds per second; None for as fast as possible."""
        return self._gate.pace.factor

    @speed.setter
    def speed(self, factor: float | None) -> None:
        self._gate.hasten(_checked_speed(factor))

    @property
    def newest(self) -> "Tick | None":
        """The newest tick; None before the first."""
        return self._newest

    def watch(self) -> Watcher:
        """Return a watcher, which gives the newest tick on request and never blocks the run."""
        return Watcher(self._newer)

    def drive(self, robot: str, command: Command | None, *, hold: float = HOLD_SECONDS) -> None:
        """Drive a robot manually; its avoidance, if any, stays active.

        Args:
            robot: Its name.
            command: Replaces the navigator's; None returns control to the navigator.
            hold: Simulated time until it expires, unless it is renewed [s].

        Raises:
            UsageError: The robot does not exist, or the command is not finite.
        """
        self._helm.take(robot, command, hold=hold)

    def touch(self, keys: Mapping[str, Any], *, follows: bool = False) -> WorldEvent:
        """Apply an event of the world file at the next tick; waits until it is accepted.

        Do not call it from the session's own thread, which calls `on_tick`. A paused run shows the touch at its next
        tick.

        Args:
            keys: As in a world file, without `time`: `{"move": "scout", "to": [5, 2]}`, `{"open": "gate"}`.
            follows: Whether a `reach` or `lead` gives a new target to a motion that an earlier touch began, such as
                dragging. It becomes a row of `then` in the event of that touch, and `on_change` is not called.

        Returns:
            The event with its time; numbers are rounded as in a world file.

        Raises:
            UsageError: The keys are invalid, they name something that does not exist, they place it where there is no
                space, or the run is over; then nothing changes.
        """
        event, taken = touch_of(keys), list[WorldEvent]()
        self._do(lambda sim: taken.append(self._take_touch(sim, event, follows=follows)), quiet=follows)
        return taken[0]

    @property
    def touched(self) -> tuple[WorldEvent, ...]:
        """Touches since the start, in order; `keep_events` writes them into the text of the world."""
        return self._touches.events

    def wait(self, *states: State, timeout: float | None = None) -> State:
        """Wait for one of these states, by default 'ended' or 'failed', and return the current state.

        Args:
            states: Any of 'loading', 'running', 'paused', 'ended' and 'failed'.
            timeout: Return after this time in any state [s]; by default never.

        Raises:
            UsageError: There is no such state.
        """
        for state in states:
            if state not in (known := get_args(State)):
                raise UsageError(Sentence("no state '{state}'{meant}", state, did_you_mean(state, known)))
        awaited, gate = states or ("ended", "failed"), self._gate
        with gate.changed:
            gate.changed.wait_for(lambda: gate.state in awaited, timeout)
            return gate.state

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
        try:
            if self._thread.is_alive():
                self._gate.leave("close")
                join(self._thread, within=TICK_TIMEOUT)
        finally:
            if self._place is not None:
                self._place.close()

    def __enter__(self) -> Self:
        """Start."""
        self.start()
        return self

    def _do(self, work: "Callable[[Simulation], None]", *, quiet: bool = False) -> None:
        """Do work in the session's thread between two ticks, and wait for it."""
        if not self._thread.is_alive() or self._gate.leaving == "close":
            raise UsageError("the session is not running; start it first")
        awaited(self._gate.schedule(work), "the end of a tick", within=TICK_TIMEOUT)
        if not quiet:
            self._notify()

    def _newer(self, number: int, timeout: float | None) -> "tuple[int, Tick] | None":
        gate = self._gate
        with gate.ticked:
            in_time = gate.ticked.wait_for(lambda: self._number > number or gate.state in ("ended", "failed"), timeout)
            if self._newest is not None and self._number > number:
                return self._number, self._newest
            if not in_time:
                raise TimeoutError(Sentence("there was no tick within {timeout:g} s", timeout))
            if gate.error is not None:
                raise gate.error
            return None

    def _notify(self) -> None:
        if self._on_change is not None:
            self._on_change()

    # The following methods run in the session's thread.

    def _work(self) -> None:
        sim: Simulation | None = None
        gate = self._gate
        try:
            while gate.leaving != "close":
                gate.begin()
                try:
                    sim = self._at_start(sim)
                    self._run(sim)
                # Any exception is raised again in the thread that waits for the run.
                except BaseException as error:
                    gate.become("failed", error)
                else:
                    gate.become("ended")
                gate.rest(sim)
        finally:
            if sim is not None:
                sim.close()
            gate.refuse()

    def _at_start(self, sim: "Simulation | None") -> "Simulation":
        """Return the simulation at its start."""
        from mjsim.sim import Simulation

        if sim is None:
            return Simulation(self.world, seed=self.seed)
        self._helm.let_go()
        noise = noise_kept(self._touches.events, sim.world)
        sim.reset(self.seed)
        for event in noise:
            sim.set_noise(event.noise, event.value)
        self._touches, self.world = Touches(noise), sim.tuned
        return sim

    def _run(self, sim: "Simulation") -> None:
        """Take all ticks of a run, or those until it must end."""
        drivers = self._driven = drivers_of(sim.world) if self._drivers is None else self._drivers
        count = sim.world.run.ticks(self.seconds)
        place = self._next_place()
        recording = nullcontext() if place is None else recorder_of(sim, drivers, count, place)
        around = nullcontext() if place is None or self._around is None else self._around(place.whole_path)
        with one_blas_thread(), around, recording as recorder:
            self._gate.pace.forget()
            try:
                with closing(ticks(sim, drivers, steer=self._helm.command)) as loop:
                    for number in range(count):
                        if not self._gate.may_go_on(sim, number):
                            return
                        tick = next(loop)
                        if self.world is not sim.tuned:
                            self.world = sim.tuned
                            self._notify()
                        self._show(tick, recorder)
                if recorder is not None:
                    record_paths(drivers, recorder, sim.time)
            except ModuleFault as fault:
                if recorder is not None and fault.robot is not None:
                    recorder.event(fault.robot, RobotEvent(sim.time, "fault", str(fault)))
                raise

    def _next_place(self) -> NewFile | None:
        """Return the reserved name of the next recording, or None."""
        place, self._place = self._place, None
        if place is None and self._named is not None:
            place = reserve(self._named, overwrite=True) if self._overwrite else reserve_next(self._named)
            self.record = place.whole_path
            self._notify()
        return place

    def _show(self, tick: "Tick", recorder: "Recorder | None") -> None:
        if recorder is not None:
            recorder.write(tick)
        with self._gate.ticked:
            self._newest = tick
            self._number += 1
            self._gate.ticked.notify_all()
        if self._on_tick is not None:
            self._on_tick(tick)

    def _take_touch(self, sim: "Simulation", event: WorldEvent, *, follows: bool) -> WorldEvent:
        if self.state in ("ended", "failed") or self._gate.leaving is not None:
            raise UsageError("the run is over; start it again")
        if isinstance(event, GoalEvent) and event.goal in sim.robots:
            require_takes_goals(self._driven, event.goal)
        touch = self._touches.take(sim, event, follows=follows)
        if isinstance(event, NoiseEvent):
            self.world = with_noise(self.world, event.noise, event.value)
        return touch


def _checked_speed(speed: float | None) -> float | None:
    if speed is not None and not speed > 0.0:
        raise UsageError(Sentence("speed is {speed:g}; it must be above 0, or None for as fast as possible", speed))
    return speed
