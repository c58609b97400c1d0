"""Detects the format of a log, and converts it."""

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from mjsim.errors import MAX_MESSAGE_LENGTH, UsageError
from mjsim.inventory import fate_of
from mjsim.logs.bags import is_bag, read_bag, schemas_of
from mjsim.logs.files import lines_of
from mjsim.logs.formats import (
    columns,
    convert_mrclam,
    convert_victoria_park,
    is_carmen,
    is_euroc,
    is_rawlog,
    is_rgbd,
    read_carmen,
    read_euroc,
    read_rawlog,
    read_rgbd,
)
from mjsim.logs.resampling import Log, Output, Wishes, record_logs, require_motion, usable
from mjsim.record import is_mcap


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
    Kind(name="a rawlog of MRPT", is_one=is_rawlog, read=lambda path, *_: [read_rawlog(path)]),
    Kind(name="a CARMEN log", is_one=is_carmen, read=lambda path, *_: [read_carmen(path)]),
)
"""Formats in the order in which they are tried; MRCLAM and Victoria Park are handled separately."""
READ = (
    "a folder of MRCLAM (Barcodes.dat), Victoria Park (inputs.dat), TUM RGB-D (rgb.txt) or EuRoC (mav0),"
    " a bag of ROS 1 or ROS 2, a CARMEN log, a rawlog of MRPT, a YAML file that describes tables (log: tables)"
)
MAX_LINES = 1000
"""Number of lines read of a file that is not a supported log, to detect whether it is truncated."""
MAX_SCHEMAS = 4
"""Maximum number of types to list of an MCAP file."""
MAX_EXAMINED = 100
"""Maximum number of files to examine in a folder that is not a log itself."""
TABLE_SUFFIXES = (".csv", ".tsv", ".dat")
TRAJECTORY_SUFFIXES = (".tum", ".g2o")
KITTI_NUMBERS = 12
"""Numbers in a row of a trajectory of KITTI; those of TUM and EuRoC contain a quaternion."""
ZSTD_SUFFIXES = (".zst", ".zstd")
ARCHIVE_SUFFIXES = (".tar", ".tgz", ".txz", ".zip", ".tar.gz", ".tar.xz", ".tar.bz2", ".7z")


def convert(path: Path, wishes: Wishes, output: Output) -> Iterator[float]:
    """Convert the log of a real robot to a recording, and yield the progress [%].

    Args:
        path: A file or a folder; if a folder is not a log but contains a single one, that is converted.
        wishes: What to import, and the noise given to modules.
        output: The recording.

    Raises:
        UsageError: It is not a supported log, a file is invalid (the message has file and line), or an option does not
            apply to its format.
        RecordingError: The recording cannot be written.
    """
    if path.is_dir() and (path / "Barcodes.dat").exists():
        _refuse(wishes, "MRCLAM", robots=True, landmarks=True)
        return convert_mrclam(path, wishes, output)
    if path.is_dir() and (path / "inputs.dat").exists():
        _refuse(wishes, "Victoria Park", robots=False, landmarks=False)
        return convert_victoria_park(path, wishes, output)
    packed = path.name.lower().endswith(ARCHIVE_SUFFIXES)
    kind = None if packed else next((kind for kind in KINDS if kind.is_one(path)), None)
    if kind is None:
        inside = _logs_in(path) if path.is_dir() else []
        if len(inside) != 1:
            raise UsageError(_unknown(path, inside))
        return convert(path / inside[0], wishes, output)
    _refuse(wishes, kind.name, robots=kind.robots, landmarks=kind.landmarks, topics=kind.topics)
    return _read_and_written(kind, path, wishes, output)


def _read_and_written(kind: Kind, path: Path, wishes: Wishes, output: Output) -> Iterator[float]:
    with ExitStack() as stack:
        logs = [usable(log) for log in kind.read(path, wishes, stack)]
        for log in logs:
            require_motion(log, path)
        yield from record_logs(logs, path, wishes, output)


def _unknown(path: Path, inside: Sequence[str]) -> str:
    """Return why a path is not a supported log, with the names of logs in it."""
    if path.name.lower().endswith(ARCHIVE_SUFFIXES):
        return f"'{path}' is an archive; unpack it and name the folder"
    if packed := [each.name for each in (path.iterdir() if path.is_dir() else [path]) if each.suffix in ZSTD_SUFFIXES]:
        return f"'{path}' holds {packed[0]}, packed by zstd, and no metadata.yaml that says so; unpack it (unzstd)"
    if inside:
        return f"'{path}' is a folder of logs; name one of them: {', '.join(inside)}"[:MAX_MESSAGE_LENGTH]
    if path.is_dir() and not any(path.iterdir()):
        return f"'{path}' is an empty folder; name a log, or a folder that holds one"
    if path.is_file() and not path.stat().st_size:
        return f"'{path}' is empty"
    if path.is_file() and (cut := _cut(path)):
        return f"'{path}' holds no log in the part that could be unpacked ({cut})"
    if path.is_file() and is_mcap(path):
        names = [f"{name[:60]} ({language[:20]})" for name, language in schemas_of(path).items()][:MAX_SCHEMAS]
        held = f"it holds {', '.join(names)}" if names else "it names no types"
        return (
            f"'{path}' is an MCAP file but not of ROS: {held}; record topics of ROS (ros2 bag record -s mcap), a"
            " recording of mjsim is replayed as it is"
        )
    if path.is_file() and (path.suffix.lower() in TRAJECTORY_SUFFIXES or _begins_with_pose(path)):
        return f"'{path}' is a trajectory, not a log; evaluate it with mjsim replay RUN.mcap --trajectory '{path}'"
    if path.is_file() and path.suffix.lower() in TABLE_SUFFIXES:
        return f"'{path}' is a table of numbers; describe its columns in a YAML file (log: tables) and name that"
    return f"'{path}' is not a supported log; give {READ}"[:MAX_MESSAGE_LENGTH]


def _cut(path: Path) -> str:
    """Return what is wrong with a truncated compressed file, else ''."""
    notes: dict[str, str] = {}
    with suppress(UsageError):
        for _ in islice(lines_of(path, notes), MAX_LINES):
            pass
    return next((fate_of(fact, value)[1] for fact, value in notes.items()), "")


def _begins_with_pose(path: Path) -> bool:
    """Return whether the first row of numbers in a text is a pose, as in the trajectories of TUM, KITTI and EuRoC."""
    try:
        row = next(line for line in islice(lines_of(path, {}), MAX_LINES) if line.strip() and line[0] not in "#%")
        numbers = [float(word) for word in row.replace(",", " ").split()]
    except (UsageError, StopIteration, ValueError):
        return False
    return len(numbers) == KITTI_NUMBERS or (len(numbers) >= 8 and abs(math.hypot(*numbers[4:8]) - 1.0) < 1e-2)


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
