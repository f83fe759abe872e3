"""A port that a device is at: a serial line, a TCP connection or a file of input events; opened, lost, opened again.

Nothing here waits: a guard runs beside it. So hosts are addresses and no names, which would have to be looked up.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import ipaddress
import os
import re
import select
import socket
import stat
import struct
import termios
import time
from dataclasses import dataclass
from typing import TypeAlias

#: Time (s) between two attempts to open a port.
RETRY_S = 0.5
#: Time (s) within which a TCP connection is there, or is tried again.
CONNECT_S = 2.0
#: A device that leaves so many bytes unread takes nothing any more.
MOST_UNSENT = 4096
CONNECTING = "it is being connected to"
_READ_BYTES = 65536
#: Time (s) that a last word has to leave.
_DRAIN_S = 0.05
_SPEED = re.compile(r"B(\d+)")
#: Bits a second that Linux has a name for.
SPEEDS = {int(match[1]): getattr(termios, name) for name in dir(termios) if (match := _SPEED.fullmatch(name))}
#: ``struct linger``: on, for 0 s.
_NO_LINGER = struct.pack("ii", 1, 0)


@dataclass(frozen=True, slots=True)
class SerialAddress:
    """A serial line: its device, and bits a second (of no meaning for one over USB)."""

    path: str
    baud: int

    def __str__(self) -> str:
        return self.path


@dataclass(frozen=True, slots=True)
class TcpAddress:
    """A device in the network, by its IP address."""

    host: str
    port: int

    def __str__(self) -> str:
        return f"tcp://{self.host}:{self.port}"


@dataclass(frozen=True, slots=True)
class InputAddress:
    """A file of input events, as ``/dev/input/by-id/...``."""

    path: str

    def __str__(self) -> str:
        return self.path


Address: TypeAlias = SerialAddress | TcpAddress | InputAddress


def address(text: str, baud: int) -> SerialAddress | TcpAddress:
    """The address that ``text`` names: ``tcp://192.168.0.10:10940``, or a serial line's device. Raises ValueError."""
    if not text.startswith("tcp://"):
        if not text.startswith("/"):
            raise ValueError(f"{text!r} is no port: /dev/serial/by-id/..., or tcp://192.168.0.10:10940")
        if baud not in SPEEDS:
            raise ValueError(f"baud {baud} is none that Linux knows; {', '.join(map(str, sorted(SPEEDS)[1:]))}")
        return SerialAddress(text, baud)
    host, _, port = text.removeprefix("tcp://").rpartition(":")
    try:
        ipaddress.ip_address(host.strip("[]"))
    except ValueError:
        raise ValueError(f"{text!r}: give the IP address; the look-up of a name would hold up the guard") from None
    if not port.isdecimal() or not 0 < int(port) < 65536:
        raise ValueError(f"{text!r}: a port is a number from 1 to 65535, as in tcp://192.168.0.10:10940")
    return TcpAddress(host.strip("[]"), int(port))


