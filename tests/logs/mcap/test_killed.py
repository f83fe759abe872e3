"""A program killed while it records: what it wrote until a second before can be read."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from app.log_tools.repair import repair
from app.logs.mcap.reader import McapLog

CHILD = """
import sys, threading, time
from pathlib import Path
from app.logs.mcap.file_sink import FileSink
from app.logs.mcap.writer import Limits, RecordingWriter
from tests.logs.mcap.disks import MANIFEST, encoder, image, odometry

def watch():
    global late
    while True:
        asleep = time.monotonic()
        time.sleep(0.02)
        late = max(late, time.monotonic() - asleep - 0.02)

late = 0.0
threading.Thread(target=watch, daemon=True).start()
path = Path(sys.argv[1])
began = time.time()
writer = RecordingWriter(lambda: FileSink([path], encoder(), MANIFEST, began), Limits(least_free_bytes=0), time.time)
number = 0
while True:
    now = time.time()
    writer.put(now, "odometry", odometry(now))
    if number % 7 == 0:
        writer.put(now, "kinect", image(now, seed=number))
    number += 1
    if now - began > float(sys.argv[2]):
        print(f"{began!r} {now!r} {number} {late}", flush=True)
    time.sleep(0.01)
"""


@pytest.mark.slow
@pytest.mark.parametrize("after_s", [0.8, 1.65, 2.3])
def test_a_killed_recording_misses_at_most_its_last_second(tmp_path: Path, after_s: float) -> None:
    path, mended = tmp_path / "log.mcap", tmp_path / "mended.mcap"
    child = subprocess.Popen(
        [sys.executable, "-c", CHILD, str(path), str(after_s)],
        stdout=subprocess.PIPE, text=True, cwd=Path(__file__).parents[3],
    )  # fmt: skip
    with child:
        assert child.stdout is not None
        began, last, number, late = child.stdout.readline().split()
        os.kill(child.pid, signal.SIGKILL)
    repair(path, mended)
    log = McapLog(mended)
    try:
        messages = list(log.messages())
        odometries = [logged for logged in messages if logged.channel == "odometry"]
        # The writer's thread was as late as others of its process, on a busy computer: at starting, writing, flushing.
        newest = odometries[-1].at if odometries else float(began)
        assert newest >= float(last) - 1.0 - 3 * float(late)
        assert len(odometries) <= int(number) + 10
        # Nothing is missing in between: what is there are the first so many, each at its time.
        assert [logged.message.stamp for logged in odometries] == [logged.at for logged in odometries]
        assert len([logged for logged in messages if logged.channel == "kinect"]) >= len(odometries) // 7
        assert log.manifest.facts["robot"] == "a test body"
        assert [file.name for file in log.manifest.files] == ["lab.yaml"]
    finally:
        log.close()
