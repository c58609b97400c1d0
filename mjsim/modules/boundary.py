"""The boundary to user code: each fault of a module becomes a ModuleFault with a one-line message."""

import inspect
import os
import re
import sys
import threading
import weakref
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from mjsim.errors import ModuleFault, one_line
from mjsim.modules.checks import kind_of
from mjsim.modules.covariances import Unfit
from mjsim.modules.hosts import Failed, Hosted
from mjsim.modules.roles import unfit_instance
from mjsim.sentences import Sentence
from mjsim.traces import own_frames

T = TypeVar("T")
BESIDE = "beside_"
"""Prefix of the packages for files beside a world; hidden in messages."""
MAX_TEXT_LENGTH = 240
"""Maximum length of a module's exception text in a message [characters]."""

_BESIDE = re.compile(rf"\b{BESIDE}\d+\.")


class Boundary:
    """Calls the modules of one robot.

    All exceptions of a module become a ModuleFault, including `SystemExit` and others that are not an `Exception`. Only
    KeyboardInterrupt passes in the main thread: Python raises it for Ctrl-C anywhere in the program.
    """

    def __init__(self, robot: str) -> None:
        """Store the robot's name for messages."""
        self._robot = robot
        # A module that closes this file probably also closes those of a recording.
        self._watched = os.open(os.devnull, os.O_RDONLY)
        self._sign = _sign(self._watched)
        weakref.finalize(self, _close, self._watched, self._sign)

    def require(self, role: str, module: object, now: float = 0.0) -> None:
        """Check that a module has the methods of its role; raises ModuleFault otherwise."""
        if problem := self._guarded(role, module, now, "", unfit_instance, role, module):
            raise self.fault(role, module, now, problem)

    def offers(self, role: str, module: object, method: str, now: float = 0.0) -> bool:
        """Return whether a module has an optional method."""
        return self._guarded(role, module, now, method, _has, module, method)

    def attribute(self, role: str, module: object, now: float, name: str) -> Any:
        """Return an attribute of a module; None if it does not exist."""
        return self._guarded(role, module, now, "", getattr, module, name, None)

    def call(self, role: str, module: object, now: float, method: str, *arguments: Any) -> Any:
        """Call a method of a module.

        Args:
            role: Role of the module.
            module: Module with the method.
            now: Simulated time [s].
            method: Its name; the lookup may also run the module's code.
            *arguments: Of the method.
        """
        answer = self._guarded(role, module, now, method, _call_method, module, method, arguments)
        if _sign(self._watched) != self._sign:
            place = _method_place(module, method)
            raise self.fault(
                role, module, now, Sentence("closed files of the simulator; close only your own{place}", place)
            )
        return answer

    def _guarded(
        self, role: str, module: object, now: float, method: str, function: Callable[..., T], *arguments: Any
    ) -> T:
        """Call a function that touches a module."""
        process = os.getpid()
        try:
            answer = function(*arguments)
        # This is the boundary: whatever the user's code raises ends the run with one line.
        except BaseException as error:
            end_copy(process, error)
            if _is_interrupt(error):
                raise
            raise self.fault(role, module, now, error_text(error, module, method)) from error
        end_copy(process)
        return answer

    def check(
        self, role: str, module: object, now: float, method: str, check: Callable[..., T], value: object, *more: Any
    ) -> T:
        """Return the result of a check of a method's result; reading a value may also run the module's code."""
        try:
            return check(value, *more)
        except Unfit as error:
            raise self.fault(
                role, module, now, Sentence("{error}{method_place}", error, _method_place(module, method))
            ) from error
        except BaseException as error:
            if _is_interrupt(error):
                raise
            problem = Sentence(
                "returned {value} that cannot be read: {text}{place}",
                *(kind_of(value), _text(error), _place(error, module)),
            )
            raise self.fault(role, module, now, problem) from error

    def fault(self, role: str, module: object, now: float, problem: str) -> ModuleFault:
        """Return the error of a module: who, when, what."""
        return fault_of(role, name_of(module), self._robot, now, problem)


