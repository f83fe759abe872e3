"""What the simulated camera needs of the computer: an EGL library to draw with, no screen and no graphics card."""

from __future__ import annotations

import ctypes
import os
import sys

MISSING_EGL = (
    "The simulated camera needs the EGL library, which is missing: install `libegl1` and `libgl1-mesa-dri` "
    "(Debian, Ubuntu: `sudo apt install libegl1 libgl1-mesa-dri`) or `mesa-libEGL` (Fedora)."
)


def gl_environment() -> dict[str, str]:
    """The environment variables the link's process is started with, so that it draws without a screen."""
    environment = {"MUJOCO_GL": os.environ.get("MUJOCO_GL", "egl" if sys.platform == "linux" else "")}
    # One rasterizer thread: a second one saves 3 ms per picture and costs more CPU than it saves
    environment["LP_NUM_THREADS"] = os.environ.get("LP_NUM_THREADS", "0")
    return environment


def check_gl() -> str | None:
    """None if the simulated camera can draw here, else one sentence that says what to install."""
    if gl_environment()["MUJOCO_GL"] != "egl":
        return None
    try:
        ctypes.CDLL("libEGL.so.1")
    except OSError:
        return MISSING_EGL
    return None
