"""Detects the format of a log, and imports it."""

from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from mjsim.errors import LONGEST_MESSAGE, UsageError
from mjsim.logs import columns, mrclam, victoria_park
from mjsim.logs.bags import is_bag, read_bag
from mjsim.logs.carmen import is_carmen, read_carmen
from mjsim.logs.euroc import is_euroc, read_euroc
from mjsim.logs.log import Log, Wishes, record_logs
from mjsim.logs.rgbd import is_rgbd, read_rgbd
from mjsim.logs.text import lines_of
from mjsim.logs.usable import require_motion, usable
from mjsim.output import require_free
from mjsim.record import Recording, is_mcap
from mjsim.world import Run, step_misfit


@dataclass(frozen=True, slots=True, kw_only=True)
class Kind:
    """A log format, whose reader returns logs in memory."""

    name: str
    is_one: Callable[[Path], bool]
    """Whether a file or folder has this format."""
    read: Callable[[Path, Wishes, ExitStack], Sequence[Log]]
    """One log for each robot; files that stay open are closed with the stack."""
    landmarks: bool = False
    """Whether it may contain surveyed landmarks."""
    robots: bool = False
    """Whether it may contain several robots."""
    topics: bool = False
    """Whether it has topics."""


KINDS: Sequence[Kind] = (
    Kind(
        name="a description of tables",
        is_one=columns.is_description,
        read=lambda path, wishes, _: [columns.read_columns(path, wishes)],
        landmarks=True,
    ),
    Kind(name="a bag of ROS", is_one=is_bag, read=read_bag, robots=True, topics=True),
    Kind(name="an RGB-D folder of TUM", is_one=is_rgbd, read=lambda path, *_: [read_rgbd(path)]),
    Kind(name="a folder of EuRoC", is_one=is_euroc, read=lambda path, *_: [read_euroc(path)]),
    Kind(name="a CARMEN log", is_one=is_carmen, read=lambda path, *_: [read_carmen(path)]),
)
"""Formats in the order in which they are tried; MRCLAM and Victoria Park are handled separately."""
READ = (
    "a folder of MRCLAM (Barcodes.dat), Victoria Park (inputs.dat), TUM RGB-D (rgb.txt) or EuRoC (mav0),"
    " a bag of ROS 1 or ROS 2, a CARMEN log, a YAML file that describes tables (log: tables)"
)
MAX_LINES = 1000
"""Of a file that is not a supported log, to tell whether it was cut."""
MAX_EXAMINED = 100
"""Maximum number of files to examine in a folder that is not a log itself."""
TABLES = (".csv", ".tsv", ".dat")
ZSTD = (".zst", ".zstd")
PACKED = (".tar", ".tgz", ".txz", ".zip", ".tar.gz", ".tar.xz", ".tar.bz2", ".7z")


def import_log(
    source: str | Path,
    *,
    wishes: Wishes | None = None,
    record: str | Path | None = None,
    progress: Callable[[float], None] | None = None,
    overwrite: bool = False,
) -> Recording:
    """Convert the log of a real robot to a recording; the format is detected from its files.

    Args:
        source: A file or a folder; if a folder is not a log but contains a single one, that is imported.
        wishes: What to import, and the noise given to modules.
        record: The MCAP file to write; by default a temporary one, deleted with the recording.
        progress: Called with the progress [%].
        overwrite: Whether `record` may replace a file.

    Raises:
        UsageError: It is not a supported log, a file is invalid (the message has file and line), an option does not
            apply to its format; or `record` exists, or is a file of the log.
        RecordingError: The file cannot be written.
    """
    path, wishes = Path(source), wishes or Wishes()
    if not path.exists():
        raise UsageError(f"no file or folder '{path}'")
    _require_possible(path, wishes, record)
    if path.is_dir() and (path / "Barcodes.dat").exists():
        _refuse(wishes, "MRCLAM", robots=True, landmarks=True)
        return _import_mrclam(path, wishes, record, progress, overwrite)
    if path.is_dir() and (path / "inputs.dat").exists():
        _refuse(wishes, "Victoria Park", robots=False, landmarks=False)
        return _import_victoria_park(path, wishes, record, progress, overwrite)
    packed = path.name.lower().endswith(PACKED)
    kind = None if packed else next((kind for kind in KINDS if kind.is_one(path)), None)
    if kind is None:
        inside = _logs_in(path) if path.is_dir() else []
        if len(inside) != 1:
            raise UsageError(_unknown(path, inside))
        return import_log(path / inside[0], wishes=wishes, record=record, progress=progress, overwrite=overwrite)
    _refuse(wishes, kind.name, robots=kind.robots, landmarks=kind.landmarks, topics=kind.topics)
    if record is not None:
        # Before a long log is read.
        require_free(Path(record), overwrite=overwrite)
    with ExitStack() as stack:
        logs = [usable(log) for log in kind.read(path, wishes, stack)]
        for log in logs:
            require_motion(log, path)
        return record_logs(logs, path, wishes, record=record, progress=progress, overwrite=overwrite)


