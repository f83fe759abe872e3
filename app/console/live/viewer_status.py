"""The status as each viewer gets it: with who drives, asks and speaks, and why its own driving waits or is slower."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

from app.console.drive import drive_lease
from app.console.drive.drive_controller import Driving
from app.console.live import messages
from app.console.live.speech import OperatorSpeech
from app.console.live.viewer import Viewer
from app.console.wire import frame


class ViewerStatus:
    """Completes the status by what ``driving`` and ``speech`` know of the viewers. ``now``: the robot's clock (s)."""

    def __init__(self, driving: Driving, speech: OperatorSpeech, now: Callable[[], float]) -> None:
        self._driving = driving
        self._speech = speech
        self._now = now

    def frames(self, status: messages.Status, viewers: Iterable[Viewer]) -> Iterator[tuple[Viewer, str]]:
        """The frame of ``status`` for each of ``viewers``, completed by driver, asker, speaker, ``waits``, ``slowed``
        and ``share``. It differs by viewer only in ``mine`` of the first three and in the last three: it is encoded
        once for all viewers with the same."""
        lease, speaker = self._driving.lease, self._speech.speaker
        frames: dict[tuple[bool, bool, bool, str, str, float], str] = {}
        for viewer in viewers:
            session = viewer.session
            waits, slowed, share = self.waits(viewer), self.slowed(viewer), self.share(viewer)
            speaks = speaker is not None and session == speaker[0]
            mine = (session == lease.driver, session == lease.asker, speaks, waits, slowed, share)
            if mine not in frames:
                name = lease.driver_name
                own = replace(
                    status,
                    driver=None if name is None else messages.Driver(name, mine[0], lease.moving),
                    speaker=None if speaker is None else messages.Speaker(speaker[1], speaks),
                    asker=self._asker(mine[1]),
                    waits=waits,
                    slowed=slowed,
                    share=share,
                )
                frames[mine] = frame("status", own)
            yield viewer, frames[mine]

    def waits(self, viewer: Viewer) -> str:
        """Why the driving of ``viewer`` waits, in words; "": it does not."""
        judged = viewer.age.last
        return f"{judged.cause}: driving waits." if judged.lasting and self._driving.drivable else ""

    def slowed(self, viewer: Viewer) -> str:
        """Why the driving of ``viewer`` is slower than its stick says, in words; "": it is not."""
        judged = viewer.age.last
        if not judged.slowed or not self._driving.drivable:
            return ""
        return f"{judged.slowed[0].upper()}{judged.slowed[1:]}: {100 * self.share(viewer):.0f} % of the speed."

    def share(self, viewer: Viewer) -> float:
        """The share of its stick's speeds that ``viewer`` is given, 0 to 1, to two places."""
        return round(viewer.age.last.share, 2) if self._driving.drivable else 1.0

    def _asker(self, mine: bool) -> messages.Asker | None:
        lease = self._driving.lease
        if lease.asker is None:
            return None
        left_s = lease.asked_at + drive_lease.ANSWER_WITHIN_S - self._now()
        return messages.Asker(lease.operators[lease.asker], mine, round(max(0.0, left_s), 1))
