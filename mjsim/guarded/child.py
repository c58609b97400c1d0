"""The child process that decodes untrusted files; `mjsim.guarded.guarded_reader` starts it.

Its standard input brings requests, pickled by the parent; its standard output takes back values in the form of
`mjsim.guarded.plain_values`.
"""

import gc
import importlib
import os
import pickle
import sys
import traceback
import warnings
from collections.abc import Callable, Iterator, Mapping
from typing import Any, BinaryIO

from mjsim.errors import WorldError
from mjsim.guarded.lockdown import lock_down
from mjsim.guarded.plain_values import send
from mjsim.guarded.request import LENGTH, OWN_ERRORS, Call, Permission
from mjsim.guarded.working import MISSING, REPORT

MAX_TRACEBACK = 20_000
"""Maximum length of the traceback that is handed back for developers [characters]."""


def main() -> None:
    """Serve requests until the parent closes the pipe."""
    requests = os.fdopen(os.dup(0), "rb")
    # Output printed by libraries must not mix with the answers.
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    warnings.simplefilter("ignore")
    if (first := _next(requests)) is None:
        return
    start: Permission = pickle.loads(first)
    _function(start.function)
    MISSING.set(lock_down(start))
    send(answers, {"missing": list(MISSING.get())})
    REPORT.set(lambda: send(answers, {"working": True}))
    gc.freeze()  # Libraries are never freed.
    while (request := _next(requests)) is not None:
        for answer in answers_to(request):
            _send(answers, answer)
        # Objects in cycles, such as MuJoCo scenes, would use up memory of the next call.
        gc.collect()
        gc.freeze()  # Only newly imported libraries remain: a pass over them takes 50 ms.


def answers_to(request: bytes) -> Iterator[Mapping[str, Any]]:
    """Yield the answers to a pickled call: parts of its value if it yields them, and its value or its error last."""
    try:
        call: Call = pickle.loads(request)  # from the parent, which is trusted
        if call.folder is not None:
            os.chdir(call.folder)
        value = _function(call.function)(*call.arguments, **call.keywords)
        if isinstance(value, Iterator):
            for part in value:
                yield {"part": part}
            value = None
        yield {"value": value}
    except MemoryError:
        yield {"memory": True}
    except ImportError as error:
        # A missing library is not the fault of the file.
        yield {"fault": str(error), "traceback": traceback.format_exc()[-MAX_TRACEBACK:]}
    except Exception as error:
        yield _described(error)


def _send(answers: BinaryIO, answer: Mapping[str, Any]) -> None:
    try:
        send(answers, answer)
    except MemoryError:
        send(answers, {"memory": True})
    except TypeError as error:
        send(answers, {"fault": str(error), "traceback": traceback.format_exc()})


def _described(error: Exception) -> Mapping[str, Any]:
    """Return an error in the form sent to the parent; an error of a library is a fault of the file."""
    said = traceback.format_exc()[-MAX_TRACEBACK:]
    if isinstance(error, WorldError):
        problems = [[each.file, each.line, each.column, each.message] for each in error.problems]
        return {"error": "WorldError", "problems": problems, "traceback": said}
    kind = next((name for name, own in OWN_ERRORS.items() if isinstance(error, own)), None)
    if kind is not None:
        return {"error": kind, "message": str(error), "traceback": said}
    if isinstance(error, OSError) and error.strerror:
        return {"failed": error.strerror, "traceback": said}
    text = str(error)
    return {"failed": f"{type(error).__name__}: {text}" if text else type(error).__name__, "traceback": said}


def _function(name: str) -> Callable[..., Any]:
    module, _, attribute = name.partition(":")
    found: Callable[..., Any] = getattr(importlib.import_module(module), attribute)
    return found


def _next(requests: BinaryIO) -> bytes | None:
    """Return the next request, pickled; None at the end."""
    head = requests.read(LENGTH.size)
    if len(head) < LENGTH.size:
        return None
    return requests.read(*LENGTH.unpack(head))


if __name__ == "__main__":
    main()
    # Threads and exit handlers of libraries have nothing left to do.
    sys.stdout.flush()
    os._exit(0)
