"""Interfaces that the Intention Translator uses: filters, parameters of modules, a solver."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any, Protocol

from app.attention.problem import Selection, SelectionProblem


class FilterTarget(Protocol):
    """The runtime's filters, by ``"Module.port"``."""

    def names(self) -> Collection[str]:
        """The filters there are."""
        ...

    def apply(self, divisors: Mapping[str, float]) -> object:
        """Set these φ (math.inf: closed) in one step, those that open or speed up first."""
        ...


class ParameterSink(Protocol):
    """Receives the parameters P' of modules."""

    def configure(self, module: str, parameters: Mapping[str, Any]) -> None:
        """Hand ``module`` all its parameters; an empty mapping returns it to its own settings."""
        ...


class Solver(Protocol):
    """Solves selection problems. All methods but ``recall`` are called beside the event loop, one at a time."""

    def prepare(self, problem: SelectionProblem) -> None:
        """Load the libraries that such problems may need, before the first is solved."""
        ...

    def recall(self, problem: SelectionProblem) -> Selection | None:
        """An answer known already, at once."""
        ...

    def solve(self, problem: SelectionProblem) -> Selection | None:
        """The answer, with its reasons. Raises SolverFailed where there was no time to find one."""
        ...

    def among(self, problem: SelectionProblem, names: Collection[str]) -> Selection:
        """The answer were there no strategies but ``names``. Raises SolverFailed as :meth:`solve`."""
        ...
