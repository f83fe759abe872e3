"""Recordings whose chunks are small and unpack to gigabytes."""

from __future__ import annotations

import resource
import struct
import subprocess
import sys
import tracemalloc
from contextlib import closing
from pathlib import Path

import mcap.reader
import pytest
from mcap.opcode import Opcode

from app.log_tools.cut import cut
from app.log_tools.repair import repair
from app.logs.catalog import read
from app.logs.layout import FACTS
from app.logs.log import LogError
from app.logs.mcap.reader import McapLog
from tests.logs.bombs import GIB, PACKED, put_chunk, zstd_of_zeros
from tests.logs.mcap.mcap_files import BEGIN, drive, write_log


@pytest.fixture
def log(tmp_path: Path) -> Path:
    return write_log(tmp_path / "a.mcap", drive(0.3))


@pytest.fixture
def nothing_is_unpacked(monkeypatch: pytest.MonkeyPatch) -> None:
    def never(*_: object, **__: object) -> None:
        raise AssertionError("a chunk was unpacked")

    monkeypatch.setattr(mcap.reader, "breakup_chunk", never)
    monkeypatch.setattr("mcap.stream_reader.breakup_chunk", never)


@pytest.mark.usefixtures("nothing_is_unpacked")
@pytest.mark.parametrize("kind", PACKED)
@pytest.mark.parametrize("declared", [4 * GIB, 1_000_000])
def test_a_chunk_that_becomes_gigabytes_is_refused_whatever_it_says(kind: str, declared: int, log: Path) -> None:
    size = 4 * GIB if kind == "zstd" else GIB
    put_chunk(log, kind, size, declared)
    words = r"the chunk of messages at byte \d+ may unpack to .*B; at most 256 MB are unpacked; `hbba log repair"
    with pytest.raises(LogError, match=words):
        McapLog(log)
    with pytest.raises(LogError, match=words):
        cut(log, log.with_name("piece.mcap"), BEGIN, BEGIN + 0.1)
    assert read("a", log, log.stat()).complete


def test_a_chunk_where_none_should_be_is_not_unpacked(log: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    data = put_chunk(log, "zstd", 4 * GIB, 4 * GIB, indexed=False).read_bytes()
    bomb = data.index(zstd_of_zeros(4 * GIB)) - 53
    assert data[bomb] == Opcode.CHUNK
    monkeypatch.setattr("mcap.stream_reader.breakup_chunk", None)
    as_summary = bytearray(data)
    struct.pack_into("<Q", as_summary, len(data) - 28, bomb)
    log.write_bytes(bytes(as_summary))
    with pytest.raises(LogError, match="there is a chunk of messages in its summary"):
        McapLog(log)
    assert not read("a", log, log.stat()).complete
    as_metadata = bytearray(data)
    struct.pack_into("<Q", as_metadata, data.rindex(FACTS.encode()) - 20, bomb)
    log.write_bytes(bytes(as_metadata))
    with pytest.raises(LogError, match=f"its index names a record that is not at byte {bomb}"):
        McapLog(log)
    assert not read("a", log, log.stat()).complete


@pytest.mark.parametrize("kind", PACKED)
@pytest.mark.parametrize("declared", [4 * GIB, 1_000_000])
def test_repair_leaves_it_out_and_saves_the_others(kind: str, declared: int, log: Path) -> None:
    with closing(McapLog(log)) as whole:
        counts = {name: channel.count for name, channel in whole.info.channels.items()}
    put_chunk(log, kind, 4 * GIB if kind == "zstd" else GIB, declared)
    tracemalloc.start()
    report = repair(log, log.with_name("saved.mcap"))
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 40_000_000
    assert [loss.what for loss in report.losses][:1] == [
        "a chunk that says it unpacks to 4.3 GB" if declared == 4 * GIB else "a chunk"
    ]
    with closing(McapLog(log.with_name("saved.mcap"))) as saved:
        assert {name: channel.count for name, channel in saved.info.channels.items()} == counts


@pytest.mark.slow
@pytest.mark.parametrize("command", [["info"], ["repair", "--force"], ["cut", "--to", "1"], ["export", "csv"]])
def test_the_commands_say_so_in_little_memory(command: list[str], log: Path) -> None:
    put_chunk(log, "zstd", 4 * GIB, 4 * GIB)
    name, *more = command
    call = [sys.executable, "-m", "app.cli", "log", name, str(log), *more]
    done = subprocess.run(
        call,
        check=False,
        capture_output=True,
        text=True,
        cwd=Path(__file__).parents[3],
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (3_000_000_000, 3_000_000_000)),
    )
    assert "Traceback" not in done.stderr
    if name == "info":
        assert "This log is damaged." in done.stdout
    elif name == "repair":
        assert "a chunk that says it unpacks to 4.3 GB" in done.stdout
    else:
        assert "may unpack to 4.3 GB; at most 256 MB are unpacked" in done.stderr
    assert done.returncode == {"info": 1, "repair": 0}.get(name, 2)
