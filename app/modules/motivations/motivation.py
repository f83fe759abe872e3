"""Motivation: the base class of modules that state desires for reasons of the robot's own."""

from __future__ import annotations

from typing import ClassVar

from app.attention.desires import Source
from app.messages import Motive
from app.runtime.module import Module


class Motivation(Module):
    """A module that states desires, of one kind (EMIB: Michaud 2002; MBA: Michaud et al. 2007; thesis 2.1.2):
    *instinctive* for what the robot itself needs by simple rules (its battery, its safety), *rational* for its task (a
    scenario, a tour, rules, what it has learned), *emotional* for conflicts and changes between tasks."""

    role = "motivations"
    #: Its kind; a subclass that is no part of a task names its own.
    motive: ClassVar[Motive] = "rational"

    @property
    def source(self) -> Source:
        """The source of its desires."""
        return Source("motivation", self.name, motive=self.motive)
