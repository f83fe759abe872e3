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


def test_a_changed_file_is_compiled_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiled, "_stamp_file", lambda: tmp_path / "made" / "kernels.sha256")
    told: list[str] = []
    assert not compiled.is_ready()
    compiled.compile_all(told.append)
    assert compiled.is_ready()
    assert len(told) == len(compiled.kernel_modules())
    monkeypatch.setattr(compiled, "kernel_modules", lambda: ["app.modules.perception.slam.matching"])
    assert not compiled.is_ready()


def test_kernels_leave_the_interpreters_lock_and_are_kept() -> None:
    from app.modules.perception.slam import matching

    dispatcher: Any = matching._fit
    assert dispatcher.targetoptions["nogil"]
    assert len(dispatcher.signatures) == 1
    assert Path(dispatcher._cache.cache_path).is_dir()
