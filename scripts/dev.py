"""Everything behind ``make``: set-up on a fresh machine, then run, test, lint or measure. Standard library only.

Each step is skipped when a stamp says that its sources have not changed, so that a second ``make run`` starts at once.
"""

from __future__ import annotations

import argparse
import contextlib
import ctypes.util
import hashlib
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

if sys.version_info < (3, 11):
    sys.exit(
        f"HBBA needs Python 3.11 or newer, and {sys.executable} is {sys.version.split()[0]}: make PYTHON=python3.12"
    )

import alongside
import installing
import locking
import page
import ros_environment
import suite
from parts import Parts, processor_s

ROOT = page.ROOT
VENV = ROOT / ".venv"
STAMP = VENV / "installed.json"
PYTHON = VENV / "bin" / "python"
MESA_DRIVERS = ("*/dri/swrast_dri.so", "*/libgallium-*.so", "dri/swrast_dri.so", "libgallium-*.so")
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


class SetupFailed(Exception):
    """Set-up cannot go on; the message is one sentence that says what to do."""


def main() -> int:
    """Do what the Makefile's target asks for."""
    parser = argparse.ArgumentParser(prog="scripts/dev.py", description=__doc__)
    tasks = ["setup", "run", "test", "test-others", "check-sources", "lint", "lint-page", "lock", "docs", "types"]
    parser.add_argument("task", choices=[*tasks, "soak", "bench", "references", "clean"])
    parser.add_argument("arguments", nargs=argparse.REMAINDER, help="handed on to hbba run, pytest or the benchmarks")
    args = parser.parse_args()
    os.chdir(ROOT)
    keep_bytecode()
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
            return run([PYTHON, ROOT / "scripts" / "documentation.py"])
        if args.task == "soak":
            set_up({"test"}, page_wanted=False, debian=True)
            os.environ["HBBA_SOAK_MINUTES"] = args.arguments[0] if args.arguments else "45"
            return run([PYTHON, "-m", "pytest", "-s", "tests/test_memory.py"])
        if args.task == "references":
            set_up({"test"}, page_wanted=False)
            return run([PYTHON, ROOT / "scripts" / "references.py", *args.arguments])
        if args.task == "types":
            set_up({"test"}, page_wanted=False)
            scripts = ("page_types.py", "client_types.py", "typescript_client.py")
            return max(run([PYTHON, ROOT / "scripts" / name]) for name in scripts)
        if args.task == "bench":
            set_up({"test", "bench"}, debian=True)
            return run([PYTHON, "-m", "benchmarks", *args.arguments])
        if args.task == "check-sources":
            return check_sources()
        if args.task == "test-others":
            return test_others()
        return test(args.arguments)
    except SetupFailed as failure:
        sys.stderr.write(f"\n{failure}\n")
        return 1
    except KeyboardInterrupt:
        return 130


def keep_bytecode() -> None:
    """Have all that is started keep its bytecode, in ``.venv`` where the environment wants none beside the sources.

    Packages are installed without it: each start of the program would compile three thousand files again, which takes
    longer than the start itself, and the tests start it some fifty times.
    """
    if os.environ.pop("PYTHONDONTWRITEBYTECODE", ""):
        os.environ.setdefault("PYTHONPYCACHEPREFIX", str(VENV / "bytecode"))


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
        make_environment()
    with ThreadPoolExecutor(2) as beside:
        node = page.find_node() if page_wanted else None
        built = beside.submit(timed("page")(build_page), node) if node is not None else None
        debian_packages = timed("Debian's packages")(install_debian_packages)
        packages = beside.submit(debian_packages, browser=browser) if debian else None
        with timed("Python packages"):
            install(extras)
        with timed("kernels"):
            compile_kernels()
        try:
            if built is not None:
                built.result()
            elif page_wanted:
                with timed("page"):
                    build_page(None)
        except page.PageFailed as failure:
            sys.stderr.write(f"\nThe operator page is not built, the console will serve a plain one. {failure}\n\n")
        if packages is not None:
            packages.result()


def make_environment() -> None:
    """Create ``.venv``; one that was made elsewhere or by another Python is replaced."""
    stamp = read_stamp()
    if stamp and (stamp["root"], stamp["python"]) != (str(ROOT), sys.version):
        shutil.rmtree(VENV)
    if PYTHON.is_file():
        return
    say("creating .venv")
    made = subprocess.run(
        [sys.executable, "-m", "venv", "--clear", str(VENV)], capture_output=True, text=True, check=False
    )
    if made.returncode:
        shutil.rmtree(VENV, ignore_errors=True)
        if "ensurepip" in made.stdout + made.stderr:
            raise SetupFailed("Python's venv module is missing: as root, apt-get install python3-venv, then try again.")
        raise SetupFailed(f"The virtual environment .venv cannot be created: {(made.stdout + made.stderr).strip()}")


