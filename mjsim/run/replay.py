"""Replays the observations of a recording through other modules."""

import json
import shutil
import sys
import time
import weakref
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
from threadpoolctl import threadpool_limits

from mjsim.errors import ModuleFault, RecordingError, UsageError, did_you_mean
from mjsim.interface import CameraFrame, Estimator, Observation, Observer
from mjsim.modules import name_of
from mjsim.output import require_free, temporary_file
from mjsim.record import (
    BELIEF_TOPICS,
    BeliefMessages,
    Copy,
    LoggedPictures,
    Order,
    RawMessage,
    Recording,
    RobotEvent,
    covariance_message,
    encode,
    event_message,
    logged_cameras,
    path_message,
    read_recording,
    with_frame,
    with_logged_cameras,
)
from mjsim.run.pilot import Driver, Pilot, final_path
from mjsim.sentences import Sentence
from mjsim.world import Use

if TYPE_CHECKING:
    from mjsim.sim import Retake


def replay(
    recording: Recording | str | Path,
    *,
    robot: str | None = None,
    estimator: Estimator,
    observer: Observer | None = None,
    record: str | Path | None = None,
    uses: Mapping[str, Use] = MappingProxyType({}),
    progress: Callable[[float], None] | None = None,
    overwrite: bool = False,
) -> Recording:
    """Replay the observations of a robot through other modules, and return the recording with their estimates.

    All numbers are exactly those that the modules of the run received. Pictures are rendered again from the recorded
    states when a module accesses them; those of a log are the recorded ones. The motion of this and all other robots is
    unchanged.

    Args:
        recording: A run, or its file.
        robot: Robot whose observations are replayed; by default the only one that has some.
        estimator: Processes all observations once, from first to last.
        observer: Replaces that of the run; by default the estimator gets all sightings of the run.
        record: The MCAP file to write; by default a temporary file, deleted with the recording.
        uses: Classes of the modules and their arguments, by 'estimator' and 'observer': stored in the recording, so
            that `compare` can tell replays apart; by default it uses the names of their classes.
        progress: Called with the simulated time of each tick once it is done [s].
        overwrite: Whether `record` may replace a file; that stays until the first ticks of the new one are written.

    Raises:
        UsageError: The robot does not exist or must be named, or `record` exists, is being written, or is the recording
            itself.
        RecordingError: The recording holds no observations of the robot, or a file cannot be read or written.
        ModuleFault: A module raised, or returned an invalid value; what was estimated until then stays in `record`.
    """
    if record is not None:
        source = recording if isinstance(recording, str | Path) else recording.path
        require_free(Path(record), overwrite=overwrite, source=Path(source))
    run = read_recording(recording) if isinstance(recording, str | Path) else recording
    robot = observed_robot(run, robot)
    if record is None:
        with temporary_file("replay.mcap") as path:
            replayed = replay(
                run, robot=robot, estimator=estimator, observer=observer, record=path, uses=uses, progress=progress
            )
        weakref.finalize(replayed, shutil.rmtree, path.parent, ignore_errors=True)
        return replayed
    record = Path(record).absolute()  # Modules may change the working directory.
    # One BLAS thread, as in the run: the same sums to the last bit.
    with threadpool_limits(1, user_api="blas"):
        driver = Driver(observer=observer, estimator=estimator)
        metadata = _metadata(run, robot, driver, uses)
        with Copy(run.path, Path(record), metadata=metadata, overwrite=overwrite) as copy:
            _write(run, robot, driver, copy, progress)
    return read_recording(record)


def observed_robot(run: Recording, robot: str | None) -> str:
    """Return a robot that has observations to replay: as named, or the only one.

    Raises:
        UsageError: The robot does not exist, or several have observations.
        RecordingError: Nothing drove it.
    """
    observed = [name for name in run.robots if run.is_observed(name)]
    if robot is None:
        if len(observed) > 1 or not run.robots:
            several = f"'{run.path}' has {len(observed)} robots with observations"
            raise UsageError(Sentence("{several}; name one of them ({observed})", several, ", ".join(observed)))
        robot = (observed or list(run.robots))[0]
    if robot not in run.robots:
        raise UsageError(
            Sentence("no robot '{robot}' in '{path}'{did_you_mean}", robot, run.path, did_you_mean(robot, run.robots))
        )
    if not run.is_observed(robot):
        raise RecordingError(
            Sentence("'{path}' holds no observation of robot '{robot}'; it had no driver in that run", run.path, robot)
        )
    return robot


def _write(
    run: Recording,
    robot: str,
    driver: Driver,
    copy: Copy,
    progress: Callable[[float], None] | None,
) -> None:
    """Write the recording of a replay."""
    from mjsim.sim import Retake

    with (
        _pilot(run, robot, driver) as pilot,
        Retake(
            run.world, robot, seed=run.seed, times=run.time, qpos=run.qpos, qvel=run.qvel, looks=run.looks
        ) as retake,
    ):
        again = _Again(run, robot, driver, pilot, retake, copy)
        for message in copy.messages():
            if again.take(message):
                copy.end_tick()
                if progress is not None:
                    progress(message.time * 1e-9)
        again.end()


def _pilot(run: Recording, robot: str, driver: Driver) -> Pilot:
    """Return the started modules, with the same inputs and random streams as in the run."""
    from mjsim.sim import Simulation

    with Simulation(run.world, seed=run.seed) as sim:
        info = with_logged_cameras(sim.robots, logged_cameras(run))[robot]
        return Pilot(driver, info, dict(sim.catalogue), sim.map, seed=run.seed)


