"""The one thread that owns the scene. It is given work through a mailbox in which newer replaces older."""

from __future__ import annotations

import asyncio
import queue
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from app.runtime.worker import ModuleWorker

if TYPE_CHECKING:
    from app.console.view.host import ViewHost

Kind = Literal["robot", "joints", "scan", "cloud", "landmarks"]


@dataclass(frozen=True, slots=True)
class PainterStatistics:
    """``drawn`` messages, and ``replaced`` by a newer one before they could be drawn."""

    drawn: int
    replaced: int


class Painter:
    """Starts viser and draws, in a daemon thread of its own, since a call of viser that hangs must hold up nobody.

    ``admitted`` and ``points_of`` are called in other threads; ``ready(port)`` in the painter's, once viser listens.
    """

    def __init__(
        self,
        model: Path,
        admitted: Callable[[int], str | None],
        points_of: Callable[[str], int],
        ready: Callable[[int], None],
    ) -> None:
        self._model = model
        self._admitted = admitted
        self._points_of = points_of
        self._ready = ready
        self._mail: dict[Kind, Any] = {}
        #: Who came (viewer, client) or left (viewer, None), in order.
        self._visits: queue.SimpleQueue[tuple[str, Any]] = queue.SimpleQueue()
        self._bell: queue.SimpleQueue[bool] = queue.SimpleQueue()
        self._rung = False
        self._drawn = self._replaced = 0
        #: viser's server; set before ``ready`` is called.
        self.host: ViewHost | None = None
        self._worker = ModuleWorker("3D view")

    def start(self) -> asyncio.Future[None]:
        """Begin; returns at once. The future is done when the thread has ended, with its exception if it failed."""
        return asyncio.wrap_future(self._worker.submit(self._run))

    def post(self, kind: Kind, message: Any) -> None:
        """Have ``message`` drawn instead of the last of its kind that still waits."""
        if kind in self._mail:
            self._replaced += 1
        self._mail[kind] = message
        self._ring()

    def stop(self) -> None:
        """Let the thread stop viser and end."""
        self._bell.put(False)
        self._worker.shutdown()

    def statistics(self) -> PainterStatistics:
        """The counters now."""
        return PainterStatistics(self._drawn, self._replaced)

    def _ring(self) -> None:
        if not self._rung:
            self._rung = True
            self._bell.put(True)

    def _visit(self, viewer: str, client: Any) -> None:
        self._visits.put((viewer, client))
        self._ring()

    def _run(self) -> None:
        # Seconds of imports, which a program that nobody looks at is spared, and its event loop in any case.
        from app.console.view.host import ViewHost
        from app.console.view.scene import Scene

        self.host = host = ViewHost(self._admitted, self._visit, lambda viewer: self._visit(viewer, None))
        try:
            scene = Scene(host.server, self._model, self._points_of)
            self._ready(host.port)
            while self._bell.get():
                # Before the mail is read: what comes from here on rings again.
                self._rung = False
                self._draw(scene)
        finally:
            host.stop()

    def _draw(self, scene: Any) -> None:
        while not self._visits.empty():
            viewer, client = self._visits.get()
            if client is None:
                scene.viewer_left(viewer)
            else:
                scene.viewer_came(viewer, client)
        # "robot" last: a world that has moved must not be seen with what was measured before.
        for kind in ("joints", "landmarks", "scan", "cloud", "robot"):
            message = self._mail.pop(kind, None)
            if message is not None:
                getattr(scene, kind)(message)
                self._drawn += 1
