"""A perception that a behavior needs for what it is asked for now, desired by the behavior itself.

What every desire of a class needs, its strategies say (``requires``). This is for what depends on the parameters of a
desire.
"""

from __future__ import annotations

from app.attention.desires import Source
from app.attention.workspace import IntentionWorkspace, UnknownDesire
from app.runtime.module import Module

#: Desired utility: any perception of the kind is enough, a better one is up to what the computer can bear.
_UTILITY = 1.0


class WantedPerception:
    """The desire of ``module`` for a perception, at most one at a time."""

    def __init__(self, module: Module) -> None:
        self._module = module
        self._cls: str | None = None
        self._id: str | None = None

    def want(self, cls: str | None, served: str) -> None:
        """Desire the class ``cls`` as intensely as the strongest desire of class ``served`` is, for which it is wanted;
        withdraw it with None, or without such a desire. It may be called in every cycle.

        A desire that others have withdrawn does not come again while ``cls`` stays the same. A class that the program
        does not have is not desired. Raises ModuleFailed in a program without an Intention Workspace.
        """
        if cls is None and self._cls is None:
            return
        workspace = self._module.service(IntentionWorkspace)
        desire = workspace.wanted(served)
        if desire is None or cls not in workspace.classes:
            cls = None
        if cls != self._cls:
            self._withdraw(workspace)
            self._cls = cls
            if cls is not None and desire is not None:
                source = Source("motivation", self._module.name)
                self._id = workspace.add(cls, intensity=desire.intensity, utility=_UTILITY, source=source).id
        elif self._id is not None and desire is not None:
            try:
                if workspace.get(self._id).intensity != desire.intensity:
                    workspace.change(self._id, intensity=desire.intensity)
            except UnknownDesire:
                self._id = None

    def _withdraw(self, workspace: IntentionWorkspace) -> None:
        if self._id is not None:
            try:
                workspace.remove(self._id)
            except UnknownDesire:
                self._module.log.debug("desire %s was withdrawn already", self._id)
            self._id = None
