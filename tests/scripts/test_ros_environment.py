"""The environment of the tests that need ROS 2: made once, and again when its lock changes; not where no wheel fits."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest


@pytest.fixture
def made(ros_environment: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[dict[str, Any]]:
    """A checkout with a lock; notes what pip is asked for, which installs nothing."""
    (tmp_path / "requirements").mkdir()
    (tmp_path / "requirements" / "ros2.lock").write_text("ros==1")
    asked: list[dict[str, Any]] = []
    monkeypatch.setattr(
        ros_environment.installing, "install", lambda *words, **named: asked.append({"words": words, **named})
    )
    monkeypatch.setattr(ros_environment.installing, "not_covered", lambda: None)
    monkeypatch.setattr(ros_environment.platform, "machine", lambda: "x86_64")
    return asked


def test_it_has_what_the_other_has_and_is_made_once(
    ros_environment: ModuleType, tmp_path: Path, made: list[dict[str, Any]]
) -> None:
    folder, here = tmp_path / "ros2", Path(sys.executable)
    python = ros_environment.python_with_ros(here, tmp_path, folder)
    assert python == folder / "bin" / "python"
    found = subprocess.run(
        [str(python), "-c", "import pytest, sys; print(sys.prefix)"], capture_output=True, text=True, check=True
    )
    assert found.stdout.strip() == str(folder), "pytest is there, in an environment of its own"
    (asked,) = made
    assert asked["words"][1:] == ("--no-deps", "--require-hashes", "-r", str(tmp_path / "requirements" / "ros2.lock"))
    assert asked["environment"] == {"PIP_PYTHON": str(python)}
    assert ros_environment.python_with_ros(here, tmp_path, folder) == python
    assert len(made) == 1
    (tmp_path / "requirements" / "ros2.lock").write_text("ros==2")
    ros_environment.python_with_ros(here, tmp_path, folder)
    assert len(made) == 2


def test_there_is_none_where_no_wheel_fits(
    ros_environment: ModuleType, tmp_path: Path, made: list[dict[str, Any]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ros_environment.platform, "machine", lambda: "aarch64")
    assert ros_environment.python_with_ros(Path(sys.executable), tmp_path, tmp_path / "ros2") is None
    assert made == []
