"""The file of memory: whole after any death of the program, refused where it is not of ours."""

from __future__ import annotations

import os
import signal
import sqlite3
import stat
import subprocess
from pathlib import Path

import hypothesis.strategies as st
import pytest
from hypothesis import given, settings

from app.base.child_processes import python
from app.memory.kept import Kept, Update
from app.memory.memory import Memory
from app.memory.store import FILE, MemoryStore, StoreBusy, StoreUnreadable
from tests.memory.remembering import LIMITS, experience

CHILD = Path(__file__).with_name("remembering.py")


def content(memory: Memory) -> Kept:
    """All that ``memory`` would keep."""
    used = {event for episode in memory.art.episodes.values() for event in episode.weights}
    return Kept(
        tuple(memory.art.events[each] for each in sorted(used)),
        tuple(memory.art.episodes.values()),
        {episode: deeds for episode, deeds in memory.deeds.items() if deeds},
    )


def test_what_is_kept_is_read_again_and_nothing_else(tmp_path: Path) -> None:
    folder = tmp_path / "memory"
    store = MemoryStore(folder)
    assert store.read() == Kept()
    assert not folder.exists(), "nothing is made before there is something to keep"
    memory = Memory(Kept(), LIMITS)
    for number in range(9):
        experience(memory, number)
    memory.perceive({"place": {"under way": 1.0}})
    store.keep(memory.take_update())
    store.close()
    assert stat.S_IMODE(store.path.stat().st_mode) == 0o600
    kept = store.read()
    assert kept == content(memory)
    assert kept.deeds[1][0].params == {"words": "who, what", "language": "en"}
    again = Memory(kept, LIMITS)
    assert again.forget(2)
    store.keep(again.take_update())
    store.close()
    assert store.read() == content(again)
    again.forget_all()
    store.keep(again.take_update())
    store.close()
    assert store.read() == Kept()
    assert b"room" not in store.path.read_bytes(), "what is deleted is overwritten"
    assert store.delete()
    assert not store.path.exists()
    assert not store.delete()


@pytest.mark.slow
def test_killed_at_any_moment_it_opens_with_all_episodes_that_were_closed(tmp_path: Path) -> None:
    known = 0
    for lines in (1, 6, 2):
        with subprocess.Popen(
            [*python(str(CHILD)), str(tmp_path), str(known)],
            stdout=subprocess.PIPE,
            text=True,
            env={**os.environ, "PYTHONPATH": str(CHILD.parents[2])},
        ) as child:
            assert child.stdout is not None
            said = [int(child.stdout.readline()) for _ in range(lines)]
            child.send_signal(signal.SIGKILL)
            said += [int(line) for line in child.stdout.read().splitlines()]
        store = MemoryStore(tmp_path)
        kept = store.read()
        store.close()
        # The next may be kept as well, of which the child did not come to say so.
        expected = Memory(Kept(), LIMITS)
        for number in range(said[-1] + 1):
            experience(expected, number)
        if kept != content(expected):
            experience(expected, said[-1] + 1)
            assert kept == content(expected)
            said.append(said[-1] + 1)
        known = said[-1] + 1


def test_an_update_that_fails_half_way_leaves_what_was_kept(tmp_path: Path) -> None:
    store, memory = MemoryStore(tmp_path), Memory(Kept(), LIMITS)
    experience(memory, 0)
    store.keep(memory.take_update())
    before = content(memory)
    experience(memory, 2)
    update = memory.take_update()
    broken = Update(update.changes, {7: memory.deeds[1]})  # there is no episode 7
    with pytest.raises(OSError, match=r"memory\.sqlite cannot be written: FOREIGN KEY"):
        store.keep(broken)
    store.close()
    assert store.read() == before


def test_what_is_no_memory_is_refused_and_set_aside(tmp_path: Path) -> None:
    path = tmp_path / FILE
    path.write_bytes(b"This is no database. " * 500)
    store = MemoryStore(tmp_path)
    with pytest.raises(StoreUnreadable, match=r"memory\.sqlite cannot be read: file is not a database"):
        store.read()
    assert store.set_aside().name == "memory.unreadable-1.sqlite"
    assert store.read() == Kept()
    with sqlite3.connect(path) as other:
        other.execute("CREATE TABLE mine (x)")
    other.close()
    with pytest.raises(StoreUnreadable, match="is of another program: its version is 0, not 1"):
        store.read()
    assert store.set_aside().name == "memory.unreadable-2.sqlite"
    with sqlite3.connect(path) as newer:
        newer.execute("CREATE TABLE event (x)")
        newer.execute("PRAGMA user_version = 9")
    newer.close()
    with pytest.raises(StoreUnreadable, match="is of a newer program: its version is 9, not 1"):
        store.read()


@settings(max_examples=30)
@given(st.integers(0, 40_000), st.binary(min_size=1, max_size=600))
def test_a_damaged_file_is_read_or_refused_in_words(
    tmp_path_factory: pytest.TempPathFactory, at: int, damage: bytes
) -> None:
    folder = tmp_path_factory.mktemp("memory")
    store, memory = MemoryStore(folder), Memory(Kept(), LIMITS)
    for number in range(0, 12, 2):
        experience(memory, number)
    store.keep(memory.take_update())
    store.close()
    data = bytearray(store.path.read_bytes())
    at %= len(data)
    data[at : at + len(damage)] = damage
    store.path.write_bytes(data)
    said = FILE
    try:
        store.read()
    except (StoreUnreadable, OSError) as refusal:
        said = str(refusal)
    finally:
        store.close()
    assert FILE in said


def test_another_program_has_it_open(tmp_path: Path) -> None:
    first, second, memory = MemoryStore(tmp_path), MemoryStore(tmp_path), Memory(Kept(), LIMITS)
    experience(memory, 0)
    first.keep(memory.take_update())
    with pytest.raises(StoreBusy, match=r"another program has .*memory\.sqlite open"):
        second.read()
    first.close()
    assert second.read() == content(memory)
    second.close()


def test_off_means_that_no_file_is_touched(tmp_path: Path) -> None:
    store, memory = MemoryStore(tmp_path, keeps=False), Memory(Kept(), LIMITS)
    experience(memory, 0)
    store.keep(memory.take_update())
    assert store.read() == Kept()
    assert list(tmp_path.iterdir()) == []
