"""How a behavior reports that what a desire asks for is done, or that it cannot be done."""

from __future__ import annotations

from collections.abc import Callable

from app.attention.workspace import IntentionWorkspace
from app.messages import Accomplished, Accomplishment, Desire
from app.runtime.module import Caution, Module


class AccomplishmentReporter:
    """Publishes :class:`Accomplishment` on the output ``accomplishments`` of ``module``, for desires of class ``cls``.

    To be made in the module's constructor, for it declares the output. It may be called in every cycle: what the
    Intention Workspace has of a desire already is not published again. An output without a channel reports nothing.
    """

    def __init__(self, module: Module, cls: str) -> None:
        self._module = module
        self._cls = cls
        self._output = module.output("accomplishments", Accomplishment)

    def report(self, outcome: Accomplished, reason: str, about: Callable[[Desire], bool]) -> None:
        """Report ``outcome`` of every desire of the class that is ``about`` it; of none that inhibits the class.

        ``reason`` is in words, "" where there is nothing to add. Raises ModuleFailed in a program without an Intention
        Workspace.
        """
        if self._output.channel is None:
            return
        workspace = self._module.service(IntentionWorkspace)
        known = {report.desire_id: report.outcome for report in workspace.accomplishments()}
        now = self._module.clock.now()
        for desire in workspace.desires():
            wanted = desire.cls == self._cls and desire.utility > 0
            if wanted and known.get(desire.id) != outcome and about(desire):
                self._output.publish(Accomplishment(now, desire.id, self._module.name, outcome, reason))

    def cautions(self) -> tuple[Caution, ...]:
        """What people must know where the output leads to no channel."""
        if self._output.channel is not None:
            return ()
        text = (
            f"the output accomplishments of {self._module.name} leads to no channel: nothing reports that a desire for "
            f"{self._cls} is done; name a channel of type Accomplishment under `outputs`"
        )
        return (Caution(f"No end of {self._cls} is reported", text),)