def _require_possible(path: Path, wishes: Wishes, record: str | Path | None) -> None:
    """Refuse a recording that would replace a file of the log, and a rate that is not possible."""
    place = None if record is None else Path(record).resolve()
    if place is not None and place.exists() and place.is_relative_to(path.resolve()):
        raise UsageError(f"'{record}' is a file of the log; name another file")
    if wishes.rate_hz is not None and (misfit := step_misfit("a tick", wishes.rate_hz, Run().step)) is not None:
        raise UsageError(f"--rate: {misfit}")


def _unknown(path: Path, inside: Sequence[str]) -> str:
    """Return why a path is not a supported log, with the names of logs in it."""
    if path.name.lower().endswith(PACKED):
        return f"'{path}' is an archive; unpack it and name the folder"
    if packed := [each.name for each in (path.iterdir() if path.is_dir() else [path]) if each.suffix in ZSTD]:
        return f"'{path}' holds {packed[0]}, packed by zstd, and no metadata.yaml that says so; unpack it (unzstd)"
    if inside:
        return f"'{path}' is a folder of logs; name one of them: {', '.join(inside)}"[:LONGEST_MESSAGE]
    if path.is_dir() and not any(path.iterdir()):
        return f"'{path}' is an empty folder; name a log, or a folder that holds one"
    if path.is_file() and not path.stat().st_size:
        return f"'{path}' is empty"
    if path.is_file() and (cut := _cut(path)):
        return f"'{path}' is no log as far as it could be unpacked ({cut})"
    if path.is_file() and is_mcap(path):
        return f"'{path}' is an MCAP file but not of ROS; a recording of mjsim is replayed as it is"
    if path.is_file() and path.suffix.lower() in TABLES:
        return f"'{path}' is a table of numbers; describe its columns in a YAML file (log: tables) and name that"
    return f"'{path}' is not a supported log; give {READ}"[:LONGEST_MESSAGE]


def _cut(path: Path) -> str:
    """Return what is wrong with a compressed file that was cut, else ''."""
    notes: dict[str, str] = {}
    with suppress(UsageError):
        for _ in islice(lines_of(path, notes), MAX_LINES):
            pass
    return next(iter(notes.values()), "")


def _logs_in(folder: Path) -> list[str]:
    """Return the names of logs in a folder."""
    inside = sorted(folder.iterdir())[:MAX_EXAMINED]
    return [each.name for each in inside if _is_folder_of_files(each) or _is_any(each)]


def _is_folder_of_files(path: Path) -> bool:
    return (path / "Barcodes.dat").is_file() or (path / "inputs.dat").is_file()


def _is_any(path: Path) -> bool:
    """Return whether a path has a format of `KINDS`; False if it cannot be read."""
    with suppress(UsageError, OSError):
        return any(kind.is_one(path) for kind in KINDS)
    return False


def _refuse(wishes: Wishes, kind: str, *, robots: bool, landmarks: bool, topics: bool = False) -> None:
    """Refuse options that do not apply to a log format."""
    if wishes.topics and not topics:
        raise UsageError(f"{kind} has no topics; leave out --topic")
    if wishes.deskew and not topics:
        raise UsageError(f"{kind} does not say when beams were measured; leave out --deskew")
    if wishes.robots and not robots:
        raise UsageError(f"{kind} has one robot; leave out --robot")
    if wishes.known_map and not landmarks:
        raise UsageError(f"{kind} has no known map; leave out --known-map")


def _number(robot: str) -> int:
    """Return the number of a robot of MRCLAM."""
    if not robot.isdecimal():
        raise UsageError(f"no robot '{robot}'; MRCLAM numbers its robots 1 to 5")
    return int(robot)


def _import_mrclam(
    path: Path, wishes: Wishes, record: str | Path | None, progress: Callable[[float], None] | None, overwrite: bool
) -> Recording:
    return mrclam.import_mrclam(
        path,
        robots=[_number(robot) for robot in wishes.robots] or None,
        rate_hz=wishes.rate_hz or mrclam.RATE,
        begin=wishes.begin,
        seconds=wishes.seconds,
        known_map=wishes.known_map,
        motion=wishes.motion_over(mrclam.MOTION),
        sighting=wishes.sighting_over(mrclam.RANGE, mrclam.BEARING),
        bias=wishes.bias,
        record=record,
        progress=progress,
        overwrite=overwrite,
    )


def _import_victoria_park(
    path: Path, wishes: Wishes, record: str | Path | None, progress: Callable[[float], None] | None, overwrite: bool
) -> Recording:
    return victoria_park.import_victoria_park(
        path,
        rate_hz=wishes.rate_hz or victoria_park.RATE,
        begin=wishes.begin,
        seconds=wishes.seconds,
        motion=wishes.motion_over(victoria_park.MOTION),
        sighting=wishes.sighting_over(victoria_park.RANGE, victoria_park.BEARING),
        bias=wishes.bias,
        record=record,
        progress=progress,
        overwrite=overwrite,
    )
