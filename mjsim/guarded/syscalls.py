"""Numbers of the system calls that a child is refused, for the two architectures that mjsim is used on.

References:
    Linux 6.12, arch/x86/entry/syscalls/syscall_64.tbl and scripts/syscall.tbl (arm64); syscalls(2).
"""

import errno
from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Refused:
    """A system call that fails with an error number."""

    x86_64: int | None
    """None where the architecture has no such call."""
    aarch64: int | None
    error: int = errno.EPERM


REFUSED: Mapping[str, Refused] = {
    # The network, and other ways to other processes.
    "socket": Refused(41, 198),
    "socketpair": Refused(53, 199),
    "io_uring_setup": Refused(425, 425, errno.ENOSYS),
    "io_uring_enter": Refused(426, 426, errno.ENOSYS),
    "io_uring_register": Refused(427, 427, errno.ENOSYS),
    "shmget": Refused(29, 194),
    "shmat": Refused(30, 196),
    "msgget": Refused(68, 186),
    "semget": Refused(64, 190),
    # Programs and other processes; C libraries use clone where clone3 is missing.
    "execve": Refused(59, 221),
    "execveat": Refused(322, 281),
    "fork": Refused(57, None),
    "vfork": Refused(58, None),
    "clone3": Refused(435, 435, errno.ENOSYS),
    "kill": Refused(62, 129),
    "tkill": Refused(200, 130),
    "rt_sigqueueinfo": Refused(129, 138),
    "rt_tgsigqueueinfo": Refused(297, 240),
    "pidfd_open": Refused(434, 434),
    "pidfd_getfd": Refused(438, 438),
    "pidfd_send_signal": Refused(424, 424),
    "ptrace": Refused(101, 117),
    "process_vm_readv": Refused(310, 270),
    "process_vm_writev": Refused(311, 271),
    "process_madvise": Refused(440, 440),
    "setsid": Refused(112, 157),
    "setrlimit": Refused(160, 164),
    # Files that cannot be inspected by their flags, and handles past the permissions of folders.
    "openat2": Refused(437, 437, errno.ENOSYS),
    "name_to_handle_at": Refused(303, 264),
    "open_by_handle_at": Refused(304, 265),
    "memfd_create": Refused(319, 279),
    # The system.
    "mount": Refused(165, 40),
    "umount2": Refused(166, 39),
    "pivot_root": Refused(155, 41),
    "chroot": Refused(161, 51),
    "unshare": Refused(272, 97),
    "setns": Refused(308, 268),
    "open_tree": Refused(428, 428),
    "move_mount": Refused(429, 429),
    "fsopen": Refused(430, 430),
    "fsconfig": Refused(431, 431),
    "fsmount": Refused(432, 432),
    "fspick": Refused(433, 433),
    "mount_setattr": Refused(442, 442),
    "bpf": Refused(321, 280),
    "perf_event_open": Refused(298, 241),
    "userfaultfd": Refused(323, 282),
    "add_key": Refused(248, 217),
    "request_key": Refused(249, 218),
    "keyctl": Refused(250, 219),
    "init_module": Refused(175, 105),
    "finit_module": Refused(313, 273),
    "delete_module": Refused(176, 106),
    "kexec_load": Refused(246, 104),
    "reboot": Refused(169, 142),
    "settimeofday": Refused(164, 170),
    "clock_settime": Refused(227, 112),
    "swapon": Refused(167, 224),
    "swapoff": Refused(168, 225),
}
WRITING: Mapping[str, Refused] = {
    "creat": Refused(85, None, errno.EACCES),
    "truncate": Refused(76, 45, errno.EACCES),
    "mkdir": Refused(83, None, errno.EACCES),
    "mkdirat": Refused(258, 34, errno.EACCES),
    "rmdir": Refused(84, None, errno.EACCES),
    "unlink": Refused(87, None, errno.EACCES),
    "unlinkat": Refused(263, 35, errno.EACCES),
    "rename": Refused(82, None, errno.EACCES),
    "renameat": Refused(264, 38, errno.EACCES),
    "renameat2": Refused(316, 276, errno.EACCES),
    "link": Refused(86, None, errno.EACCES),
    "linkat": Refused(265, 37, errno.EACCES),
    "symlink": Refused(88, None, errno.EACCES),
    "symlinkat": Refused(266, 36, errno.EACCES),
    "mknod": Refused(133, None, errno.EACCES),
    "mknodat": Refused(259, 33, errno.EACCES),
}
"""Calls that change folders; a child with a scratch folder may use them."""
ATTRIBUTES: Mapping[str, Refused] = {
    "chmod": Refused(90, None),
    "fchmod": Refused(91, 52),
    "fchmodat": Refused(268, 53),
    "fchmodat2": Refused(452, 452),
    "chown": Refused(92, None),
    "fchown": Refused(93, 55),
    "lchown": Refused(94, None),
    "fchownat": Refused(260, 54),
    "utime": Refused(132, None),
    "utimes": Refused(235, None),
    "futimesat": Refused(261, None),
    "utimensat": Refused(280, 88),
    "setxattr": Refused(188, 5),
    "lsetxattr": Refused(189, 6),
    "fsetxattr": Refused(190, 7),
    "removexattr": Refused(197, 14),
    "lremovexattr": Refused(198, 15),
    "fremovexattr": Refused(199, 16),
}
"""Calls that change who may use a file, and when it was changed."""
OPEN, OPENAT, CLONE, TGKILL, PRLIMIT = (
    Refused(2, None, errno.EACCES),
    Refused(257, 56, errno.EACCES),
    Refused(56, 220),
    Refused(234, 131),
    Refused(302, 261),
)
"""Calls that are refused for some of their arguments."""
