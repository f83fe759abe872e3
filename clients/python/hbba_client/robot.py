"""The robot for programs that wait for each answer."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Self

import httpx
import msgspec
from websockets.exceptions import InvalidHandshake, InvalidStatus
from websockets.sync.client import connect

from .held import LONGEST_WAIT_S, RENEWALS, new_desire, renewal
from .live import NO_PICTURES, message_of
from .operations import Operations
from .records import Desire, DesireReport
from .request import BASE, Problem, Request, Unreachable, address_of, headers_of, live_url, problem_of, with_cookies


class HeldDesire:
    """A desire that is renewed until its block ends."""

    def __init__(self, robot: Robot, desire: Desire) -> None:
        self.robot = robot
        self.desire = desire

    @property
    def id(self) -> str:
        """The desire's id."""
        return self.desire.id

    def wait(self, timeout_s: float = LONGEST_WAIT_S) -> DesireReport:
        """Wait for its outcome, ``timeout_s`` at the most; ``outcome`` of the report is null where none came."""
        until = time.monotonic() + timeout_s
        while True:
            left = max(0.0, until - time.monotonic())
            report = self.robot.get_desire(self.id, wait=min(left, LONGEST_WAIT_S))
            if report.outcome is not None or left <= LONGEST_WAIT_S:
                return report


class Robot(Operations):
    """A console at ``address``; None: ``HBBA_ADDRESS`` of the environment, or ``http://127.0.0.1:8080``.

    ``token``: the console's, where it asks for one; None: ``HBBA_TOKEN`` of the environment (``log_in`` is for
    passwords). ``operator``: the name that others
    see beside what this program does. ``etags``: the newest version of what was read, by path, for ``if_match``.
    Refusals are raised as Problem, a console that does not answer as Unreachable.
    """

    def __init__(
        self,
        address: str | None = None,
        *,
        token: str | None = None,
        operator: str | None = None,
        transport: httpx.BaseTransport | None = None,
    ) -> None:
        self.address = address_of(address)
        self.operator = operator
        self.etags: dict[str, str] = {}
        self._headers = headers_of(token, operator)
        self._http = httpx.Client(base_url=self.address, headers=self._headers, transport=transport)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the connections."""
        self._http.close()

    def ask(self, request: Request) -> Any:
        """The answer to ``request``. Raises Problem for a refusal, Unreachable where none comes."""
        try:
            response = self._http.request(**request.options())
        except httpx.TransportError as failure:
            raise Unreachable(f"{self.address} does not answer: {failure}") from failure
        if etag := response.headers.get("etag"):
            self.etags[request.path] = etag
        return request.decoded(response)

    def download_recording(self, name: str, file: Path) -> None:
        """Write the recording ``name`` to ``file``. Role: spectator."""
        url = f"{BASE}/recordings/{Request.quoted(name)}"
        with self._http.stream("GET", url, timeout=httpx.Timeout(30.0)) as response:
            if response.status_code >= 400:
                response.read()
                raise problem_of(response.status_code, response.content)
            with file.open("wb") as out:
                for piece in response.iter_bytes():
                    out.write(piece)

    @contextmanager
    def desire(
        self,
        desire_class: str,
        params: dict[str, Any] | None = None,
        *,
        intensity: float = 4.0,
        utility: float = 1.0,
        security: bool = False,
        ttl: float = 30.0,
    ) -> Iterator[HeldDesire]:
        """Desire something for as long as the block lasts.

        The desire is renewed meanwhile and removed at the end; where this program dies it expires within ``ttl``
        seconds. One that the robot has accomplished, or somebody removed, is not created again.
        """
        body = new_desire(desire_class, params or {}, intensity=intensity, utility=utility, security=security, ttl=ttl)
        held = HeldDesire(self, self.create_desire(body))
        over = threading.Event()
        renewing = threading.Thread(target=self._renew, args=(held.id, ttl, over), name=f"renew {held.id}", daemon=True)
        renewing.start()
        try:
            yield held
        finally:
            over.set()
            renewing.join()
            self._remove(held.id)

    def _renew(self, desire: str, ttl: float, over: threading.Event) -> None:
        while not over.wait(ttl / RENEWALS):
            try:
                self.change_desire(desire, renewal(ttl))
            except Problem:
                return  # it has left
            except Unreachable:
                continue

    def _remove(self, desire: str) -> None:
        with suppress(Unreachable):  # it expires
            try:
                self.remove_desire(desire)
            except Problem as problem:
                if problem.status != 404:
                    raise

    @contextmanager
    def live(self) -> Iterator[Iterator[msgspec.Struct]]:
        """The live stream: records as they come, of the types in ``hbba_client.records.LIVE``.

        While a stream is open the robot attends to telepresence, as for a page. Raises Unreachable.
        """
        headers = with_cookies(self._headers, self._http.cookies)
        try:
            connection = connect(live_url(self.address, self.operator), additional_headers=headers)
        except InvalidStatus as refusal:
            raise problem_of(refusal.response.status_code, bytes(refusal.response.body)) from None
        except (OSError, InvalidHandshake) as failure:
            raise Unreachable(f"{self.address} does not answer: {failure}") from failure
        with connection:
            connection.send(NO_PICTURES)
            yield (message for frame in connection if (message := message_of(frame)) is not None)
