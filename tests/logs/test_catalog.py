"""The folder of recordings: what is in it, closed or not, read once."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.writer import Writer

from app.logs import catalog as rooms
from app.logs.catalog import Catalog
from app.logs.layout import FACTS
from app.logs.library import RecordingLibrary

BEGIN_NS = 1_795_000_000_250_000_000


def write(path: Path, *, seconds: int = 5, robot: str | None = "IRL-1/TR", closed: bool = True) -> None:
    """An MCAP file of one message a second."""
    with path.open("wb") as file:
        writer = Writer(file, chunk_size=64)
        writer.start(profile="ros2")
        if robot is not None:
            writer.add_metadata("other", {"robot": "somebody else"})
            writer.add_metadata(FACTS, {"robot": robot})
        channel = writer.register_channel("/topic", "cdr", 0)
        for second in range(seconds + 1):
            stamp = BEGIN_NS + second * 1_000_000_000
            writer.add_message(channel, stamp, bytes(100), stamp)
        if closed:
            writer.finish()


@pytest.fixture
def library(tmp_path: Path) -> RecordingLibrary:
    """A folder that is not there yet."""
    library = RecordingLibrary(tmp_path / "recordings")
    library.folder.mkdir()
    return library


def test_no_folder_is_no_recordings(tmp_path: Path) -> None:
    assert Catalog(RecordingLibrary(tmp_path / "not" / "there")).recordings() == []


def test_a_closed_recording_has_times_and_robot(library: RecordingLibrary) -> None:
    write(library.path("tour"))
    (recording,) = Catalog(library).recordings()
    assert recording.name == "tour"
    assert recording.complete
    assert recording.bytes == library.path("tour").stat().st_size
    assert recording.begin == 1_795_000_000.25
    assert recording.duration_s == 5.0
    assert recording.robot == "IRL-1/TR"


def test_one_that_was_not_closed_has_its_begin(library: RecordingLibrary) -> None:
    write(library.path("killed"), closed=False)
    (recording,) = Catalog(library).recordings()
    assert not recording.complete
    assert recording.begin == 1_795_000_000.25
    assert recording.duration_s is None
    assert recording.robot == "IRL-1/TR"


def test_one_that_a_program_writes_is_distinct_from_one_that_was_left(library: RecordingLibrary) -> None:
    write(library.path("tour"), closed=False)
    catalog = Catalog(library)
    assert not catalog.recordings()[0].written
    with library.path("tour").open("rb") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        os.utime(library.path("tour"))
        assert catalog.recordings()[0].written
        assert catalog.written("tour")
    # Nothing of the file has changed but that.
    assert not catalog.recordings()[0].written
    assert not catalog.written("tour")


def test_a_recording_without_messages_or_facts_has_no_times(library: RecordingLibrary) -> None:
    write(library.path("empty"), seconds=-1, robot=None)
    (recording,) = Catalog(library).recordings()
    assert recording.complete
    assert (recording.begin, recording.duration_s, recording.robot) == (None, None, "")


def test_the_newest_comes_first_and_what_cannot_be_asked_for_is_left_out(library: RecordingLibrary) -> None:
    write(library.path("b"))
    write(library.path("a"))
    library.path("dust").write_bytes(b"")
    os.utime(library.path("dust"), (1, 1))
    (library.folder / "notes.txt").write_text("no recording")
    (library.folder / "with blank.mcap").write_bytes(b"")
    (library.folder / "folder.mcap").mkdir()
    assert [recording.name for recording in Catalog(library).recordings()] == ["b", "a", "dust"]


def test_a_file_is_read_again_only_when_it_has_changed(
    library: RecordingLibrary, monkeypatch: pytest.MonkeyPatch
) -> None:
    read: list[str] = []

    def counted(name: str, path: Path, status: os.stat_result) -> rooms.Recording:
        read.append(name)
        return original(name, path, status)

    original = rooms.read
    monkeypatch.setattr(rooms, "read", counted)
    write(library.path("tour"))
    catalog = Catalog(library)
    assert catalog.recordings() == catalog.recordings()
    assert read == ["tour"]
    write(library.path("tour"), seconds=9)
    assert catalog.recordings()[0].duration_s == 9.0
    assert read == ["tour", "tour"]
    catalog.delete("tour")
    assert catalog.recordings() == []


def test_one_that_is_deleted_meanwhile_does_not_hide_the_others(
    library: RecordingLibrary, monkeypatch: pytest.MonkeyPatch
) -> None:
    @contextmanager
    def deleting(folder: Path) -> Iterator[list[os.DirEntry[str]]]:
        with scandir(folder) as entries:
            found = list(entries)
        library.path("gone").unlink()
        yield found

    scandir = os.scandir
    write(library.path("gone"))
    write(library.path("tour"))
    monkeypatch.setattr(os, "scandir", deleting)
    assert [recording.name for recording in Catalog(library).recordings()] == ["tour"]


@given(cut=st.integers(0, 2_000), noise=st.binary(max_size=64))
def test_whatever_a_crash_left_is_listed(tmp_path_factory: pytest.TempPathFactory, cut: int, noise: bytes) -> None:
    library = RecordingLibrary(tmp_path_factory.mktemp("recordings"))
    write(library.path("whole"))
    whole = library.path("whole").read_bytes()
    library.path("torn").write_bytes(whole[: min(cut, len(whole) - 1)] + noise)
    torn = next(recording for recording in Catalog(library).recordings() if recording.name == "torn")
    assert torn.bytes == min(cut, len(whole) - 1) + len(noise)
    assert torn.begin in (None, 1_795_000_000.25) or noise


@pytest.mark.parametrize(
    "name", ["", ".", "..", "../tour", "a/b", "a\\b", "tour\n", "tour\0", ".hidden", "-x", "ｔour", "tour：", "x" * 101]
)
def test_no_name_leads_out_of_the_folder(library: RecordingLibrary, name: str) -> None:
    catalog = Catalog(library)
    with pytest.raises(ValueError, match="a recording's name has"):
        catalog.delete(name)
    with pytest.raises(ValueError, match="a recording's name has"):
        catalog.has(name)


def test_deleting_what_is_not_there_says_so(library: RecordingLibrary) -> None:
    with pytest.raises(FileNotFoundError):
        Catalog(library).delete("gone")
