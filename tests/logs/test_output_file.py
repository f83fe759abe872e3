"""Files come to be whole or not at all."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from app.logs.log import LogError
from app.logs.output_file import DiskTrouble, check_new, replacing


def test_a_file_appears_when_it_is_whole(tmp_path: Path) -> None:
    target = tmp_path / "a.csv"
    with replacing(target) as part:
        assert (part.parent, part.suffix) == (tmp_path, ".csv")
        assert part.name.startswith(".")
        part.write_text("whole")
        assert not target.exists()
    assert target.read_text() == "whole"
    assert list(tmp_path.iterdir()) == [target]


@pytest.mark.parametrize("failure", [KeyboardInterrupt, ValueError, LogError])
def test_after_a_failure_there_is_what_was_before(failure: type[BaseException], tmp_path: Path) -> None:
    target = tmp_path / "a.csv"
    target.write_text("before")

    def fail() -> None:
        with replacing(target, force=True) as part:
            part.write_text("half")
            raise failure

    with pytest.raises(failure):
        fail()
    assert target.read_text() == "before"
    assert list(tmp_path.iterdir()) == [target]


def test_nothing_written_is_no_file(tmp_path: Path) -> None:
    with replacing(tmp_path / "a.csv"):
        pass
    assert list(tmp_path.iterdir()) == []


def test_who_comes_meanwhile_is_not_overwritten(tmp_path: Path) -> None:
    target = tmp_path / "a.csv"

    def race() -> None:
        with replacing(target) as part:
            part.write_text("ours")
            target.write_text("theirs")

    with pytest.raises(LogError, match="has come to be meanwhile"):
        race()
    assert target.read_text() == "theirs"


@pytest.mark.parametrize(
    ("number", "sentence"),
    [(errno.ENOSPC, "is full: a.csv was not written"), (errno.EACCES, "a.csv cannot be written: Permission denied")],
)
def test_the_disks_trouble_is_said_in_words(number: int, sentence: str, tmp_path: Path) -> None:
    def write() -> None:
        with replacing(tmp_path / "a.csv"):
            raise OSError(number, os.strerror(number))

    with pytest.raises(DiskTrouble, match=sentence):
        write()


def test_a_folder_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(LogError, match=f"there is no folder {tmp_path}/none"):
        check_new(tmp_path / "none" / "a.csv", force=False)
