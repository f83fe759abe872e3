"""A Zenoh session between the robot and its nodes: who listens, who connects, and bytes to and from the event loop.

Nothing is scouted for and no plugin is loaded: the two ends know each other by an address, or not at all. Zenoh's
threads hand over to the loop by :class:`Mailbox`; what is sent goes by :class:`Outbox`, whose thread may wait.
"""

from __future__ import annotations

import asyncio
import json
import logging
import threading
from collections import deque
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from app.base.errors import ConfigError
from app.remote.settings import TlsFiles, checked_endpoint

if TYPE_CHECKING:
    import zenoh

T = TypeVar("T")

log = logging.getLogger("hbba.remote")

PREFIX = "hbba/nodes"
ROBOT_ALIVE = f"{PREFIX}/robot"
#: A peer that says nothing for so long is taken for lost by Zenoh; a frozen one is found sooner, by its beats.
LEASE_MS = 1000
#: A message from elsewhere that is larger is refused before it is put together.
MOST_BYTES = 64 * 1024 * 1024
#: Envelopes that may wait for the loop, and to be sent.
MOST_WAITING = 512


def join_key(node: str) -> str:
    return f"{PREFIX}/{node}/join"


def alive_key(node: str, instance: str) -> str:
    return f"{PREFIX}/{node}/{instance}/alive"


def to_key(node: str, instance: str) -> str:
    return f"{PREFIX}/{node}/{instance}/to"


def from_key(node: str, instance: str) -> str:
    return f"{PREFIX}/{node}/{instance}/from"


def configuration(*, listen: str | None = None, join: str | None = None, tls: TlsFiles | None = None) -> dict[str, Any]:
    """Zenoh's settings, by path, of the end that listens or of the one that joins. Raises ValueError for an endpoint
    that may not be used."""
    endpoint = checked_endpoint(listen or join or "")
    if endpoint.startswith("tls/") and tls is None:
        raise ValueError(f"{endpoint} needs certificates: of the authority, and this end's own with its key")
    settings: dict[str, Any] = {
        "mode": "peer",
        "listen/endpoints": [endpoint] if listen else [],
        "listen/exit_on_failure": True,
        "connect/endpoints": [endpoint] if join else [],
        "connect/exit_on_failure": False,
        "connect/timeout_ms": -1,
        "connect/retry": {"period_init_ms": 200, "period_max_ms": 1000, "period_increase_factor": 2},
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        "transport/link/protocols": [endpoint.partition("/")[0]],
        "transport/link/tx/lease": LEASE_MS,
        "transport/link/rx/max_message_size": MOST_BYTES,
        "transport/shared_memory/enabled": False,
    }
    if tls is not None:
        side = "listen" if listen else "connect"
        settings |= {
            "transport/link/tls/root_ca_certificate": str(tls.ca),
            "transport/link/tls/enable_mtls": True,
            "transport/link/tls/verify_name_on_connect": True,
            f"transport/link/tls/{side}_certificate": str(tls.certificate),
            f"transport/link/tls/{side}_private_key": str(tls.key),
        }
    return settings


def open_session(settings: dict[str, Any]) -> zenoh.Session:
    """A session with these settings; it blocks. Raises ConfigError where Zenoh is absent or cannot listen."""
    try:
        import zenoh
    except ImportError:
        raise ConfigError("nodes need Zenoh, which is not installed: pip install 'hbba[remote]'") from None
    config = zenoh.Config()
    for path, value in settings.items():
        config.insert_json5(path, json.dumps(value))
    try:
        return zenoh.open(config)
    except zenoh.ZError as failure:
        where = (settings["listen/endpoints"] or settings["connect/endpoints"])[0]
        raise ConfigError(f"Zenoh does not open {where}: {str(failure).splitlines()[0]}") from failure


class Mailbox(Generic[T]):
    """Passes on to ``take``, on the event loop, what other threads put; bounded: the oldest are lost, and logged."""

    def __init__(self, name: str, take: Callable[[T], None], capacity: int = MOST_WAITING) -> None:
        self._name = name
        self._take = take
        self._loop = asyncio.get_running_loop()
        self._lock = threading.Lock()
        self._waiting: deque[T] = deque(maxlen=capacity)
        self._scheduled = self._closed = False
        self.lost = 0

    def put(self, item: T) -> None:
        """From any thread; never waits."""
        with self._lock:
            if self._closed:
                return
            self.lost += len(self._waiting) == self._waiting.maxlen
            self._waiting.append(item)
            if self._scheduled:
                return
            self._scheduled = True
        self._loop.call_soon_threadsafe(self._drain)

    def close(self) -> None:
        """Hand nothing over any more."""
        with self._lock:
            self._closed = True
            self._waiting.clear()

    def _drain(self) -> None:
        with self._lock:
            items, lost = list(self._waiting), self.lost
            self._waiting.clear()
            self._scheduled, self.lost = False, 0
        if lost:
            log.warning("%s: %d messages came faster than they could be taken, and are lost", self._name, lost)
        for item in items:
            self._take(item)


class Outbox:
    """Sends bytes to one key, in order, from a thread of its own; what does not fit its queue is dropped, and counted
    in ``dropped``."""

    def __init__(self, session: zenoh.Session, key: str) -> None:
        self._session = session
        self._key = key
        self._thread = ThreadPoolExecutor(1, thread_name_prefix=f"send {key}")
        self._waiting = 0
        self._lock = threading.Lock()
        self.dropped = 0
        self.sent_bytes = 0

    def send(self, data: bytes, *, newest: bool = False) -> None:
        """Send ``data`` beside the loop. ``newest``: given up where the link is congested, since a newer one comes."""
        with self._lock:
            if self._waiting >= MOST_WAITING:
                self.dropped += 1
                return
            self._waiting += 1
        try:
            self._thread.submit(self._put, data, newest)
        except RuntimeError:  # closed meanwhile
            self._waiting = 0

    def close(self) -> None:
        """Send nothing any more; what waits is dropped."""
        self._thread.shutdown(wait=False, cancel_futures=True)

    def _put(self, data: bytes, newest: bool) -> None:
        import zenoh

        control = zenoh.CongestionControl.DROP if newest else zenoh.CongestionControl.BLOCK
        try:
            self._session.put(self._key, data, congestion_control=control, express=True)
            self.sent_bytes += len(data)
        except zenoh.ZError as failure:
            log.info("nothing can be sent to %s: %s", self._key, str(failure).splitlines()[0])
        finally:
            with self._lock:
                self._waiting -= 1
