"""An environment for the tests that need ROS 2: ``.venv/ros2``, with all that ``.venv`` has, and ``ros2.lock``.

ROS 2's wheels bring a start-up file by which each Python of their environment starts twice, with another library path.
So they are in an environment of their own, and everything else runs without them. Standard library only.
"""

from __future__ import annotations

import hashlib
import platform
import subprocess
import sys
from pathlib import Path

import installing

#: What wheels there are (requirements/ros2.lock) are for this machine alone.
MACHINE = "x86_64"
TESTS = (
    *(
        f"tests/robots/ros2/test_{name}.py"
        for name in ("link", "program", "camera_link", "joints", "stretch", "your_robot")
    ),
    "tests/logs/ros/live/test_classes.py",
    "tests/modules/viewers/ros2/test_server.py",
)
"""Those that are run in it; in ``.venv`` these are skipped."""


def python_with_ros(python: Path, root: Path, folder: Path) -> Path | None:
    """The interpreter of the environment in ``folder``, made unless it is what the lock asks for; None where the wheels
    are not for this computer. ``python`` is that of ``.venv``. Raises installing.PipFailed."""
    if platform.machine() != MACHINE or installing.not_covered() is not None:
        return None
    lock = installing.lock_file(root, "ros2")
    wanted = hashlib.sha256(lock.read_bytes() + sys.version.encode()).hexdigest()
    stamp, interpreter = folder / "installed", folder / "bin" / "python"
    if stamp.is_file() and stamp.read_text(encoding="utf-8") == wanted:
        return interpreter
    subprocess.run([str(python), "-m", "venv", "--clear", "--without-pip", str(folder)], check=True)
    others = "(path for path in sys.path if path and not path.startswith(sys.base_prefix))"
    beside = _run(python, f"import sys; print(*{others}, sep='\\n')")
    ours = _run(interpreter, "import sysconfig; print(sysconfig.get_path('purelib'))").strip()
    Path(ours, "beside.pth").write_text(beside + f"{root}\n", encoding="utf-8")
    options = ["--no-deps", "--require-hashes", "-r", str(lock)]
    where = {"PIP_PYTHON": str(interpreter)}
    installing.install(python, *options, title="ROS 2, for its tests", environment=where)
    stamp.write_text(wanted, encoding="utf-8")
    return interpreter


def _run(python: Path, program: str) -> str:
    return subprocess.run([str(python), "-P", "-c", program], check=True, capture_output=True, text=True).stdout
