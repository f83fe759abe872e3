"""pip behind the set-up: how far it is, and what a person reads when it fails."""

from __future__ import annotations

import io
import sys
from pathlib import Path
from types import ModuleType

import pytest

REFUSED = """
WARNING: Retrying (Retry(total=0, connect=None)) after connection broken by 'ProxyError('Cannot connect to proxy.', \
OSError('Tunnel connection failed: 407 Proxy Authentication Required'))': /simple/segno/
ERROR: No matching distribution found for segno
"""
ABSENT = """
WARNING: Retrying (Retry(total=0, connect=None)) after connection broken by 'ProxyError('Cannot connect to proxy.', \
NewConnectionError('<connection>: Failed to establish a new connection: [Errno 111] Connection refused'))': /segno/
"""
UNREACHED = "NewConnectionError('<connection>: Failed to establish a new connection: [Errno 101] Unreachable')"


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def pip(folder: Path, program: str) -> Path:
    """A Python whose pip is ``program``, in the language of the shell."""
    python = folder / "python"
    python.write_text(f"#!/bin/sh\n{program}\n")
    python.chmod(0o755)
    return python


def test_what_pip_writes_is_progress_in_words(installing: ModuleType) -> None:
    progress = installing.Progress()
    assert progress.read("Collecting scipy<2,>=1.13 (from hbba==0.1.0)\n") == "1 packages so far, now scipy"
    assert progress.read("  Downloading scipy-1.16.0.whl (35 MB)\n") is None
    assert progress.read("Collecting numpy (from scipy)\n") == "2 packages so far, now numpy"
    assert progress.read("Collecting numpy (from gtsam)\n") == "2 packages so far, now numpy"
    assert progress.read("Installing collected packages: numpy, scipy\n") == "putting 2 packages into place"
    assert "does not answer" in progress.read("WARNING: Retrying (Retry(total=4)) after connection broken by ...\n")


def test_a_terminal_shows_one_line_while_pip_works(installing: ModuleType, tmp_path: Path) -> None:
    shown, seen = tmp_path / "shown", Terminal()

    class Noting(Terminal):
        def write(self, text: str) -> int:
            if "now scipy" in text:
                shown.touch()
            return seen.write(text)

    # It works until what it says was seen.
    python = pip(tmp_path, f'echo "Collecting scipy"; while [ ! -e {shown} ]; do sleep 0.05; done')
    installing.install(python, "-e", ".", title="Python packages", out=Noting())
    assert "\r\x1b[Khbba: Python packages: 1 packages so far, now scipy (" in seen.getvalue()
    assert seen.getvalue().endswith("\r\x1b[K"), "the line is taken away"
    assert "\n" not in seen.getvalue()


def test_a_file_gets_whole_lines(installing: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(installing, "LINE_EVERY_S", 0.01)
    shown, seen = tmp_path / "shown", io.StringIO()

    class Noting(io.StringIO):
        def write(self, text: str) -> int:
            if "now scipy" in text:
                shown.touch()
            return seen.write(text)

    python = pip(tmp_path, f'echo "Collecting scipy"; while [ ! -e {shown} ]; do sleep 0.05; done')
    installing.install(python, "scipy", title="Python packages", out=Noting())
    assert "\x1b" not in seen.getvalue()
    assert all(line.startswith("hbba: Python packages: ") for line in seen.getvalue().splitlines())


@pytest.mark.parametrize(
    ("said", "sentence"),
    [
        (
            REFUSED,
            "The proxy does not let pip through to the Python package index (Tunnel connection failed: 407 ",
        ),
        (ABSENT, "The proxy does not let pip through to the Python package index (Connection refused): correct"),
        (UNREACHED, "The Python package index cannot be reached: connect this computer"),
        ("ERROR: ResolutionImpossible", "pip could not install the project:\nERROR: ResolutionImpossible"),
    ],
)
def test_a_failure_is_said_with_what_to_do(installing: ModuleType, tmp_path: Path, said: str, sentence: str) -> None:
    (tmp_path / "said").write_text(said)
    with pytest.raises(installing.PipFailed) as failure:
        installing.install(pip(tmp_path, f"cat {tmp_path / 'said'}; exit 1"), "segno", title="x", out=io.StringIO())
    assert str(failure.value).startswith(sentence)
    assert said is not REFUSED or "\n" not in str(failure.value)


def test_pip_is_asked_for_just_what_was_wanted(installing: ModuleType, tmp_path: Path) -> None:
    python = pip(tmp_path, f'echo "$@ $HBBA_SKIP_WEB" > {tmp_path / "asked"}')
    installing.install(python, "-e", ".[test]", title="x", environment={"HBBA_SKIP_WEB": "1"}, out=sys.stdout)
    asked = (tmp_path / "asked").read_text()
    assert asked == "-m pip install --disable-pip-version-check --progress-bar=off --no-compile -e .[test] 1\n"


@pytest.mark.parametrize(
    "said",
    [
        "ERROR: THESE PACKAGES DO NOT MATCH THE HASHES FROM THE REQUIREMENTS FILE. ...",
        "ERROR: Could not find a version ...\nERROR: No matching distribution found for x==9",
    ],
)
def test_an_index_with_other_files_is_known(installing: ModuleType, tmp_path: Path, said: str) -> None:
    (tmp_path / "said").write_text(said)
    python = pip(tmp_path, f"cat {tmp_path / 'said'}; exit 1")
    with pytest.raises(installing.NotAsLocked):
        installing.install_locked(python, tmp_path, ["run"], title="x")


def test_an_index_out_of_reach_is_no_other_index(installing: ModuleType, tmp_path: Path) -> None:
    (tmp_path / "said").write_text(REFUSED)
    with pytest.raises(installing.PipFailed) as failure:
        installing.install_locked(pip(tmp_path, f"cat {tmp_path / 'said'}; exit 1"), tmp_path, ["run"], title="x")
    assert not isinstance(failure.value, installing.NotAsLocked)


def test_locks_are_installed_by_their_hashes_alone(installing: ModuleType, tmp_path: Path) -> None:
    python = pip(tmp_path, f'echo "$@" > {tmp_path / "asked"}')
    installing.install_locked(python, Path("root"), ["run", "test"], title="x")
    files = "-r root/requirements/run.lock -r root/requirements/test.lock"
    assert f"--no-deps --require-hashes {files}\n" in (tmp_path / "asked").read_text()


@pytest.mark.parametrize(
    ("version", "system", "machine", "other"),
    [
        ((3, 11, 7), "linux", "x86_64", None),
        ((3, 14, 0), "linux", "aarch64", None),
        ((3, 15, 0), "linux", "x86_64", "CPython 3.15"),
        ((3, 12, 0), "linux", "riscv64", "Linux on riscv64"),
        ((3, 12, 0), "darwin", "arm64", "Darwin on arm64"),
    ],
)
def test_the_locks_are_for_some_computers(
    installing: ModuleType,
    monkeypatch: pytest.MonkeyPatch,
    version: tuple[int, ...],
    system: str,
    machine: str,
    other: str | None,
) -> None:
    monkeypatch.setattr(installing.sys, "version_info", version)
    monkeypatch.setattr(installing.sys, "platform", system)
    monkeypatch.setattr(installing.platform, "machine", lambda: machine)
    monkeypatch.setattr(installing.platform, "system", system.capitalize)
    monkeypatch.setattr(installing.platform, "python_implementation", lambda: "CPython")
    assert installing.not_covered() == other
