"""The cost of replaying a recording: reading it, and running the whole program on it.

The recording is the reference of the simulated lab (a minute of driving past posters). *read*: every message decoded,
pictures and depth included, beside rosbags' AnyReader that deserializes the same topics and OpenCV that decodes the
same JPEGs. *headless*: all modules and attention on it, in virtual time; *sensors only* leaves out the perceptions.
``python -m benchmarks.replay`` prints the table. *times real time* counts CPU time of the process, all its threads.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from rosbags.highlevel import AnyReader

from app.logs.open import open_log
from app.logs.replay.headless import run_headless
from app.logs.replay.options import ReplayOptions
from benchmarks.report import Row, benchmark_main, row

LOG = Path(__file__).resolve().parent.parent / "tests" / "references" / "lab.mcap"
SENSORS = ("Kinect", "Hokuyo", "WheelOdometry")


def measure(rounds: int) -> list[Row]:
    """All cases, ours and the peer's in turn."""
    cv2.setNumThreads(1)
    log = open_log(LOG)
    duration_s = log.info.duration_s
    log.close()
    ours, peer, whole, sensors = [], [], [], []
    _cpu(_read_ours)
    for _ in range(rounds):
        ours.append(duration_s / _cpu(_read_ours))
        peer.append(duration_s / _cpu(_read_rosbags))
        whole.append(duration_s / _replay(ReplayOptions()))
        sensors.append(duration_s / _replay(ReplayOptions(only=SENSORS, desires=False)))
    unit = "× real time"
    return [
        row("replay", "read", "every message decoded", unit, ours, peer, "rosbags AnyReader + OpenCV"),
        row("replay", "headless", "whole program", unit, whole),
        row("replay", "headless", "sensors only", unit, sensors),
    ]


def _cpu(work: Callable[[], None]) -> float:
    began = time.process_time()
    work()
    return time.process_time() - began


def _read_ours() -> None:
    log = open_log(LOG)
    for _ in log.messages():
        pass
    log.close()


def _read_rosbags() -> None:
    """The topics that a robot's own log would have: derived ones are ours to add."""
    with AnyReader([LOG]) as reader:
        connections = [c for c in reader.connections if not _derived(c.topic)]
        for connection, _, raw in reader.messages(connections):
            message: Any = reader.deserialize(raw, connection.msgtype)
            if connection.msgtype == "sensor_msgs/msg/CompressedImage":
                cv2.cvtColor(np.asarray(cv2.imdecode(np.asarray(message.data), cv2.IMREAD_COLOR)), cv2.COLOR_BGR2RGB)


def _derived(topic: str) -> bool:
    return topic == "/tf" or topic.rpartition("/")[2] in ("camera_info", "points", "markers")


def _replay(options: ReplayOptions) -> float:
    """CPU time (s) of one headless replay, once it runs."""
    log = open_log(LOG)
    try:
        return run_headless(log, options, digests=False).cpu_s
    finally:
        log.close()


if __name__ == "__main__":
    sys.exit(benchmark_main(__doc__, lambda quick: measure(2 if quick else 7)))
