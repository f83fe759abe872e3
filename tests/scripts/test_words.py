"""The check of private words: what counts as prose, which words are private, and what the figures say."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A project with one room of app/ and one page."""
    (tmp_path / "app" / "room").mkdir(parents=True)
    (tmp_path / "docs").mkdir()
    (tmp_path / "app" / "room" / "a.py").write_text('"""Words of a docstring."""\n')
    (tmp_path / "docs" / "a.md").write_text("Words of a page.\n")
    return tmp_path


def test_docstrings_and_comments_are_prose_and_code_is_not(words: ModuleType, tmp_path: Path) -> None:
    file = tmp_path / "a.py"
    file.write_text('"""Was told.\n\nAnd ``told``.\n"""\n\ntold = "told"  # begun\n')

    count, findings = words.measured(file)

    assert [(finding.line, finding.word) for finding in findings] == [(1, "told"), (6, "begun")]
    assert count == 4  # the four words of prose


def test_a_page_is_prose_but_for_its_code(words: ModuleType, tmp_path: Path) -> None:
    file = tmp_path / "a.md"
    file.write_text("Told `told`.\n\n    told\n\n```\ntold\n```\n\nWhoever comes.\n")

    count, findings = words.measured(file)

    assert [(finding.line, finding.word) for finding in findings] == [(1, "Told"), (9, "Whoever")]
    assert count == 3


def test_released_versions_of_a_changelog_stay_as_they_were(words: ModuleType, tmp_path: Path) -> None:
    file = tmp_path / "CHANGELOG.md"
    file.write_text("## [Unreleased]\n\nTold.\n\n## [0.1.0] - 2026-11-22\n\nTold.\n")

    assert [finding.line for finding in words.measured(file)[1]] == [3]


def test_what_is_allowed_does_not_count(words: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(words, "ALLOWED", (("a.md", "ISO 1: hands", "the title of a standard"),))
    for name in ("a.md", "b.md"):
        (tmp_path / name).write_text("See ISO 1: hands.\n")

    assert [finding.path.name for name in ("a.md", "b.md") for finding in words.measured(tmp_path / name)[1]] == [
        "b.md"
    ]


def test_plain_prose_passes(words: ModuleType, project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert words.report(project) == 0
    assert "app/room" in capsys.readouterr().out
    assert words.report(project, quiet=True) == 0
    assert not capsys.readouterr().out


@pytest.mark.parametrize(("file", "text"), [("app/room/b.py", "# told\n"), ("docs/b.md", "Told.\n")])
def test_a_group_above_the_limit_fails_with_the_place_of_each_word(
    words: ModuleType, project: Path, capsys: pytest.CaptureFixture[str], file: str, text: str
) -> None:
    (project / file).write_text(text)

    assert words.report(project, quiet=True) == 1
    assert f"{file}:1: " in capsys.readouterr().out


def test_tests_are_counted_but_do_not_fail(words: ModuleType, project: Path) -> None:
    (project / "tests").mkdir()
    (project / "tests" / "test_a.py").write_text("# told\n")

    assert words.report(project) == 0


def test_the_groups_hold_every_room_of_the_project(words: ModuleType) -> None:
    rooms = {f"app/{folder.name}" for folder in (ROOT / "app").iterdir() if (folder / "__init__.py").is_file()}

    assert rooms <= set(words.groups(ROOT))
