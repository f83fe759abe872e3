"""The cameras' thread: renders the body's cameras into the image rings.

Drawing takes longer than a control step and releases the interpreter's lock, so it has a thread of its own; the control
loop only gives it a snapshot when it is free and collects finished images. Where an image is not finished when the next
is due, the loop pauses simulated time: a computer too slow for the rates slows the world, not the camera. The OpenGL
context belongs to this thread.

One thread renders all cameras: two would compete for the CPU, each with a copy of every texture. The camera with the
shortest period goes first, even between the parts of another's image; but one that has waited longer than its own
period goes before the others, so that under overload all rates fall in proportion.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import mujoco
from numpy.random import Generator

from app.robots.simulated.camera_rendering import CameraRenderer, open_renderers
from app.robots.simulated.image_ring import SLOTS, ImageRing
from app.robots.simulated.link_protocol import ImageNotice
from app.robots.simulated.renderer import Renderer, WorldSnapshot
from app.robots.stream_config import StreamsConfig


@dataclass(slots=True, eq=False)
class _RenderJob:
    """An image in progress, requested at ``since`` (s, monotonic)."""

    snapshot: WorldSnapshot
    steps: Iterator[None]
    since: float


class CameraThread:
    """Renders snapshots on request. ``rngs``, ``rings`` and cameras are by stream."""

    def __init__(
        self,
        model: mujoco.MjModel,
        streams: StreamsConfig,
        rings: Mapping[str, ImageRing],
        rngs: Mapping[str, Generator],
        wake: Callable[[], None],
    ) -> None:
        self._model = model
        self._streams = streams
        self._rings = rings
        self._rngs = rngs
        self._wake = wake
        self._periods = {
            name: 1.0 / config.rate_hz
            for name, config in (("kinect", streams.kinect), ("panorama", streams.panorama))
            if config is not None
        }
        self._condition = threading.Condition()
        self._asked: dict[str, tuple[WorldSnapshot, float]] = {}
        self._busy: set[str] = set()
        self._ending = False
        self._ready = threading.Event()
        self._counts = dict.fromkeys(self._periods, 0)
        self._thread = threading.Thread(target=self._run, name="camera", daemon=True)
        self.finished: deque[ImageNotice] = deque()
        self.failure: BaseException | None = None
        self._thread.start()

    def wait_ready(self, timeout_s: float) -> None:
        """Wait until it can draw; raises the thread's error, or TimeoutError."""
        if not self._ready.wait(timeout_s):
            raise TimeoutError(f"the camera could not be set up in {timeout_s:.0f} s")
        if self.failure is not None:
            raise self.failure

    def busy(self, stream: str) -> bool:
        """Whether that camera's last snapshot is not finished yet."""
        return stream in self._busy

    def request(self, stream: str, snapshot: WorldSnapshot) -> None:
        """Have ``snapshot`` drawn for the camera ``stream``; not while it is ``busy``."""
        with self._condition:
            self._busy.add(stream)
            self._asked[stream] = (snapshot, time.monotonic())
            self._condition.notify()

    def close(self, timeout_s: float) -> None:
        with self._condition:
            self._ending = True
            self._condition.notify()
        self._thread.join(timeout_s)

    def _run(self) -> None:
        try:
            renderer = Renderer(self._model)
            renderers = open_renderers(renderer, self._model, self._streams, self._rngs)
            self._ready.set()
            self._serve(renderers)
            renderer.close()
        except BaseException as failure:  # noqa: BLE001  # raised in the control loop, which ends the process
            self.failure = failure
            self._ready.set()
            self._wake()

    def _serve(self, renderers: Mapping[str, CameraRenderer]) -> None:
        jobs: dict[str, _RenderJob] = {}
        while self._wait(bool(jobs)):
            with self._condition:
                for stream, (snapshot, since) in self._asked.items():
                    jobs[stream] = _RenderJob(snapshot, renderers[stream].draw(snapshot), since)
                self._asked.clear()
            stream = self._most_urgent(jobs)
            if next(jobs[stream].steps, stream) is stream:
                self._finish(stream, renderers[stream], jobs.pop(stream).snapshot)

    def _wait(self, working: bool) -> bool:
        """Wait for something to do; False at the end."""
        with self._condition:
            while not (working or self._asked or self._ending):
                self._condition.wait()
            return not self._ending

    def _most_urgent(self, jobs: Mapping[str, _RenderJob]) -> str:
        now = time.monotonic()
        waited = {stream: (now - job.since) / self._periods[stream] for stream, job in jobs.items()}
        latest = max(waited, key=lambda stream: waited[stream])
        return latest if waited[latest] > 1.0 else min(waited, key=lambda stream: self._periods[stream])

    def _finish(self, stream: str, eye: CameraRenderer, snapshot: WorldSnapshot) -> None:
        slot = self._counts[stream] % SLOTS
        self._counts[stream] += 1
        ring = self._rings[stream]
        eye.measure(*ring.begin(slot))
        sequence = 2 * self._counts[stream]
        ring.finish(slot, sequence)
        notice = ImageNotice(stream, slot, sequence, snapshot.stamp, X_BC=snapshot.X_BC, periods=snapshot.periods)
        self.finished.append(notice)
        with self._condition:
            self._busy.discard(stream)
        self._wake()
