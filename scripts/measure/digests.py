"""Digest every number of some short runs, to verify that a change of the program changes none.

    python scripts/measure/digests.py -o before.json          with the program as it was
    python scripts/measure/digests.py --against before.json   with the program as it is

The runs use every kind of drive, sensor, door, thing that moves and event, the radio, latency, cameras and
recognition. A digest is the SHA-256 of one key of a topic (or one column of an export) over the whole run, in a
canonical form, so that a key or a topic that is new is told apart from one that differs. What depends on the clock
(`/timing`) is left out. Poses are split: where x, y and heading stay, height, roll and pitch may still change. The
exit code is 1 when something differs or is missing. The numbers hold for one machine.
"""

import argparse
import csv
import dataclasses
import hashlib
import json
import math
import struct
import subprocess
import sys
import tempfile
from collections import defaultdict
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from mcap.reader import make_reader

WORLDS = Path(__file__).parent / "digest_worlds"
SHIPPED = Path(__file__).resolve().parents[2] / "worlds"
RUNS: Mapping[str, tuple[Path, float]] = {
    "drives": (WORLDS / "drives.yaml", 8.0),
    "mecanum": (WORLDS / "mecanum.yaml", 8.0),
    "senses": (WORLDS / "senses.yaml", 6.0),
    "events": (WORLDS / "events.yaml", 6.0),
    "gallery": (SHIPPED / "gallery.yaml", 4.0),
}
"""World and seconds of each run."""
ROUNDED = 7
"""Decimals of a cosine or a sine of a heading that was computed from a quaternion: the last bits of a heading may
change when a base also rolls and pitches."""
Digests = dict[str, str]


class Sums:
    """A digest for each key, over all values that came under it."""

    def __init__(self) -> None:
        """Begin without a key."""
        self._hashes: dict[str, Any] = defaultdict(hashlib.sha256)

    def add(self, key: str, value: object) -> None:
        """Add a value: bytes as they are, all else in its canonical form."""
        data = value if isinstance(value, bytes) else json.dumps(canonical(value), sort_keys=True).encode()
        self._hashes[key].update(struct.pack("<Q", len(data)) + data)

    def digests(self) -> Digests:
        """Return the digest of each key."""
        return {key: found.hexdigest() for key, found in sorted(self._hashes.items())}


