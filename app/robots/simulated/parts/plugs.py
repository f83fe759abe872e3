"""Ports that simulated parts are plugged in at: a pseudo-terminal with a name, a TCP server, a pipe of input events."""

from __future__ import annotations

import contextlib
import errno
import os
import random
import socket
import tty
from pathlib import Path
from typing import Protocol


class Plug(Protocol):
    """A port of this side: what the other end sends is read, what is sent may be lost."""

    def plug(self) -> None: ...

    def unplug(self) -> None: ...

    @property
    def descriptors(self) -> list[int]:
        """What select may wait for."""
        ...

    def read(self) -> bytes:
        """What has come, nothing where nothing has."""
        ...

    def write(self, data: bytes) -> None:
        """Send ``data``; what the other end does not take is lost."""
        ...


class Terminal:
    """A serial line: a pseudo-terminal that ``path`` names."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._ends: tuple[int, int] | None = None

    def plug(self) -> None:
        if self._ends is None:
            self._ends = os.openpty()
            tty.setraw(self._ends[1])
            os.set_blocking(self._ends[0], False)
            self._path.unlink(missing_ok=True)
            self._path.symlink_to(os.ttyname(self._ends[1]))

    def unplug(self) -> None:
        if self._ends is not None:
            self._path.unlink(missing_ok=True)
            for end in self._ends:
                os.close(end)
            self._ends = None

    @property
    def descriptors(self) -> list[int]:
        return [] if self._ends is None else [self._ends[0]]

    def read(self) -> bytes:
        if self._ends is None:
            return b""
        try:
            return os.read(self._ends[0], 4096)
        except BlockingIOError:
            return b""

    def write(self, data: bytes) -> None:
        if self._ends is not None:
            with contextlib.suppress(BlockingIOError):
                os.write(self._ends[0], data)


class Server:
    """A device in the network: one connection at a time; ``port`` 0 is any free one."""

    def __init__(self, host: str, port: int) -> None:
        self._listener = socket.create_server((host, port))
        self._listener.setblocking(False)
        self.address: tuple[str, int] = self._listener.getsockname()[:2]
        self._plugged = False
        self._connection: socket.socket | None = None

    def plug(self) -> None:
        self._plugged = True

    def unplug(self) -> None:
        self._plugged = False
        self._drop()

    @property
    def descriptors(self) -> list[int]:
        found = [self._listener.fileno()]
        return found if self._connection is None else [*found, self._connection.fileno()]

    def read(self) -> bytes:
        with contextlib.suppress(BlockingIOError):
            connection, _ = self._listener.accept()
            self._drop()
            if self._plugged:
                connection.setblocking(False)
                self._connection = connection
            else:
                connection.close()
        if self._connection is None:
            return b""
        try:
            data = self._connection.recv(4096)
        except BlockingIOError:
            return b""
        except ConnectionError:
            data = b""
        if not data:
            self._drop()
        return data

    def write(self, data: bytes) -> None:
        if self._connection is not None:
            try:
                self._connection.send(data)
            except BlockingIOError:
                pass
            except ConnectionError:
                self._drop()

    def close(self) -> None:
        """Listen no more."""
        self.unplug()
        self._listener.close()

    def _drop(self) -> None:
        if self._connection is not None:
            self._connection.close()
            self._connection = None


class Pipe:
    """A file of input events: a named pipe at ``path``."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._end: int | None = None

    def plug(self) -> None:
        if self._end is None:
            self._path.unlink(missing_ok=True)
            os.mkfifo(self._path)
            self._end = os.open(self._path, os.O_RDWR | os.O_NONBLOCK)

    def unplug(self) -> None:
        if self._end is not None:
            self._path.unlink(missing_ok=True)
            os.close(self._end)
            self._end = None

    @property
    def descriptors(self) -> list[int]:
        return []

    def read(self) -> bytes:
        return b""

    def write(self, data: bytes) -> None:
        if self._end is not None:
            with contextlib.suppress(BlockingIOError):
                os.write(self._end, data)


class Noise:
    """Damages a share of the bytes that pass."""

    def __init__(self, seed: int) -> None:
        self.share = 0.0
        self._random = random.Random(seed)

    def damaged(self, data: bytes) -> bytes:
        """``data`` as it arrives."""
        if not self.share:
            return data
        return bytes(byte ^ 0x15 if self._random.random() < self.share else byte for byte in data)


def plug_at(where: str) -> Plug:
    """The plug that ``where`` names: ``tcp://IP:PORT``, or the path of a serial line. Raises OSError."""
    if not where.startswith("tcp://"):
        return Terminal(Path(where))
    host, _, port = where.removeprefix("tcp://").rpartition(":")
    if not port.isdecimal():
        raise OSError(errno.EINVAL, f"{where}: tcp://IP:PORT")
    return Server(host.strip("[]"), int(port))
