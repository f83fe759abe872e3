"""How old an operator's command is when it comes: an upper bound that no delay can hide.

A message of a page says three times: when it was sent and when the newest stamp of the robot had come (both by the
page's clock), and that stamp (by the robot's clock). With its arrival here these are NTP's four timestamps (RFC 5905),
taken from this end:

    robot   T1 heard ──────╮                      ╭──▶ T4 now
                           ▼                      │
    page              T2 heard_at ──────▶ T3 sent

What has to be added to the page's clock to give the robot's is at least T1 - T2, for nothing arrives before it is sent.
That is NTP's offset less its uncertainty of half the round trip; of the last seconds, the sample whose answer was the
quickest counts, lowered by what the clocks may have drifted since. So a command is at most T4 - T3 - (T1 - T2) old.
NTP's own estimate would suppose that both ways take equally long: if the way here alone were late by 3 s, it would call
the command 1.5 s old. The bound supposes nothing: it errs only to the safe side, by how long the robot's own words take
to the page. How old what the operator sees is, T4 - T1, needs no clock but the robot's.

A command that is a little late still drives, slower: so that the way driven until a release arrives stays the same.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

#: Two clocks differ in rate by less: each is slewed by at most 500 ppm.
DRIFT = 1e-3
WINDOW_S = 30.0
#: Browsers round their clock, to 16.7 ms at worst.
RESOLUTION_S = 0.02
#: A command whose time lies further ahead of the robot's is of a clock that is not understood.
FUTURE_TOLERANCE_S = 0.05
#: What the operator sees may be older than a command by this: the page itself refuses to drive when it has heard no
#: status for so long.
VIEW_ALLOWANCE_S = 0.5
#: Late for longer, a hold is over: a hitch gives no notice, and the key need not be pressed again after it.
LASTING_S = 0.5
#: The same for full speed.
FULL_VIEW_ALLOWANCE_S = 0.2
#: Once slowed, by as much (s) a second the age that counts falls: jitter does not make the speed waver.
RECOVERY = 0.05
#: A limit that takes less of the speed is none.
LEAST_LIMIT = 0.02
_MOST_SAMPLES = 1000

UNTIMED = "A command without t, heard and heard_t does not say when it was given (How old a command is, live-stream.md)"
FUTURE = "The command comes from the future: this page's clock is not understood"


@dataclass(frozen=True, slots=True)
class Times:
    """Times (s) in a message: ``sent`` and ``heard_at`` by the page's clock, ``heard`` by the robot's."""

    sent: float
    heard: float
    heard_at: float


@dataclass(frozen=True, slots=True)
class Judgement:
    """``cause``: why the message may move nothing, a clause for people, "" where it may.

    ``age_s``: how old it is at most, None where that is not known. ``lasting``: it has been so for a while. ``share``:
    of the body's speeds, 0 to 1, that it may command, and ``slowed`` why that is not all of them, a clause for people.
    """

    cause: str = ""
    age_s: float | None = None
    lasting: bool = False
    share: float = 1.0
    slowed: str = ""


class OffsetBound:
    """The least (s) that has to be added to a page's clock to give the robot's."""

    def __init__(self) -> None:
        #: (when by the robot's clock, offset), the best first; each is worth more than those after it.
        self._samples: deque[tuple[float, float]] = deque(maxlen=_MOST_SAMPLES)

    def hear(self, heard: float, heard_at: float) -> None:
        """The robot's stamp ``heard`` was there at ``heard_at`` of the page's clock."""
        sample = (heard, heard - heard_at)
        while self._samples and _worth(self._samples[-1]) <= _worth(sample):
            self._samples.pop()
        self._samples.append(sample)

    def at(self, now: float) -> float:
        """The bound at ``now`` of the robot's clock; there must have been a sample."""
        while len(self._samples) > 1 and self._samples[0][0] < now - WINDOW_S:
            self._samples.popleft()
        heard, offset = self._samples[0]
        return offset - DRIFT * max(0.0, now - heard)

    def reset(self) -> None:
        """Drop all samples."""
        self._samples.clear()


def _words(seconds: float) -> str:
    return f"{seconds:.1f} s" if seconds < 60 else "many minutes"


def _worth(sample: tuple[float, float]) -> float:
    heard, offset = sample
    return offset + DRIFT * heard


class CommandAge:
    """Judges the messages of one page: a command is valid for ``validity_s``, and up to ``full_speed_s`` it has the
    body's full speed."""

    def __init__(self, validity_s: float, full_speed_s: float | None = None) -> None:
        """``full_speed_s`` None: as long as it is valid."""
        self._validity_s = validity_s
        self._full_speed_s = validity_s if full_speed_s is None else min(full_speed_s, validity_s)
        #: The greatest delays lately (s): of commands, and of what the operator sees; and as of when.
        self._slow_age_s = self._slow_view_s = 0.0
        self._slow_at = 0.0
        self._offset = OffsetBound()
        self._late_since: float | None = None
        #: Of the last message that could be judged.
        self.last = Judgement()

    def judge(self, now: float, times: Times | None) -> Judgement:
        """Whether a message that came ``now`` may move something; ``times`` None: it does not say when it was sent."""
        if times is None:
            return Judgement(UNTIMED, lasting=True)
        self.last = self._judge(now, times)
        return self.last

    def _judge(self, now: float, times: Times) -> Judgement:
        self._offset.hear(times.heard, times.heard_at)
        age_s = now - (times.sent + self._offset.at(now))
        view_s = now - times.heard
        if not min(age_s, view_s) >= -FUTURE_TOLERANCE_S:
            self._offset.reset()
            return Judgement(FUTURE, lasting=True)
        age_s = max(0.0, age_s) + RESOLUTION_S
        if age_s > self._validity_s:
            cause = f"Commands arrive up to {_words(age_s)} late"
        elif view_s > self._validity_s + VIEW_ALLOWANCE_S:
            cause = f"What you see is {_words(view_s)} old"
        else:
            self._late_since = None
            share, slowed = self._limit(now, age_s, view_s)
            return Judgement(age_s=age_s, share=share, slowed=slowed)
        if self._late_since is None:
            self._late_since = now
        return Judgement(cause, age_s, now - self._late_since >= LASTING_S)

    def _limit(self, now: float, age_s: float, view_s: float) -> tuple[float, str]:
        """The share of the speed for the delays of late, and why it is not all."""
        fallen = RECOVERY * max(0.0, now - self._slow_at)
        self._slow_age_s = max(age_s, self._slow_age_s - fallen)
        self._slow_view_s = max(view_s, self._slow_view_s - fallen)
        self._slow_at = now
        by_age = self._full_speed_s / max(self._slow_age_s, self._full_speed_s)
        full_view_s = self._full_speed_s + FULL_VIEW_ALLOWANCE_S
        by_view = full_view_s / max(self._slow_view_s, full_view_s)
        share = min(by_age, by_view)
        if share > 1.0 - LEAST_LIMIT:
            return 1.0, ""
        if by_age <= by_view:
            return share, f"commands arrive up to {self._slow_age_s:.2f} s late"
        return share, f"what you see is {self._slow_view_s:.2f} s old"