def canonical(value: object) -> object:
    """Return a value as JSON has it; numbers keep all their digits, and zero has no sign: both zeros are equal."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {each.name: canonical(getattr(value, each.name)) for each in dataclasses.fields(value)}
    if isinstance(value, np.ndarray | np.generic):
        return canonical(value.tolist())
    if isinstance(value, Mapping):
        return {str(key): canonical(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [canonical(item) for item in value]
    return 0.0 if isinstance(value, float) and value == 0.0 else value


def of_recording(path: Path) -> Digests:
    """Return a digest for each key of each topic."""
    sums = Sums()
    with path.open("rb") as stream:
        for schema, channel, message in make_reader(stream).iter_messages(log_time_order=False):
            if channel.topic == "/timing":
                continue
            sums.add(f"{channel.topic} log time", message.log_time)
            name = schema.name if schema is not None else ""
            for key, value in _parts(name, channel.message_encoding, message.data):
                sums.add(f"{channel.topic} {key}".rstrip(), value)
    return sums.digests()


def _parts(schema: str, encoding: str, data: bytes) -> Iterator[tuple[str, object]]:
    """Yield key and value of what a message holds."""
    if schema == "foxglove.FrameTransforms":
        for frame in fields(data).get(1, ()):
            yield from _frame(frame)
    elif encoding != "json":
        yield "", data
    else:
        message = json.loads(data)
        if schema == "foxglove.PoseInFrame":
            pose = message.pop("pose")
            yield "x, y", [pose["position"][axis] for axis in "xy"]
            yield "z, quaternion", [pose["position"]["z"], pose["orientation"]]
        yield from message.items()


def _frame(data: bytes) -> Iterator[tuple[str, object]]:
    """Yield what a `foxglove.FrameTransform` holds."""
    frame = fields(data)
    child = frame[3][0].decode()
    moved, turned = (fields(frame.get(number, [b""])[0]) for number in (4, 5))
    x, y, z = (_double(moved, number) for number in (1, 2, 3))
    qx, qy, qz, qw = (_double(turned, number) for number in (1, 2, 3, 4))
    yield f"{child} parent, stamp", [frame[2][0].decode(), frame[1][0].hex()]
    yield f"{child} x, y, heading", [x, y, *_cos_sin(qx, qy, qz, qw)]
    yield f"{child} z, quaternion", [z, qx, qy, qz, qw]


def _cos_sin(qx: float, qy: float, qz: float, qw: float) -> list[float]:
    """Return cosine and sine of the heading of a unit quaternion, rounded; never a negative zero."""
    heading = math.atan2(2.0 * (qx * qy + qw * qz), 1.0 - 2.0 * (qy * qy + qz * qz))
    return [round(math.cos(heading), ROUNDED) + 0.0, round(math.sin(heading), ROUNDED) + 0.0]


def _double(message: Mapping[int, list[bytes]], number: int) -> float:
    return float(struct.unpack("<d", message[number][0])[0]) if number in message else 0.0


def fields(data: bytes) -> dict[int, list[bytes]]:
    """Return the fields of a Protocol Buffers message by number, in the order in which they came.

    References:
        Protocol Buffers encoding: a field is a varint key (number << 3 | wire type), then its value.
    """
    found: dict[int, list[bytes]] = defaultdict(list)
    place = 0
    while place < len(data):
        key, place = _varint(data, place)
        begin = place
        match key & 7:
            case 0:
                _, place = _varint(data, place)
            case 1:
                place += 8
            case 5:
                place += 4
            case _:
                size, begin = _varint(data, place)
                place = begin + size
        found[key >> 3].append(data[begin:place])
    return found


def _varint(data: bytes, place: int) -> tuple[int, int]:
    value = shift = 0
    while True:
        byte = data[place]
        value |= (byte & 0x7F) << shift
        place, shift = place + 1, shift + 7
        if byte < 0x80:
            return value, place


def of_tables(folder: Path) -> Digests:
    """Return a digest for each column of each CSV file, and for each trajectory."""
    sums = Sums()
    for file in sorted(folder.iterdir()):
        if file.suffix == ".tum":
            for row in np.loadtxt(file).tolist():
                sums.add(f"{file.name} time, x, y, heading", [*row[:3], *_cos_sin(*row[4:])])
                sums.add(f"{file.name} z, quaternion", row[3:])
            continue
        with file.open() as stream:
            for row in csv.DictReader(stream):
                for column, text in row.items():
                    sums.add(f"{file.name} {column}", text)
    return sums.digests()


def of_arrays(arrays: Mapping[str, Any], name: str = "") -> Digests:
    """Return a digest for each array, also of structs within each other, as MATLAB's files have them."""
    found: Digests = {}
    for key, value in arrays.items():
        if key.startswith("__"):
            continue
        if isinstance(value, np.ndarray) and value.dtype.names:
            fields = {field: value[field].ravel()[0] for field in value.dtype.names}
            found |= of_arrays(fields, f"{name}{key}.")
        else:
            sums = Sums()
            sums.add("", [str(value.dtype), value.shape, value])
            found[f"{name}{key}"] = sums.digests()[""]
    return found


