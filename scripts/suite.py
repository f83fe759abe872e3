"""Which tests run when: three commands side by side, so that two cores are busy throughout. Standard library only."""

from __future__ import annotations

from pathlib import Path

#: Prefix of a command with lower priority: tests in virtual time leave the processor to those against the clock.
GIVING_WAY = ("nice", "-n", "3")

#: Libraries of linear algebra compute in the calling thread, as in the program: theirs spin while they wait, at the
#: cost of the tests beside. Read when numpy is loaded, which a plugin of pytest does before any file of ours.
SINGLE = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")

#: The share of the examples that each property is tried on (tests/conftest.py): in each run others, so that many runs
#: try many. All of them, and more: HBBA_EXAMPLES=3 make test.
EXAMPLES, SHARE = "HBBA_EXAMPLES", "0.3"

#: Tests of the page in a real browser: one after another from the beginning, as the longest. They share a robot.
BROWSER = ("tests/browser",)

#: Other tests against the clock. They wait for most of their time, and go beside those of the browser.
HURRIED = (
    "tests/commands/test_body_options.py",
    "tests/commands/test_run.py",
    "tests/console/live/test_late_commands.py",
    "tests/console/live/test_lost_body.py",
    "tests/console/test_playback.py",
    "tests/console/test_replays.py",
    "tests/console/test_without_driving.py",
    "tests/experiments/overload",
    "tests/logs/replay/test_playback.py",
    "tests/modules/recording",
    "tests/program/test_system.py",
    "tests/remote/test_nodes.py",
    "tests/robots/devices",
    "tests/robots/replayed",
    "tests/robots/ros2/rosbridge",
    "tests/robots/simulated/acoustics/test_link_sound.py",
    "tests/robots/simulated/test_guard_for_real.py",
    "tests/robots/simulated/test_link.py",
    "tests/runtime/test_clock.py",
    "tests/runtime/test_load.py",
    "tests/runtime/test_realtime.py",
    "tests/runtime/test_watchdog.py",
)


def browser(python: Path) -> list[object]:
    """The command for :data:`BROWSER`."""
    return [python, "-m", "pytest", *BROWSER]


def hurried(python: Path) -> list[object]:
    """The command for :data:`HURRIED`."""
    return [python, "-m", "pytest", "-p", "no:cacheprovider", *HURRIED]


def patient(python: Path, workers: int) -> list[object]:
    """The command for all tests that leave the processor to others, in so many processes."""
    # Files go to processes in the order that tests/conftest.py puts them in.
    by_file = ["-n", workers, "--dist", "loadfile", "--no-loadscope-reorder", "-p", "no:cacheprovider"]
    others = [f"--ignore={room}" for room in (*BROWSER, *HURRIED)]
    return [*GIVING_WAY, python, "-m", "pytest", *by_file, *others, "tests"]
