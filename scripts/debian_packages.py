"""Debian's packages that the robot and its tests need, installed where we may. Standard library only."""

from __future__ import annotations

import ctypes.util
import os
import shutil
import subprocess
import sys
from pathlib import Path

import page
from running import say

MESA_DRIVERS = ("*/dri/swrast_dri.so", "*/libgallium-*.so", "dri/swrast_dri.so", "libgallium-*.so")


def install(*, browser: bool = True) -> None:
    """Mesa for the simulated camera and, for tests, a ``browser``: installed where we may, else named.

    The other browser and its display are not in every distribution: they are installed by themselves.
    """
    sys.path.insert(0, str(page.ROOT))
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
        missing, others = install_those(missing), install_those(others)
    wanting = "the tests that need them are skipped" if browser else "the simulated robot does not start"
    for lacking in (missing, others):
        if lacking:
            sys.stderr.write(
                f"\nMissing for {' and '.join(sorted(set(lacking.values())))}: as root, apt-get install"
                f" {' '.join(lacking)} (without, {wanting}).\n\n"
            )


def install_those(packages: dict[str, str]) -> dict[str, str]:
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
