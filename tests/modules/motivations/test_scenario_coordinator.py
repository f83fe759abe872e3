from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pytest

from app.attention.desires import DesireClasses, Source
from app.attention.workspace import IntentionWorkspace, WorkspaceChange
from app.messages import Landmark, Landmarks
from app.modules.desire_classes import desire_classes
from app.runtime.clock import run_virtual

from ..fakes import Bench

MODULE = "app.modules.motivations.scenario_coordinator:ScenarioCoordinator"


def bench(settings: Mapping[str, Any] | None = None) -> tuple[Bench, IntentionWorkspace, list[WorkspaceChange]]:
    workspace = IntentionWorkspace(DesireClasses(desire_classes()), lambda: 5.0)
    changes: list[WorkspaceChange] = []
    workspace.observe(changes.append)
    b = Bench(MODULE, inputs={"landmarks": Landmarks}, services={IntentionWorkspace: workspace}, settings=settings)
    return b, workspace, changes


def test_the_thesiss_desires_stand_while_it_lives() -> None:
    async def main() -> None:
        b, workspace, changes = bench()
        async with b:
            desires = {d.cls: d for d in workspace.desires()}
            assert {c: (d.intensity, d.utility, d.security) for c, d in desires.items()} == {
                "FindQRCodes": (8, 1, False),
                "Teleoperation": (8, 1, True),
            }
            assert {d.source for d in desires.values()} == {Source("motivation", "Tested")}
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
            assert sorted(d.cls for d in workspace.desires()) == ["FindQRCodes", "Teleoperation"]
            b.feed("landmarks", Landmarks(1.0, (landmark,)))

    run_virtual(main())


def test_a_desire_somebody_removed_meanwhile_does_not_matter() -> None:
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
