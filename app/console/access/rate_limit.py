"""How often one client may do something: a bucket each, which fills again with time."""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Callable, Hashable

from app.console.problems import Problem

#: At most so many clients are kept; of more, the one that was quiet for longest is dropped.
MOST_CLIENTS = 1000


class RateLimit:
    """``burst`` at once, and ``per_s`` a second in the long run, for each client; ``now`` gives seconds of any steady
    clock."""

    def __init__(self, now: Callable[[], float], *, burst: int, per_s: float) -> None:
        self._now = now
        self._burst = burst
        self._per_s = per_s
        #: What is left of each client's bucket, and when that was.
        self._left: OrderedDict[Hashable, tuple[float, float]] = OrderedDict()

    def __len__(self) -> int:
        return len(self._left)

    def wait_s(self, client: Hashable) -> float:
        """Take one of ``client``'s; 0, or seconds until there is one to take."""
        now = self._now()
        left, at = self._left.pop(client, (float(self._burst), now))
        left = min(left + (now - at) * self._per_s, float(self._burst))
        wait_s = 0.0 if left >= 1 else (1 - left) / self._per_s
        self._left[client] = (left if wait_s else left - 1, now)
        while len(self._left) > MOST_CLIENTS:
            self._left.popitem(last=False)
        return wait_s

    def take(self, client: Hashable) -> None:
        """Take one of ``client``'s. Raises Problem where there is none."""
        if (wait_s := self.wait_s(client)) > 0:
            seconds = math.ceil(wait_s)
            raise Problem(
                429,
                "too-many-requests",
                f"That was asked too often: try again in {seconds} s.",
                headers={"Retry-After": str(seconds)},
            )