class Port:
    """The port at ``address``. ``problem`` says to people why it is not open, "" while it is."""

    def __init__(self, address: Address) -> None:
        self.address = address
        self.problem = CONNECTING
        self._descriptor: int | None = None
        self._socket: socket.socket | None = None
        self._connecting = False
        self._unsent = b""
        #: When (s) it is tried next, and when an attempt to connect is over.
        self._due = 0.0
        self._over = 0.0

    @property
    def descriptor(self) -> int | None:
        """What select may wait for; None while there is none."""
        return self._descriptor

    @property
    def waits_to_write(self) -> bool:
        """Whether select should wait until it can be written to."""
        return self._connecting or bool(self._unsent)

    @property
    def is_open(self) -> bool:
        return self._descriptor is not None and not self._connecting

    def tend(self, now: float) -> bool:
        """Open the port if it is lost and an attempt is due at ``now`` (s); whether it has just opened."""
        if self._connecting:
            return self._connected(now)
        if self._descriptor is not None or now < self._due:
            return False
        self._due = now + RETRY_S
        try:
            self._open(now)
        except OSError as failure:
            self._close()
            self.problem = _words(failure)
        return self.is_open

    def read(self) -> bytes:
        """What has come; nothing where nothing has, or where the port is lost."""
        if self._descriptor is None or self._connecting:
            return b""
        try:
            data = os.read(self._descriptor, _READ_BYTES)
        except BlockingIOError:
            return b""
        except OSError as failure:
            self.lose(_lost(failure))
            return b""
        if not data:
            self.lose("it was unplugged" if self._socket is None else "it closed the connection")
        return data

    def write(self, data: bytes) -> None:
        """Send ``data``, after what waits already. A device that takes nothing loses the port."""
        if self.is_open and data:
            self._unsent += data
            self.flush()
            if len(self._unsent) > MOST_UNSENT:
                self.lose("it takes nothing that is sent to it")

    def flush(self) -> None:
        """Send what waits, as far as it can be sent now."""
        while self._unsent and self._descriptor is not None and not self._connecting:
            try:
                sent = os.write(self._descriptor, self._unsent)
            except BlockingIOError:
                return
            except OSError as failure:
                self.lose(_lost(failure))
                return
            self._unsent = self._unsent[sent:]

    def lose(self, problem: str) -> None:
        """Close the port because of ``problem``; it is opened again."""
        self._close()
        self.problem = problem

    def _open(self, now: float) -> None:
        match self.address:
            case TcpAddress(host, port):
                family = socket.AF_INET6 if ":" in host else socket.AF_INET
                self._socket = socket.socket(family, socket.SOCK_STREAM | socket.SOCK_NONBLOCK)
                self._descriptor = self._socket.fileno()
                self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                # A command that a reader left waiting is worth nothing later.
                self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _NO_LINGER)
                problem = self._socket.connect_ex((host, port))
                if problem not in (0, errno.EINPROGRESS):
                    raise OSError(problem, os.strerror(problem))
                self._connecting, self._over = True, now + CONNECT_S
            case SerialAddress(path, baud):
                self._descriptor = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK | os.O_CLOEXEC)
                _set_raw(self._descriptor, SPEEDS[baud])
                self.problem = ""
            case InputAddress(path):
                self._descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
                if stat.S_ISREG(os.fstat(self._descriptor).st_mode):
                    raise OSError(errno.ENODEV, "it is a plain file, and no device")
                self.problem = ""

    def _connected(self, now: float) -> bool:
        assert self._socket is not None
        _, writable, _ = select.select([], [self._socket], [], 0)
        if not writable:
            if now >= self._over:
                self.lose("it does not answer")
            return False
        if problem := self._socket.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR):
            self.lose(_words(OSError(problem, os.strerror(problem))))
            return False
        self._connecting, self.problem = False, ""
        return True

    def close(self) -> None:
        """Release it, once what was sent has left, or a moment later."""
        self.flush()
        over = time.monotonic() + _DRAIN_S
        while self._descriptor is not None and _waiting_in(self._descriptor) and time.monotonic() < over:
            time.sleep(_DRAIN_S / 10)
        self.lose("closed")

    def _close(self) -> None:
        descriptor, self._descriptor = self._descriptor, None
        found, self._socket = self._socket, None
        waiting = descriptor is not None and found is None and _waiting_in(descriptor) > 0
        self._unsent, self._connecting = b"", False
        if found is not None:
            found.close()
        elif descriptor is not None:
            # What waits in a line that is gone would hold the closing up, for seconds.
            if waiting:
                with contextlib.suppress(termios.error):
                    termios.tcflush(descriptor, termios.TCOFLUSH)
            os.close(descriptor)


def _waiting_in(descriptor: int) -> int:
    """Bytes that a serial line has not sent yet."""
    try:
        (count,) = struct.unpack("i", fcntl.ioctl(descriptor, termios.TIOCOUTQ, bytes(4)))
    except OSError:
        return 0
    return int(count)


def _set_raw(descriptor: int, speed: int) -> None:
    """Make the line give and take bytes as they are, for this program alone. Raises OSError."""
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise OSError(errno.EBUSY, "another program has it") from None
    try:
        attributes = termios.tcgetattr(descriptor)
        attributes[0:4] = [0, 0, termios.CS8 | termios.CREAD | termios.CLOCAL, 0]
        attributes[4:6] = [speed, speed]
        attributes[6][termios.VMIN], attributes[6][termios.VTIME] = 1, 0
        termios.tcsetattr(descriptor, termios.TCSANOW, attributes)
        termios.tcflush(descriptor, termios.TCIOFLUSH)
    except termios.error as failure:
        if failure.args[0] == errno.ENOTTY:
            raise OSError(errno.ENOTTY, "it is no serial port") from None
        raise OSError(*failure.args) from None


def _lost(failure: OSError) -> str:
    return "it was unplugged" if failure.errno in (errno.EIO, errno.ENODEV, errno.ENXIO) else _words(failure)


def _words(failure: OSError) -> str:
    """Why a port cannot be opened, and what to do."""
    match failure.errno:
        case errno.ENOENT | errno.ENXIO | errno.ENODEV if failure.strerror == os.strerror(failure.errno):
            return "there is no such device: is it plugged in?"
        case errno.EACCES | errno.EPERM:
            return "no permission: add the user to the group that owns it (dialout, input), and log in again"
        case errno.ECONNRESET | errno.EPIPE:
            return "it closed the connection"
        case errno.EBUSY:
            return "another program has it open"
        case errno.ECONNREFUSED:
            return "nothing listens there"
        case errno.EHOSTUNREACH | errno.ENETUNREACH:
            return "there is no way to that address: is its cable plugged in?"
        case _:
            return failure.strerror or str(failure)
