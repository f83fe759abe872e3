"""What a body has of this computer's devices: its camera, microphones and loudspeaker, each read while it is wanted."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from functools import partial
from typing import Any, Protocol

from app.base.kinematic_model import KinematicModel
from app.link import StreamDescription
from app.messages import Audio, Image
from app.robots.devices.config import CameraConfig, SoundInputConfig, SpeakerConfig
from app.robots.devices.player import Player
from app.robots.devices.reader_thread import InputReader
from app.robots.devices.sound import no_sound_card
from app.robots.devices.streams import AudioFrames, ImageFrames

log = logging.getLogger("hbba.devices")

_MOST_PICTURES, _MOST_FRAMES = 2, 94


class HasDevices(Protocol):
    """The configuration of a body with devices, each None where there is none."""

    @property
    def name(self) -> str: ...
    @property
    def camera(self) -> CameraConfig | None: ...
    @property
    def microphones(self) -> SoundInputConfig | None: ...
    @property
    def loudspeaker(self) -> SpeakerConfig | None: ...


class Senses:
    """The devices of ``config``, placed by ``model`` once for all: no joint may move them.

    ``now()`` is the robot's clock (s); ``deliver(stream, message)`` is called on the loop.
    """

    def __init__(
        self,
        config: HasDevices,
        model: KinematicModel,
        now: Callable[[], float],
        deliver: Callable[[str, Any], None],
    ) -> None:
        self._name = config.name
        self._readers: dict[str, InputReader[Any]] = {}
        #: Descriptions of the streams that they give.
        self.streams: dict[str, StreamDescription] = {}
        self._player: Player | None = None
        self._mute = no_sound_card() if config.loudspeaker is not None else ""
        if config.loudspeaker is not None and not self._mute:
            self._player = Player(config.loudspeaker)
        if config.camera is not None:
            eye = ImageFrames(config.camera, model.pose(config.camera.link), now)
            self._readers["camera"] = InputReader(
                "camera", eye.open, partial(deliver, "camera"), pause_s=eye.pause_s, most_waiting=_MOST_PICTURES
            )
            self.streams["camera"] = StreamDescription("camera", Image, config.camera.rate_hz or 15.0)
        if config.microphones is not None:
            ear = AudioFrames(config.microphones, model.pose(config.microphones.link), now)
            self._readers["microphones"] = InputReader(
                "microphones", ear.open, partial(deliver, "microphones"), pause_s=ear.pause_s,
                most_waiting=_MOST_FRAMES,
            )  # fmt: skip
            rate_hz = config.microphones.rate / config.microphones.frame_samples
            self.streams["microphones"] = StreamDescription("microphones", Audio, rate_hz)

    @property
    def has_loudspeaker(self) -> bool:
        """Whether :meth:`play` has an effect."""
        return self._player is not None

    async def start(self) -> list[str]:
        """Open the devices; why some cannot be, each of which is logged and tried again."""
        if self._mute:
            log.warning("%s is mute: %s", self._name, self._mute)
        problems = await asyncio.gather(*(reader.start() for reader in self._readers.values()))
        if self._player is not None:
            self._player.start()
        return [problem for problem in problems if problem]

    async def stop(self) -> None:
        """Release the devices; idempotent."""
        await asyncio.gather(*(reader.stop() for reader in self._readers.values()))
        if self._player is not None:
            self._player.stop()

    def want(self, stream: str, wanted: bool) -> None:
        """Set whether ``stream`` is wanted: one that is not is not read, and is released after a time. No effect for a
        stream of others."""
        if stream in self._readers:
            self._readers[stream].want(wanted)

    def play(self, audio: Audio) -> None:
        """Play one frame of one channel through the loudspeaker, where there is one."""
        if self._player is not None:
            self._player.play(audio)
