"""Everything behind ``make``: set-up on a fresh machine, then run, test, lint or measure. Standard library only.

Each step is skipped when a stamp says that its sources have not changed, so that a second ``make run`` starts at once.
"""

from __future__ import annotations

import argparse
import os
import shutil
import signal
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path

if sys.version_info < (3, 11):
    sys.exit(
        f"HBBA needs Python 3.11 or newer, and {sys.executable} is {sys.version.split()[0]}: make PYTHON=python3.12"
    )

import alongside
import debian_packages
import environment
import installing
import locking
import page
import ros_environment
import suite
from parts import Parts, processor_s
from running import run, say

JUNK = [
    ".venv",
    "web/node_modules",
    "app/console/static",
    "build",
    "dist",
    ".pytest_cache",
    ".mypy_cache",
    ".ruff_cache",
    ".hypothesis",
    ".import_linter_cache",
]


def main() -> int:
    """Do what the Makefile's target asks for."""
    parser = argparse.ArgumentParser(prog="scripts/dev.py", description=__doc__)
    tasks = ["setup", "run", "test", "test-hurried", "check-sources", "lint", "lint-page", "lock", "docs", "types"]
    parser.add_argument("task", choices=[*tasks, "soak", "bench", "references", "clean"])
    parser.add_argument("arguments", nargs=argparse.REMAINDER, help="handed on to hbba run, pytest or the benchmarks")
    args = parser.parse_args()
    os.chdir(environment.ROOT)
    environment.keep_bytecode()
    try:
        if args.task == "clean":
            return clean()
        if args.task == "run":
            set_up({"speech", "video"}, debian=True, browser=False)
            run_hbba(args.arguments)
        if args.task == "setup":
            set_up({"test", "docs"})
            return 0
        if args.task == "lint":
            set_up({"test"}, page_wanted=False)
            return lint()
        if args.task == "lint-page":
            return lint_page()
        if args.task == "lock":
            return lock(args.arguments)
        if args.task == "docs":
            set_up({"docs"}, page_wanted=False)
            return run([environment.PYTHON, environment.ROOT / "scripts" / "documentation.py"])
        if args.task == "soak":
            set_up({"test"}, page_wanted=False, debian=True)
            os.environ["HBBA_SOAK_MINUTES"] = args.arguments[0] if args.arguments else "45"
            return run([environment.PYTHON, "-m", "pytest", "-s", "tests/test_memory.py"])
        if args.task == "references":
            set_up({"test"}, page_wanted=False)
            return run([environment.PYTHON, environment.ROOT / "scripts" / "references.py", *args.arguments])
        if args.task == "types":
            set_up({"test"}, page_wanted=False)
            scripts = ("page_types.py", "client_types.py", "typescript_client.py")
            return max(run([environment.PYTHON, environment.ROOT / "scripts" / name]) for name in scripts)
        if args.task == "bench":
            set_up({"test", "bench"}, debian=True)
            return run([environment.PYTHON, "-m", "benchmarks", *args.arguments])
        if args.task == "check-sources":
            return check_sources()
        if args.task == "test-hurried":
            return test_hurried()
        return test(args.arguments)
    except environment.SetupFailed as failure:
        sys.stderr.write(f"\n{failure}\n")
        return 1
    except KeyboardInterrupt:
        return 130


# --- Set-up ------------------------------------------------------------------------------------------------------


def set_up(
    extras: set[str],
    *,
    page_wanted: bool = True,
    debian: bool = False,
    browser: bool = True,
    parts: Parts | None = None,
) -> None:
    """Set up the virtual environment with ``extras``, the compiled kernels and, if wanted, the page and Debian's
    packages.

    ``browser``: also the Debian package of the browser for tests. Steps independent of the environment run in parallel.
    ``parts`` gets the time of each.
    """
    timed = (parts or Parts()).timed
    with timed("environment"):
        environment.make_environment()
    with ThreadPoolExecutor(2) as beside:
        node = page.find_node() if page_wanted else None
        built = beside.submit(timed("page")(environment.build_page), node) if node is not None else None
        install_debian = timed("Debian's packages")(debian_packages.install)
        packages = beside.submit(install_debian, browser=browser) if debian else None
        with timed("Python packages"):
            environment.install(extras)
        with timed("kernels"):
            environment.compile_kernels()
        try:
            if built is not None:
                built.result()
            elif page_wanted:
                with timed("page"):
                    environment.build_page(None)
        except page.PageFailed as failure:
            sys.stderr.write(f"\nThe operator page is not built, the console will serve a plain one. {failure}\n\n")
        if packages is not None:
            packages.result()


def lock(arguments: list[str]) -> int:
    """Renew ``requirements/*.lock``."""
    environment.make_environment()
    try:
        installing.install(environment.PYTHON, locking.UV_REQUIREMENT, title="uv")
    except installing.PipFailed as failure:
        raise environment.SetupFailed(str(failure)) from None
    say("resolving all packages for all platforms")
    return locking.main(environment.VENV / "bin" / "uv", environment.ROOT, arguments)


# --- Tasks -------------------------------------------------------------------------------------------------------


