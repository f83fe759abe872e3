"""For every test: asyncio's debug mode, where it is not slow, and an error where the program blocks the event loop."""

from __future__ import annotations

import asyncio.constants
import faulthandler
import gc
import logging
import os
import sys
import traceback
from collections.abc import Iterator
from itertools import islice
from types import FrameType

import pytest
from _pytest.faulthandler import fault_handler_stderr_fd_key
from blockbuster import blockbuster_ctx
from hypothesis import is_hypothesis_test, settings

from app.robots.simulated.gl import gl_environment
from tests.examples_share import fewer

for name, value in gl_environment().items():
    os.environ.setdefault(name, value)  # before anything imports mujoco, which reads it then

#: So many new objects, of which none is garbage yet, are made before some are looked for.
GARBAGE_AFTER = 20_000

#: So many frames, the innermost, are kept of where a callback, task or future was made, which debug mode notes.
NOTED_FRAMES = 5
asyncio.constants.DEBUG_STACK_DEPTH = NOTED_FRAMES  # type: ignore[misc]  # a constant of asyncio alone
_walk_stack = traceback.walk_stack


def _walk_noted(f: FrameType | None) -> Iterator[tuple[FrameType, int]]:
    """The stack from ``f`` on; little of it for a future, which notes that of the function that makes it.

    Futures note the whole stack with its lines of source, and pytest's own frames are some fifty: most of the time of
    debug mode.
    """
    walked = _walk_stack(f)
    return islice(walked, NOTED_FRAMES) if f is sys._getframe(2) else walked


traceback.walk_stack = _walk_noted

# No deadline: on a shared computer a slow example says nothing about the program.
settings.register_profile("house", deadline=None, max_examples=fewer(100))
settings.load_profile("house")


def pytest_configure(config: pytest.Config) -> None:
    """Settle what of this computer tests must not depend on."""
    # What was measured on this computer must not decide what attention selects in a test.
    os.environ["HBBA_HOST"] = "the-tests"
    config.addinivalue_line("markers", "blocking(reason): this test may block the event loop, and says why")


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Files with slow tests first: where processes share the files, none is left with a long one in the end."""
    _try_fewer_examples(items)
    long = {item.path for item in items if item.get_closest_marker("slow") is not None}
    items.sort(key=lambda item: item.path not in long)


def _try_fewer_examples(items: list[pytest.Item]) -> None:
    """The share of examples also for tests that say how many they want; hypothesis has no other door to those."""
    tests = {item.obj for item in items if isinstance(item, pytest.Function) and is_hypothesis_test(item.obj)}
    for test in tests:
        own: settings | None = getattr(test, "_hypothesis_internal_use_settings", None)
        if own is not None and own.max_examples != settings.default.max_examples:
            test._hypothesis_internal_use_settings = settings(own, max_examples=fewer(own.max_examples))


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Iterator[None]:
    """Leave libraries, test files and tests, more than a million objects, out of all collections of garbage.

    With these, and as often as Python's own threshold of 700 new objects starts one, they took a quarter of the time.
    """
    gc.disable()
    collected = yield
    gc.collect()
    gc.freeze()
    gc.set_threshold(GARBAGE_AFTER)
    gc.enable()
    return collected


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """asyncio's debug mode for every loop made from here on, virtual ones included; but not in slow tests.

    It notes where each callback comes from, which takes a third of the time of those that replay a log or run a world.
    """
    os.environ["PYTHONASYNCIODEBUG"] = "1" if item.get_closest_marker("slow") is None else ""


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_teardown(item: pytest.Item) -> Iterator[None]:
    """A teardown that hangs ends the process, too: pytest cancels its own deadline when a test has failed."""
    limit_s = float(item.config.getini("faulthandler_timeout"))
    faulthandler.dump_traceback_later(limit_s, exit=True, file=item.config.stash[fault_handler_stderr_fd_key])
    return (yield)


@pytest.fixture(autouse=True)
def _nothing_blocks_the_loop(request: pytest.FixtureRequest) -> Iterator[None]:
    """A call of ours that blocks the event loop (sleep, file, socket, lock) raises BlockingError."""
    if request.node.get_closest_marker("blocking") is not None:
        yield
        return
    with blockbuster_ctx(scanned_modules="app"):
        yield


@pytest.fixture(autouse=True)
def _logs_are_left_as_found() -> Iterator[None]:
    """A command run within the tests sends all logs to its own stream, which is closed when later tests log."""
    root = logging.getLogger()
    handlers, level = root.handlers[:], root.level
    yield
    root.handlers[:] = handlers
    root.setLevel(level)