def of_module_values() -> Digests:
    """Return digests of results of the API with few sensed ticks, changed noise, and a reset."""
    import mjsim

    world = mjsim.load_world(WORLDS / "senses.yaml")
    text = (WORLDS / "senses.yaml").read_text()
    louder = mjsim.parse_world(text.replace("range: 0.05, bearing_deg: 1", "range: 0.2, bearing_deg: 3"))
    sums = Sums()
    with mjsim.Simulation(world, seed=5) as sim:
        for again in (False, True):
            if again:
                sim.reset(6)
            for tick in range(60):
                if tick % 7 in (0, 3):
                    _add_values(sums, sim)
                if tick == 30:
                    sim.retune(louder)
                sim.apply("scout", mjsim.Command(0.4, 0.0, 0.5))
                sim.step()
        for name, info in sim.robots.items():
            _add_fields(sums, f"{name} info", info)
            for sensor, sheet in info.sensors.items():
                _add_fields(sums, f"{name} info {sensor}", sheet)
    return sums.digests()


def _add_values(sums: Sums, sim: Any) -> None:
    for robot in sim.robots:
        _add_fields(sums, robot, sim.sense(robot))
        sums.add(f"{robot} identities", sim.identities(robot))


def _add_fields(sums: Sums, name: str, value: Any) -> None:
    for each in dataclasses.fields(value):
        if each.name != "sensors":
            sums.add(f"{name} {each.name}", getattr(value, each.name))


def run_command(*words: object) -> None:
    """Run a command of mjsim as a user does."""
    command = [str(Path(sys.executable).parent / "mjsim"), *map(str, words)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(command)}\n{done.stderr}")


def all_digests(folder: Path) -> dict[str, Digests]:
    """Make all runs, and return the digests of each."""
    found = {}
    for name, (world, seconds) in RUNS.items():
        file = folder / f"{name}.mcap"
        run_command("run", world, "--seconds", seconds, "-o", file)
        found[name] = of_recording(file)
        print(f"{name}: {len(found[name])} digests", file=sys.stderr)
    run, again = folder / "senses.mcap", folder / "replayed.mcap"
    run_command(
        *("replay", run, "--robot", "scout", "--estimator", f"{WORLDS / 'steps.py'}:Everything"),
        *("--observer", "mjsim.algorithms.beacon_vision:BeaconVision{camera: front}", "-o", again),
    )
    found["replay"] = of_recording(again)
    for kind in ("tum", "csv"):
        run_command("export", run, f"--{kind}", folder / kind)
        found[f"export {kind}"] = of_tables(folder / kind)
    run_command("export", run, "--npz", folder / "run.npz", "--mat", folder / "run.mat")
    with np.load(folder / "run.npz") as arrays:
        found["export npz"] = of_arrays(arrays)
    found["export mat"] = of_arrays(_matlab(folder / "run.mat"))
    found["values"] = of_module_values()
    return found


def _matlab(file: Path) -> dict[str, Any]:
    from scipy.io import loadmat

    arrays: dict[str, Any] = loadmat(file)
    return arrays


def compare(before: Mapping[str, Digests], after: Mapping[str, Digests]) -> bool:
    """Print what differs, what is missing and what is new; return whether all old entries are unchanged."""
    same = True
    for run in {**before, **after}:
        old, new = before.get(run, {}), after.get(run, {})
        differs = [key for key in old if key in new and old[key] != new[key]]
        gone, fresh = [key for key in old if key not in new], [key for key in new if key not in old]
        same &= not differs and not gone
        print(f"{run}: {len(old) - len(differs) - len(gone)} of {len(old)} the same")
        for word, keys in (("differs", differs), ("gone", gone), ("new", fresh)):
            for key in keys:
                print(f"  {word:8}{key}")
    return same


def main() -> None:
    """Digest, write and compare."""
    parser = argparse.ArgumentParser(description="Digest every number of some short runs.")
    parser.add_argument("-o", dest="out", type=Path, metavar="JSON", help="write the digests")
    parser.add_argument("--against", type=Path, metavar="JSON", help="compare with digests that were written before")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        found = all_digests(Path(folder))
    if options.out is not None:
        options.out.write_text(json.dumps(found, indent=1) + "\n")
    if options.against is not None and not compare(json.loads(options.against.read_text()), found):
        sys.exit(1)


if __name__ == "__main__":
    main()
