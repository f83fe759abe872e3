"""Damage in the middle of a recording: said in words, and read around."""

from __future__ import annotations

from pathlib import Path

import pytest

from app.logs.mcap.damage import LogDamaged, missing, place, skipping
from app.logs.mcap.reader import McapLog
from tests.logs.replay.logs import BEGIN, damage, lab_manifest, lab_messages, write_log


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_log(tmp_path_factory.mktemp("recordings") / "walk.mcap", lab_messages(4.0), lab_manifest())


@pytest.mark.parametrize(
    ("seconds", "words"),
    [(0.0, "0:00.0"), (7.5, "0:07.5"), (59.99, "0:59.9"), (60.0, "1:00.0"), (3723.45, "1:02:03.4"), (-1.0, "0:00.0")],
)
def test_a_place_in_words(seconds: float, words: str) -> None:
    assert place(seconds) == words


def test_reading_goes_on_behind_the_damaged_chunk(recording: Path, tmp_path: Path) -> None:
    path = tmp_path / "damaged.mcap"
    path.write_bytes(recording.read_bytes())
    begin, end = damage(path, BEGIN + 2.0)
    log, damages = McapLog(path), list[LogDamaged]()
    for since in (None, BEGIN + 1.0, (begin + end) / 2):
        damages.clear()
        came = [logged.at for logged in skipping(log, since, ("odometry",), damages.append)]
        expected = [m.at for m in lab_messages(4.0) if m.channel == "odometry" and m.at >= (since or 0.0)]
        assert came == pytest.approx([at for at in expected if not begin <= at <= end])
        assert [(d.begin, d.end) for d in damages] == [pytest.approx((begin, end))]
    words = f"{end - begin:.1f} s from {place(begin - BEGIN)} cannot be read"
    assert missing(damages[0], log.info) == words
    assert f"damaged.mcap is damaged: {words}. `hbba log repair" in str(damages[0])
    log.close()


def test_damage_at_the_end_leaves_nothing(recording: Path, tmp_path: Path) -> None:
    path = tmp_path / "damaged.mcap"
    path.write_bytes(recording.read_bytes())
    begin, _ = damage(path, BEGIN + 3.98)
    log, damages = McapLog(path), list[LogDamaged]()
    assert max(logged.at for logged in skipping(log, None, None, damages.append)) <= begin
    assert missing(damages[0], log.info) == f"nothing from {place(begin - BEGIN)} on can be read"
    log.close()
