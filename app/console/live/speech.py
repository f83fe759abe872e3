"""Push-to-talk: one operator at a time speaks through the robot, on the channel ``operator_voice``."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from app.console.live.protocol import Voice, decode_voice
from app.link import RobotLink
from app.messages import Audio, read_only
from app.runtime.channel import Channel
from app.runtime.clock import Clock

#: A talk has ended after this long (s) without a frame.
PAUSE_S = 0.5
#: A frame that is older (s) when it comes is passed over, as is one that so much waits to be played before.
LATE_S = 0.5
#: A talk of so long (s) of which nothing could be played gets a notice.
MUTE_S = 1.0

RECORDING = "This is a recording: nothing can be said in it."
NO_LOUDSPEAKER = "{robot} has no loudspeaker."
TOO_LATE = (
    "What you say arrives too late to be played: the connection is slow, or this page's clock is wrong; reload it."
)
NO_CHANNEL = "This program has no channel operator_voice: speech cannot be played."

Notify = Callable[[str, Literal["info", "warning", "error"], str], None]


@dataclass(slots=True)
class _Talk:
    """One page's push-to-talk, held since ``began``. ``refused``: it began while another spoke.
    ``notified``: it had its notice. ``played``: something of it was."""

    began: float
    heard: float
    seq: int
    played: bool = False
    refused: bool = False
    notified: bool = False


class OperatorSpeech:
    """Takes the frames of every page. ``notify(session, level, text)`` reaches one page."""

    def __init__(
        self,
        clock: Clock,
        link: RobotLink,
        channel: Channel[Audio] | None,
        notify: Notify,
        *,
        recording: bool = False,
    ) -> None:
        self._clock = clock
        self._channel = channel
        self._notify = notify
        #: Why speech cannot be played here; "" where it can.
        self.in_vain = ""
        if recording:
            self.in_vain = RECORDING
        elif not link.description.loudspeaker:
            self.in_vain = NO_LOUDSPEAKER.format(robot=link.description.name)
        elif channel is None:
            self.in_vain = NO_CHANNEL
        self._talks: dict[str, _Talk] = {}
        self._speaker: tuple[str, str] | None = None
        self._samples = 0
        #: What was published will have been played by then, if it is played as it comes.
        self._played_until = 0.0

    @property
    def speaker(self) -> tuple[str, str] | None:
        """Session and operator of who speaks now."""
        if self._speaker is not None and not self._is_held(self._speaker[0], self._clock.now()):
            self._speaker = None
        return self._speaker

    def hear(self, session: str, operator: str, frame: bytes) -> None:
        """A binary frame of kind 17 came from a page."""
        if self.in_vain:
            if session not in self._talks:
                self._talks[session] = _Talk(0.0, 0.0, 0)
                self._notify(session, "warning", self.in_vain)
            return
        now = self._clock.now()
        if not self._is_held(session, now):
            self._talks[session] = _Talk(now, now, -1)
        talk = self._talks[session]
        talk.heard = now
        try:
            voice = decode_voice(frame)
        except ValueError as error:
            self._warn(session, talk, f"What you say cannot be played: {error}.")
            return
        if len(voice.samples) == 0:
            self.gone(session)
            return
        if (speaker := self.speaker) is not None and speaker[0] != session:
            talk.refused = True
            self._warn(session, talk, f"The robot's voice is in use by {speaker[1]}: press again when they have ended.")
            return
        if talk.refused or voice.seq <= talk.seq:
            return
        talk.seq = voice.seq
        self._speaker = (session, operator)
        talk.played |= self._publish(voice, now)
        if not talk.played and now - talk.began > MUTE_S:
            self._warn(session, talk, TOO_LATE)

    def gone(self, session: str) -> None:
        """It let go, or its connection ended."""
        self._talks.pop(session, None)
        if self._speaker is not None and self._speaker[0] == session:
            self._speaker = None

    def _is_held(self, session: str, now: float) -> bool:
        talk = self._talks.get(session)
        return talk is not None and now - talk.heard <= PAUSE_S

    def _warn(self, session: str, talk: _Talk, text: str) -> None:
        if not talk.notified:
            talk.notified = True
            self._notify(session, "warning", text)

    def _publish(self, voice: Voice, now: float) -> bool:
        """Have it played; False if it comes too late."""
        begins = max(self._played_until, now)
        late = voice.stamp > 0 and now - voice.stamp > LATE_S
        if late or begins - now > LATE_S or self._channel is None:
            return False
        self._played_until = begins + len(voice.samples) / voice.rate
        stamp = min(voice.stamp, now) if voice.stamp > 0 else now
        samples = voice.samples[:, None]
        places = read_only(np.zeros((0, 3)))
        self._channel.publish(
            Audio(
                stamp, "operator", samples=read_only(samples), rate=voice.rate, first_sample=self._samples, p_BM=places
            )
        )
        self._samples += len(voice.samples)
        return True
