"""LookAt by itself, at a face or a sound: what it looks at, the perception that it desires, and when it gives up."""

from __future__ import annotations

import math
from typing import Any

from app.attention.desires import Desire, DesireClass, DesireClasses, Source
from app.attention.workspace import IntentionWorkspace
from app.base.geometry import Pose2
from app.messages import DesireReport, Faces, SoundSources
from app.modules.behaviors.gaze.look_at import LOCATE_FACES, LOCATE_VOICES, LOOK_AT
from app.runtime.clock import VirtualClock, in_virtual_time
from tests.modules.behaviors.gaze.head_bench import commanded, desire, head_bench, off_axis_deg
from tests.modules.behaviors.gaze.percepts import faces, sounds, source
from tests.modules.fakes import Bench

PERCEPTIONS = (LOCATE_FACES, LOCATE_VOICES)
ANN = Source("operator", "Ann")


class Asked:
    """LookAt on its bench, and the Intention Workspace that its desires and reports go to."""

    def __init__(self, inputs: dict[str, type[Any]] | None = None) -> None:
        classes = [LOOK_AT, *(DesireClass(name, name, "") for name in PERCEPTIONS)]
        self.workspace = IntentionWorkspace(DesireClasses(classes), VirtualClock().now)
        ports = {"faces": Faces, "sources": SoundSources} if inputs is None else inputs
        self.bench: Bench = head_bench("look_at:LookAt", ports, workspace=self.workspace, give_up_s=2.0)
        self.bench.graph.channel("accomplishments").observe(self.workspace.accomplish)

    def look_at(self, **params: Any) -> str:
        """It is desired, and attention lets it look."""
        added = self.workspace.add("LookAt", intensity=5, utility=4, params=params, source=ANN)
        desire(self.bench, **added.params)
        return added.id

    def perceptions(self) -> list[Desire]:
        return [each for each in self.workspace.desires() if each.cls in PERCEPTIONS]

    def report(self, desire_id: str) -> DesireReport:
        return self.workspace.report(desire_id)


@in_virtual_time
async def test_a_face_is_looked_at_and_faces_are_located_while_one_is_desired() -> None:
    asked = Asked()
    async with asked.bench as b:
        wanted = asked.look_at(face=True)
        assert await commanded(b, 0.5, Pose2()) == [], "none is seen yet"
        (perception,) = asked.perceptions()
        assert (perception.cls, perception.intensity, perception.source.kind) == (LOCATE_FACES, 5, "motivation")
        b.feed("faces", faces(b.clock.now(), {1: (3.0, 0.0, 1.6), 2: (1.5, 1.0, 1.6)}))
        assert off_axis_deg((await commanded(b, 0.5, Pose2()))[-1], [1.5, 1.0, 1.6]) < 0.1
        assert asked.report(wanted).outcome == "done"
        asked.workspace.change(wanted, intensity=7)
        await commanded(b, 0.2, Pose2())
        assert [each.intensity for each in asked.perceptions()] == [7]
        desire(b, x=1.0, y=1.0, frame="base_link")
        await commanded(b, 0.2, Pose2())
        assert asked.perceptions() == [], "a point needs no perception"


@in_virtual_time
async def test_the_face_of_a_number_is_looked_at() -> None:
    asked = Asked()
    async with asked.bench as b:
        asked.look_at(face=True, track=1)
        await commanded(b, 0.2, Pose2())
        b.feed("faces", faces(b.clock.now(), {1: (3.0, 0.0, 1.6), 2: (1.5, 1.0, 1.6)}))
        assert off_axis_deg((await commanded(b, 0.5, Pose2()))[-1], [3.0, 0.0, 1.6]) < 0.1


@in_virtual_time
async def test_the_loudest_voice_or_the_loudest_sound_is_looked_at() -> None:
    asked = Asked()
    async with asked.bench as b:
        asked.look_at(sound="voice")
        await commanded(b, 0.2, Pose2())
        assert [each.cls for each in asked.perceptions()] == [LOCATE_VOICES]
        heard = source(1, 0.8, -40), source(2, -0.8, -20, speech=0.1)
        b.feed("sources", sounds(b.clock.now(), *heard))
        at = [2 * math.cos(0.8), 2 * math.sin(0.8), 1.0]
        assert off_axis_deg((await commanded(b, 0.5, Pose2()))[-1], at) < 0.1
        asked.look_at(sound="any")
        await commanded(b, 0.2, Pose2())
        b.feed("sources", sounds(b.clock.now(), *heard))
        at = [2 * math.cos(0.8), -2 * math.sin(0.8), 1.0]
        assert off_axis_deg((await commanded(b, 0.5, Pose2()))[-1], at) < 0.1


@in_virtual_time
async def test_without_any_it_gives_up_with_a_reason_and_is_done_once_there_is_one() -> None:
    asked = Asked()
    async with asked.bench as b:
        wanted = asked.look_at(face=True)
        await commanded(b, 1.5, Pose2())
        assert asked.report(wanted).outcome is None
        assert await commanded(b, 1.0, Pose2()) == []
        report = asked.report(wanted)
        assert (report.outcome, report.reason) == ("failed", "it gave up: a face was not perceived within 2 s")
        assert len(asked.perceptions()) == 1, "one may come"
        b.feed("faces", faces(b.clock.now(), {4: (2.0, -0.5, 1.5)}))
        assert off_axis_deg((await commanded(b, 0.5, Pose2()))[-1], [2.0, -0.5, 1.5]) < 0.1
        assert asked.report(wanted).outcome == "done"


@in_virtual_time
async def test_no_perception_is_desired_while_attention_does_not_let_it_look_or_after_it_ended() -> None:
    asked = Asked()
    async with asked.bench as b:
        asked.look_at(face=True)
        await commanded(b, 0.2, Pose2())
        assert len(asked.perceptions()) == 1
        b.graph.filters.apply({"Tested.command": math.inf})
        await commanded(b, 0.2, Pose2())
        assert asked.perceptions() == []
        b.graph.filters.apply({"Tested.command": 1})
        await commanded(b, 0.2, Pose2())
        assert len(asked.perceptions()) == 1
    assert asked.perceptions() == []


@in_virtual_time
async def test_a_perception_that_a_person_withdrew_stays_withdrawn() -> None:
    asked = Asked()
    async with asked.bench as b:
        wanted = asked.look_at(face=True)
        await commanded(b, 0.2, Pose2())
        (perception,) = asked.perceptions()
        asked.workspace.remove(perception.id)
        await commanded(b, 2.5, Pose2())
        assert asked.perceptions() == []
        assert asked.report(wanted).outcome == "failed"


@in_virtual_time
async def test_a_program_without_the_perception_fails_at_once_with_a_reason() -> None:
    asked = Asked(inputs={})
    async with asked.bench as b:
        face = asked.look_at(face=True)
        await commanded(b, 0.2, Pose2())
        assert (asked.report(face).outcome, asked.report(face).reason) == (
            "failed",
            "this program does not look for faces",
        )
        sound = asked.look_at(sound="any")
        await commanded(b, 0.2, Pose2())
        assert asked.report(sound).reason == "this program does not listen for sounds"
        assert asked.perceptions() == []
