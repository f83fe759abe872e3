"""Neither the program nor the libraries that it loads send reports to a server."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.no_network import needs_filter

ROOT = Path(__file__).resolve().parent.parent

HEAR = """
import numpy as np
from app.modules.perception.voices.voice_activity import VoiceActivityDetector

judge = VoiceActivityDetector()
judge.update({1: np.zeros(16_000, np.float32)})
assert judge.speech(1) < 0.5
"""

DOCTOR = """
from app import cli

cli.main(["doctor"])
"""

EVERY_LIBRARY = """
import importlib

for name in (
    "fastapi", "gtsam", "matplotlib.pyplot", "mcap", "mujoco", "numba", "onnxruntime", "ortools.sat.python.cp_model",
    "rosbags.highlevel", "scipy.signal", "soundfile", "trimesh", "uvicorn", "viser", "zxingcpp",
):
    importlib.import_module(name)
"""


@needs_filter
@pytest.mark.slow
@pytest.mark.parametrize(
    ("program", "forbidden"),
    [
        pytest.param(HEAR, "internet_sockets", id="the network that hears voices"),
        pytest.param(EVERY_LIBRARY, "internet_sockets", id="every library, loaded"),
        pytest.param(DOCTOR, "connections", id="hbba doctor"),  # it binds the console's port, and connects to no server
    ],
)
def test_nothing_reports_to_anybody(program: str, forbidden: str, tmp_path: Path) -> None:
    # The kernel ends the process at the first attempt, in whichever thread or language it is made.
    guarded = f"from tests.no_network import forbid_{forbidden}\nforbid_{forbidden}()\nimport app\n{program}"
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("ORT_", "XDG_"))}
    done = subprocess.run(
        [sys.executable, "-c", guarded],
        cwd=ROOT,
        env=environment | {"HOME": str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, f"ended with {done.returncode} (-31: at a socket)\n{done.stdout}{done.stderr}"
    written = {str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*")}
    assert not {path for path in written if "Microsoft" in path or "onnxruntime" in path}, written


@needs_filter
@pytest.mark.parametrize("forbidden", ["internet_sockets", "connections"])
def test_the_guard_of_these_tests_bites(forbidden: str) -> None:
    program = (
        f"from tests.no_network import forbid_{forbidden}\nimport socket\nforbid_{forbidden}()\n"
        "socket.socket(socket.AF_INET, socket.SOCK_DGRAM).connect(('127.0.0.1', 9))"
    )
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, check=False)
    assert done.returncode == -31


def test_reports_are_off_before_anything_of_the_program_is_loaded() -> None:
    """The package's own file does it, so that no import of ours can be earlier."""
    imported = [
        node for node in ast.walk(ast.parse((ROOT / "app/__init__.py").read_text())) if isinstance(node, ast.Import)
    ]
    assert [alias.name for node in imported for alias in node.names] == ["os"]
    assert os.environ["ORT_DISABLE_TELEMETRY"] not in ("", "0")
