"""Whether the sensors may be driven by: fresh, and depth pictures that are alive (the thesis's silent Kinect failure)."""

from __future__ import annotations

from dataclasses import dataclass

from app.messages import Image, LaserScan


@dataclass(frozen=True, slots=True)
class DepthWatch:
    """What became of the depth pictures: ``good`` is the stamp of the newest that was alive, None before the first;
    ``problem`` says what is wrong with the newest, "" if nothing; ``digest`` of its pixels."""

    good: float | None = None
    problem: str = ""
    digest: int = 0


def watch_depth(watch: DepthWatch, image: Image, scan: LaserScan | None = None) -> DepthWatch:
    """Look at one more picture: all zero, all the same, or the one before over again is not alive.

    A wall so near that a depth camera is blind to it leaves zeros too: ``scan`` tells, if it shows one there.
    """
    raise NotImplementedError


def unfit(
    now: float,
    scan_stamp: float | None,
    depth: DepthWatch | None,
    limit_s: float = 0.3,
) -> str:
    """Why the robot must not be driven, in words; "" if it may. ``depth`` None: a body without such a camera."""
    raise NotImplementedError
