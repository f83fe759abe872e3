"""A ring's folder: locked while its program runs, joined into one recording when it is saved or was left behind.

Folders left by a program that was killed or stopped are found by the next one (:func:`leftovers`) and become
recordings.
"""

from __future__ import annotations

import errno
import fcntl
import os
import secrets
import shutil
import socket
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

from app.logs.log import LogError
from app.logs.mcap.chunks import join, scan
from app.logs.mcap.structure import DAMAGE
from app.logs.output_file import Progress, unwatched
from app.logs.stamps import SECOND, to_ns

#: Ending of a segment's file name, and of the file with the state at its begin.
SEGMENT = ".mcap"
STATE = "-state.mcap"
_LOCK = "lock"
_NEW = ".new-"
_SAVING = ".saving-"


def leftovers(folder: Path) -> list[Path]:
    """Rings below ``folder`` (a library's ``ring_folder``) whose program is gone."""
    if not folder.is_dir():
        return []
    _sweep(folder)
    homes = (home for home in sorted(folder.iterdir()) if home.is_dir() and not home.name.startswith(_NEW))
    return [home for home in homes if _is_left(home)]


def rescue(home: Path, targets: Iterable[Path], progress: Progress = unwatched) -> Path | None:
    """Make a recording of the ring left in ``home`` and delete it; None if it holds no message or another does it.

    Raises LogError, OSError; then nothing is deleted.
    """
    with _claimed(home) as mine:
        if not mine:
            return None
        saved = None
        try:
            whole = [path for path in _segments(home) if _messages(path)]
            if whole:
                state = whole[0].with_name(whole[0].name.removesuffix(SEGMENT) + STATE)
                saved = save(state, whole, targets, progress)
        except DAMAGE as error:
            raise LogError(f"it is damaged ({error}); `hbba log repair` saves what is whole of each file") from error
        shutil.rmtree(home)
        return saved


def size_of(home: Path) -> int:
    """Bytes of the ring in ``home``."""
    return sum(path.stat().st_size for path in home.glob(f"*{SEGMENT}"))


def begin_of(home: Path) -> float:
    """When the oldest message of the ring in ``home`` arrived (robot's clock, s); 0 if there is none."""
    begins = []
    for path in _segments(home):
        with suppress(LogError, *DAMAGE), open(path, "rb") as file:
            begins.append(scan(file).begin_ns)
    return min((begin for begin in begins if begin), default=0) / SECOND


def save(state: Path, segments: list[Path], targets: Iterable[Path], progress: Progress) -> Path:
    """Join the files in the ring's folder; the result gets its name when it is complete, so that no reader sees half of
    it."""
    part = state.parent.parent / f"{_SAVING}{secrets.token_hex(4)}"
    try:
        with open(part, "xb") as file:
            with suppress(OSError):  # a file system without locks
                fcntl.flock(file, fcntl.LOCK_EX)
            join([state, *segments], file, progress)
        for target in targets:
            target.parent.mkdir(parents=True, exist_ok=True)
            with suppress(FileExistsError):
                _name(part, target)
                return target
    finally:
        part.unlink(missing_ok=True)
    raise LogError("every name is taken")


def _name(part: Path, target: Path) -> None:
    """Let the file ``part`` be found as ``target`` too. Raises FileExistsError where that is another file."""
    try:
        os.link(part, target)
    except FileExistsError:
        raise
    except OSError:  # a file system without links
        if target.exists():
            raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(target)) from None
        part.rename(target)


def _sweep(folder: Path) -> None:
    """Delete what programs that were killed while they saved had joined by then: the segments are still there."""
    for part in folder.glob(f"{_SAVING}*"):
        # Locked by its writer; on a file system without locks that is not known.
        with suppress(OSError), open(part, "rb") as file:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
            part.unlink()


def make_home(folder: Path, at: float) -> tuple[Path, IO[bytes]]:
    """A new folder with its lock. It is locked before it gets its name, so that no program takes it for a leftover."""
    folder.mkdir(parents=True, exist_ok=True)
    fresh = Path(tempfile.mkdtemp(prefix=_NEW, dir=folder))
    lock = open(fresh / _LOCK, "xb")  # noqa: SIM115  # closed with the ring
    lock.write(_owner(os.getpid()))
    lock.flush()
    with suppress(OSError):  # a file system without locks
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    home = folder / f"{to_ns(at)}-{fresh.name.removeprefix(_NEW)}"
    fresh.rename(home)
    return home, lock


def _is_left(home: Path) -> bool:
    with _claimed(home) as mine:
        return mine


@contextmanager
def _claimed(home: Path) -> Iterator[bool]:
    """Hold the lock of the ring in ``home`` meanwhile; False if a running program holds it, or the ring is gone."""
    try:
        lock = open(home / _LOCK, "rb")  # noqa: SIM115  # closed below
    except OSError:
        yield home.is_dir()  # its lock was deleted, which nothing of ours does
        return
    with lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            yield False
        except OSError:  # a file system without locks
            yield _is_gone(lock.read())
        else:
            yield home.is_dir()  # the former holder may have deleted it


def _owner(pid: int) -> bytes:
    """The process that writes a ring; says on a file system without locks whether it still runs."""
    return f"{pid} {socket.gethostname()}".encode()


def _is_gone(owner: bytes) -> bool:
    """Whether the program ``owner`` is known to have ended; of another computer's, nothing is known."""
    pid = owner.partition(b" ")[0].decode()
    if not pid.isdecimal() or owner != _owner(int(pid)):
        return False
    try:
        os.kill(int(pid), 0)
    except ProcessLookupError:
        return True
    except OSError:  # it is another user's
        return False
    return False


def _segments(home: Path) -> list[Path]:
    return sorted(path for path in home.glob(f"*{SEGMENT}") if not path.name.endswith(STATE))


def _messages(path: Path) -> int:
    try:
        with open(path, "rb") as file:
            return scan(file).messages
    except LogError:
        return 0
