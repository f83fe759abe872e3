"""For a process that is to end at its first attempt to reach another computer, in whichever language that is made."""

from __future__ import annotations

import ctypes
import platform
import socket
import struct
import sys

import pytest

_PR_SET_NO_NEW_PRIVS, _PR_SET_SECCOMP, _SECCOMP_MODE_FILTER = 38, 22, 2
#: Of ``seccomp_data``: where the call's number and its first argument are.
_NUMBER, _FIRST_ARGUMENT = 0, 16
_LOAD, _JUMP_IF_EQUAL, _RETURN = 0x20, 0x15, 0x06
_KILL_PROCESS, _ALLOW = 0x80000000, 0x7FFF0000
#: Numbers of system calls: socket, connect.
_CALLS = {"x86_64": (41, 42), "aarch64": (198, 203)}

needs_filter = pytest.mark.skipif(
    sys.platform != "linux" or platform.machine() not in _CALLS, reason="needs Linux's filter of system calls"
)


def forbid_internet_sockets() -> None:
    """From now on, a socket of the internet ends this process (SIGSYS)."""
    number, _ = _CALLS[platform.machine()]
    _filter(
        (_LOAD, 0, 0, _NUMBER),
        (_JUMP_IF_EQUAL, 0, 4, number),
        (_LOAD, 0, 0, _FIRST_ARGUMENT),
        (_JUMP_IF_EQUAL, 1, 0, socket.AF_INET),
        (_JUMP_IF_EQUAL, 0, 1, socket.AF_INET6),
        (_RETURN, 0, 0, _KILL_PROCESS),
        (_RETURN, 0, 0, _ALLOW),
    )


def forbid_connections() -> None:
    """From now on, a connection of any kind ends this process (SIGSYS)."""
    _, number = _CALLS[platform.machine()]
    _filter(
        (_LOAD, 0, 0, _NUMBER),
        (_JUMP_IF_EQUAL, 0, 1, number),
        (_RETURN, 0, 0, _KILL_PROCESS),
        (_RETURN, 0, 0, _ALLOW),
    )


class _Program(ctypes.Structure):
    _fields_ = [("length", ctypes.c_ushort), ("instructions", ctypes.c_void_p)]


def _filter(*instructions: tuple[int, int, int, int]) -> None:
    """Have the kernel pass every system call of this process, its threads and children through ``instructions``."""
    code = b"".join(struct.pack("HBBI", *instruction) for instruction in instructions)
    memory = ctypes.create_string_buffer(code, len(code))
    program = _Program(len(instructions), ctypes.cast(memory, ctypes.c_void_p))
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.prctl(_PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) or libc.prctl(
        _PR_SET_SECCOMP, _SECCOMP_MODE_FILTER, ctypes.byref(program), 0, 0
    ):
        raise OSError(ctypes.get_errno(), "the kernel refuses a filter of system calls")
