"""The lab's rules beside the motivation that they replace, on what was heard in the trial."""

from __future__ import annotations

import heapq
import json
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from app.attention.desires import DesireClass, DesireClasses
from app.attention.rule_book import RuleBook
from app.attention.timeline import Timeline
from app.attention.workspace import IntentionWorkspace, WorkspaceChange
from app.base import paths
from app.messages import Darkness, LoudNoise, Message, PerceptEvent, SoundSource, SoundSources
from app.runtime.channel_table import ChannelSpec, ChannelTable
from app.runtime.clock import run_virtual
from tests.modules.fakes import Bench

CLASSES = DesireClasses(
    DesireClass(name, name, "")
    for name in ("FindQRCodes", "LocateFaces", "DetectNoises", "SLAM", "Teleoperation", "LocateVoices")
)
TYPES: dict[str, type[Any]] = {
    "loud_noises": LoudNoise,
    "sound_sources": SoundSources,
    "percept_events": PerceptEvent,
    "darkness": Darkness,
}
SOUNDS = Path(__file__).with_name("trial_sounds.json")


def heard() -> Iterator[tuple[float, str, Message]]:
    """Time (s), channel and message of what was heard in the trial, in its order."""
    sounds = json.loads(SOUNDS.read_text(encoding="utf-8"))
    noises = ((at, "loud_noises", LoudNoise(at, ratio, -20.0)) for at, ratio in sounds["noises"])
    sources = (
        (
            at,
            "sound_sources",
            SoundSources(
                at,
                (0.0, 0.0, 0.8),
                tuple(
                    SoundSource(
                        number, (1.0, 0.0, 0.0), 0.1, -30.0, active, math.nan if speech is None else speech, 2.0, 1.0
                    )
                    for number, (active, speech) in enumerate(found)
                ),
            ),
        )
        for at, found in sounds["sources"]
    )
    return heapq.merge(noises, sources, key=lambda each: each[0])


class Side:
    """One of the two motivations with a workspace of its own, and what it did there."""

    def __init__(self, module: str, ports: dict[str, str]) -> None:
        self.ports = ports
        self.done: list[tuple[float, str, str, float, float, bool]] = []
        self.workspace = IntentionWorkspace(CLASSES, lambda: self.bench.clock.now())
        self.workspace.observe(self._note)
        table = ChannelTable(
            {name: ChannelSpec.model_validate({"type": kind.__name__}) for name, kind in TYPES.items()}
        )
        services: dict[type[Any], Any] = {
            IntentionWorkspace: self.workspace,
            Timeline: Timeline(100, lambda: self.bench.clock.now()),
            RuleBook: RuleBook([paths.config_dir() / "rules" / "lab.yaml"]),
            ChannelTable: table,
        }
        inputs = {port: TYPES[channel] for channel, port in ports.items()}
        self.bench = Bench(module, inputs=inputs, services=services)

    def feed(self, channel: str, message: Message) -> None:
        self.bench.feed(self.ports[channel], message)

    def _note(self, change: WorkspaceChange) -> None:
        now = round(self.bench.clock.now(), 3)
        found = [("added", desire) for desire in change.added] + [(gone.reason, gone.desire) for gone in change.removed]
        self.done += [(now, what, d.cls, d.intensity, d.utility, d.security) for what, d in found]


@pytest.mark.parametrize(
    "deaf", [lambda _: False, lambda channel: channel == "sound_sources"], ids=["with voices", "without"]
)
def test_rules_desire_in_the_trial_what_the_coordinator_does_and_when(deaf: Callable[[str], bool]) -> None:
    rules = Side("app.modules.motivations.rules:Rules", {name: name for name in TYPES if name != "darkness"})
    coordinator = Side(
        "app.modules.motivations.scenario_coordinator:ScenarioCoordinator",
        {"loud_noises": "noises", "sound_sources": "sources"},
    )

    async def pass_time(until: float) -> None:
        clock = rules.bench.clock
        while clock.now() < until:
            # As the translator, whose timer is set to the next one that ends.
            ends = min((s.workspace.next_expiry or math.inf for s in (rules, coordinator)), default=math.inf)
            await clock.sleep_until(min(until, ends))
            for side in (rules, coordinator):
                side.workspace.expire()

    sounds = list(heard())

    async def main() -> None:
        async with coordinator.bench, rules.bench:
            begin = rules.bench.clock.now()
            for at, channel, message in sounds:
                await pass_time(begin + at)
                if not deaf(channel):
                    rules.feed(channel, message)
                    coordinator.feed(channel, message)
            await pass_time(begin + 95.0)

    run_virtual(main())
    voices = [(what, cls) for _, what, cls, *_ in coordinator.done if cls == "LocateVoices"]
    assert len(voices) >= 8, "the trial wakes it several times"
    assert len(rules.done) == len(coordinator.done)
    for mine, its in zip(rules.done, coordinator.done, strict=True):
        assert mine[1:] == its[1:]
        assert mine[0] == pytest.approx(its[0], abs=0.25), "one beat of either"
