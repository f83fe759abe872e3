from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

import pytest
from pydantic import BaseModel

from app.attention.desires import DesireClass, DesireClasses, Source
from app.attention.workspace import IntentionWorkspace, WorkspaceChange
from app.messages import Landmark, Landmarks, LoudNoise, SoundSource, SoundSources
from app.modules.perception.telepresence import TELEPRESENCE
from app.runtime.clock import run_virtual
from tests.modules.fakes import Bench

MODULE = "app.modules.motivations.scenario_coordinator:ScenarioCoordinator"


class Nothing(BaseModel):
    """Parameters of a class that has none."""


USUAL = {"FindQRCodes", "LocateFaces", "DetectNoises", "SLAM", "Teleoperation"}
CLASSES = {
    name: DesireClass(name=name, title=name, description=f"{name}.", parameters=Nothing)
    for name in (*USUAL, "LocateVoices")
} | {"Telepresence": TELEPRESENCE}
PORTS = {"landmarks": Landmarks, "noises": LoudNoise, "sources": SoundSources}
NOISE = LoudNoise(1.0, 40.0, -20.0)


class Life:
    """The module with a workspace whose clock is the bench's."""

    def __init__(self, settings: Mapping[str, Any] | None = None, classes: Iterable[str] = CLASSES) -> None:
        known = DesireClasses(CLASSES[name] for name in classes)
        self.workspace = IntentionWorkspace(known, lambda: self.bench.clock.now())
        self.changes: list[WorkspaceChange] = []
        self.workspace.observe(self.changes.append)
        services = {IntentionWorkspace: self.workspace}
        self.bench = Bench(MODULE, inputs=PORTS, services=services, settings=settings)

    async def pass_time(self, seconds: float) -> None:
        """Let time go on, desires expiring as the translator makes them."""
        for _ in range(round(seconds / 0.05)):
            await self.bench.clock.sleep(0.05)
            self.workspace.expire()

    def speak(self, speech: float, *, active: bool = True) -> None:
        source = SoundSource(1, (1.0, 0.0, 0.0), 0.1, -30.0, active, speech, 2.0, 1.0)
        self.bench.feed("sources", SoundSources(self.bench.clock.now(), (0.0, 0.0, 0.8), (source,)))

    @property
    def listens(self) -> bool:
        return "LocateVoices" in self.workspace.strongest()


def bench(settings: Mapping[str, Any] | None = None) -> tuple[Bench, IntentionWorkspace, list[WorkspaceChange]]:
    life = Life(settings)
    return life.bench, life.workspace, life.changes


def test_the_thesiss_desires_stand_while_it_lives() -> None:
    async def main() -> None:
        b, workspace, changes = bench()
        async with b:
            desires = {d.cls: d for d in workspace.desires()}
            assert {c: (d.intensity, d.utility, d.security) for c, d in desires.items()} == {
                "FindQRCodes": (8, 1, False),
                "LocateFaces": (8, 1, False),
                "DetectNoises": (8, 1, False),
                "SLAM": (8, 1, False),
                "Teleoperation": (8, 1, True),
            }
            assert {d.source for d in desires.values()} == {Source("motivation", "Tested", motive="rational")}
            assert len(changes) == 1, "one transaction, one notification"
        assert workspace.desires() == ()
        assert len(changes) == 2

    run_virtual(main())


def test_restarts_do_not_double_desires() -> None:
    async def main() -> None:
        b, workspace, _ = bench()
        async with b:
            landmark = Landmark("stop", (1.0, 2.0, 0.5), 0.02, 1, 0.0, 0.0)
            b.feed("landmarks", Landmarks(1.0, ("not a landmark",)))  # type: ignore[arg-type]  # makes it fail
            await b.clock.sleep(5.0)
            assert b.supervisor.states["Tested"].restarts == 1
            assert sorted(d.cls for d in workspace.desires()) == sorted(USUAL)
            b.feed("landmarks", Landmarks(1.0, (landmark,)))

    run_virtual(main())


def test_a_desire_removed_meanwhile_does_not_matter() -> None:
    async def main() -> None:
        b, workspace, _ = bench()
        async with b:
            workspace.remove(workspace.desires()[0].id)
        assert workspace.desires() == ()

    run_virtual(main())


