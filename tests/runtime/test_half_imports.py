"""What failed imports leave behind."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import pytest

from app.runtime.half_imports import forget_half_imports


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A package whose import fails in the middle, once ``late`` does."""
    package = tmp_path / "broken_half"
    package.mkdir()
    (package / "early.py").write_text("VALUE = 1\n")
    (package / "__init__.py").write_text("import broken_half.early, broken_half.late\nbroken_half.early.VALUE\n")
    (package / "late.py").write_text("raise OSError(24, 'Too many open files')\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    return package


def test_a_second_import_succeeds_once_the_rest_of_the_first_is_forgotten(package: Path) -> None:
    with pytest.raises(OSError, match="Too many open files"):
        importlib.import_module("broken_half")
    (package / "late.py").write_text("VALUE = 'a file of another size'\n")
    with pytest.raises(AttributeError, match="early"):
        importlib.import_module("broken_half")  # what this is about
    assert "broken_half.early" in forget_half_imports()
    importlib.import_module("broken_half")


def test_nothing_else_is_forgotten() -> None:
    forget_half_imports()
    before = dict(sys.modules)
    assert forget_half_imports() == []
    assert sys.modules == before
