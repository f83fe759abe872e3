"""TrackFace, TrackCode and TrackSound by themselves: what they look at, and when they give up."""

from __future__ import annotations

import math

import pytest

from app.attention.desires import DesireClasses, Source
from app.attention.workspace import IntentionWorkspace
from app.base.geometry import Pose2
from app.messages import Faces, QRCodes, SoundSources
from app.modules.behaviors.gaze.track_object import TRACK_FACE
from app.runtime.clock import VirtualClock, in_virtual_time
from tests.modules.behaviors.gaze.head_bench import commanded, desire, head_bench, move_base, off_axis_deg
from tests.modules.behaviors.gaze.percepts import codes, faces, sounds, source
from tests.modules.fakes import Bench


def track_face(**settings: float) -> Bench:
    return head_bench("track_object:TrackFace", {"faces": Faces}, **settings)


@in_virtual_time
async def test_the_nearest_face_is_looked_at_while_the_robot_turns() -> None:
    async with track_face() as b:
        desire(b, track=None)
        assert await commanded(b, 0.5, Pose2()) == [], "none is seen yet"
        b.feed("faces", faces(b.clock.now(), {1: (3.0, 0.0, 1.6), 2: (1.5, 1.0, 1.6)}))
        assert off_axis_deg((await commanded(b, 0.5, Pose2()))[-1], [1.5, 1.0, 1.6]) < 0.1
        turned = await commanded(b, 0.5, Pose2(0.0, 0.0, math.atan2(1.0, 1.5)))
        assert off_axis_deg(turned[-1], [math.hypot(1.5, 1.0), 0.0, 1.6]) < 0.1


@in_virtual_time
async def test_a_face_is_placed_with_the_pose_of_its_own_instant() -> None:
    async with track_face() as b:
        desire(b, track=None)
        for step in range(11):  # half a turn a second; the image is of the middle of it
            move_base(b, Pose2(0.0, 0.0, 0.05 * step))
            await b.clock.sleep(0.1)
            if step == 5:
                stamp = b.clock.now() - 0.1
        b.feed("faces", faces(stamp, {1: (2.0, 0.0, 1.5)}))
        looked = await commanded(b, 0.3, Pose2(0.0, 0.0, 0.5))
        bearing = 0.05 * 5 - 0.5
        assert off_axis_deg(looked[-1], [2 * math.cos(bearing), 2 * math.sin(bearing), 1.5]) < 0.1


@in_virtual_time
async def test_its_last_place_is_looked_at_for_a_while_then_it_gives_up_with_a_reason(
    caplog: pytest.LogCaptureFixture,
) -> None:
    caplog.set_level("INFO")
    workspace = IntentionWorkspace(DesireClasses([TRACK_FACE]), VirtualClock().now)
    wanted = workspace.add("TrackFace", intensity=5, utility=4, params={"track": 4}, source=Source("rest", "a test")).id
    async with head_bench("track_object:TrackFace", {"faces": Faces}, workspace=workspace, give_up_s=2.0) as b:
        b.graph.channel("accomplishments").observe(workspace.accomplish)
        desire(b, track=4)
        await commanded(b, 0.2, Pose2())
        b.feed("faces", faces(b.clock.now(), {4: (2.0, 0.5, 1.5)}))
        looked = await commanded(b, 4.0, Pose2())
        assert off_axis_deg(looked[-1], [2.0, 0.5, 1.5]) < 0.1
        assert looked[-1].stamp - looked[0].stamp == pytest.approx(2.0, abs=0.2)
        reason = "it gave up: face 4 has not been perceived for 2 s"
        assert reason in caplog.messages
        report = workspace.report(wanted)
        assert (report.outcome, report.reason, report.ended) == ("failed", reason, None)
        b.feed("faces", faces(b.clock.now(), {4: (2.0, -0.5, 1.5)}))
        assert off_axis_deg((await commanded(b, 0.5, Pose2()))[-1], [2.0, -0.5, 1.5]) < 0.1
        assert workspace.report(wanted).outcome == "done"


@in_virtual_time
async def test_a_code_is_tracked_by_its_text_once_its_place_is_known() -> None:
    async with head_bench("track_object:TrackCode", {"codes": QRCodes}) as b:
        desire(b, text="poster 2")
        await commanded(b, 0.2, Pose2())
        b.feed("codes", codes(b.clock.now(), {"poster 1": (2.0, 1.0, 1.2), "poster 2": None}))
        assert await commanded(b, 0.5, Pose2()) == []
        b.feed("codes", codes(b.clock.now(), {"poster 1": (2.0, 1.0, 1.2), "poster 2": (2.0, -1.0, 1.2)}))
        assert off_axis_deg((await commanded(b, 0.5, Pose2()))[-1], [2.0, -1.0, 1.2]) < 0.1


@in_virtual_time
async def test_the_loudest_voice_is_looked_at_and_a_louder_noise_is_not() -> None:
    async with head_bench("track_sound:TrackSound", {"sources": SoundSources}) as b:
        desire(b, sound="voice", track=None)
        await commanded(b, 0.2, Pose2())
        voice, noise = source(1, 0.8, -40), source(2, -0.8, -20, speech=0.1)
        unjudged, over = source(3, 1.5, -10, speech=math.nan), source(4, -1.5, -10, active=False)
        b.feed("sources", sounds(b.clock.now(), voice, noise, unjudged, over))
        at = [2 * math.cos(0.8), 2 * math.sin(0.8), 1.0]
        assert off_axis_deg((await commanded(b, 0.5, Pose2()))[-1], at) < 0.1
        desire(b, sound="any", track=None)
        await commanded(b, 0.2, Pose2())
        b.feed("sources", sounds(b.clock.now(), voice, noise))
        at = [2 * math.cos(0.8), -2 * math.sin(0.8), 1.0]
        assert off_axis_deg((await commanded(b, 0.5, Pose2()))[-1], at) < 0.1
