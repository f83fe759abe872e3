"""Debian's packages: which are asked for, and what a person reads who may not install them."""

from __future__ import annotations

from types import ModuleType

import pytest

from tests.scripts.stand_ins import Programs, use


def on_a_bare_debian(debian_packages: ModuleType, monkeypatch: pytest.MonkeyPatch, uid: int) -> Programs:
    monkeypatch.delenv("HBBA_CHROMIUM", raising=False)
    monkeypatch.setattr(debian_packages.shutil, "which", lambda name: "/usr/bin/apt-get" if name == "apt-get" else None)
    monkeypatch.setattr(debian_packages.ctypes.util, "find_library", lambda name: None)
    monkeypatch.setattr(debian_packages.os, "geteuid", lambda: uid)
    return use(monkeypatch, Programs())


def test_root_gets_the_missing_debian_packages(debian_packages: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    apt = on_a_bare_debian(debian_packages, monkeypatch, uid=0)
    debian_packages.install()
    assert apt.commands[0][-1] == "update"
    assert {"chromium", "libegl1"} <= set(apt.commands[1])
    # Another distribution may lack these, and its apt-get would then install none of all that it is asked for.
    assert apt.commands[2][-2:] == ["firefox-esr", "xvfb"]
    assert len(apt.commands) == 3


def test_who_runs_the_robot_gets_no_browser_for_tests(
    debian_packages: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    apt = on_a_bare_debian(debian_packages, monkeypatch, uid=0)
    debian_packages.install(browser=False)
    assert "libegl1" in apt.commands[1]
    assert len(apt.commands) == 2
    assert "chromium" not in apt.commands[1]


def test_without_root_the_missing_packages_are_named(
    debian_packages: ModuleType, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    apt = on_a_bare_debian(debian_packages, monkeypatch, uid=1000)
    debian_packages.install()
    assert apt.commands == []
    assert "as root, apt-get install chromium libegl1" in capsys.readouterr().err
