"""Kernels are found, compiled once, and known to be compiled."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from app import compiled


def test_files_with_kernels_are_found() -> None:
    names = compiled.kernel_modules()
    assert "app.modules.perception.slam.matching" in names
    assert "app.compiled" not in names


def test_what_changed_is_compiled_again_and_nothing_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiled, "_stamp_file", lambda: tmp_path / "made" / "kernels.sha256")
    names = ["app.modules.perception.slam.matching", "app.modules.perception.slam.search"]
    monkeypatch.setattr(compiled, "kernel_modules", lambda: names)
    told: list[str] = []
    assert not compiled.is_ready()
    compiled.compile_all(told.append)
    assert compiled.is_ready()
    assert [text.split()[1] for text in told] == names
    digest = compiled._digest
    monkeypatch.setattr(compiled, "_digest", lambda name: "other" if name == names[1] else digest(name))
    assert not compiled.is_ready()
    compiled.compile_all(told.append)
    assert told[2:] == [f"compiling {names[1]} (1 of 1)"]


def test_kernels_leave_the_interpreters_lock_and_are_kept() -> None:
    from app.modules.perception.slam import matching

    dispatcher: Any = matching._fit
    assert dispatcher.targetoptions["nogil"]
    assert len(dispatcher.signatures) == 1
    assert Path(dispatcher._cache.cache_path).is_dir()
