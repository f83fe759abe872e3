"""What visitors of a rehearsal do beside following: they agree, ask, press the button to go on, let the robot pass."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack

from app.messages import Speech
from app.modules.motivations.tour_guide.wishes import PASS
from app.program.system import System

#: They agree, ask and press so long (s) after they can.
ANSWER_S = 2.0


class VisitorReplies:
    """Replies to the guide of ``system``: each question of a stop is asked once. ``let_pass`` is called when the robot
    asks for it. ``hesitate()`` is the time (s) until the next reply. A context manager."""

    def __init__(
        self, system: System, let_pass: Callable[[], None], hesitate: Callable[[], float] = lambda: ANSWER_S
    ) -> None:
        self._system = system
        self._let_pass = let_pass
        self._hesitate = hesitate
        self._wait_s = hesitate()
        self._said = ""
        self._stack = ExitStack()
        #: Stop and question, in the order asked.
        self.asked: list[tuple[str, str]] = []

    def __enter__(self) -> VisitorReplies:
        for channel in self._system.graph.channels.values():
            if channel.message_type is Speech:
                self._stack.callback(channel.observe(self._hear))
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def look(self) -> None:
        """Reply, if it is time; to be called at least each second."""
        server = self._system.tour_run.server
        shown = server.progress
        if self._system.clock.now() - shown.since < self._wait_s:
            return
        if shown.state == "confirming" and "agree" in shown.buttons:
            server.press("agree")
        elif shown.state != "listening":
            return
        elif (new := next((q.id for q in shown.questions if (shown.stop, q.id) not in self.asked), None)) is not None:
            self.asked.append((shown.stop, new))
            server.ask(new)
        elif shown.press and "next" in shown.buttons:
            server.press("next")
        else:
            return
        self._wait_s = self._hesitate()

    def _hear(self, speech: Speech) -> None:
        said = speech.desire if speech.state == "speaking" else ""
        if said and said != self._said and speech.text in PASS.values():
            self._let_pass()
        self._said = said
