"""How a behavior reports that what a desire asks for is done, or that it cannot be done."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from app.attention.workspace import IntentionWorkspace
from app.messages import Accomplished, Accomplishment, Desire
from app.runtime.module import Caution, Module


class AccomplishmentReporter:
    """Publishes :class:`Accomplishment` on the output ``accomplishments`` of ``module``, for desires of class ``cls``.

    To be made in the module's constructor, for it declares the output. It may be asked in every cycle: a report is
    repeated only once the desire's parameters or the report's outcome are others. An output without a channel reports
    nothing.
    """

    def __init__(self, module: Module, cls: str) -> None:
        self._module = module
        self._cls = cls
        self._output = module.output("accomplishments", Accomplishment)
        self._reported: dict[str, tuple[Accomplished, Mapping[str, Any]]] = {}

    def report(
        self, outcome: Accomplished, reason: str, about: Callable[[Desire], bool], *, behavior: str = ""
    ) -> None:
        """Report ``outcome`` of every desire of the class that is ``about`` it; of none that inhibits the class.

        ``reason`` is in words, "" where there is nothing to add. ``behavior``: who found it out, if not this module.
        Raises ModuleFailed in a program without an Intention Workspace.
        """
        if self._output.channel is None:
            return
        desires = [d for d in self._module.service(IntentionWorkspace).desires() if d.cls == self._cls]
        standing = {desire.id for desire in desires}
        self._reported = {key: known for key, known in self._reported.items() if key in standing}
        now = self._module.clock.now()
        for desire in desires:
            known = (outcome, desire.params)
            if desire.utility > 0 and self._reported.get(desire.id) != known and about(desire):
                self._reported[desire.id] = known
                self._output.publish(Accomplishment(now, desire.id, behavior or self._module.name, outcome, reason))

    def cautions(self) -> tuple[Caution, ...]:
        """What people must know where the output leads to no channel."""
        if self._output.channel is not None:
            return ()
        text = (
            f"the output accomplishments of {self._module.name} leads to no channel: nothing reports that a desire for "
            f"{self._cls} is done; name a channel of type Accomplishment under `outputs`"
        )
        return (Caution(f"No end of {self._cls} is reported", text),)
