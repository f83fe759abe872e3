"""A module whose work in threads takes more CPU than it needs, from a moment on."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from typing import Any, TypeVar

from app.runtime.load import CpuMeter

T = TypeVar("T")


class DearMeter(CpuMeter):
    """In the place of a module's ``meter``: lets its calls in threads take ``factor`` times their CPU."""

    __slots__ = ("_meter", "factor")

    def __init__(self, meter: CpuMeter) -> None:
        super().__init__()
        self._meter = meter
        self.factor = 1.0

    @property
    def cpu_ns(self) -> int:
        return self._meter.cpu_ns

    def step(self, advance: Callable[..., T], *args: Any) -> T:
        return self._meter.step(advance, *args)

    def call(self, function: Callable[..., T], *args: Any) -> T:
        return self._meter.call(partial(_dearly, self.factor, function), *args)


def _dearly(factor: float, function: Callable[..., T], *args: Any) -> T:
    began = time.thread_time()
    result = function(*args)
    until = began + factor * (time.thread_time() - began)
    while time.thread_time() < until:
        pass
    return result
