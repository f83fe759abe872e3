"""Process-wide settings of OpenCV."""

from __future__ import annotations

import cv2


def use_calling_thread() -> None:
    """Keep OpenCV's work in the calling thread, for the whole process.

    Work in its own thread pool would be missing from the modules' CPU times, and so from attention.
    """
    cv2.setNumThreads(0)
