"""The one thread that owns the scenes. It draws the newest state of the world at each viewer's pace."""

from __future__ import annotations

import asyncio
import queue
import time
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.console.view.scene_state import World
from app.console.view.viewer_rate import Pace
from app.link import BaseLimits
from app.runtime.worker import ModuleWorker

if TYPE_CHECKING:
    from app.console.view.host import ViewHost
    from app.console.view.picking import Pick
    from app.console.view.viewer_camera import CameraState


@dataclass(frozen=True, slots=True)
class PainterStatistics:
    """``drawn`` parts of the world, over all viewers; the longest time (s) that drawing one round took."""

    drawn: int
    longest_s: float


@dataclass(frozen=True, slots=True)
class BodyModel:
    """The body's ``model`` (URDF), the link of the camera whose pictures people see ("": none), and its ``footprint``:
    corners (m) in ``base_link``; ``limits`` of its base, None where nothing is predicted."""

    model: Path
    eye: str
    footprint: tuple[tuple[float, float], ...]
    limits: BaseLimits | None = None


class Painter:
    """Starts viser and draws, in a daemon thread of its own: a call of viser that hangs must not hold up the program.

    ``admitted`` is called in viser's thread; ``pace`` says what each viewer bears and is called in the painter's, as is
    ``ready(port)``, once viser listens.
    """

    def __init__(
        self,
        body: BodyModel,
        admitted: Callable[[int], str | None],
        pace: Callable[[], Mapping[str, Pace]],
        *,
        ready: Callable[[int], None],
    ) -> None:
        self._body = body
        self._admitted = admitted
        self._pace = pace
        self._ready = ready
        self._world: World | None = None
        #: Viewers that came (viewer, client) or left (viewer, None), in order.
        self._visits: queue.SimpleQueue[tuple[str, Any]] = queue.SimpleQueue()
        #: Points of viewers' pictures (viewer, u, v) that are asked for, with what the answer is for.
        self._asked: queue.SimpleQueue[tuple[tuple[str, float, float], Future[Pick | None]]] = queue.SimpleQueue()
        #: One waiting ring is enough; False ends it.
        self._bell: queue.SimpleQueue[bool] = queue.SimpleQueue()
        self._rung = False
        self._drawn = 0
        self._longest_s = 0.0
        self._cameras: Mapping[str, CameraState] = {}
        self._stamps: Mapping[str, float | None] = {}
        #: viser's server; set before ``ready`` is called.
        self.host: ViewHost | None = None
        self._worker = ModuleWorker("3D view")

    def start(self) -> asyncio.Future[None]:
        """Begin; returns at once. The future is done when the thread has ended, with its exception if it failed."""
        return asyncio.wrap_future(self._worker.submit(self._run))

    def show(self, world: World) -> None:
        """What is known now, instead of what was."""
        self._world = world
        self._ring()

    def pick(self, viewer: str, u: float, v: float) -> asyncio.Future[Pick | None]:
        """What is drawn at a point of the viewer's picture (shares of its width and height), None: it is no viewer. Not
        answered once the thread has ended."""
        answer: Future[Pick | None] = Future()
        self._asked.put(((viewer, u, v), answer))
        self._ring()
        return asyncio.wrap_future(answer)

    def stop(self) -> None:
        """Let the thread stop viser and end."""
        self._bell.put(False)
        self._worker.shutdown()

    def statistics(self) -> PainterStatistics:
        return PainterStatistics(self._drawn, self._longest_s)

    def cameras(self) -> Mapping[str, CameraState]:
        """What each viewer sees from."""
        return self._cameras

    def stamps(self) -> Mapping[str, float | None]:
        """Of the robot as each viewer was sent it last (s, the robot's clock)."""
        return self._stamps

    def _ring(self) -> None:
        if not self._rung:
            self._rung = True
            self._bell.put(True)

    def _visit(self, viewer: str, client: Any) -> None:
        self._visits.put((viewer, client))
        self._ring()

    def _run(self) -> None:
        # Imports take seconds: only a program with a viewer spends them, and never on its event loop.
        from app.console.view.body_nodes import Body
        from app.console.view.host import ViewHost
        from app.console.view.scene import Scene

        body = Body(self._body.model, self._body.eye)
        self.host = host = ViewHost(self._admitted, self._visit, lambda viewer: self._visit(viewer, None))
        try:
            scene = Scene(host.server, body, self._body.footprint, self._body.limits)
            self._ready(host.port)
            while self._bell.get():
                # Before anything is read: what comes from here on rings again.
                self._rung = False
                while not self._visits.empty():
                    viewer, client = self._visits.get()
                    if client is None:
                        scene.viewer_left(viewer)
                    else:
                        scene.viewer_came(viewer, client)
                began = time.monotonic()
                if self._world is not None:
                    self._drawn += scene.draw(self._world, began, self._pace())
                while not self._asked.empty():
                    point, answer = self._asked.get()
                    if answer.set_running_or_notify_cancel():
                        answer.set_result(scene.pick(*point))
                self._cameras, self._stamps = scene.states(), scene.stamps()
                self._longest_s = max(self._longest_s, time.monotonic() - began)
        finally:
            host.stop()
