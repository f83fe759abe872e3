"""Child processes run this program's code, whatever lies in the folder that a person works in."""

from __future__ import annotations

import math
import subprocess
import sys
from pathlib import Path

import pytest

from app.base import child_processes

ROOT = Path(__file__).resolve().parents[2]
#: Files that may start an interpreter by its name: the helper itself, and the benchmarks, which are not installed.
ALLOWED = {ROOT / "app" / "base/child_processes.py", ROOT / "app" / "commands" / "bench.py"}
SPAWNING = """
import math, os
from multiprocessing import get_context
from app.base.child_processes import safe_path
from app.base.geometry import wrap_angle

if __name__ == "__main__":
    pool = get_context("spawn")
    with safe_path():
        pool = pool.Pool(1)
    print(f"{-pool.apply(wrap_angle, (math.pi,)):.6f}", os.environ.get("PYTHONSAFEPATH"))
    pool.terminate()
"""


@pytest.fixture
def strangers_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working folder holds an ``app`` of another program, and a file named as one of the standard library."""
    (tmp_path / "app").mkdir()
    (tmp_path / "app" / "__init__.py").write_text("raise SystemExit('another app')\n")
    (tmp_path / "fractions.py").write_text("raise SystemExit('another fractions')\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.usefixtures("strangers_folder")
@pytest.mark.parametrize(
    ("module", "arguments"),
    [
        ("app.base.compiled", []),
        ("app.console.replay_process", ["0"]),  # of no running console: it ends at once
        ("app.cli", ["--version"]),
    ],
)
def test_a_module_is_ours_in_a_strangers_folder(module: str, arguments: list[str]) -> None:
    done = subprocess.run(child_processes.python("-m", module, *arguments), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert not done.stderr


def test_code_on_the_command_line_is_spared_too(strangers_folder: Path) -> None:
    program = "import app, fractions; print(app.__file__)"
    done = subprocess.run(child_processes.python("-c", program), capture_output=True, text=True, check=True)
    assert Path(done.stdout.strip()) == ROOT / "app" / "__init__.py"


def test_what_multiprocessing_starts_is_spared_too(strangers_folder: Path, tmp_path: Path) -> None:
    (strangers_folder / "socket.py").write_text("raise SystemExit('another socket')\n")
    program = tmp_path / "elsewhere" / "program.py"  # as the command hbba: a script of another folder
    program.parent.mkdir()
    program.write_text(SPAWNING)
    done = subprocess.run([sys.executable, program], capture_output=True, text=True, check=False)
    assert done.stdout == f"{math.pi:.6f} None\n", done.stderr


def test_a_path_that_a_person_named_holds(strangers_folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (strangers_folder / "lib").mkdir()
    (strangers_folder / "lib" / "theirs.py").write_text("word = 'found'\n")
    monkeypatch.setenv("PYTHONPATH", str(strangers_folder / "lib"))
    program = "import theirs; print(theirs.word)"
    assert subprocess.run(child_processes.python("-c", program), capture_output=True, check=True).stdout == b"found\n"


def test_every_child_of_the_program_is_started_so() -> None:
    files = [path for path in (ROOT / "app").rglob("*.py") if "sys.executable" in path.read_text(encoding="utf-8")]
    assert set(files) <= ALLOWED