def test_configuration_chooses_the_desires() -> None:
    wanted = [{"class": "Telepresence", "intensity": 3, "utility": 2, "params": {"max_points": 2000}}]

    async def main() -> None:
        b, workspace, _ = bench({"desires": wanted})
        async with b:
            (desire,) = workspace.desires()
            assert (desire.cls, desire.intensity, desire.utility) == ("Telepresence", 3, 2)
            assert desire.params == {"max_points": 2000, "jpeg_quality": 80}

    run_virtual(main())


def test_one_bad_desire_posts_none_and_says_why() -> None:
    wanted = [{"class": "FindQRCodes"}, {"class": "Telepresence", "params": {"max_points": 3}}]

    async def main() -> None:
        b, workspace, _ = bench({"desires": wanted})
        async with b:
            assert workspace.desires() == ()
            assert "params.max_points" in b.problem

    run_virtual(main())


def test_a_code_found_is_logged_once(caplog: pytest.LogCaptureFixture) -> None:
    first = Landmark("stop 1", (1.0, 2.0, 0.5), 0.02, 1, 0.0, 0.0)
    second = Landmark("stop 2", (3.0, 2.0, 0.5), 0.02, 1, 0.0, 0.0)

    async def main() -> None:
        b, _, _ = bench()
        async with b:
            for known in ((first,), (first,), (first, second)):
                b.feed("landmarks", Landmarks(1.0, known))
                await b.settle()

    caplog.set_level("INFO", "hbba")
    run_virtual(main())
    assert [r.args[0] for r in caplog.records if "found" in r.msg] == ["stop 1", "stop 2"]  # type: ignore[index]


def test_what_nothing_serves_is_not_desired() -> None:
    async def main() -> None:
        life = Life(classes=("FindQRCodes", "Teleoperation", "Telepresence"))
        async with life.bench as b:
            assert {d.cls for d in life.workspace.desires()} == {"FindQRCodes", "Teleoperation"}
            b.feed("noises", NOISE)
            await b.settle()
            assert len(life.workspace.desires()) == 2
            assert not b.problem

    run_virtual(main())


def test_a_loud_noise_makes_it_listen_for_five_seconds() -> None:
    async def main() -> None:
        life = Life()
        async with life.bench as b:
            assert not life.listens
            b.feed("noises", NOISE)
            await b.settle()
            desire = life.workspace.strongest()["LocateVoices"]
            assert (desire.intensity, desire.utility, desire.security) == (8, 1, False)
            await life.pass_time(4.8)
            assert life.listens
            await life.pass_time(0.4)
            assert not life.listens
            b.feed("noises", NOISE)
            await b.settle()
            assert life.listens

    run_virtual(main())


def test_it_listens_on_without_a_gap_while_a_voice_is_located() -> None:
    async def main() -> None:
        life = Life()
        async with life.bench as b:
            b.feed("noises", NOISE)
            await b.settle()
            (desire,) = [d for d in life.workspace.desires() if d.cls == "LocateVoices"]
            for _ in range(60):
                life.speak(0.9)
                await life.pass_time(0.25)
                assert life.workspace.get(desire.id).id == desire.id
            renewals = [c for c in life.changes if c.changed]
            assert len(renewals) == 3, "15 s of speech: every 5 s or a little sooner"
            await life.pass_time(10.3)
            assert not life.listens

    run_virtual(main())


@pytest.mark.parametrize(
    ("speech", "active", "kept"), [(0.1, True, False), (0.9, False, False), (math.nan, True, True)]
)
def test_only_what_may_be_a_voice_keeps_it_listening(speech: float, active: bool, kept: bool) -> None:
    async def main() -> None:
        life = Life()
        async with life.bench as b:
            b.feed("noises", NOISE)
            await b.settle()
            life.speak(speech, active=active)
            await life.pass_time(6.0)
            assert life.listens == kept

    run_virtual(main())


def test_noise_upon_noise_prolongs_one_desire() -> None:
    async def main() -> None:
        life = Life()
        async with life.bench as b:
            for _ in range(4):
                b.feed("noises", NOISE)
                await life.pass_time(3.0)
            assert [d.cls for d in life.workspace.desires()].count("LocateVoices") == 1
        assert life.workspace.desires() == ()

    run_virtual(main())
