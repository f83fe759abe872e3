"""Many runs of a calibration in one replay: an instance of the module for each, so that the log is decoded once.

Decoding a minute of pictures takes longer than most perceptions take to process them. So the instances read the same
channels, each behind filters, on output channels and with a CPU meter of its own. They compute one at a time, and CPU
time is counted within each turn: the results and costs of each equal those of a replay of its own.
"""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Any, TypeVar

from app.attention.strategies import CLOSED
from app.logs.replay.calibration_runs import Run
from app.program.config import Configuration
from app.program.system import System
from app.runtime.filter_bank import FilterBank, Pin
from app.runtime.load import CpuMeter

T = TypeVar("T")

#: Greatest number of instances: beyond that there is little left to share, and each may need tens of megabytes.
MOST = 32
#: A φ at which the first message passes, and no other for longer than any log is.
_ONE_ALONE = 1_000_000_000


@dataclass(frozen=True, slots=True)
class BatchReplay:
    """A program of ``runs`` of one module: the nth by the module ``names[n]``, with its percepts on the channel
    ``events[n]`` (None: on none); ``pins`` fixes its filters, ``parameters`` are those of each."""

    configuration: Configuration
    runs: tuple[Run, ...]
    names: tuple[str, ...]
    events: tuple[str | None, ...]
    pins: Mapping[str, Pin]
    parameters: Mapping[str, Mapping[str, Any]]

    def begin(self, filters: FilterBank) -> None:
        """Let messages pass by each run's φ from now on, after its offset."""
        for name, run in zip(self.names, self.runs, strict=True):
            if run.phi > 1:
                filters.pin(f"{name}.{run.port}", Pin(run.phi, run.offset))


def batch_program(configuration: Configuration, runs: Sequence[Run], attended: Collection[str]) -> BatchReplay:
    """The program that makes ``runs``, all of one module, at once.

    Of the filters ``attended`` by attention (``Module.port``), those not measured are closed. Those measured let one
    message pass and then wait for :meth:`BatchReplay.begin`. A module's events are the messages of its first output in
    configuration order.
    """
    module = runs[0].module
    spec = configuration.program.modules[module]
    names = tuple(f"{module}~{number}" for number in range(len(runs)))
    modules, channels, events = {}, dict(configuration.channels), []
    pins: dict[str, Pin] = {}
    for number, (name, run) in enumerate(zip(names, runs, strict=True)):
        outputs = {port: f"{channel}~{number}" for port, channel in spec.outputs.items()}
        channels.update({outputs[port]: configuration.channels[channel] for port, channel in spec.outputs.items()})
        modules[name] = spec.model_copy(update={"outputs": outputs})
        events.append(next(iter(outputs.values()), None))
        ports = (port for owner, _, port in (other.partition(".") for other in attended) if owner == module)
        pins.update({f"{name}.{port}": Pin(CLOSED) for port in ports})
        pins[f"{name}.{run.port}"] = Pin(run.phi if run.phi == 1 else _ONE_ALONE)
    return BatchReplay(
        replace(
            configuration, program=configuration.program.model_copy(update={"modules": modules}), channels=channels
        ),
        tuple(runs),
        names=names,
        events=tuple(events),
        pins=pins,
        parameters={name: json.loads(run.parameters) for name, run in zip(names, runs, strict=True)},
    )


def batches(runs: Sequence[Run], most: int = MOST) -> list[list[Run]]:
    """``runs`` in their order, cut into pieces of one module, one repetition and at most ``most``.

    Of a φ with fewer offsets than fit, all are in one piece: each message is then one instance's.
    """
    found: list[list[Run]] = []
    for _, of_module in groupby(runs, key=lambda run: (run.module, run.repeat)):
        piece: list[Run] = []
        for _, of_phi in groupby(of_module, key=lambda run: (run.port, run.parameters, run.phi)):
            offsets = list(of_phi)
            if piece and len(piece) + len(offsets) > most:
                found.append(piece)
                piece = []
            piece += offsets
            while len(piece) > most:
                found.append(piece[:most])
                piece = piece[most:]
        if piece:
            found.append(piece)
    return found


class ExclusiveCpuMeter(CpuMeter):
    """A meter whose module computes only while no other one with the same ``lock`` does; waiting costs nothing."""

    __slots__ = ("_turn",)

    def __init__(self, lock: threading.RLock) -> None:
        super().__init__()
        self._turn = lock

    def call(self, function: Callable[..., T], *args: Any) -> T:
        """As :meth:`CpuMeter.call`, once the lock is free."""
        with self._turn:
            return super().call(function, *args)


def serialize_computing(system: System) -> None:
    """Make the modules of ``system``, which does not run yet, compute one at a time.

    In parallel they would evict each other's data from the processor's caches, and each would seem to cost more.
    """
    lock = threading.RLock()
    for slot in system.graph.modules.values():
        slot.context.meter = ExclusiveCpuMeter(lock)
