"""The environment in ``.venv``: made, filled with what the project asks for, its kernels and the page built by it.

Each step is skipped when a stamp says that its sources have not changed. Standard library only.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import installing
import page
from running import run, say

ROOT = page.ROOT
VENV = ROOT / ".venv"
STAMP = VENV / "installed.json"
PYTHON = VENV / "bin" / "python"


class SetupFailed(Exception):
    """Set-up cannot go on; the message is one sentence that says what to do."""


def keep_bytecode() -> None:
    """Have all that is started keep its bytecode, in ``.venv`` where the environment wants none beside the sources.

    Packages are installed without it: each start of the program would compile three thousand files again, which takes
    longer than the start itself, and the tests start it some fifty times.
    """
    if os.environ.pop("PYTHONDONTWRITEBYTECODE", ""):
        os.environ.setdefault("PYTHONPYCACHEPREFIX", str(VENV / "bytecode"))


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


def read_stamp() -> dict[str, Any] | None:
    """The stamp of the last installation, or None."""
    try:
        stamp: dict[str, Any] | None = json.loads(STAMP.read_text(encoding="utf-8")) if PYTHON.is_file() else None
    except (OSError, ValueError):
        return None
    return stamp
