"""The folder of a sweep: its description, and one file per finished run."""

import json
import os
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

from mjsim.errors import UsageError
from mjsim.output import locked_folder, remove_leftovers, replace_file, require_free
from mjsim.sweep.bundle import Bundle
from mjsim.sweep.sweep_plan import Job, SweepPlan
from mjsim.sweep.sweep_worker import Outcome

FORMAT = 1
VERSIONED_PACKAGES = ("mjsim", "mujoco", "numpy", "scipy", "opencv-python-headless")
"""Packages that the results depend on."""


def versions() -> dict[str, str]:
    """Return the installed versions of the packages that the results depend on."""
    return {name: version(name) for name in VERSIONED_PACKAGES}


@dataclass(frozen=True, slots=True)
class Store:
    """Reads and writes the folder of a sweep; files are written completely or not at all."""

    folder: Path
    keep: bool
    """Whether recordings are kept."""

    @property
    def runs(self) -> Path:
        """Folder of the files of runs."""
        return self.folder / "runs"

    @contextmanager
    def held(self) -> Iterator[None]:
        """Lock the folder for the block, since other sweeps would delete unfinished runs; create it if necessary.

        Raises:
            UsageError: Another sweep is running there, or the folder cannot be created.
        """
        with ExitStack() as stack:
            try:
                require_free(self.folder / "sweep.json", overwrite=True)
                self.folder.mkdir(parents=True, exist_ok=True)
                ours = stack.enter_context(locked_folder(self.folder))
            except OSError as error:
                raise UsageError(f"cannot write '{self.folder}': {error.strerror}") from error
            if not ours:
                raise UsageError(
                    f"another sweep is running in '{self.folder}'; wait for its end, or name another folder"
                )
            yield

    def open(self, plan: SweepPlan, bundle: Bundle) -> Path:
        """Start or resume a sweep; return the path of its world file.

        Raises:
            UsageError: The folder has other contents, or cannot be written.
        """
        identity = _identity(plan, bundle)
        path = self.folder / "sweep.json"
        try:
            if path.is_file():
                _require_same(self.folder, json.loads(path.read_bytes()), identity)
            elif self.folder.is_dir() and any(self.folder.iterdir()):
                raise UsageError(f"'{self.folder}' contains files that do not belong to a sweep; name a new folder")
            self.runs.mkdir(parents=True, exist_ok=True)
            self.write("sweep.json", _json(identity))
            remove_leftovers(self.runs)
            for left in self.runs.glob("*.part"):
                left.unlink(missing_ok=True)
            return bundle.unpack(self.folder / "world")
        except OSError as error:
            raise UsageError(f"cannot write '{self.folder}': {error.strerror}") from error
        except ValueError as error:
            raise UsageError(f"'{path}' is damaged: {error}; name a new folder") from error

    def outcome(self, job: Job) -> Outcome | None:
        """Return the outcome of a finished run; None for one that is still to do."""
        try:
            outcome: Outcome = json.loads((self.runs / f"{job.name}.json").read_bytes())
        except (OSError, ValueError):
            return None
        return outcome

    def put(self, job: Job, outcome: Outcome) -> None:
        """Store the outcome of a run."""
        self.write(f"runs/{job.name}.json", f"{json.dumps(outcome)}\n".encode())

    def write(self, name: str, data: bytes) -> None:
        """Write a file atomically.

        Raises:
            UsageError: It cannot be written.
        """
        path = self.folder / name
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            replace_file(path, data)
        except OSError as error:
            raise UsageError(f"cannot write '{path}': {error.strerror}") from error

    @contextmanager
    def recording(self, job: Job) -> Iterator[Path]:
        """Yield the path for the recording of a run, which is deleted after the block unless recordings are kept."""
        part = self.runs / f"{job.name}.{os.getpid()}.part"
        try:
            yield part
            if self.keep:
                part.replace(self.runs / f"{job.name}.mcap")
        finally:
            part.unlink(missing_ok=True)


def _identity(plan: SweepPlan, bundle: Bundle) -> dict[str, Any]:
    """Return all data that identifies a sweep."""
    return {
        "format": FORMAT,
        "world": bundle.main,
        "seeds": list(plan.seeds),
        # The order of the keys is that of the cases.
        "set": [[key, *values] for key, values in plan.settings.items()],
        "seconds": plan.seconds,
        "robot": plan.robot,
        "keep": plan.keep,
        "versions": versions(),
        "files": bundle.digests(),
    }


def _require_same(folder: Path, stored: Mapping[str, Any], given: Mapping[str, Any]) -> None:
    """Check that two sweeps are the same; the UsageError names the first difference."""
    for key, value in json.loads(_json(given)).items():
        was = stored.get(key)
        if was == value:
            continue
        if isinstance(was, dict) and isinstance(value, dict):
            part = next(name for name in sorted({*was, *value}) if was.get(name) != value.get(name))
            was, value = was.get(part), value.get(part)
            change = f"{part} has changed" if key == "files" else f"{part} was {_short(was)} and is {_short(value)}"
        else:
            change = f"{key} was {_short(was)} and is {_short(value)}"
        raise UsageError(f"'{folder}' holds another sweep: {change}; name another folder")


def _short(value: Any) -> str:
    text = "not given" if value is None else json.dumps(value)
    return text if len(text) <= 60 else f"{text[:40]} ... {text[-16:]}"


def _json(value: Any) -> bytes:
    return (json.dumps(value, indent=1) + "\n").encode()
