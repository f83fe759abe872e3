"""OpenCV as this program uses it."""

from __future__ import annotations

import cv2


def use_calling_thread() -> None:
    """Keep OpenCV's work in the thread that calls it, for the whole process.

    Its own thread pool would do the work where no module's CPU time is measured, and where attention cannot see it.
    """
    cv2.setNumThreads(0)
