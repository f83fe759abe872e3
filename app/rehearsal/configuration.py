"""The program of a rehearsal, made from a robot's: what needs pictures, sound or a charger is left out or stood in for.

| module | in a rehearsal |
|---|---|
| a sensor's | left out, where the body does not have its stream |
| SLAM2D, FaceDetector | stood in for by the truth, under the same name: the same strategies and filters |
| a behavior that moves the body and looks at pictures, too | runs without them |
| one that moves it and needs another missing sensor, as Docking | left out |
| one that attention can choose, as a perception | runs, and gets nothing, so that attention has the same choice |
| any other that reads a missing sensor | runs without it, or is left out where it has nothing else to go by |
| recorders | left out |
| Say | speaks in writing: sentences take their time |
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace

from app.base.yaml_source import suggestion
from app.link import RobotDescription
from app.modules.behaviors.speech.say import Say
from app.modules.perception.face_detector import FaceDetector
from app.modules.perception.slam_2d import SLAM2D
from app.modules.recording.recorder import Recorder
from app.program.config import Configuration
from app.runtime.channel_table import ChannelSpec
from app.runtime.graph import ModuleSpec, load_class
from app.runtime.module import Module

_STAND_INS = "app.modules.perception.stand_ins"
#: Message types that move the body, and that of pictures.
_MOTION, _PICTURE = frozenset({"Twist", "JointCommand"}), "Image"
#: Those that only say how the robot itself moves: nothing is perceived by them alone.
_SELF = frozenset({"Odometry", "JointState"})


def rehearsed(
    configuration: Configuration, body: RobotDescription, map_name: str, without: Collection[str] = ()
) -> Configuration:
    """``configuration`` for a rehearsal with ``body`` on the kept map ``map_name``, ``without`` the modules so named.

    Raises ConfigError for a program that neither localizes itself nor has a module named in ``without``.
    """
    modules = configuration.program.modules
    for name in without:
        if name not in modules:
            raise configuration.program_document.error(f"there is no module {name}; {suggestion(name, list(modules))}")
    missing = frozenset(_missing(modules, body.streams))
    kept: dict[str, ModuleSpec] = {}
    localizes = False
    for name, spec in modules.items():
        kind = load_class(spec.class_path)
        if name in without:
            continue
        if kind is None:  # the graph refuses it
            kept[name] = spec
        elif issubclass(kind, SLAM2D):
            localizes = True
            kept[name] = _standing_in(spec, "true_localization:TrueLocalization", ("scans", "odometry"), map=map_name)
        elif issubclass(kind, FaceDetector):
            eyes = _standing_in(spec, "true_faces:TrueFaces", ("images", "panorama"))
            kept[name] = eyes.model_copy(update={"inputs": {**eyes.inputs, **_map_channel(modules)}})
        elif (able := _able(spec, kind, missing, configuration.channels, body.streams)) is not None:
            kept[name] = able
    if not localizes:
        raise configuration.program_document.error(
            "a program without SLAM2D knows no map, so no tour of it can be rehearsed", ("modules",)
        )
    program = configuration.program.model_copy(update={"modules": kept})
    return replace(configuration, program=program, channels=_channels(configuration.channels, kept, body))


def _missing(modules: Mapping[str, ModuleSpec], streams: Collection[str]) -> Iterator[str]:
    """The channels of sensors that the body does not have."""
    for spec in modules.values():
        kind = load_class(spec.class_path)
        for port, stream in (kind.streams if kind is not None else {}).items():
            if stream not in streams and port in spec.outputs:
                yield spec.outputs[port]


def _able(
    spec: ModuleSpec,
    kind: type[Module],
    missing: Collection[str],
    channels: Mapping[str, ChannelSpec],
    streams: Collection[str],
) -> ModuleSpec | None:
    """The module as it can run without the channels ``missing``; None where it cannot, or need not."""
    if issubclass(kind, Recorder) or set(kind.streams.values()) - kind.optional_streams - set(streams):
        return None
    if issubclass(kind, Say):
        settings = {**spec.settings, "engine": {"engine": "text"}, "engines": {}}
        spec = spec.model_copy(update={"settings": settings})
    dark = {port: channel for port, channel in spec.inputs.items() if channel in missing}
    if not dark:
        return spec
    if any(channels[channel].message in _MOTION for channel in spec.outputs.values() if channel in channels):
        if any(channels[channel].message != _PICTURE for channel in dark.values()):
            return None
    elif kind.desire_classes:
        return spec
    lit = {port: channel for port, channel in spec.inputs.items() if port not in dark}
    if all(channels[channel].message in _SELF for channel in lit.values() if channel in channels):
        return None
    return spec.model_copy(update={"inputs": lit})


def _standing_in(spec: ModuleSpec, stand_in: str, inputs: Collection[str], **settings: object) -> ModuleSpec:
    """``stand_in`` in the place of ``spec``, with those of its ``inputs``; outputs that it does not have are silent."""
    outputs = {port: channel for port, channel in spec.outputs.items() if port in _OUTPUTS[stand_in]}
    return spec.model_copy(
        update={
            "class_path": f"{_STAND_INS}.{stand_in}",
            "inputs": {port: channel for port, channel in spec.inputs.items() if port in inputs},
            "outputs": outputs,
            "settings": settings,
        }
    )


_OUTPUTS: Mapping[str, frozenset[str]] = {
    "true_localization:TrueLocalization": frozenset({"localization", "map", "zones"}),
    "true_faces:TrueFaces": frozenset({"faces"}),
}


def _map_channel(modules: Mapping[str, ModuleSpec]) -> dict[str, str]:
    """The input ``map`` of a module that wants to know walls; none where nothing publishes a map."""
    for spec in modules.values():
        kind = load_class(spec.class_path)
        if kind is not None and issubclass(kind, SLAM2D) and "map" in spec.outputs:
            return {"map": spec.outputs["map"]}
    return {}


def _channels(
    channels: Mapping[str, ChannelSpec], modules: Mapping[str, ModuleSpec], body: RobotDescription
) -> dict[str, ChannelSpec]:
    """The table: what nothing produces is external and never stale; the body's streams come at its rates."""
    produced = {channel for spec in modules.values() for channel in spec.outputs.values()}
    rates = {
        spec.outputs[port]: body.streams[stream].rate_hz
        for spec in modules.values()
        for port, stream in _relayed(spec)
        if port in spec.outputs and stream in body.streams
    }
    table: dict[str, ChannelSpec] = {}
    for name, row in channels.items():
        changes: dict[str, object] = {}
        if name not in produced:
            changes = {"external": True, "rate_hz": None}
        elif row.rate_hz is not None and name in rates:
            changes = {"rate_hz": min(row.rate_hz, rates[name])}
        table[name] = row.model_copy(update=changes)
    return table


def _relayed(spec: ModuleSpec) -> Iterator[tuple[str, str]]:
    kind = load_class(spec.class_path)
    yield from (kind.streams if kind is not None else {}).items()