def run_hbba(arguments: list[str]) -> None:
    """Become ``hbba run``, so that signals reach it directly."""
    hbba = environment.VENV / "bin" / "hbba"
    os.execv(hbba, [str(hbba), "run", *arguments])


def lint() -> int:
    """Everything that reads the sources without running them."""
    parts = Parts()
    status = first_failure(
        parts,
        [
            ["ruff", "check", "--quiet", "--output-format=concise", "."],
            ["ruff", "format", "--quiet", "--output-format=concise", "--check", "."],
            ["mypy", "--no-error-summary"],
            ["lint-imports", "--no-logo"],
            ["python", "scripts/words.py", "--quiet"],
        ],
    )
    with parts.timed("the page's sources"):
        page_status = lint_page()
    say(f"lint took: {parts}")
    return page_status or status


def lint_page() -> int:
    """The same for the page's sources."""
    say("running biome and tsc on the page")
    return web_script("lint", "check")


def test(arguments: list[str]) -> int:
    """Set up, lint, the page's own tests, and pytest."""
    began, parts = time.monotonic(), Parts()
    set_up({"test", "docs"}, debian=True, parts=parts)
    say(f"set-up took {time.monotonic() - began:.0f} s: {parts}")
    os.environ.update(dict.fromkeys(suite.SINGLE, "1"))
    if arguments:
        return run([environment.PYTHON, "-m", "pytest", *arguments])
    os.environ.setdefault(suite.EXAMPLES, suite.SHARE)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # so that nothing of ours goes on without us
    workers = min(os.cpu_count() or 1, 4)
    parts, statuses = Parts(), dict[str, int]()
    with ExitStack() as ends:
        beside = {
            what: ends.enter_context(alongside.alongside(command))
            for what, command in {
                "lint and the page's tests": [*suite.GIVING_WAY, environment.PYTHON, __file__, "check-sources"],
                "other tests against the clock": [environment.PYTHON, __file__, "test-hurried"],
                "patient tests": suite.patient(environment.PYTHON, workers),
            }.items()
        }
        say(f"running the browser's tests; beside them {', '.join(beside)}")
        with parts.timed("the browser's tests"):
            statuses["the browser's tests"] = run(suite.browser(environment.PYTHON))
        for what, command in beside.items():
            say(f"{what}{', while they go on' if command.running() else ''}:")
            statuses[what] = command.show()
            parts.note(what, command.took_s())
    say(f"side by side: {parts}")
    for what, status in statuses.items():
        if status:
            say(f"{what}: failed, see above")
    say(f"everything took {time.monotonic() - began:.0f} s, of {os.cpu_count()} processors {processor_s():.0f} s")
    return next((status for status in statuses.values() if status), 0)


def test_hurried() -> int:
    """The tests against the clock that need no browser, then those of robots over ROS 2, where its wheels are."""
    parts = Parts()
    with parts.timed("tests against the clock"):
        status = run(suite.hurried(environment.PYTHON))
    driven, ros = 0, set_up_ros(parts)
    if ros is not None:
        with parts.timed("robots over ROS 2"):
            driven = run([ros, "-m", "pytest", "-p", "no:cacheprovider", *ros_environment.TESTS])
    say(f"took: {parts}")
    return status or driven


def set_up_ros(parts: Parts) -> Path | None:
    """Make the environment of the tests that need ROS 2; None where its wheels are not for this computer."""
    try:
        with parts.timed("ROS 2"):
            return ros_environment.python_with_ros(environment.PYTHON, environment.ROOT, environment.VENV / "ros2")
    except installing.PipFailed as failure:
        raise environment.SetupFailed(str(failure)) from None


def check_sources() -> int:
    """Lint, and the page's own tests."""
    status = lint()
    parts = Parts()
    with parts.timed("the page's tests"):
        web_status = web_tests()
    say(f"took: {parts}")
    return web_status or status


def web_tests() -> int:
    """The page's unit tests."""
    say("running the page's tests")
    return web_script("test")


def web_script(*scripts: str) -> int:
    """Run ``scripts`` of ``web/package.json`` one after another; 0, or 1 if one failed, which says why."""
    try:
        node = environment.node_or_install()
        page.install_packages(node)
        output = "".join(page.run_npm(node, "run", script) for script in scripts)
    except page.PageFailed as failure:
        sys.stderr.write(f"{failure}\n")
        return 1
    sys.stdout.writelines(f"{line}\n" for line in output.splitlines() if " passed " in line)
    return 0


def clean() -> int:
    """Remove everything that can be made again."""
    for name in JUNK:
        shutil.rmtree(environment.ROOT / name, ignore_errors=True)
    for folder in environment.ROOT.rglob("__pycache__"):
        shutil.rmtree(folder, ignore_errors=True)
    return 0


def first_failure(parts: Parts, commands: list[list[str]]) -> int:
    """Run all ``commands`` of the environment, each a part of ``parts``; the status of the first that failed, or 0."""
    statuses = []
    for name, *arguments in commands:
        what = " ".join(word for word in (name, *arguments) if word[0] not in "-.")
        say(f"running {what}")
        with parts.timed(what):
            statuses.append(run([environment.VENV / "bin" / name, *arguments]))
    return next((status for status in statuses if status), 0)


if __name__ == "__main__":
    sys.exit(main())
