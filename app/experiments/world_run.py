"""A whole program in a simulated world on virtual time: as fast as the computer allows, and deterministic.

``run_in_world(configuration, body, script)`` builds the program around a body in lockstep (``LockstepLink``), runs the
coroutine ``script`` beside it in virtual time and returns what that returns.
"""

from __future__ import annotations

import itertools
from collections.abc import Awaitable, Callable, Collection, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeVar

from app.base.yaml_source import suggestion
from app.maps.library import MapLibrary
from app.modules.recording.recorder import Recorder
from app.program.beside import run_beside
from app.program.config import Configuration
from app.program.system import System
from app.robots.config import RobotConfig
from app.robots.factory import create_lockstep
from app.robots.simulated.lockstep import LockstepLink
from app.robots.simulated.world_config import WorldConfig
from app.runtime.clock import VirtualClock, run_virtual
from app.runtime.filter_bank import Pin
from app.runtime.graph import load_class

T = TypeVar("T")

PATIENCE_S = 600.0
"""Time limit (real s) for results of threads; only beyond it a run depends on the machine."""
ORIGIN = 1_000_000.0
"""The robot's clock (s) at the begin."""


@dataclass(frozen=True, slots=True)
class WorldRun:
    """A running program: ``system`` is all of it, ``link`` its body, which offers the ground truth."""

    system: System
    link: LockstepLink


def run_in_world(
    configuration: Configuration,
    body: RobotConfig,
    script: Callable[[WorldRun], Awaitable[T]],
    *,
    world: WorldConfig | None = None,
    cameras: bool = False,
    microphones: bool = False,
    without: Collection[str] = (),
    pins: Mapping[str, Pin] | None = None,
    maps: MapLibrary | None = None,
) -> T:
    """Run ``script`` beside the program of ``configuration`` in the world of ``body``, in virtual time.

    Modules of streams that the body does not have (its cameras, without ``cameras``; its microphones, without
    ``microphones``) and those named in ``without`` are left out, and strategies work without them. ``world`` replaces
    the one that the body's file names. ``pins`` and ``maps`` as for ``System``. Not to be called on an event loop.
    Raises what the script raises, ConfigError, and what ended the program if it ended before the script.
    """
    clock = VirtualClock(ORIGIN)
    link = create_lockstep(body, clock, world=world, cameras=cameras, microphones=microphones)
    system = System(
        able(configuration, link, without),
        link=link,
        body=body,
        clock=clock,
        pins=pins,
        maps=maps,
        new_id=_numbered(),
        partial=True,
        reproducible=True,
    )
    return run_virtual(run_beside(system, partial(script, WorldRun(system, link))), patience_s=PATIENCE_S)


def able(
    configuration: Configuration, link: LockstepLink, without: Collection[str] = (), *, recorders: bool = False
) -> Configuration:
    """``configuration`` without the modules that need a stream missing from ``link``, and without those named in
    ``without``.

    The channels of omitted modules stay silent. Recorders are left out as well, unless ``recorders``: they write in
    real time.
    """
    streams = set(link.description.streams)
    modules = {}
    for name, spec in configuration.program.modules.items():
        kind = load_class(spec.class_path)  # the graph refuses a missing one
        if name in without:
            continue
        if kind is not None:
            lacks = set(kind.streams.values()) - kind.optional_streams - streams
            if lacks or (issubclass(kind, Recorder) and not recorders):
                continue
        modules[name] = spec
    produced = {channel for spec in modules.values() for channel in spec.outputs.values()}
    channels = {
        name: spec if name in produced else spec.model_copy(update={"external": True, "rate_hz": None})
        for name, spec in configuration.channels.items()
    }
    program = configuration.program.model_copy(update={"modules": modules})
    return replace(configuration, program=program, channels=channels)


def with_settings(configuration: Configuration, settings: Mapping[str, Mapping[str, object]]) -> Configuration:
    """``configuration`` with other ``settings`` of some modules, by module. Raises ConfigError for one there is not."""
    modules = dict(configuration.program.modules)
    for name, more in settings.items():
        if name not in modules:
            raise configuration.program_document.error(f"there is no module {name}; {suggestion(name, list(modules))}")
        modules[name] = modules[name].model_copy(update={"settings": {**modules[name].settings, **more}})
    return replace(configuration, program=configuration.program.model_copy(update={"modules": modules}))


def _numbered() -> Callable[[], str]:
    """Ids of desires in the order they come."""
    numbers = itertools.count(1)
    return lambda: f"d{next(numbers)}"
