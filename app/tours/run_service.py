"""The service of the tour under way, for other parts of the program; the module that guides attaches its server."""

from __future__ import annotations

from typing import Protocol

from app.base.service_slot import ServiceSlot
from app.messages import TourButton, TourProgress
from app.tours.model import Tour
from app.tours.run_report import RunReport


class TourRefused(Exception):
    """The request cannot be met now; the message is one sentence, that says why."""


class TourRunServer(Protocol):
    """Guides tours; all methods are called on the event loop, and raise TourRefused."""

    @property
    def tour(self) -> Tour | None:
        """The tour that is led, or waits for visitors; None: there is none."""
        ...

    @property
    def progress(self) -> TourProgress:
        """How the tour goes."""
        ...

    @property
    def report(self) -> RunReport | None:
        """What the run under way has been so far, or the last one was; None before the first."""
        ...

    def start_tour(self, tour: Tour, *, language: str, waits: bool) -> None:
        """Begin ``tour`` in ``language``; ``waits``: wait for visitors, or its schedule, to begin it, again and again.

        Refused while another is under way, where its places are not on the map in use, and while the robot is held.
        """
        ...

    def press(self, button: TourButton) -> None:
        """Press ``button``; refused where it does nothing now."""
        ...

    def choose(self, stop: str) -> None:
        """Go to the stop with the id ``stop``."""
        ...

    def ask(self, question: str) -> None:
        """A visitor asks the question with the id ``question`` of this stop."""
        ...

    def dismiss(self) -> None:
        """Wait for visitors no more; refused while a tour is under way."""
        ...


class TourRunService(ServiceSlot[TourRunServer]):
    """The service of the tour under way: its server, which a module attaches while it runs."""

    def __init__(self) -> None:
        super().__init__(lambda: TourRefused("this program leads no tours: no TourGuide runs"))

    @property
    def server(self) -> TourRunServer:
        """The server. Raises TourRefused while there is none."""
        return self.provider
