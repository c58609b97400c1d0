"""Converts your own observations to a recording, for replay, report, compare and video."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from mjsim.errors import MAX_MESSAGE_LENGTH, UsageError
from mjsim.geometry import Array
from mjsim.interface import Command, Observation, ReadingType, form_fields, named, retimed
from mjsim.logs.resampling import AHEAD, Log, RobotLog, Wishes, kept, recorded, world_of, write_ticks
from mjsim.output import require_free
from mjsim.record import LoggedCamera, Recording, check_fit, logged_frame
from mjsim.world import SENSOR_KINDS, Camera, World, step_misfit

MAX_JITTER = 1e-3
"""Tolerance of times relative to a constant rate, in ticks."""
MILLISECOND_TOLERANCE = 1e-3
"""Tolerance for a whole number of milliseconds [ms]."""
MAX_RATE_HZ = 250.0
"""Maximum tick rate [Hz]."""
_OF_LOGS = {"sightings", "cameras", "scans", "clouds", "imu"}
"""Readings for which a log has fields of their own."""


def write_log(
    record: str | Path,
    observations: Sequence[Observation],
    *,
    robot: str = "robot",
    truth: ArrayLike | None = None,
    landmarks: Mapping[str, tuple[float, float]] | None = None,
    world: World | None = None,
    metadata: Mapping[str, str] | None = None,
    overwrite: bool = False,
    progress: Callable[[float], None] | None = None,
) -> Recording:
    """Write a robot's observations, one per tick, as a recording and return it.

    Times and stamps are relative to the first observation. All kinds of readings are stored; pictures and depth without
    loss, so that replayed modules get them; segmentations are left out. The recording's estimate is dead reckoning.

    Args:
        record: The MCAP file to write.
        observations: At least two, at a constant rate, each with the odometry since the previous one.
        robot: Its name.
        truth: True pose of the robot at each, (x, y, heading), shape (N, 3) [m, m, rad]; NaN rows where unknown.
        landmarks: Positions of landmarks by the names in sightings [m]; modules do not get them.
        world: The world, with this robot, its sensors and its start; it gives the mounts of the sensors. By default a
            bare floor with the sensors of the observations.
        metadata: Added to that of the recording.
        overwrite: Whether `record` may replace a file.
        progress: Called with the progress [%].

    Raises:
        UsageError: The file exists, odometry or a scan is invalid, times are not at a constant rate, the truth has
            another shape, the pictures of a camera have several sizes, a rate or a name is not possible in a world, or
            the world lacks the robot or the sensor of a reading.
        RecordingError: The file cannot be written.
    """
    require_free(Path(record), overwrite=overwrite)
    observations = tuple(observations)
    _require_numbers(observations)
    rate = _rate_of(observations)
    poses, cameras = _poses(truth, len(observations)), _cameras(observations, placed=world is None)
    room = world if world is not None else _room(observations, robot, poses, landmarks or {}, cameras, rate)
    _require_robot(room, robot, cameras)
    _require_sensors(room, robot, observations)
    if abs(room.run.rate_hz - rate) > MAX_JITTER * rate:
        raise UsageError(
            f"observations come at {rate:g} Hz and the world's ticks at {room.run.rate_hz:g}; make them equal"
        )
    first = observations[0].time

    write = partial(
        write_ticks,
        room,
        {robot: _Observed(observations, poses, first, room.run.steps_per_tick * room.run.step)},
        metadata={"log": "observations", "log start": repr(first), **{k: str(v) for k, v in (metadata or {}).items()}},
        cameras={(robot, name): camera for name, camera in cameras.items()},
    )
    return recorded(lambda output: write(output=output), record=record, overwrite=overwrite, progress=progress)


@dataclass(frozen=True, slots=True, eq=False)
class _Observed:
    """Observations with times relative to the first."""

    observations: Sequence[Observation]
    truth: Array
    first: float
    dt: float
    poses: None = None
    """None: the poses are planar."""

    def observation(self, row: int) -> Observation:
        """Return an observation at its tick."""
        seen = retimed(self.observations[row], lambda time: time - self.first)
        frames = {name: logged_frame(frame) for name, frame in seen.cameras.items()}
        return replace(seen, time=row * self.dt, dt=self.dt, cameras=frames)

    def command(self, row: int) -> Command:
        """Return the mean twist since the previous tick."""
        moved = self.observations[row].odometry
        return Command(moved.forward / self.dt, moved.left / self.dt, moved.turn / self.dt)

    def identities(self, row: int) -> tuple[str | None, ...]:
        """Return the names of the sightings."""
        return tuple(sighting.name for sighting in self.observations[row].sightings)


def _cameras(observations: Sequence[Observation], *, placed: bool) -> dict[str, LoggedCamera]:
    """Return the data sheet of each camera with pictures.

    Args:
        observations: Observations with the pictures.
        placed: Whether to assume a mount on the robot: looking ahead, 0.3 m above the floor.

    Raises:
        UsageError: A camera has pictures of several sizes, or of another size than its intrinsics.
    """
    found: dict[str, LoggedCamera] = {}
    for row, seen in enumerate(observations):
        for name, frame in seen.cameras.items():
            camera = found.setdefault(name, LoggedCamera(frame.intrinsics, AHEAD if placed else None))
            if frame.depth is not None and not camera.has_depth:
                found[name] = replace(camera, has_depth=True)
            if frame.image.dtype != np.uint8:
                raise UsageError(
                    f"observation {row}: a picture of '{name}' has the type {frame.image.dtype}; it must be uint8"
                )
            intrinsics = camera.intrinsics
            size = (intrinsics.height, intrinsics.width)
            for shape in (frame.image.shape[:2], size if frame.depth is None else np.shape(frame.depth)):
                if shape != size:
                    raise UsageError(
                        f"observation {row}: camera '{name}' gave {shape[1]} x {shape[0]} pixels; its intrinsics are"
                        f" for {size[1]} x {size[0]}"
                    )
    return found


def _require_robot(world: World, robot: str, cameras: Mapping[str, LoggedCamera]) -> None:
    """Check that the robot is in the world, with its cameras.

    Raises:
        UsageError: It is not.
    """
    found = next((item for item in world.robots if item.name == robot), None)
    if found is None:
        raise UsageError(f"no robot '{robot}' in the world; give the world in which it drove, or none")
    sizes = {each.camera: (each.width, each.height) for each in found.sensors if isinstance(each, Camera)}
    for name, camera in cameras.items():
        size = camera.intrinsics.width, camera.intrinsics.height
        if sizes.get(name) != size:
            raise UsageError(
                f"no camera '{name}' of {size[0]} x {size[1]} pixels, the size of its pictures, on robot '{robot}' in"
                " the world"
            )


def _require_sensors(world: World, robot: str, observations: Sequence[Observation]) -> None:
    """Check that each reading is of a sensor that the robot has in the world.

    Raises:
        UsageError: One is not; the recording could not be read.
    """
    sensors = next(item.sensors for item in world.robots if item.name == robot)
    for row, seen in enumerate(observations):
        try:
            check_fit(seen, sensors)
        except ValueError as error:
            raise UsageError(f"observation {row}: {error}"[:MAX_MESSAGE_LENGTH]) from None


def _require_numbers(observations: Sequence[Observation]) -> None:
    """Check the shapes and values of odometry, scans, sightings and inertial readings.

    Raises:
        UsageError: They are invalid.
    """
    for row, seen in enumerate(observations):
        moved = seen.odometry
        if np.shape(moved.covariance) != (3, 3):
            shape = np.shape(moved.covariance)
            raise UsageError(f"observation {row}: the covariance of its odometry has shape {shape}; it must be (3, 3)")
        if not np.isfinite([moved.forward, moved.left, moved.turn, *np.ravel(moved.covariance)]).all():
            raise UsageError(f"observation {row}: its odometry holds a number that is not finite")
        if (np.diag(moved.covariance) < 0.0).any():
            raise UsageError(f"observation {row}: the covariance of its odometry has a variance below 0")
        if fault := _fault_of_readings(seen):
            raise UsageError(f"observation {row}: {fault}")
        for name, scan in seen.scans.items():
            if not isinstance(scan.ranges, np.ndarray):
                raise UsageError(f"observation {row}: the ranges of scan '{name:.40}' are not an array")
            if scan.ranges.ndim != 1:
                shape = scan.ranges.shape
                raise UsageError(
                    f"observation {row}: the ranges of scan '{name:.40}' have shape {shape}; it must be (n,)"
                )
            if not np.isfinite([scan.range_min, scan.range_max]).all():
                raise UsageError(f"observation {row}: the limits of scan '{name:.40}' are not finite")


def _fault_of_readings(seen: Observation) -> str:
    """Return what is wrong with the sightings or inertial readings of an observation, '' for nothing."""
    for sighting in seen.sightings:
        if not (sighting.name is None or isinstance(sighting.name, str)):
            return f"a sighting has the name {sighting.name!r:.40}; it is a text, or None"
        if not (0.0 < sighting.range < np.inf and np.isfinite(sighting.bearing)):
            seen_at = f"range {sighting.range:g} m and bearing {sighting.bearing:g} rad"
            return f"a sighting has {seen_at}; both must be finite, and the range above 0"
        if np.shape(sighting.covariance) != (2, 2) or not np.isfinite(sighting.covariance).all():
            return "the covariance of a sighting is not (2, 2) finite numbers"
    for reading in seen.imu:
        for name, values in (("acceleration", reading.acceleration), ("turn", reading.turn)):
            if not isinstance(values, np.ndarray) or values.shape != (3,):
                return f"the {name} of an inertial reading is not an array of shape (3,)"
    return ""


def _rate_of(observations: Sequence[Observation]) -> float:
    """Return the rate of the observations [Hz]."""
    if len(observations) < 2:
        raise UsageError(f"{len(observations)} observations; a recording needs at least two")
    times = np.array([seen.time for seen in observations])
    step = float(times[-1] - times[0]) / (len(times) - 1)
    if not step > 0.0:
        raise UsageError("the times of the observations do not increase; give them in order of time")
    errors = np.abs(times - times[0] - step * np.arange(len(times)))
    worst = int(np.argmax(errors))
    if errors[worst] > MAX_JITTER * step:
        raise UsageError(
            f"observation {worst} is at {times[worst]:.6g} s, {errors[worst]:.3g} s off a rate of {1 / step:.6g} Hz;"
            " give one observation per tick at a constant rate"
        )
    milliseconds = round(1e3 * step)
    # Times stored with few digits still mean whole milliseconds, or an integer rate.
    rate = 1e3 / milliseconds if abs(1e3 * step - milliseconds) < MILLISECOND_TOLERANCE else round(1.0 / step, 3)
    if rate > MAX_RATE_HZ:
        raise UsageError(f"{rate:g} observations per second; at most {MAX_RATE_HZ:g} can be recorded")
    return rate


def _poses(truth: ArrayLike | None, count: int) -> Array:
    """Return the truth as an array of floats, shape (count, 3)."""
    if truth is None:
        return np.full((count, 3), np.nan)
    try:
        poses = np.asarray(truth, dtype=float)
    except (TypeError, ValueError) as error:
        raise UsageError(f"the truth is not a table of numbers: {error}"[:MAX_MESSAGE_LENGTH]) from None
    if poses.shape != (count, 3):
        raise UsageError(f"the truth has shape {poses.shape}; with {count} observations it must be ({count}, 3)")
    return poses


def _room(
    observations: Sequence[Observation],
    robot: str,
    poses: Array,
    landmarks: Mapping[str, tuple[float, float]],
    cameras: Mapping[str, LoggedCamera],
    rate: float,
) -> World:
    """Return a bare floor and a robot with the sensors of its observations."""
    known = poses[np.isfinite(poses).all(axis=1)]
    scans = {name: kept([scan]) for seen in observations for name, scan in seen.scans.items()}
    frames = {name: kept([logged_frame(frame)]) for seen in observations for name, frame in seen.cameras.items()}
    clouds = {name: kept([cloud]) for seen in observations for name, cloud in seen.clouds.items()}
    log = RobotLog(
        sightings=[sighting for seen in observations for sighting in seen.sightings],
        scans=scans,
        cameras=frames,
        clouds=clouds,
        imu=[reading for seen in observations for reading in seen.imu],
        truth=np.concatenate([[0.0], known[0]])[None] if len(known) else None,
    )
    span = (0.0, (len(observations) - 1) / rate)
    whole = Log(
        kind="observations",
        robot=log,
        name=robot,
        landmarks=landmarks,
        cameras=cameras,
        sensors=[*_sensor_texts(observations, rate)],
        steps=next((ticks.resolution for seen in observations for ticks in seen.encoders.values()), None),
    )
    return world_of(
        [whole],
        "log",
        span=span,
        rate_hz=rate,
        wishes=Wishes(),
        source="observations",
        step_ms=_step_ms(rate),
    )


def _sensor_texts(observations: Sequence[Observation], rate: float) -> Iterator[str]:
    """Yield the text of each sensor that a log has no field for, with the keys that follow from its readings."""
    for kind, model in SENSOR_KINDS.items():
        if model.reading in _OF_LOGS:
            continue
        known = {name: each for seen in observations for name, each in named(getattr(seen, model.reading))}
        for name, reading in known.items():
            kind_of_reading: ReadingType = type(reading)
            told = [part.name for part, form in form_fields(kind_of_reading) if form.is_fixed]
            keys = [f", {key}: {getattr(reading, key)!r}" for key in told if key in model.model_fields]
            yield f"{{{kind}: {name}{''.join(keys)}, rate_hz: {rate!r}}}"


def _step_ms(rate: float) -> int:
    """Return the longest physics step of which a tick is a whole number."""
    steps = (4, 2, 1)
    misfits = [step_misfit("a tick", rate, step / 1000) for step in steps]
    if all(misfits):
        raise UsageError(f"observations: {misfits[-1]}; give them at such a rate")
    return steps[misfits.index(None)]
