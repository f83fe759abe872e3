"""A service of the program that one module provides while it runs, and others use without an import of the module."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

T = TypeVar("T")


class ServiceSlot(Generic[T]):
    """Holds the provider of a service, or none; for use on one thread.

    A module attaches its provider in ``start`` and detaches it in ``stop``. The newest provider counts: one that is
    replaced before it detaches (a module restarts) detaches without effect.
    """

    def __init__(self, missing: Callable[[], Exception]) -> None:
        """``missing`` makes the exception that :attr:`provider` raises while there is none."""
        self._missing = missing
        self._provider: T | None = None

    def attach(self, provider: T) -> Callable[[], None]:
        """Take ``provider`` into use; returns a function that detaches it and may be called twice."""
        self._provider = provider

        def detach() -> None:
            if self._provider is provider:
                self._provider = None

        return detach

    @property
    def available(self) -> bool:
        """Whether there is a provider."""
        return self._provider is not None

    @property
    def provider(self) -> T:
        """The provider. Raises what ``missing`` makes while there is none."""
        if self._provider is None:
            raise self._missing()
        return self._provider
