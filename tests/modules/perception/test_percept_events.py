"""PerceptEvents on faces, codes, voices and noises: named, placed in odom; what rests neither leaves nor wakes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from app.base.geometry import Pose2, Pose3
from app.messages import (
    Darkness,
    Divisors,
    Face,
    Faces,
    LoudNoise,
    Odometry,
    PerceptEvent,
    QRCode,
    QRCodes,
    SoundSource,
    SoundSources,
)
from app.runtime.channel_table import ChannelSpec
from app.runtime.clock import VirtualClock, run_virtual
from app.runtime.graph import Graph, ModuleSpec, WiringError
from app.runtime.module import Module, ModuleContext
from tests.modules.fakes import Bench, drain

INPUTS: dict[str, type[Any]] = {
    "codes": QRCodes,
    "faces": Faces,
    "sources": SoundSources,
    "noises": LoudNoise,
    "odometry": Odometry,
    "divisors": Divisors,
}
LISTENING = "LoudNoiseDetector.audio"


def bench(without: tuple[str, ...] = (), **settings: Any) -> Bench:
    return Bench(
        "app.modules.perception.percept_events:PerceptEvents",
        inputs={name: kind for name, kind in INPUTS.items() if name not in without},
        outputs={"events": PerceptEvent},
        settings=settings,
    )


def faces(stamp: float, *tracks: int, frame: str = "kinect", x: float = 2.0) -> Faces:
    found = tuple(
        Face(track, 0.9, (0, 0, 9, 9), np.zeros((5, 2), np.float32), (x, 0.0, 1.5), np.eye(3), x, 0.1)
        for track in tracks
    )
    return Faces(stamp, frame, 640, 480, Pose3.identity(), found)


def codes(stamp: float, *texts: str) -> QRCodes:
    found = tuple(QRCode(text, np.zeros((4, 2), np.float32), None) for text in texts)
    return QRCodes(stamp, "kinect", 640, 480, Pose3.identity(), found)


def sounds(stamp: float, azimuth: float | None, speech: float = 0.9) -> SoundSources:
    """One source in that direction, sounding; None: it is silent."""
    angle = azimuth or 0.0
    direction = (math.cos(angle), math.sin(angle), 0.0)
    source = SoundSource(4, direction, 0.8, -30.0, azimuth is not None, speech, math.nan, math.nan)
    return SoundSources(stamp, (0.0, 0.0, 1.0), (source,))


class Play:
    """Feeds a bench, and odometry (standing at ``X_OB``) with everything."""

    def __init__(self, b: Bench, X_OB: Pose2 | None = None) -> None:
        self.bench = b
        self.X_OB = X_OB or Pose2(0.0, 0.0, 0.0)
        self.events = b.listen("events")

    async def feed(
        self, port: str, make: Any, *args: Any, times: int = 5, every_s: float = 0.25, **kwargs: Any
    ) -> None:
        for _ in range(times):
            await self.bench.clock.sleep(every_s)
            now = self.bench.clock.now()
            if self.bench.slot.context.inputs["odometry"].connected:
                self.bench.feed("odometry", Odometry(now, self.X_OB, 0.0, 0.0))
            self.bench.feed(port, make(now, *args, **kwargs))
            await self.bench.settle()

    def names(self) -> list[tuple[str, str]]:
        return [(event.name, event.subject) for event in drain(self.events)]


def test_a_face_appears_changes_and_leaves_where_it_is_in_odom() -> None:
    async def main() -> None:
        async with bench() as b:
            play = Play(b, Pose2(1.0, 2.0, math.pi / 2))
            begin = b.clock.now()
            await play.feed("faces", faces, 3)
            (event,) = drain(play.events)
            assert (event.name, event.kind, event.subject, event.source) == ("face.appears", "face", "3", "kinect")
            assert event.p_OP == pytest.approx((1.0, 4.0, 1.5))
            assert event.heading == pytest.approx(math.pi / 2)
            assert event.confidence == 0.9
            assert event.since == pytest.approx(begin + 0.25, abs=0.01)
            assert event.stamp == pytest.approx(begin + 0.75, abs=0.01)
            await play.feed("faces", faces, 3, times=8, x=3.0)
            assert play.names() == [("face.changes", "3")]
            await play.feed("faces", faces, times=12)
            (event,) = drain(play.events)
            assert (event.name, event.subject) == ("face.leaves", "3")
            assert event.p_OP == pytest.approx((1.0, 5.0, 1.5)), "where it was last"

    run_virtual(main())


def test_a_robot_that_turns_changes_nothing() -> None:
    async def main() -> None:
        async with bench() as b:
            play = Play(b)
            await play.feed("faces", faces, 3, x=2.0)
            play.X_OB = Pose2(0.0, 0.0, math.pi)
            await play.feed("faces", faces, 3, times=12, x=-2.0)
            assert play.names() == [("face.appears", "3")]

    run_virtual(main())


def test_a_code_is_one_by_its_text() -> None:
    async def main() -> None:
        async with bench() as b:
            play = Play(b)
            await play.feed("codes", codes, "lab", "office")
            await play.feed("codes", codes, "lab", times=20)
            assert play.names() == [("code.appears", "lab"), ("code.appears", "office"), ("code.leaves", "office")]

    run_virtual(main())


def test_a_voice_appears_when_it_is_probably_one_and_leaves_when_it_falls_silent() -> None:
    async def main() -> None:
        async with bench() as b:
            play = Play(b)
            await play.feed("sources", sounds, 0.2, math.nan, every_s=0.1)
            await play.feed("sources", sounds, 0.2, 0.2, every_s=0.1)
            assert play.names() == [], "not judged, then no voice"
            await play.feed("sources", sounds, 0.2, 0.9, every_s=0.1)
            (event,) = drain(play.events)
            assert (event.name, event.subject, event.p_OP) == ("voice.appears", "4", None)
            assert event.heading == pytest.approx(0.2)
            await play.feed("sources", sounds, 1.0, 0.9, every_s=0.5)
            assert play.names() == [("voice.changes", "4")]
            await play.feed("sources", sounds, None, times=30, every_s=0.1)
            assert play.names() == [("voice.leaves", "4")]

    run_virtual(main())


def test_noises_in_quick_succession_are_one_that_leaves_with_the_quiet() -> None:
    async def main() -> None:
        async with bench() as b:
            play = Play(b)
            await play.feed("noises", LoudNoise, 30.0, -20.0, every_s=0.5)
            assert play.names() == [("noise.appears", "")]
            await b.clock.sleep(1.5)
            assert play.names() == [("noise.leaves", "")]

    run_virtual(main())


def test_quiet_is_not_heard_while_the_detector_is_closed() -> None:
    async def main() -> None:
        async with bench() as b:
            play = Play(b)
            await play.feed("noises", LoudNoise, 30.0, -20.0, times=1)
            b.feed("divisors", Divisors(b.clock.now(), (LISTENING,), (math.inf,)))
            await b.clock.sleep(60)
            assert play.names() == [("noise.appears", "")]
            b.feed("divisors", Divisors(b.clock.now(), (LISTENING,), (1.0,)))
            await b.clock.sleep(1.5)
            assert play.names() == [("noise.leaves", "")]

    run_virtual(main())


@pytest.mark.parametrize("rest_s", [3.0, 60.0])
def test_what_rests_does_not_leave(rest_s: float) -> None:
    """φ = ∞: no image is looked at, so no message comes; and the first look after that is but one look."""

    async def main() -> None:
        async with bench() as b:
            play = Play(b)
            await play.feed("faces", faces, 3)
            await b.clock.sleep(rest_s)
            await play.feed("faces", faces, times=1)
            await play.feed("faces", faces, 3, times=5)
            assert play.names() == [("face.appears", "3")]

    run_virtual(main())


def test_after_a_restart_what_is_there_does_not_appear_again() -> None:
    async def main() -> None:
        async with bench() as b:
            play = Play(b)
            await play.feed("faces", faces, 3)
            b.slot.module.fail(RuntimeError("tried"))
            await b.clock.sleep(2.0)
            await play.feed("faces", faces, 3)
            await play.feed("faces", faces, times=12)
            assert play.names() == [("face.appears", "3"), ("face.leaves", "3")]

    run_virtual(main())


def test_without_odometry_there_are_events_without_places() -> None:
    async def main() -> None:
        async with bench(without=("odometry",), face={"sightings": 1}) as b:
            play = Play(b)
            await play.feed("faces", faces, 3, times=1)
            (event,) = drain(play.events)
            assert (event.name, event.p_OP, event.heading) == ("face.appears", None, None)

    run_virtual(main())


def test_a_kind_that_a_message_type_declares_has_settings_of_its_own() -> None:
    def there(**settings: Any) -> list[str]:
        found: list[str] = []

        async def main() -> None:
            inputs = {"darkness": Darkness}
            async with Bench(
                "app.modules.perception.percept_events:PerceptEvents",
                inputs=inputs,
                outputs={"events": PerceptEvent},
                settings=settings,
            ) as b:
                events = b.listen("events")
                for step, dark in enumerate((True, True, True, False, False)):
                    b.feed("darkness", Darkness(float(step), "kinect", 0.0, dark))
                    await b.settle()
                found.extend(f"{event.name} {event.stamp:g}" for event in drain(events))

        run_virtual(main())
        return found

    assert there() == ["dark.appears 1", "dark.leaves 4"]
    assert there(dark={"sightings": 3}) == ["dark.appears 2", "dark.leaves 4"], "the rest keeps its default"
    assert there(dark={"off_s": 9}) == ["dark.appears 1"]


def test_the_hysteresis_of_a_kind_that_no_input_brings_is_refused() -> None:
    with pytest.raises(WiringError, match="brings percepts of kind 'smoke'; there are code, face, noise, voice"):
        bench(smoke={"sightings": 3})
    with pytest.raises(WiringError, match="smoke"):
        bench(smoke=3)


def test_settings_change_only_what_they_name() -> None:
    b = bench(face={"off_s": 5.0})
    module: Any = b.slot.module
    assert module.settings.face.off_s == 5.0
    assert module.settings.face.sightings == 3
    with pytest.raises(Exception, match="face"):
        bench(face={"of_s": 5.0})


class Lazy(Module):
    """A perception that rests while its output is not wanted."""

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.faces = self.output("faces", Faces)


def test_a_perception_is_not_kept_awake_for_its_events() -> None:
    modules = {
        "Lazy": {"class": f"{__name__}:Lazy", "outputs": {"faces": "faces"}},
        "PerceptEvents": {
            "class": "app.modules.perception.percept_events:PerceptEvents",
            "inputs": {"faces": "faces"},
            "outputs": {"events": "events"},
        },
    }
    graph = Graph(
        clock=VirtualClock(),
        channels={name: ChannelSpec(type=kind) for name, kind in (("faces", "Faces"), ("events", "PerceptEvent"))},
        modules={name: ModuleSpec.model_validate(spec) for name, spec in modules.items()},
        services={},
    )
    graph.channel("events").subscribe("a rule")
    lazy: Any = graph.modules["Lazy"].module
    assert not lazy.faces.wanted
    graph.channel("faces").subscribe("a viewer")
    assert lazy.faces.wanted
