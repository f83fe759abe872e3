"""HBBA: a robot runtime with selective attention and a web operator console.

Whatever imports any of it sends nothing anywhere: libraries that would report to their makers are silenced here, before
one of them can be loaded, in every process of the program.
"""

import os

#: ONNX Runtime (1.32) reads it when it is loaded; without, it keeps an identifier of the computer and a queue of
#: reports in the home folder. A value that is set already is kept.
os.environ.setdefault("ORT_DISABLE_TELEMETRY", "1")