def end_copy(process: int, error: BaseException | None = None) -> None:
    """End this process if it is a copy that a module made with `os.fork`: only one process may continue a run.

    Args:
        process: Id of the process of the run.
        error: What the module raised in it.
    """
    if os.getpid() != process:
        code = error.code if isinstance(error, SystemExit) else 0 if error is None else 1
        os._exit(code if isinstance(code, int) else 1)


def _sign(descriptor: int) -> tuple[int, int]:
    """Return what identifies an open file; two zeros if the descriptor is closed."""
    try:
        found = os.fstat(descriptor)
    except OSError:
        return 0, 0
    return found.st_dev, found.st_ino


def _close(descriptor: int, sign: tuple[int, int]) -> None:
    if _sign(descriptor) == sign:
        os.close(descriptor)


def fault_of(role: str, module: str, robot: str, now: float, problem: str) -> ModuleFault:
    """Return the error of a module with a given display name."""
    return ModuleFault(
        Sentence("{role} {module} of robot '{robot}' at {now:.2f} s {problem}", role, module, robot, now, problem),
        robot=robot,
    )


def _is_interrupt(error: BaseException) -> bool:
    return isinstance(error, KeyboardInterrupt) and threading.current_thread() is threading.main_thread()


def _call_method(module: Any, method: str, arguments: tuple[Any, ...]) -> Any:
    return getattr(module, method)(*arguments)


def _has(module: object, method: str) -> bool:
    return callable(getattr(module, method, None))


def name_of(module: object) -> str:
    """Return the name of a module in messages."""
    if isinstance(module, Hosted):
        return module.name
    return module.__name__ if isinstance(module, type) else type(module).__name__


def error_text(error: BaseException, module: object = None, method: str = "") -> str:
    """Return 'raised ...' with the place in the user's own code, on one line."""
    if isinstance(module, Hosted) and isinstance(error, (Failed, Unfit)):
        return str(error) if isinstance(error, Failed) else f"{error}{_method_place(module, method)}"
    return Sentence("raised {text}{place}", _text(error), _place(error, module) or _method_place(module, method))


def is_of_users(error: BaseException) -> bool:
    """Return whether an exception was raised in, or below, user code."""
    return bool(_place(error, None))


def _text(error: BaseException) -> str:
    """Return type and text of an exception; its `__str__` may be user code."""
    try:
        text = _BESIDE.sub("", one_line(error.msg if isinstance(error, SyntaxError) else str(error)))
    except Exception:
        text = "its text cannot be read"
    if len(text) > MAX_TEXT_LENGTH:
        text = f"{text[:MAX_TEXT_LENGTH]}..."
    if isinstance(error, ValueError) and "read-only" in text:
        text += "; inputs of a module are read-only; copy them first"
    return f"{type(error).__name__}: {text}" if text else type(error).__name__


def _place(error: BaseException, module: object) -> str:
    """Return ' (file:line)' of the innermost frame in user code; '' if there is none."""
    if isinstance(error, SyntaxError) and error.filename and error.lineno:
        return f" ({Path(error.filename).name}:{error.lineno})"
    home = getattr(sys.modules.get(type(module).__module__), "__file__", None)
    for frame in reversed(own_frames(error, home)):
        return f" ({Path(frame.filename).name}:{frame.lineno})"
    return ""


def _method_place(module: object, method: str) -> str:
    """Return ' (file:line)' of the definition of a method; '' if unknown."""
    if isinstance(module, Hosted):
        return f" ({module.place})" if module.place else ""
    found = inspect.getattr_static(type(module), method, None)
    code = getattr(inspect.unwrap(getattr(found, "__func__", found)), "__code__", None)
    return f" ({Path(code.co_filename).name}:{code.co_firstlineno})" if code is not None else ""
