"""How large and how good one viewer's pictures are, and how many are on the way, from how late they are drawn: pure.

The lag that counts is what comes on top of the viewer's shortest round trip: leaving, waiting on the way, drawing.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

#: What drawing may come later than the shortest round trip (s).
TARGET_S = 0.08
_COMFORT = 0.4
_SMOOTHING = 0.35
#: Time (s) for a change to show before the next; and before a better picture is tried again, more after each failure.
_SETTLE_S = 0.4
_FIRST_TRY_S = 3.0
_LAST_TRY_S = 30.0
#: A better picture that is too late within this time (s) has failed.
_FAILED_WITHIN_S = 3.0
#: A round trip counts as the shortest for so long (s).
_SHORTEST_KEPT_S = 30.0
#: Pictures come 15 times a second: so many may be on the way on a long link, if nothing waits there.
_PERIOD_S = 1 / 15
MOST_UNDER_WAY = 6

#: Share of the width that is shown, and JPEG's quality (None: as it comes), the best first; each takes about 0.7 of the
#: bytes of the one before.
RUNGS: tuple[tuple[float, int | None], ...] = (
    (1.0, None),
    (1.0, 60),
    (0.85, 55),
    (0.7, 50),
    (0.6, 45),
    (0.5, 40),
    (0.4, 35),
    (0.33, 30),
    (0.25, 25),
)
#: From the second rung on, for a page that decodes VP9: share of the width, and bits for each pixel of a picture. Not
#: on the first: a VP9 takes a third to a fifth of the bytes of a JPEG, and two to five times the processor
#: (``python -m benchmarks.picture_coding``), which a link that is fast enough does not ask for.
VIDEO_RUNGS: tuple[tuple[float, float], ...] = (
    (1.0, 0.17),
    (1.0, 0.12),
    (0.85, 0.12),
    (0.7, 0.12),
    (0.6, 0.12),
    (0.5, 0.12),
    (0.4, 0.12),
    (0.25, 0.16),
)
#: JPEGs of the first rung take several times the bytes of video: the longest time (s) until they are tried again.
_LAST_TRY_OF_JPEG_S = 240.0
#: Pictures have one of these widths (px), so that viewers share them.
WIDTHS = (120, 160, 200, 240, 320, 400, 480, 560, 640, 800, 960, 1280, 1600, 1920)


@dataclass(frozen=True, slots=True)
class Form:
    """``width`` in px (None: as it comes) and JPEG's ``quality`` (None: as it comes) of a viewer's pictures.

    ``bits`` for each pixel of a picture that is VP9, > 0; None: it is a JPEG.
    """

    width: int | None = None
    quality: int | None = None
    bits: float | None = None


@dataclass(frozen=True, slots=True)
class PictureBudget:
    """``rung`` of :data:`RUNGS`; the smoothed lag ``late_s`` beyond the shortest round trip ``trip_s``."""

    rung: int = 0
    late_s: float | None = None
    trip_s: float | None = None
    trip_at: float = 0.0
    changed_at: float = 0.0
    raised_at: float = -1e9
    try_after_s: float = _FIRST_TRY_S
    try_jpeg_after_s: float = _FIRST_TRY_S

    @property
    def most_under_way(self) -> int:
        """How many pictures may be on the way: as many as a long link holds, one where they wait on it."""
        if self.trip_s is None or self.late_s is None or self.late_s > TARGET_S:
            return 1
        return min(MOST_UNDER_WAY, 1 + int(self.trip_s / _PERIOD_S))

    def form(self, source: int, shown: int | None, *, vp9: bool = False) -> Form:
        """The form of a picture ``source`` px wide that is ``shown`` that wide (None: not known, all of it), for a page
        that decodes ``vp9`` or does not."""
        video = vp9 and self.rung > 0
        share, quality = RUNGS[self.rung]
        if video:
            share, bits = VIDEO_RUNGS[self.rung - 1]
        wanted = share * min(shown or source, source)
        width = next((width for width in WIDTHS if width >= wanted), source)
        whole = width > 0.8 * source and share == 1.0
        if video:
            return Form(source if whole else min(width, source), bits=bits)
        if whole:
            return Form(None, quality)
        return Form(min(width, source), quality or 70)


def round_trip(budget: PictureBudget, trip_s: float, now: float) -> PictureBudget:
    """The budget after a round trip of a small message was measured."""
    if budget.trip_s is None or trip_s <= budget.trip_s or now - budget.trip_at > _SHORTEST_KEPT_S:
        return replace(budget, trip_s=trip_s, trip_at=now)
    return budget


def drawn(budget: PictureBudget, lag_s: float, now: float, *, vp9: bool = False) -> PictureBudget:
    """The budget after the page, which decodes ``vp9`` or does not, said that a picture was drawn, ``lag_s`` after it
    was sent; ``now`` in s."""
    late = max(0.0, lag_s - (budget.trip_s or 0.0))
    smooth = late if budget.late_s is None else budget.late_s + _SMOOTHING * (late - budget.late_s)
    after = replace(budget, late_s=smooth)
    since = now - budget.changed_at
    # By the better of the two: one late picture is no trend, and a trend that has ended must not cut on.
    if min(smooth, late) > TARGET_S and since >= _SETTLE_S and budget.rung < len(RUNGS) - 1:
        failed = now - budget.raised_at < _FAILED_WITHIN_S
        if vp9 and budget.rung == 0:
            # From JPEG to video: a fifth of the bytes.
            again = min(2 * budget.try_jpeg_after_s, _LAST_TRY_OF_JPEG_S) if failed else _FIRST_TRY_S
            return replace(after, rung=1, changed_at=now, try_jpeg_after_s=again)
        try_after = min(2 * budget.try_after_s, _LAST_TRY_S) if failed else budget.try_after_s
        # Far too late: two at once.
        steps = 2 if late > 2 * TARGET_S else 1
        return replace(after, rung=min(budget.rung + steps, len(RUNGS) - 1), changed_at=now, try_after_s=try_after)
    waits = max(budget.try_after_s, budget.try_jpeg_after_s) if vp9 and budget.rung == 1 else budget.try_after_s
    if smooth < _COMFORT * TARGET_S and since >= waits and budget.rung > 0:
        kept = now - budget.raised_at > 2 * _FAILED_WITHIN_S
        calm = _FIRST_TRY_S if kept and budget.raised_at > budget.changed_at - _SETTLE_S else budget.try_after_s
        return replace(after, rung=budget.rung - 1, changed_at=now, raised_at=now, try_after_s=calm)
    return after
