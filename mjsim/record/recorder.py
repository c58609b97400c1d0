"""Writes ticks to a file in a thread, while the loop continues."""

import queue
import threading
import time
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np

from mjsim.errors import RecordingError
from mjsim.geometry import Array, Pose, Pose3
from mjsim.interface import RobotInfo
from mjsim.output import Destination
from mjsim.record.belief import BeliefMessages
from mjsim.record.joint_messages import joint_messages
from mjsim.record.json_messages import (
    command_message,
    event_message,
    observation_message,
    path_message,
    pose_message,
    state_message,
    things_message,
    timing_message,
    truth_message,
    world_event_message,
)
from mjsim.record.mechanism_messages import sensor_messages
from mjsim.record.numbers import Message
from mjsim.record.readings import CODECS
from mjsim.record.recording_name import reserve
from mjsim.record.recording_writer import Batch, Writer
from mjsim.record.tick import Order, RobotEvent, Tick
from mjsim.world import World

MAX_DELAY = 0.4
"""Maximum time, simulated and wall-clock, that a tick waits in the queue, and then in a chunk [s]."""


class Recorder:
    """A recording being written: `write` takes each tick, and a separate thread encodes and writes it.

    If that thread falls behind, `write` waits for it, so nothing is lost. A killed process loses less than its last
    second.

    Args:
        path: The MCAP file, or its reserved name; it appears with the first complete tick. Folders are created if
            necessary.
        world: The world of the run; its text and pictures go into the file.
        seed: Seed of the run.
        robots: Data sheet of each robot.
        metadata: Versions, command line and the like.
        pictures: Whether to write camera pictures and the map as a grid; both can be rendered again from the rest.
        overwrite: Whether a file at the path may be replaced.

    Raises:
        UsageError: The file exists, or is being written.
        RecordingError: The file cannot be written; also from `write`, `event` and `close`. Data written before stays.
    """

    def __init__(
        self,
        path: str | Path | Destination,
        *,
        world: World,
        seed: int,
        robots: Mapping[str, RobotInfo],
        metadata: Mapping[str, str],
        pictures: bool = True,
        overwrite: bool = False,
    ) -> None:
        codecs = [
            (robot, codec)
            for robot, info in robots.items()
            for codec in CODECS
            if any(sensor.kind == codec.sensor for sensor in info.sensors.values())
        ]
        self._topics = [
            (f"/{robot}/{codec.topic.name}", codec.topic.message, robot)
            for robot, codec in codecs
            if codec.topic is not None
        ]
        self._streams = [(robot, codec.field, codec.stream) for robot, codec in codecs if codec.stream is not None]
        self._drawings = [
            (drawing, robot, codec.field)
            for robot, codec in codecs
            for drawing in codec.drawings
            if pictures or not drawing.is_picture
        ]
        place = path if isinstance(path, Destination) else reserve(path, overwrite=overwrite)
        self._writer = Writer(place, world=world, seed=seed, robots=robots, metadata=metadata)
        dt = min((info.dt for info in robots.values()), default=MAX_DELAY)
        self._is_drawn = pictures
        self._queue: queue.Queue[Batch | None] = queue.Queue(min(max(round(MAX_DELAY / dt), 2), 64))
        self._beliefs = {robot: BeliefMessages(robot) for robot in robots}
        self._began = time.perf_counter()
        self._failure: BaseException | None = None
        self._closed = False
        self._thread = threading.Thread(target=self._work, name="mjsim-recorder", daemon=True)
        self._thread.start()

    def write(self, tick: Tick) -> None:
        """Record a tick; mutable data is copied before this returns."""
        moments = {robot: seen.moment for robot, seen in tick.seen.items()}
        self._put(
            Batch(
                time=tick.time,
                messages=self._messages(tick, moments),
                joints=[
                    (f"/{robot}/covariance", order.estimate, np.array(order.estimate.joint_covariance, dtype=float))
                    for robot, order in tick.orders.items()
                    if order.estimate.joint_covariance is not None
                ],
                drawn=[
                    (drawing, robot, name, reading)
                    for drawing, robot, field in self._drawings
                    if robot in tick.seen
                    for name, reading in getattr(tick.seen[robot], field).items()
                ],
                frames=_frames(tick),
                moments=moments,
                looks=tick.looks if tick.events else None,
                closing=[
                    ("/timing", timing_message(tick, time.perf_counter() - self._began)),
                    ("/state", state_message(tick)),
                ],
            )
        )

    def _messages(self, tick: Tick, moments: Mapping[str, float]) -> list[tuple[str, Message]]:
        """Return all messages of a tick except pictures, joint covariances and those that close it."""
        messages: list[tuple[str, Message]] = []
        for robot, planar in tick.truth.items():
            truth = truth_message(tick.time, planar, tick.poses[robot], moment=moments.get(robot))
            messages.append((f"/{robot}/truth", truth))
        for robot, seen in tick.seen.items():
            messages.append((f"/{robot}/observation", observation_message(seen)))
        for topic, message_of, robot in self._topics:
            message = message_of(tick, robot)
            if message is not None:
                messages.append((topic, message))
        for robot, field, stream in self._streams:
            if robot in tick.seen:
                messages += stream.messages(robot, getattr(tick.seen[robot], field))
        messages += joint_messages(tick.time, tick.joints)
        messages += sensor_messages(tick.time, tick.readings)
        for robot, order in tick.orders.items():
            messages += self._order_messages(tick.time, robot, order, moment=moments.get(robot))
        messages += [("/events", world_event_message(tick.time, event)) for event in tick.events]
        if tick.things:
            messages.append(("/things", things_message(tick.time, tick.things)))
        return messages

    def event(self, robot: str, event: RobotEvent) -> None:
        """Record an event of a robot outside of ticks."""
        self._put(Batch(time=event.time, messages=[(f"/{robot}/events", event_message(robot, event))]))

    def path(self, robot: str, time: float, path: Array) -> None:
        """Record the final trajectory of a robot's estimator after the last tick.

        Args:
            robot: Its name.
            time: Time of the last tick [s].
            path: Rows of time [s], x, y [m] and heading [rad], shape (M, 4).
        """
        self._put(Batch(time=time, messages=[(f"/{robot}/path", path_message(time, path))]))

    def add_metadata(self, entries: Mapping[str, str]) -> None:
        """Add entries that were not known at the beginning to the metadata, after the last tick."""
        if entries:
            self._put(Batch(time=0.0, metadata=entries))

    def close(self) -> None:
        """Write all waiting data and end the file; further calls do nothing."""
        if self._closed:
            return
        self._finish()
        if self._failure is not None:
            raise self._failure

    def __enter__(self) -> Self:
        """Return itself; leaving the block closes the file."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Close the file; an exception of the block is not suppressed."""
        if error is None:
            self.close()
        else:
            # The error being raised is more useful than a second one from here.
            self._finish()

    def _order_messages(
        self, now: float, robot: str, order: Order, *, moment: float | None
    ) -> list[tuple[str, Message]]:
        odometry = pose_message(now, order.dead_reckoning, order.dead_reckoning_covariance, moment=moment)
        messages = [
            ("odometry", odometry),
            ("command", command_message(now, order)),
            *self._beliefs[robot].of(now, order, moment=moment),
            *(("events", event_message(robot, event)) for event in order.events),
        ]
        return [(f"/{robot}/{kind}", message) for kind, message in messages]

    def _put(self, batch: Batch) -> None:
        if self._closed:
            raise RecordingError("this recording is closed; nothing more can be written to it")
        while True:
            if self._failure is not None:
                raise self._failure
            try:
                self._queue.put(batch, timeout=MAX_DELAY)
            except queue.Full:
                continue  # The thread may have failed meanwhile.
            return

    def _finish(self) -> None:
        self._closed = True
        while self._thread.is_alive():
            try:
                self._queue.put(None, timeout=MAX_DELAY)
            except queue.Full:
                continue
            self._thread.join()

    def _work(self) -> None:
        try:
            try:
                self._write_batches()
            except BaseException:
                self._writer.spoil()
                raise
            finally:
                self._writer.close()
        # Whatever it is, it is raised again in the thread of the loop.
        except BaseException as error:
            self._failure = error

    def _write_batches(self) -> None:
        """Write the map, then batches; end a chunk when it is old, in wall-clock or simulated time."""
        if self._is_drawn:
            self._writer.draw_floor()
        first: Batch | None = None
        began = 0.0
        while True:
            try:
                wait = None if first is None else max(0.0, began + MAX_DELAY - time.perf_counter())
                batch = self._queue.get(timeout=wait)
            except queue.Empty:
                self._writer.flush()
                first = None
                continue
            if batch is None:
                return
            self._writer.put(batch)
            if first is None:
                first, began = batch, time.perf_counter()
            if batch.time - first.time >= MAX_DELAY or time.perf_counter() - began >= MAX_DELAY:
                self._writer.flush()
                first = None


def _frames(tick: Tick) -> dict[str, Pose | Pose3]:
    """Return the pose in the world of each frame: bases, estimates, dead reckoning and moved things."""
    frames: dict[str, Pose | Pose3] = {f"{robot}/base": tick.poses[robot] for robot in tick.truth}
    for robot, order in tick.orders.items():
        frames[f"{robot}/estimate"] = order.estimate.pose
        frames[f"{robot}/odometry"] = order.dead_reckoning
    return {**frames, **tick.things}
