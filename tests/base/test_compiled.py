"""Kernels are found, compiled once, and known to be compiled."""

from __future__ import annotations

import ast
from pathlib import Path
from typing import Any

import pytest

from app.base import compiled


def test_files_with_kernels_are_found() -> None:
    names = compiled.kernel_modules()
    assert "app.modules.perception.slam.scan_matching" in names
    assert "app.base.compiled" not in names


def test_in_files_with_kernels_only_these_leave_out_types() -> None:
    source = Path(compiled.__file__).parents[2]
    for name in compiled.kernel_modules():
        tree = ast.parse(source.joinpath(*name.split(".")).with_suffix(".py").read_text())
        for function in (node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)):
            if not any("kernel(" in ast.unparse(each) for each in function.decorator_list):
                untyped = [each.arg for each in function.args.args if each.annotation is None and each.arg != "self"]
                assert not untyped, f"{name}: {function.name} says no type of {untyped}"
                assert function.returns is not None, f"{name}: {function.name} says no type of its result"


@pytest.mark.parametrize(
    ("text", "has"),
    [
        ("from app.base.compiled import kernel", True),
        ("if True:\n    from app.base.compiled import kernel as k, make_ready", True),
        ("from app.base.compiled import (\n    kernel,\n    make_ready,\n)", True),
        ("from app.base.compiled import make_ready", False),
        ("from app.base.compiled import (\n    kernel_modules,\n)\nkernel = 1", False),
        ("from app.base.compiled import kernel_modules, make_ready  # and no other\n", False),
        ('"""Not so: from app.base.compiled import kernel"""', False),
    ],
)
def test_a_file_with_kernels_imports_what_makes_them(text: str, has: bool, tmp_path: Path) -> None:
    (tmp_path / "file.py").write_text(text)
    assert compiled._has_kernel(tmp_path / "file.py") is has


def test_what_changed_is_compiled_again_and_nothing_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiled, "_stamp_file", lambda: tmp_path / "made" / "kernels.sha256")
    names = ["app.modules.perception.slam.correlative_matching", "app.modules.perception.slam.scan_matching"]
    monkeypatch.setattr(compiled, "kernel_modules", lambda: names)
    lines: list[str] = []
    assert not compiled.is_ready()
    compiled.compile_all(lines.append)
    assert compiled.is_ready()
    assert sorted(text.split()[1] for text in lines) == sorted(names)
    digest = compiled._digest
    monkeypatch.setattr(compiled, "_digest", lambda name: "other" if name == names[1] else digest(name))
    assert not compiled.is_ready()
    compiled.compile_all(lines.append)
    assert lines[2:] == [f"compiled {names[1]} (1 of 1)"]


def test_a_file_that_cannot_be_compiled_keeps_no_other_from_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiled, "_stamp_file", lambda: tmp_path / "kernels.sha256")
    names = ["app.no_such_file", "app.modules.perception.slam.correlative_matching"]
    monkeypatch.setattr(compiled, "kernel_modules", lambda: names)
    monkeypatch.setattr(compiled, "_digest", lambda name: "now")
    lines: list[str] = []
    with pytest.raises(ModuleNotFoundError, match="no_such_file"):
        compiled.compile_all(lines.append)
    assert [text.split()[1] for text in lines] == names[1:]
    assert compiled._missing() == names[:1]


def test_kernels_leave_the_interpreters_lock_and_are_kept() -> None:
    from app.modules.perception.slam import scan_matching

    dispatcher: Any = scan_matching._fit
    assert dispatcher.targetoptions["nogil"]
    assert len(dispatcher.signatures) == 1
    assert Path(dispatcher._cache.cache_path).is_dir()
