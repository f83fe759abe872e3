"""The program of a replay: the log's own, without the modules for which the log has no messages."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from app.base import paths
from app.base.errors import ConfigError
from app.base.yaml_source import suggestion
from app.link import RobotDescription, StreamDescription
from app.logs.log import Log, LogInfo
from app.logs.replay.options import ReplayOptions
from app.logs.replay.unpack_attachments import extract
from app.messages import (
    Desires,
    Divisors,
    IntentionReport,
    LoadReport,
    LogLine,
    ModuleRecord,
    RecorderStatus,
    TimelineEvent,
)
from app.modules.recording.recorder import Recorder
from app.program.config import Configuration, load_configuration
from app.robots.factory import load_body, standing_streams
from app.runtime.channel_table import ChannelSpec
from app.runtime.graph import Graph, ModuleSpec, load_class
from app.runtime.module import Module

#: Records that a program publishes about itself: a replayed program publishes its own.
OWN_RECORDS: frozenset[type[Any]] = frozenset(
    {Desires, Divisors, TimelineEvent, IntentionReport, LoadReport, LogLine, ModuleRecord, RecorderStatus}
)
#: Those among them that people watch as they were recorded, where the log has them.
WATCHED: frozenset[type[Any]] = frozenset({IntentionReport})
NOT_ASKED = "not asked for"
_STREAM = "stream."


@dataclass(frozen=True, slots=True)
class ReplayProgram:
    """A program to be run on a log.

    ``configuration`` as it will run; ``description`` of the body; ``streams``: the channel of the log for each stream
    of the body; ``fed``: channels without a producer in the program, taken from the log; ``left_out``: modules that do
    not run, with the reason in words; ``silent``: inputs (``Module.port``) of running modules that can get no message
    (inputs from operators are silent if none were recorded).
    """

    configuration: Configuration
    description: RobotDescription
    streams: Mapping[str, str]
    fed: tuple[str, ...]
    left_out: Mapping[str, str]
    silent: Mapping[str, str]


def prepare(
    log: Log, options: ReplayOptions, folder: Path, idle: Mapping[str, str] | None = None, *, watched: bool = False
) -> ReplayProgram:
    """Put the program together; the log's files are written under ``folder``, which must outlive the program.

    ``idle``: modules that stay out besides, with the reason in words (see :func:`idle_modules`). ``watched``: people
    watch it, who are shown the intentions of the log.

    Raises ConfigError for a mistake in the configuration or the options, LogError for files that cannot be.
    """
    configuration = _configuration(log, options, folder)
    robot = load_body(configuration.path(configuration.program.robot))
    facts = log.manifest.facts
    streams = _streams(log, configuration)
    modules, left_out = _modules(configuration, options, streams, idle or {})
    if not modules:
        reasons = "; ".join(f"{name}: {why}" for name, why in left_out.items())
        raise ConfigError(f"no module of this program can run on it ({reasons})", str(log.info.path))
    produced = {channel for spec in modules.values() for channel in spec.outputs.values()}
    own = OWN_RECORDS - WATCHED if watched else OWN_RECORDS
    fed = tuple(
        name for name in configuration.channels if name not in produced and _feeds(log.info, configuration, name, own)
    )
    channels = _as_recorded(log.info, configuration.channels, modules.values(), fed)
    silent = {
        f"{module}.{port}": channel
        for module, spec in modules.items()
        for port, channel in spec.inputs.items()
        if channel not in produced and channel not in fed and not configuration.channels[channel].external
    }
    program = configuration.program.model_copy(update={"modules": modules})
    return ReplayProgram(
        replace(configuration, program=program, channels=channels),
        RobotDescription(
            name=facts.get("robot") or f"{log.info.path.name} ({log.info.format})",
            model_path=robot.model,
            limits=robot.limits.base(),
            streams=standing_streams(robot) | {s: _describe(log.info, configuration, s, c) for s, c in streams.items()},
            simulated=False,
            footprint=robot.footprint,
            height_m=robot.height_m,
            groups=dict(robot.groups),
            arms=dict(robot.arm_descriptions),
        ),
        streams=streams,
        fed=fed,
        left_out=left_out,
        silent=silent,
    )


def idle_modules(program: ReplayProgram, graph: Graph) -> dict[str, str]:
    """Modules of ``graph`` that do nothing in this replay, since none of their inputs can get a message; with the
    reason.

    Inputs that are always open (odometry, commands of operators) or auxiliary do not count: they only support others. A
    motivation, which has no outputs, counts as active even without messages.
    """
    found = {}
    for name, slot in graph.modules.items():
        inputs = slot.context.inputs.values()
        open_to = [
            p for p in inputs if p.connected and not p.always_open and p.name not in slot.module.auxiliary_inputs
        ]
        if open_to and slot.context.outputs and all(f"{name}.{port.name}" in program.silent for port in open_to):
            channels = sorted({program.silent[f"{name}.{port.name}"] for port in open_to})
            if not isinstance(slot.module, Recorder):
                found[name] = f"the log has no {' and no '.join(channels)}"
    return found


def _configuration(log: Log, options: ReplayOptions, folder: Path) -> Configuration:
    # Costs as they were where it was recorded, or other intentions would follow.
    host = log.manifest.facts.get("host") or None
    if isinstance(options.config, Configuration):
        return options.config
    if options.config is not None:
        return load_configuration(options.config, host=host)
    program = log.manifest.facts.get("program")
    if not program:
        # Recorded by another program: ours runs on it, as far as the log has something for it.
        return load_configuration(paths.config_dir() / "lab.yaml")
    home = extract(log.manifest, folder)
    configuration = load_configuration(home / program, host=host)
    body = log.manifest.facts.get("body", "")
    if body not in {file.name for file in log.manifest.files}:  # recorded before there was a choice
        return configuration
    return replace(configuration, program=configuration.program.model_copy(update={"robot": Path(body)}))


def _streams(log: Log, configuration: Configuration) -> dict[str, str]:
    """Stream: channel of the log, as its manifest says, else as the configuration would record it."""
    named = {
        fact.removeprefix(_STREAM): channel for fact, channel in log.manifest.facts.items() if fact.startswith(_STREAM)
    }
    for spec in configuration.program.modules.values():
        module_class = load_class(spec.class_path)
        for port, stream in (module_class.streams if module_class else {}).items():
            if port in spec.outputs:
                named.setdefault(stream, spec.outputs[port])
    return {stream: channel for stream, channel in named.items() if channel in log.info.channels}


def _modules(
    configuration: Configuration, options: ReplayOptions, streams: Collection[str], idle: Mapping[str, str]
) -> tuple[dict[str, ModuleSpec], dict[str, str]]:
    """The modules that run, and those that do not with the reason."""
    everything = configuration.program.modules
    for name in options.only or ():
        if name not in everything:
            raise ConfigError(f"there is no module {name!r}; {suggestion(name, list(everything))}", "--only")
    kept: dict[str, ModuleSpec] = {}
    left_out: dict[str, str] = {}
    for name, spec in everything.items():
        module_class = load_class(spec.class_path)
        why = _obstacle(name, module_class, options, streams) or idle.get(name, "")
        if why:
            left_out[name] = why
        else:
            kept[name] = spec
    return kept, left_out


def _obstacle(name: str, module_class: type[Module] | None, options: ReplayOptions, streams: Collection[str]) -> str:
    """Why the module stays out, in words; "" for one that runs (one that does not exist is the graph's to refuse)."""
    if module_class is not None and issubclass(module_class, Recorder):
        return "" if options.record else NOT_ASKED
    if options.only is not None and name not in options.only:
        return NOT_ASKED
    if module_class is None:
        return ""
    missing = sorted(set(module_class.streams.values()) - module_class.optional_streams - set(streams))
    return f"the log has no {' and no '.join(missing)}" if missing else ""


def _feeds(info: LogInfo, configuration: Configuration, name: str, own: Collection[type[Any]]) -> bool:
    """Whether the log can feed the channel ``name``: not with what the program publishes of its ``own``."""
    logged = info.channels.get(name)
    if logged is None or logged.message_type in own:
        return False
    return logged.message_type is _message_type(configuration.channels[name])


def _message_type(spec: ChannelSpec) -> type[Any] | None:
    try:
        return spec.message_type
    except (KeyError, ConfigError):
        return None  # the graph says so, with the line


def _as_recorded(
    log: LogInfo, channels: Mapping[str, ChannelSpec], modules: Collection[ModuleSpec], fed: Collection[str]
) -> dict[str, ChannelSpec]:
    """The table of channels for this log.

    Channels that are read but not produced are external. Those fed from the log have the log's rate, or they would be
    stale all the time; channels that can get no message are never stale.
    """
    produced = {channel for spec in modules for channel in spec.outputs.values()}
    relayed = {
        channel
        for spec in modules
        if (module_class := load_class(spec.class_path)) is not None
        for port, channel in spec.outputs.items()
        if port in module_class.streams
    }
    read = {channel for spec in modules for channel in spec.inputs.values()}
    table: dict[str, ChannelSpec] = {}
    for name, spec in channels.items():
        changes: dict[str, Any] = {}
        if name not in produced and (name in fed or name in read):
            changes["external"] = True
        if spec.rate_hz is not None and (name in fed or name in relayed) and name in log.channels:
            changes["rate_hz"] = min(spec.rate_hz, _mean_rate(log, name) or spec.rate_hz)
        elif name not in produced:
            changes["rate_hz"] = None
        table[name] = spec.model_copy(update=changes)
    return table


def _mean_rate(log: LogInfo, channel: str) -> float | None:
    """Messages a second over the whole log; None with too few messages."""
    count = log.channels[channel].count
    return (count - 1) / log.duration_s if count > 1 and log.duration_s > 0 else None


def _describe(info: LogInfo, configuration: Configuration, stream: str, channel: str) -> StreamDescription:
    logged = info.channels[channel]
    spec = configuration.channels.get(channel)
    rate_hz = logged.rate_hz or (spec.rate_hz if spec is not None else None)
    if rate_hz is None:
        rate_hz = _mean_rate(info, channel) or 1.0
    return StreamDescription(stream, logged.message_type, rate_hz)
