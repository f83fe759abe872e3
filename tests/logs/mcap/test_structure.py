"""Every exception of the library for a damaged MCAP file becomes a message that it is damaged."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from app.log_tools.cut import cut
from app.logs import catalog
from app.logs.log import LogError
from app.logs.mcap.channel_sizes import channel_bytes
from app.logs.mcap.structure import is_closed, is_mcap
from app.logs.open import open_log
from tests.logs.importers.bags import Sent, header, write_ros2_mcap
from tests.logs.mcap.mcap_files import drive, write_log

#: Which byte (counted from the end, where the index is), and what becomes of it.
DAMAGE = st.lists(st.tuples(st.integers(9, 4000), st.sampled_from([0, 1, 0x7F, 0xFF])), min_size=1, max_size=4)


def read_through(path: Path) -> None:
    log = open_log(path)
    try:
        _ = log.manifest
        for _ in log.messages():
            pass
    finally:
        log.close()


def looked_up(path: Path) -> None:
    catalog.read(path.stem, path, path.stat())


def cut_out(path: Path) -> None:
    cut(path, path.with_name("piece.mcap"), force=True)


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> list[bytes]:
    """A recording of ours, one that another tool copied, and one of another program."""
    folder = tmp_path_factory.mktemp("whole")
    stamps = [10**18 + i * 10**8 for i in range(20)]
    sent = [Sent(at, "/odom", "nav_msgs/msg/Odometry", {"header": header(at, "odom")}) for at in stamps]
    return [
        write_log(folder / "ours.mcap", drive(1.0)).read_bytes(),
        write_log(folder / "copied.mcap", drive(1.0), library="another tool").read_bytes(),
        write_ros2_mcap(folder / "other.mcap", sent).read_bytes(),
    ]


@pytest.mark.parametrize("use", [read_through, looked_up, cut_out, channel_bytes])
@given(which=st.integers(0, 2), damage=DAMAGE)
@example(which=2, damage=[(62, 255), (318, 0), (3461, 1), (265, 255)])  # an index that promises what is not there
@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_damage_is_a_log_error_or_nothing(
    files: list[bytes], tmp_path: Path, use: Callable[[Path], object], which: int, damage: list[tuple[int, int]]
) -> None:
    data = bytearray(files[which])
    for place, byte in damage:
        data[max(8, len(data) - place)] = byte
    path = tmp_path / "damaged.mcap"
    path.write_bytes(data)
    with suppress(LogError):
        use(path)


def test_what_begins_and_ends_as_it_should(tmp_path: Path) -> None:
    whole = write_log(tmp_path / "a.mcap", drive(0.2))
    cut_off = tmp_path / "b.mcap"
    cut_off.write_bytes(whole.read_bytes()[:-1])
    empty = tmp_path / "c.mcap"
    empty.write_bytes(whole.read_bytes()[:8])
    answers = []
    for path in (whole, cut_off, empty):
        with path.open("rb") as file:
            answers.append((is_mcap(path), is_closed(file)))
    assert answers == [(True, True), (True, False), (True, False)]
    assert not is_mcap(tmp_path)
    assert not is_mcap(tmp_path / "nowhere.mcap")
