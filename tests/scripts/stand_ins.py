"""What tests of the set-up have instead of other programs and of pip."""

from __future__ import annotations

import subprocess
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest


class Programs:
    """Replaces subprocess.run: notes the commands and answers for them."""

    def __init__(self, status: int = 0, output: str = "") -> None:
        self.commands: list[list[str]] = []
        self.status = status
        self.output = output

    def __call__(self, command: list[object], **_: Any) -> SimpleNamespace:
        self.commands.append([str(word) for word in command])
        return SimpleNamespace(returncode=self.status, stdout=self.output, stderr="")


def use(monkeypatch: pytest.MonkeyPatch, programs: Programs) -> Programs:
    monkeypatch.setattr(subprocess, "run", programs)
    return programs


class Pip:
    """Replaces ``installing.install`` and ``install_locked``: notes what they are asked for, and fails.

    ``failure`` is raised by the first, ``unlike`` by the second.
    """

    def __init__(self, failure: Exception | None = None, unlike: Exception | None = None) -> None:
        self.asked: list[tuple[str, ...]] = []
        self.locked: list[list[str]] = []
        self.failure = failure
        self.unlike = unlike

    def __call__(self, _python: Path, *arguments: str, **_: Any) -> None:
        self.asked.append(arguments)
        if self.failure is not None:
            raise self.failure

    def install_locked(self, _python: Path, _root: Path, needs: list[str], **_: Any) -> None:
        self.locked.append(needs)
        if self.unlike is not None:
            raise self.unlike


def use_pip(installing: ModuleType, monkeypatch: pytest.MonkeyPatch, pip: Pip) -> Pip:
    monkeypatch.setattr(installing, "install", pip)
    monkeypatch.setattr(installing, "install_locked", pip.install_locked)
    monkeypatch.setattr(installing, "not_covered", lambda: None)
    return pip
