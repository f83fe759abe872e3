"""Numerical kernels: functions that numba compiles, once on a computer, and that run without the interpreter's lock.

A kernel has an explicit signature, so that it is compiled when its file is imported (not at its first call, while the
robot runs) and loaded from numba's cache afterwards. Files with kernels are imported late, where their functions are
first needed. ``python -m app.base.compiled`` compiles all of them; set-up does so.

A kernel calls only kernels of its own file: numba's cache does not notice a change in another file.
It copies arrays element by element: the message of ``a[k] = b`` for shapes that differ takes 4 s to compile.
Its signature says its types; its parameters and its result are not annotated again.
"""

from __future__ import annotations

import hashlib
import importlib
import os
import platform
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from functools import cache
from importlib import metadata
from multiprocessing import get_context
from pathlib import Path
from typing import Any, TypeVar, cast

from app.base.child_processes import end_with_parent, python

try:
    import fcntl
except ImportError:  # Windows: two may compile at once, which does no harm
    fcntl = None  # type: ignore[assignment]

F = TypeVar("F", bound=Callable[..., Any])

_APP = Path(__file__).resolve().parents[1]
#: Matches a file that imports :func:`kernel` itself, not just other names of this file. It works on the text: modules
#: look for kernels in several threads at once, and objects that ``ast.parse`` builds in several threads can cause a
#: SystemError.
_IMPORT = re.compile(r"^\s*from app\.base\.compiled import (?:\([^)]*|[^\n(]*)\bkernel\b", re.MULTILINE)


def kernel(signature: str | list[str], *, fastmath: bool = False, **options: Any) -> Callable[[F], F]:
    """Compile the decorated function for ``signature``, as ``"float64[:](float32[::1], int64)"``; it runs without the
    GIL. The signature says the types of the arguments, in place of annotations.

    Arrays of a signature are writable ones: pass a copy of a read-only one. ``fastmath`` ignores NaN and infinity: only
    for kernels that get neither. Further ``options`` are numba's own.
    """
    import numba

    def decorate(function: F) -> F:
        return cast(F, numba.njit(signature, cache=True, nogil=True, fastmath=fastmath, **options)(function))

    return decorate


@cache
def kernel_modules() -> tuple[str, ...]:
    """The names of all modules of this program that have kernels: it reads every file, once."""
    files = [file for file in sorted(_APP.rglob("*.py")) if file != Path(__file__).resolve() and _has_kernel(file)]
    return tuple(".".join(("app", *file.relative_to(_APP).with_suffix("").parts)) for file in files)


def is_ready() -> bool:
    """Whether the cache of this computer holds the present version of all kernels."""
    return not _missing()


def make_ready() -> None:
    """Compile, in a child process, every kernel that is not compiled yet. Blocks until it is done.

    A failure to compile is not raised here: the import of the kernel raises it.
    """
    if not is_ready():
        subprocess.run(python("-m", "app.base.compiled"), stdin=subprocess.DEVNULL, check=False)


def compile_all(say: Callable[[str], None]) -> None:
    """Compile every kernel that is not compiled yet, in as many processes as there are cores; calls ``say`` with a line
    for each finished file. Raises the exception of the first file that failed, once the others are done.

    Processes that compile at the same time take turns; the later ones find the kernels compiled.
    """
    with _alone():
        missing = {name: _digest(name) for name in _missing()}
        if not missing:
            return
        workers = min(os.cpu_count() or 1, len(missing))
        with ProcessPoolExecutor(workers, mp_context=get_context("spawn"), initializer=end_with_parent) as pool:
            jobs = {pool.submit(_compile, name): name for name in missing}
            for number, job in enumerate(as_completed(jobs), 1):
                if job.exception() is None:
                    _note(jobs[job], missing[jobs[job]])
                    say(f"compiled {jobs[job]} ({number} of {len(missing)})")
        for job in jobs:
            job.result()


def _compile(name: str) -> None:
    importlib.import_module(name)


def _missing() -> list[str]:
    noted = _noted()
    return [name for name in kernel_modules() if noted.get(name) != _digest(name)]


@contextmanager
def _alone() -> Iterator[None]:
    """Hold the lock beside the stamp, where there can be one."""
    stamp = _stamp_file()
    try:
        stamp.parent.mkdir(parents=True, exist_ok=True)
        lock = stamp.with_suffix(".lock").open("w")
    except OSError:
        yield
        return
    with lock:
        if fcntl is not None:
            fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def _noted() -> dict[str, str]:
    """Digests of what is compiled, by module."""
    try:
        lines = _stamp_file().read_text(encoding="utf-8").splitlines()
    except OSError:
        return {}
    return dict(line.split(" ", 1) for line in lines if " " in line)


def _note(name: str, digest: str) -> None:
    noted = _noted() | {name: digest}
    try:
        _stamp_file().write_text("".join(f"{n} {d}\n" for n, d in noted.items()), encoding="utf-8")
    except OSError:
        return  # nowhere to note it: numba's own cache decides whether to compile again


def _has_kernel(file: Path) -> bool:
    return _IMPORT.search(file.read_text(encoding="utf-8")) is not None


def _digest(name: str) -> str:
    """Of everything that the module's compiled code depends on."""
    digest = hashlib.sha256()
    for part in (sys.version, platform.machine(), platform.processor(), _cpu(), metadata.version("numba")):
        digest.update(part.encode())
    digest.update(_APP.parent.joinpath(*name.split(".")).with_suffix(".py").read_bytes())
    return digest.hexdigest()


@cache
def _cpu() -> str:
    import llvmlite.binding

    return str(llvmlite.binding.get_host_cpu_name())


def _stamp_file() -> Path:
    """Path of the stamp: beside the code, as numba's cache, if that folder is writable, else in the user's cache."""
    beside = _APP / "__pycache__"
    if os.access(beside if beside.is_dir() else _APP, os.W_OK):
        return beside / "kernels.sha256"
    cache = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(cache) / "hbba" / f"kernels-{hashlib.sha256(str(_APP).encode()).hexdigest()[:16]}.sha256"


def main() -> int:
    """Compile everything, saying each file on standard output."""
    end_with_parent()

    def say(text: str) -> None:
        print(f"hbba: {text}", flush=True)

    compile_all(say)
    return 0


if __name__ == "__main__":
    sys.exit(main())
