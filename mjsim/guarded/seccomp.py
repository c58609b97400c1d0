"""A filter of the system calls of this process, which refuses the network, programs, signals and writing files.

References:
    seccomp(2), prctl(2), capabilities(7); linux/filter.h, linux/seccomp.h, linux/audit.h of Linux 6.12.
"""

import ctypes
import errno
import os
import platform
import struct
import sys
from collections.abc import Sequence

from mjsim.guarded import syscalls
from mjsim.guarded.syscalls import Refused

_INSTRUCTION = struct.Struct("<HBBI")
_LOAD, _EQUAL, _NOT_BELOW, _ANY_BIT, _RETURN = 0x20, 0x15, 0x35, 0x45, 0x06
"""BPF_LD|BPF_W|BPF_ABS, BPF_JMP|BPF_JEQ|BPF_K, BPF_JMP|BPF_JGE|BPF_K, BPF_JMP|BPF_JSET|BPF_K, BPF_RET|BPF_K."""
_NUMBER, _ARCHITECTURE, _ARGUMENTS = 0, 4, 16
"""Offsets in `struct seccomp_data`."""
_ALLOW, _ERROR = 0x7FFF0000, 0x00050000
_X32 = 0x40000000
"""Bit of the calls of the x32 form of x86-64, which has other numbers."""
_AUDIT = {"x86_64": 0xC000003E, "aarch64": 0xC00000B7}
_SECCOMP = {"x86_64": 317, "aarch64": 277}
_SET_MODE_FILTER, _FOR_ALL_THREADS = 1, 1
_NO_NEW_PRIVILEGES = 38
_WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
_CLONE_THREAD = 0x00010000
Instruction = tuple[int, int, int, int]
"""An instruction of classic BPF: operation, instructions skipped if true and if false, operand."""
Program = list[Instruction]
_ALLOWED: Instruction = (_RETURN, 0, 0, _ALLOW)


def refuse_calls(*, writing: bool) -> bool:
    """Put the filter on all threads of this process, for good; return whether the system supports it.

    Args:
        writing: Whether files may be written, where other limits allow it.
    """
    machine = platform.machine()
    if sys.platform != "linux" or sys.byteorder != "little" or machine not in _AUDIT or sys.maxsize < 2**32:
        return False
    code = b"".join(_INSTRUCTION.pack(*each) for each in program(machine, writing=writing))
    held = ctypes.create_string_buffer(code, len(code))
    # struct sock_fprog: the number of instructions, six bytes of padding, and their address.
    fprog = struct.pack("<H6xQ", len(code) // _INSTRUCTION.size, ctypes.addressof(held))
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.prctl(_NO_NEW_PRIVILEGES, 1, 0, 0, 0) != 0:
        return False
    return int(libc.syscall(_SECCOMP[machine], _SET_MODE_FILTER, _FOR_ALL_THREADS, fprog)) == 0


def program(machine: str, *, writing: bool) -> Program:
    """Return the filter for an architecture, as `platform.machine` names it."""
    code: Program = [(_LOAD, 0, 0, _ARCHITECTURE), (_EQUAL, 1, 0, _AUDIT[machine]), _error(errno.ENOSYS)]
    code.append((_LOAD, 0, 0, _NUMBER))
    if machine == "x86_64":
        code += [(_NOT_BELOW, 0, 1, _X32), _error(errno.ENOSYS)]
    for call in (*syscalls.REFUSED.values(), *syscalls.ATTRIBUTES.values()):
        code += _case(call, machine)
    if not writing:
        for call in syscalls.WRITING.values():
            code += _case(call, machine)
        code += _case(syscalls.OPEN, machine, _unless_any(1, _WRITES))
        code += _case(syscalls.OPENAT, machine, _unless_any(2, _WRITES))
    code += _case(syscalls.CLONE, machine, _if(_ANY_BIT, 0, _CLONE_THREAD))
    code += _case(syscalls.TGKILL, machine, _if(_EQUAL, 0, os.getpid()))
    code += _case(syscalls.PRLIMIT, machine, _if_null(2))
    return [*code, _ALLOWED]


def _error(number: int) -> Instruction:
    return _RETURN, 0, 0, _ERROR | number


def _case(call: Refused, machine: str, allowed: Sequence[Instruction] = ()) -> Program:
    """Return instructions that refuse a call, unless others before have allowed it."""
    number = call.x86_64 if machine == "x86_64" else call.aarch64
    if number is None:
        return []
    refused = [*allowed, _error(call.error)]
    return [(_EQUAL, 0, len(refused), number), *refused]


def _argument(index: int, *, upper: bool = False) -> Instruction:
    """Load one half of an argument of the call."""
    return _LOAD, 0, 0, _ARGUMENTS + 8 * index + 4 * upper


def _if(comparison: int, index: int, value: int) -> Program:
    """Allow a call if the lower half of an argument compares with a value."""
    return [_argument(index), (comparison, 0, 1, value), _ALLOWED]


def _unless_any(index: int, bits: int) -> Program:
    """Allow a call if an argument has none of some bits."""
    return [_argument(index), (_ANY_BIT, 1, 0, bits), _ALLOWED]


def _if_null(index: int) -> Program:
    """Allow a call if an argument is a null pointer."""
    return [_argument(index), (_EQUAL, 0, 3, 0), _argument(index, upper=True), (_EQUAL, 0, 1, 0), _ALLOWED]
