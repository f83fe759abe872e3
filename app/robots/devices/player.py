"""Playback thread of the loudspeaker."""

from __future__ import annotations

import logging
import threading
from collections import deque

from app.messages import Audio
from app.robots.devices.config import SpeakerConfig
from app.robots.devices.image_inputs import InputUnavailable
from app.robots.devices.reader_thread import RETRY_S
from app.robots.devices.sound import LoudspeakerStream

#: Greatest waiting time (s) of frames; beyond it the oldest is dropped.
QUEUED_S = 0.5

log = logging.getLogger("hbba.devices")


class Player:
    """Opens the loudspeaker with the first frame; logs a failure once, and retries while there are frames."""

    def __init__(self, config: SpeakerConfig) -> None:
        self._config = config
        self._condition = threading.Condition()
        self._frames: deque[Audio] = deque()
        self._ending = False

    def start(self) -> None:
        """Start the thread."""
        threading.Thread(target=self._run, name="loudspeaker", daemon=True).start()

    def stop(self) -> None:
        """End the thread, silent at once."""
        with self._condition:
            self._ending = True
            self._condition.notify()

    def play(self, audio: Audio) -> None:
        """Queue one frame."""
        with self._condition:
            self._frames.append(audio)
            while len(self._frames) > 1 and sum(len(f.samples) / f.rate for f in self._frames) > QUEUED_S:
                self._frames.popleft()
            self._condition.notify()

    def _run(self) -> None:
        speaker: LoudspeakerStream | None = None
        reported = ""
        while (audio := self._next()) is not None:
            try:
                if speaker is not None and speaker.rate != audio.rate:
                    speaker.close()
                    speaker = None
                if speaker is None:
                    speaker = LoudspeakerStream(self._config, audio.rate)
                speaker.write(audio.samples[:, 0])
                reported = ""
            except InputUnavailable as failure:
                if speaker is not None:
                    speaker.close()
                    speaker = None
                if str(failure) != reported:
                    reported = str(failure)
                    log.warning("%s", reported)
                self._be_silent(RETRY_S)
        if speaker is not None:
            speaker.close()

    def _be_silent(self, seconds: float) -> None:
        """Discard frames for this time, unless the thread ends."""
        with self._condition:
            self._condition.wait_for(lambda: self._ending, seconds)
            self._frames.clear()

    def _next(self) -> Audio | None:
        with self._condition:
            while not self._frames and not self._ending:
                self._condition.wait()
            return None if self._ending else self._frames.popleft()