def install(extras: set[str]) -> None:
    """Install the project, editable, with ``extras``, unless it is installed as pyproject.toml asks for now."""
    digest = hashlib.sha256()
    locks = sorted(path.relative_to(ROOT) for path in ROOT.glob("requirements/*.lock"))
    for name in (Path("pyproject.toml"), Path("hatch_build.py"), *locks):
        digest.update((ROOT / name).read_bytes())
    wanted = digest.hexdigest()
    stamp = read_stamp()
    installed = set(stamp["extras"]) if stamp else set()
    if stamp and stamp["hash"] == wanted and extras <= installed:
        return
    extras = extras | installed
    say("installing Python packages (a minute or two the first time)")
    target = f".[{','.join(sorted(extras))}]" if extras else "."
    options = ["--no-build-isolation"] if install_locked(extras) else []
    try:
        # After the locks only the project itself is left, and what pyproject.toml asks for since they were made.
        installing.install(PYTHON, *options, "-e", target, title="Python packages", environment={"HBBA_SKIP_WEB": "1"})
    except installing.PipFailed as failure:
        raise SetupFailed(str(failure)) from None
    content = {"hash": wanted, "extras": sorted(extras), "root": str(ROOT), "python": sys.version}
    STAMP.write_text(json.dumps(content), encoding="utf-8")


def install_locked(extras: set[str]) -> bool:
    """Install what the locks name for ``extras``; False where they are not for this computer or its package index."""
    needs = ["build", "run", *sorted(extras)]
    if (other := installing.not_covered()) is not None:
        say(f"the locked versions are not for {other}: installing what pyproject.toml allows")
        return False
    try:
        installing.install_locked(PYTHON, ROOT, needs, title="Python packages")
    except installing.NotAsLocked:
        say("the package index serves other files than the locked ones: installing what pyproject.toml allows")
        return False
    except installing.PipFailed as failure:
        raise SetupFailed(str(failure)) from None
    return True


def lock(arguments: list[str]) -> int:
    """Renew ``requirements/*.lock``."""
    make_environment()
    try:
        installing.install(PYTHON, locking.UV_REQUIREMENT, title="uv")
    except installing.PipFailed as failure:
        raise SetupFailed(str(failure)) from None
    say("resolving all packages for all platforms")
    return locking.main(VENV / "bin" / "uv", ROOT, arguments)


def compile_kernels() -> None:
    """Compile the numerical kernels unless the cache holds their present version."""
    asked = [PYTHON, "-c", "import sys; from app.base import compiled; sys.exit(0 if compiled.is_ready() else 1)"]
    if run(asked) == 0:
        return
    say("compiling the numerical kernels (a minute the first time)")
    if run([PYTHON, "-m", "app.base.compiled"]):
        raise SetupFailed("The numerical kernels could not be compiled: see the error above.")


def build_page(node: page.Node | None) -> None:
    """Build the page unless it is current, with one from PyPI where there is no ``node``. Raises PageFailed."""
    if page.is_current():
        return
    node = node or node_or_install()
    say("building the operator page")
    page.build(node)


def node_or_install() -> page.Node:
    """The machine's Node, or one from PyPI put into ``.venv``. Raises PageFailed."""
    site_packages = next((VENV / "lib").glob("python3*/site-packages"))
    node = page.find_node(site_packages)
    if node is None:
        say("installing Node from PyPI")
        with contextlib.suppress(installing.PipFailed):  # what to do about it is said below
            installing.install(PYTHON, page.NODE_REQUIREMENT, title="Node")
        node = page.find_node(site_packages)
    if node is None:
        raise page.PageFailed("Install Node 20.19 or newer with npm (nodejs.org), then try again.")
    return node


def install_debian_packages(*, browser: bool = True) -> None:
    """Mesa for the simulated camera and, for tests, a ``browser``: installed where we may, else named.

    The other browser and its display are not in every distribution: they are installed by themselves.
    """
    sys.path.insert(0, str(ROOT))
    from app.commands.doctor import find_chromium  # needs the standard library alone

    missing: dict[str, str] = {}
    if browser and find_chromium() is None:
        missing["chromium"] = "the browser tests"
    if ctypes.util.find_library("EGL") is None:
        missing["libegl1"] = "the simulated camera"
    if not any(any(Path("/usr").glob(f"lib*/{name}")) for name in MESA_DRIVERS) and not Path("/dev/nvidiactl").exists():
        missing["libgl1-mesa-dri"] = "the simulated camera"
    others: dict[str, str] = {}
    if browser and not (shutil.which("firefox-esr") or shutil.which("firefox")):
        others["firefox-esr"] = "the browser tests in Firefox"
    if browser and not shutil.which("Xvfb"):
        others["xvfb"] = "the browser tests in Firefox"
    if not missing and not others:
        return
    if os.geteuid() == 0 and shutil.which("apt-get"):
        apt_get("update")
        missing, others = install_of_debian(missing), install_of_debian(others)
    wanting = "the tests that need them are skipped" if browser else "the simulated robot does not start"
    for lacking in (missing, others):
        if lacking:
            sys.stderr.write(
                f"\nMissing for {' and '.join(sorted(set(lacking.values())))}: as root, apt-get install"
                f" {' '.join(lacking)} (without, {wanting}).\n\n"
            )


