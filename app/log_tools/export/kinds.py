"""The kinds of files that a log can be exported as; nothing heavy, since the command line reads it at every start."""

from __future__ import annotations

from collections.abc import Mapping

KINDS: Mapping[str, str] = {
    "png": "each image, and its depth in millimetres as 16 bit, named by its stamp",
    "mp4": "a video per camera, at the time it really took",
    "csv": "a table per channel of numbers and words",
    "wav": "the sound of each microphone",
    "pcd": "each depth image, scan or cloud as points in base_link, named by its stamp",
}
