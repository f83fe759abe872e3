"""A process whose loop is to be on time."""

from __future__ import annotations

import subprocess
import sys

CHECK = """
import gc, sys, time
from app.runtime.punctual import be_punctual
objects = [[number] for number in range(300_000)]
be_punctual()
begin = time.thread_time()
gc.collect()
assert time.thread_time() - begin < 0.005, "what stood before is looked at"
assert gc.get_freeze_count() >= 300_000
assert sys.getswitchinterval() <= 0.001
"""


def test_what_stands_is_not_looked_at_again_and_threads_give_way_sooner() -> None:
    subprocess.run([sys.executable, "-c", CHECK], check=True, timeout=20)  # habits of a whole process