def install_of_debian(packages: dict[str, str]) -> dict[str, str]:
    """Install Debian's ``packages``, by name; what is missing then."""
    if not packages:
        return {}
    say(f"installing {' '.join(packages)}")
    return {} if apt_get("install", "-y", "--no-install-recommends", *packages) == 0 else packages


def apt_get(*arguments: str) -> int:
    """Run ``apt-get`` in silence; its status."""
    return subprocess.run(
        ["apt-get", "-qq", "-o", "Dpkg::Use-Pty=0", *arguments],
        env={**os.environ, "DEBIAN_FRONTEND": "noninteractive"},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        check=False,
    ).returncode


def read_stamp() -> dict[str, Any] | None:
    """The stamp of the last installation, or None."""
    try:
        stamp: dict[str, Any] | None = json.loads(STAMP.read_text(encoding="utf-8")) if PYTHON.is_file() else None
    except (OSError, ValueError):
        return None
    return stamp


# --- Tasks -------------------------------------------------------------------------------------------------------


def run_hbba(arguments: list[str]) -> None:
    """Become ``hbba run``, so that signals reach it directly."""
    hbba = VENV / "bin" / "hbba"
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
    ros = None if arguments else set_up_ros(parts)
    say(f"set-up took {time.monotonic() - began:.0f} s: {parts}")
    os.environ.update(dict.fromkeys(suite.SINGLE, "1"))
    if arguments:
        return run([PYTHON, "-m", "pytest", *arguments])
    os.environ.setdefault(suite.EXAMPLES, suite.SHARE)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # so that nothing of ours goes on without us
    with (
        alongside.alongside([*suite.GIVING_WAY, PYTHON, __file__, "check-sources"]) as sources,
        alongside.alongside([PYTHON, __file__, "test-others"]) as others,
    ):
        say("running tests that run against the clock; beside them lint, the page's tests and all others")
        parts = Parts()
        hurried = test_against_the_clock(ros, parts)
        say("lint and the page's tests:")
        checked = sources.show()
        say("the others, while they go on:" if others.running() else "the others:")
        tested = others.show()
        parts.note("lint and the page's tests", sources.took_s())
        parts.note("all other tests", others.took_s())
    say(f"side by side: {parts}")
    for what, status in (
        ("lint or the page's tests", checked),
        ("tests against the clock", hurried),
    ):
        if status:
            say(f"{what}: failed, see above")
    say(f"everything took {time.monotonic() - began:.0f} s, of {os.cpu_count()} processors {processor_s():.0f} s")
    return hurried or tested or checked


def set_up_ros(parts: Parts) -> Path | None:
    """Make the environment of the tests that need ROS 2; None where its wheels are not for this computer."""
    try:
        with parts.timed("ROS 2"):
            return ros_environment.python_with_ros(PYTHON, ROOT, VENV / "ros2")
    except installing.PipFailed as failure:
        raise SetupFailed(str(failure)) from None


def test_against_the_clock(ros: Path | None, parts: Parts) -> int:
    """The hurried tests, then those that need ROS 2, timed in ``parts``.

    ``ros``: the interpreter that has ROS 2; None: the wheels are not for this computer.
    """
    with parts.timed("tests against the clock"):
        status = run(suite.hurried(PYTHON))
    driven = 0
    if ros is not None:
        with parts.timed("robots over ROS 2"):
            driven = run([ros, "-m", "pytest", "-p", "no:cacheprovider", *ros_environment.TESTS])
    return status or driven


def test_others() -> int:
    """All patient tests, then the rest of those against the clock."""
    parts = Parts()
    with parts.timed("patient tests"):
        status = run(suite.patient(PYTHON, min(os.cpu_count() or 1, 4)))
    with parts.timed("the rest against the clock"):
        rest = run(suite.afterwards(PYTHON))
    say(f"the others took: {parts}")
    return status or rest


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
        node = node_or_install()
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
        shutil.rmtree(ROOT / name, ignore_errors=True)
    for folder in ROOT.rglob("__pycache__"):
        shutil.rmtree(folder, ignore_errors=True)
    return 0


def first_failure(parts: Parts, commands: list[list[str]]) -> int:
    """Run all ``commands`` of the environment, each a part of ``parts``; the status of the first that failed, or 0."""
    statuses = []
    for name, *arguments in commands:
        what = " ".join(word for word in (name, *arguments) if word[0] not in "-.")
        say(f"running {what}")
        with parts.timed(what):
            statuses.append(run([VENV / "bin" / name, *arguments]))
    return next((status for status in statuses if status), 0)


def run(command: list[object]) -> int:
    """Run ``command`` with our output as its own."""
    return subprocess.run([str(word) for word in command], stdin=subprocess.DEVNULL, check=False).returncode


def say(text: str) -> None:
    """Print one line of progress."""
    over = "\r\x1b[K" if sys.stdout.isatty() else ""  # pip's progress, which goes on below
    sys.stdout.write(f"{over}hbba: {text}\n")
    sys.stdout.flush()


if __name__ == "__main__":
    sys.exit(main())
