"""A program killed while it records: what it wrote until a second before can be read."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from app.log_tools.repair import repair
from app.logs.mcap.reader import McapLog
from app.logs.mcap.writer import BEAT_S, FLUSH_S

CHILD = """
import os, signal, sys, time
from pathlib import Path
from app.logs.mcap.file_sink import FileSink
from app.logs.mcap.writer import Limits, RecordingWriter
from tests.logs.mcap.disks import MANIFEST, encoder, image, odometry

class Watched(FileSink):
    written = flushed = 0.0

    def write(self, at, channel, message):
        super().write(at, channel, message)
        self.written = at

    def flush(self):
        until = self.written
        super().flush()
        self.flushed = until

path = Path(sys.argv[1])
began = time.time()
writer = RecordingWriter(lambda: Watched([path], encoder(), MANIFEST, began), Limits(least_free_bytes=0), time.time)
number = 0
while True:
    now = time.time()
    writer.put(now, "odometry", odometry(now))
    if number % 7 == 0:
        writer.put(now, "kinect", image(now, seed=number))
    number += 1
    if now - began > float(sys.argv[2]) and writer.sink and writer.sink.flushed:
        print(f"{writer.sink.flushed!r} {number}", flush=True)
        os.kill(os.getpid(), signal.SIGKILL)
    time.sleep(0.01)
"""


@pytest.mark.slow
@pytest.mark.parametrize("after_s", [0.8, 1.65, 2.3])
def test_a_killed_recording_has_all_that_was_flushed_twice_a_second(tmp_path: Path, after_s: float) -> None:
    path, mended = tmp_path / "log.mcap", tmp_path / "mended.mcap"
    child = subprocess.run(
        [sys.executable, "-c", CHILD, str(path), str(after_s)],
        stdout=subprocess.PIPE, text=True, cwd=Path(__file__).parents[3], check=False,
    )  # fmt: skip
    assert child.returncode == -signal.SIGKILL
    flushed, number = child.stdout.split()
    assert FLUSH_S + BEAT_S < 1.0, "a second is what is promised to be lost at most"
    repair(path, mended)
    log = McapLog(mended)
    try:
        messages = list(log.messages())
        odometries = [logged for logged in messages if logged.channel == "odometry"]
        assert messages[-1].at >= float(flushed)
        assert len(odometries) <= int(number)
        # Nothing is missing in between: what is there are the first so many, each at its time.
        assert [logged.message.stamp for logged in odometries] == [logged.at for logged in odometries]
        assert len([logged for logged in messages if logged.channel == "kinect"]) >= len(odometries) // 7
        assert log.manifest.facts["robot"] == "a test body"
        assert [file.name for file in log.manifest.files] == ["lab.yaml"]
    finally:
        log.close()
