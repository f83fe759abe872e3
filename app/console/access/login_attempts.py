"""Wrong tokens are slowed: each address by its own, and more so while many addresses try."""

from __future__ import annotations

import ipaddress
from collections import OrderedDict, deque
from collections.abc import Callable
from dataclasses import dataclass

#: So many mistakes cost nothing; each further one doubles the wait, from a second on.
FREE = 5
LONGEST_WAIT_S = 300.0
#: Mistakes of an address expire so long after its last one.
EXPIRE_AFTER_S = 900.0
#: With so many mistakes a minute, of all addresses, only the first one of an address is free.
MANY_A_MINUTE = 100
#: At most so many are kept; the one that was quiet for longest is dropped.
MOST_ADDRESSES = 1000


@dataclass(slots=True)
class _Mistakes:
    count: int
    last: float
    until: float


class Attempts:
    """Mistakes by address. ``now`` gives seconds of any steady clock.

    An address without a mistake never waits, however many others make some.
    """

    def __init__(self, now: Callable[[], float]) -> None:
        self._now = now
        self._mistakes: OrderedDict[str, _Mistakes] = OrderedDict()
        self._recent: deque[float] = deque(maxlen=MANY_A_MINUTE)

    def __len__(self) -> int:
        return len(self._mistakes)

    def wait_s(self, address: str) -> float:
        """Seconds until ``address`` may try again; 0: now."""
        mistakes = self._mistakes.get(origin_of(address))
        return 0.0 if mistakes is None else max(0.0, mistakes.until - self._now())

    def failed(self, address: str) -> None:
        """A token of ``address`` was wrong."""
        now, key = self._now(), origin_of(address)
        before = self._mistakes.pop(key, None)
        if before is None or now - before.last > EXPIRE_AFTER_S:
            before = _Mistakes(0, now, now)
        count = before.count + 1
        self._recent.append(now)
        beyond = count - (1 if self._many(now) else FREE)
        wait_s = 0.0 if beyond <= 0 else min(2.0 ** min(beyond - 1, 30), LONGEST_WAIT_S)
        self._mistakes[key] = _Mistakes(count, now, now + wait_s)
        while len(self._mistakes) > MOST_ADDRESSES:
            self._mistakes.popitem(last=False)

    def _many(self, now: float) -> bool:
        return len(self._recent) == MANY_A_MINUTE and now - self._recent[0] < 60.0


def origin_of(address: str) -> str:
    """The part of an address that counts as one: of IPv6 the network of 64 bits, which one computer has all of."""
    try:
        parsed = ipaddress.ip_address(address.partition("%")[0])
    except ValueError:
        return address
    if parsed.version == 4:
        return str(parsed)
    if (mapped := parsed.ipv4_mapped) is not None:
        return str(mapped)
    return str(ipaddress.ip_network((int(parsed) >> 64 << 64, 64)))