def _metadata(run: Recording, robot: str, driver: Driver, uses: Mapping[str, Use]) -> dict[str, str]:
    metadata = {
        "command": " ".join(sys.argv),
        "replay of": str(run.path),
        "replay of command": run.metadata.get("command", ""),
        "replayed robot": robot,
        "replayed estimator": name_of(driver.estimator),
        "replayed modules": json.dumps({part: use.model_dump(mode="json") for part, use in uses.items()}),
    }
    return metadata | ({"replayed observer": name_of(driver.observer)} if driver.observer is not None else {})


OF_MODULES = ("fault", "lost", "found")
"""Kinds of events that a replay does not copy: its own modules determine whether they happen."""


class _Again:
    """A replay in progress."""

    def __init__(self, run: Recording, robot: str, driver: Driver, pilot: Pilot, retake: "Retake", copy: Copy) -> None:
        self._run, self._robot, self._pilot, self._retake, self._copy = run, robot, pilot, retake, copy
        self._logged = LoggedPictures(run, robot)
        self._driver, self._observes_anew = driver, driver.observer is not None
        self._last = round(float(run.time[-1]) * 1e9)
        self._made_anew = {f"/{robot}/{kind}" for kind in BELIEF_TOPICS}
        self._beliefs = BeliefMessages(robot)
        self._row = 0
        self._order: Order | None = None
        self._began = time.perf_counter()

    def take(self, message: RawMessage) -> bool:
        """Take the next message of the recording; returns whether it ended a tick."""
        topic, robot = message.topic, self._robot
        if self._is_of_no_whole_tick(message) or topic in self._made_anew or self._is_of_modules(message):
            return False
        if topic == f"/{robot}/observation":
            self._copy.keep(message)
            self._decide(message)
        elif topic == "/tf" and self._order is not None:
            pose = self._order.estimate.pose
            self._copy.keep(message, data=with_frame(message.data, f"{robot}/estimate", self._moment, pose))
        elif topic == "/timing":
            self._copy.keep(message, data=self._timing())
        else:
            self._copy.keep(message)
        if topic != "/state":
            return False
        self._row, self._order = self._row + 1, None
        return True

    @property
    def _now(self) -> float:
        return float(self._run.time[self._row])

    @property
    def _moment(self) -> float:
        """When the robot was at its poses of this tick [s]."""
        return float(self._run.robots[self._robot].moments[self._row])

    def _is_of_no_whole_tick(self, message: RawMessage) -> bool:
        """Return whether a message belongs to an incomplete last tick of a truncated file; events need no tick."""
        over = message.time > self._last or self._row == len(self._run.time)
        return over and message.topic.rpartition("/")[2] not in ("events", "path")

    def _is_of_modules(self, message: RawMessage) -> bool:
        """Return whether a message reports that a module failed in the run, or that its estimator was lost."""
        return message.topic == f"/{self._robot}/events" and self._run.event_in(message).kind in OF_MODULES

    def _decide(self, message: RawMessage) -> None:
        """Run the modules on an observation, and write their results."""
        robot, seen = self._robot, self._observation(message)
        try:
            order = self._order = self._pilot.decide(seen)
        except ModuleFault as fault:
            self._note(self._now, fault)
            raise
        for kind, belief in self._beliefs.of(self._now, order, moment=seen.moment):
            self._copy.put(f"/{robot}/{kind}", self._now, belief)
        for event in order.events:
            if event.kind in OF_MODULES:
                self._copy.put(f"/{robot}/events", self._now, event_message(robot, event))
        joint = order.estimate.joint_covariance
        if joint is not None:
            values = covariance_message(self._now, order.estimate, np.asarray(joint, dtype=float))
            self._copy.put(f"/{robot}/covariance", self._now, values)

    def end(self) -> None:
        """Write the final trajectory, if the estimator has one."""
        now = float(self._run.time[-1])
        try:
            path = final_path(self._robot, self._driver, now)
        except ModuleFault as fault:
            self._note(now, fault)
            raise
        if path is not None:
            self._copy.put(f"/{self._robot}/path", now, path_message(now, path))

    def _note(self, now: float, fault: ModuleFault) -> None:
        self._copy.put(f"/{self._robot}/events", now, event_message(self._robot, RobotEvent(now, "fault", str(fault))))

    def _observation(self, message: RawMessage) -> Observation:
        """Return the observation given to the modules of the run."""
        seen, stamps = self._run.observation_in(message)
        take = self._logged.at(message.time) if self._logged.cameras else self._retake.frame
        seen = replace(seen, cameras=CameraFrames(stamps, take))
        if self._observes_anew:
            return seen
        return replace(seen, sightings=self._run.robots[self._robot].sightings[self._row])

    def _timing(self) -> bytes:
        """Return the computing time of this tick: only of the modules that ran."""
        costs = self._order.timing if self._order is not None else {}
        parts = [{"part": f"{self._robot}/{part}", "seconds": seconds} for part, seconds in costs.items()]
        return encode({"time": self._now, "clock": time.perf_counter() - self._began, "parts": parts})


class CameraFrames(Mapping[str, CameraFrame]):
    """The pictures of an observation by camera, each rendered or decoded on first access."""

    def __init__(self, stamps: Mapping[str, float], take: Callable[[str, float], CameraFrame]) -> None:
        """Store when each picture was taken [s], and the function that returns it, given camera and stamp."""
        self._stamps, self._take = stamps, take
        self._taken: dict[str, CameraFrame] = {}

    def __getitem__(self, camera: str) -> CameraFrame:
        """Return the picture of a camera."""
        if camera not in self._taken:
            self._taken[camera] = self._take(camera, self._stamps[camera])
        return self._taken[camera]

    def __iter__(self) -> Iterator[str]:
        """Yield the names of the cameras with pictures in this tick."""
        return iter(self._stamps)

    def __len__(self) -> int:
        """Return the number of pictures."""
        return len(self._stamps)
