"""Communicates with a program in JSON: one line per request, one line per answer."""

import difflib
import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from numpy.random import Generator

from mjsim.errors import one_line
from mjsim.interface import Tree, json_line
from mjsim.modules.foreign import ON_STANDARD, Answer, Engine, Process, ShownOutput, Workplace
from mjsim.modules.hosts import Failed

VERSION = 1
"""Version of the protocol in docs/programs.md."""

MIN_SIMILARITY = 0.75
"""Minimum similarity of two keys for one to be taken for a misspelling [1]."""
MAY_BE_TRUE = ("joined",)
"""Keys of answers whose values are true or false."""


class ProgramEngine(Engine):
    """A program that reads requests from standard input and answers on standard output."""

    counts_last = False

    def __init__(
        self, command: Sequence[str], place: Workplace, *, who: str, patience: float, paths: Sequence[Path]
    ) -> None:
        """Store how to start it.

        Args:
            command: Program and arguments, relative to the folder of the world.
            place: That folder.
            who: Robot and role, as a prefix of its output.
            patience: Time limit of an answer [s].
            paths: Folders placed at the front of PATH.
        """
        self._command, self._place, self._who, self._patience, self._paths = command, place, who, patience, paths
        self._process: Process | None = None
        self._fields: Sequence[str] = ()
        self._has_booleans = False

    def start(self, robot: Mapping[str, Tree], rng: Generator, fields: Sequence[str]) -> bool:
        """Start the program and send it the data of its robot; return whether it asks for pictures."""
        self.close()
        self._fields = fields
        folder = self._place.enter()
        more = {"PATH": os.pathsep.join([*(str(folder / path) for path in self._paths), os.environ.get("PATH", "")])}
        words = self._place.spelled(self._command)
        self._process = Process(words, folder, shell=ON_STANDARD, output=ShownOutput(self._who), more=more)
        seed = int(rng.integers(2**53))
        answer = self._send({"call": "start", "version": VERSION, "seed": seed, "robot": robot})
        pictures = answer.get("pictures", False)
        if not isinstance(pictures, bool):
            raise Failed("answered start with pictures that are not true or false")
        return pictures

    def call(self, method: str, given: Mapping[str, Tree]) -> Answer:
        """Return the program's answer; `torques`, which is not an object, as the field ''."""
        answer = self._send({"call": method, **given})
        known = ("tau",) if method == "torques" else self._fields
        for key in answer:
            # Other keys are the program's own, but one that is nearly right is a mistake that would have no effect.
            meant = [] if key in known else difflib.get_close_matches(key, known, n=1, cutoff=MIN_SIMILARITY)
            if meant and meant[0] not in answer:
                raise Failed(f"answered with the key '{key[:40]}'; did you mean '{meant[0]}'?")
        known_fields = {key: value for key, value in answer.items() if key in known}
        if self._has_booleans and (key := _truth_value_in(known_fields)):
            raise Failed(f"answered with {key} that holds true or false; write numbers")
        return {"": answer.get("tau")} if method == "torques" else answer

    def close(self) -> None:
        """End the program."""
        if self._process is not None:
            self._process.close()
            self._process = None
        self._place.leave()

    def _send(self, message: Mapping[str, Tree]) -> dict[str, Any]:
        if self._process is None:
            raise Failed("is called after its run has ended; start another run")
        line = self._process.exchange(json_line(message), _LineEnd().find, patience=self._patience)
        try:
            answer = json.loads(line)
        except (ValueError, RecursionError):
            text = one_line(line[:200].decode(errors="replace"))[:60]
            remedy = "write each answer on one line" if text in ("{", "[") else "print other output to standard error"
            raise Failed(f"answered '{text}', which is not JSON; {remedy}") from None
        if not isinstance(answer, dict):
            raise Failed("answered JSON that is not an object; write {...}")
        if "error" in answer:
            raise Failed(f"raised {one_line(str(answer['error']))[:240]}")
        self._has_booleans = b"true" in line or b"false" in line
        return answer


def _truth_value_in(answer: Any, key: str = "") -> str:
    """Return the key of a true or false where numbers belong, '' for none; NumPy would take these for 1 and 0."""
    if isinstance(answer, bool):
        return "" if key in MAY_BE_TRUE else key
    if isinstance(answer, dict):
        parts = [(part, name) for name, part in answer.items() if name != "messages"]
    else:
        parts = [(part, key) for part in answer] if isinstance(answer, list) else []
    return next((found for part, name in parts if (found := _truth_value_in(part, name))), "")


class _LineEnd:
    """Finds the end of a line that arrives in parts; each byte is examined once."""

    def __init__(self) -> None:
        self._searched = 0

    def find(self, got: bytearray) -> int:
        """Return the length of the line, 0 while it has no end."""
        end = got.find(b"\n", self._searched) + 1
        self._searched = len(got)
        return end
