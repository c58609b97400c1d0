"""Synchronises the thread of a run between two ticks: its pace in real time, pauses and requests."""

import threading
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from typing import TYPE_CHECKING, Literal

from mjsim.errors import UsageError

if TYPE_CHECKING:
    from mjsim.sim import Simulation


State = Literal["loading", "running", "paused", "ended", "failed"]
"""loading: compiling and starting modules; ended: all ticks are done, or it was stopped; failed: see `error`."""
Leaving = Literal["restart", "stop", "close"]
"""Reason for leaving a run before its end."""
Work = Callable[["Simulation"], None]
"""Work to do between two ticks."""


class Gate:
    """State and requests of a run. The first methods are for any thread, the others for the thread of the run."""

    def __init__(self, speed: float | None, notify: Callable[[], None]) -> None:
        """Start in the state 'loading'.

        Args:
            speed: Simulated seconds per second; None for as fast as possible.
            notify: Called after each change of state.
        """
        lock = threading.RLock()
        self.changed = threading.Condition(lock)
        """Notified of every change of the attributes below."""
        self.ticked = threading.Condition(lock)
        """Separate, so that ticks do not wake threads that wait for the end."""
        self.pace = Pace(speed)
        self.state: State = "loading"
        self.error: BaseException | None = None
        self.leaving: Leaving | None = None
        self._held = self._owed = self._shut = False
        self._is_single = False
        self._requests: deque[tuple[Work, Future[None]]] = deque()
        self._notify = notify

    @property
    def shown(self) -> State:
        """The state for people: a paused run that takes a single tick stays paused, and so does its button."""
        with self.changed:
            return "paused" if self._is_single and self.state == "running" else self.state

    def hold(self, held: bool, *, owed: bool = False) -> None:
        """Pause or resume the run; a paused run may be allowed one tick."""
        with self.changed:
            self._held, self._owed, self._is_single = held, owed, owed
            if self.state == "paused" and (owed or not held):
                self.state = "running"
            self.changed.notify_all()
        self._notify()

    def leave(self, why: Leaving) -> None:
        """End the run early; 'close' is final."""
        with self.changed:
            if self.leaving == "close":
                return
            self.leaving = why
            if why == "restart":
                self.state = "loading"
            self.changed.notify_all()
        self._notify()

    def hasten(self, speed: float | None) -> None:
        """Change the speed."""
        with self.changed:
            self.pace.factor = speed
            self.pace.forget()
            self.changed.notify_all()
        self._notify()

    def schedule(self, work: Work) -> Future[None]:
        """Schedule work in the run's thread between two ticks."""
        done: Future[None] = Future()
        with self.changed:
            if self._shut:
                done.set_exception(_closed())
                return done
            self._requests.append((work, done))
            self.changed.notify_all()
        return done

    def begin(self) -> None:
        """Record that a run begins or restarts."""
        with self.changed:
            if self.leaving == "restart":
                self.leaving = None
            self.error = None

    def may_go_on(self, sim: "Simulation", number: int) -> bool:
        """Wait until a tick is due, doing requested work meanwhile; return False if the run must end."""
        while True:
            self._answer(sim)
            with self.changed:
                if self.leaving is not None:
                    return False
                wait = self._until_due(number * sim.dt, first=number == 0)
                # Until the first tick, modules are being prepared.
                state: State = "loading" if number == 0 else "paused" if wait is None else "running"
                changed, self.state = state != self.state, state
                if changed:
                    self.changed.notify_all()
                if wait == 0.0:
                    self._owed = self._owed and number == 0
                elif not changed and not self._requests:
                    self.changed.wait(wait)
            if changed:
                self._notify()
            if wait == 0.0:
                return True

    def become(self, state: State, error: BaseException | None = None) -> None:
        """Record how the run ended."""
        with self.changed:
            if self.leaving == "restart":
                state = "loading"
            self.state, self.error = state, error
            self.changed.notify_all()
            self.ticked.notify_all()
        self._notify()

    def rest(self, sim: "Simulation | None") -> None:
        """Wait for a restart or the end, doing requested work meanwhile."""
        while True:
            self._answer(sim)
            with self.changed:
                if self.leaving == "stop":
                    self.leaving = None
                if self.leaving is not None:
                    return
                if not self._requests:
                    self.changed.wait()

    def refuse(self) -> None:
        """Refuse all pending and future requests."""
        with self.changed:
            self._shut = True
            while self._requests:
                self._requests.popleft()[1].set_exception(_closed())

    def _until_due(self, simulated: float, *, first: bool) -> float | None:
        """Return how long to wait for the tick of a simulated time [s]; None while the run is held."""
        if first or self._owed:
            return 0.0
        if self._held:
            self.pace.forget()
            return None
        return self.pace.left(simulated)

    def _answer(self, sim: "Simulation | None") -> None:
        """Do the requested work."""
        while self._requests:
            work, done = self._requests.popleft()
            if not done.set_running_or_notify_cancel():
                continue  # The caller no longer waits.
            if sim is None:
                done.set_exception(UsageError("the world is not loaded yet; wait until the run has begun"))
                continue
            try:
                work(sim)
            # Any exception is raised again in the calling thread.
            except BaseException as error:
                done.set_exception(error)
            else:
                done.set_result(None)


def _closed() -> UsageError:
    return UsageError("the session was closed; create another")


MAX_DELAY = 1.0
"""A run delayed by more than this [s] does not catch up, but continues from where it is."""


class Pace:
    """Holds a run to a multiple of real time; without a factor it runs as fast as possible."""

    def __init__(self, factor: float | None) -> None:
        """Start; the first tick is due at once."""
        self.factor = factor
        """Simulated seconds per second; None for as fast as possible."""
        self._anchor: tuple[float, float] | None = None

    def forget(self) -> None:
        """Restart the pace with the next tick, after a pause or a change of the factor."""
        self._anchor = None

    def left(self, simulated: float) -> float:
        """Return the time to wait for a tick at a simulated time [s]; 0 if it is due."""
        if self.factor is None:
            return 0.0
        now = time.perf_counter()
        if self._anchor is None:
            self._anchor = now, simulated
        began, first = self._anchor
        left = began + (simulated - first) / self.factor - now
        if left < -MAX_DELAY:
            self._anchor = now, simulated
        return max(left, 0.0)
