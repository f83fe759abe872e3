from __future__ import annotations

import asyncio
import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.link import LinkFailed
from app.messages import Audio, Image, LinkStatus
from app.robots.devices.config import CameraConfig, DevicesConfig, SoundInputConfig, SpeakerConfig
from app.robots.devices.link import DevicesLink
from app.robots.devices.reader_thread import InputReader
from tests.patience import PATIENCE_S
from tests.robots.devices.files import DESK, MODEL, link, picture_file, ramp, sound_file, video_file


class Collected:
    """What a stream gives, and a way to wait for so many of it."""

    def __init__(self, body: DevicesLink, stream: str) -> None:
        self.messages: list[Any] = []
        self._came = asyncio.Event()
        body.attach(stream, self._take)

    def _take(self, message: Any) -> None:
        self.messages.append(message)
        self._came.set()

    async def wait(self, count: int) -> list[Any]:
        async with asyncio.timeout(PATIENCE_S):
            while len(self.messages) < count:
                self._came.clear()
                await self._came.wait()
        return self.messages


async def test_a_video_is_seen_from_the_camera_s_place(tmp_path: Path) -> None:
    body = link(CameraConfig(source=str(video_file(tmp_path, [40, 120, 200])), horizontal_fov_deg=90))
    pictures = Collected(body, "camera")
    body.demand("camera", math.inf)
    await body.start()
    got: list[Image] = await pictures.wait(2)
    # A busy computer catches up after a late frame; a reader without the film's pace would never pause.
    while not any(after.stamp - before.stamp > 0.005 for before, after in pairwise(got)):
        got = await pictures.wait(len(got) + 1)
    await body.stop()
    first = got[0]
    assert isinstance(first, Image)
    assert first.depth is None
    assert first.camera.fx == pytest.approx(32.0)
    assert not first.color.flags.writeable
    assert first.X_BC.translation[2] == pytest.approx(0.97)
    assert np.allclose(first.X_BC.rotation @ [0, 0, 1], [1, 0, 0]), "it looks forward"


async def test_sound_is_continuous_and_has_a_place(tmp_path: Path) -> None:
    path = sound_file(tmp_path, ramp(16000))
    body = link(microphones=SoundInputConfig(source=str(path), positions=((0, 0.1, 0), (0, -0.1, 0))))
    frames = Collected(body, "microphones")
    body.demand("microphones", math.inf)
    await body.start()
    got: list[Audio] = await frames.wait(5)
    await body.stop()
    assert [frame.first_sample for frame in got[:5]] == [0, 512, 1024, 1536, 2048]
    assert np.array_equal(np.concatenate([frame.samples[:, 0] for frame in got[:5]]), np.arange(2560))
    assert np.allclose(got[0].p_BM, [[0, 0.1, 0.97], [0, -0.1, 0.97]])


async def test_an_unwanted_stream_is_not_read(tmp_path: Path) -> None:
    body = link(microphones=SoundInputConfig(source=str(sound_file(tmp_path, ramp(16000)))))
    frames = Collected(body, "microphones")
    status = Collected(body, "status")
    await body.start()
    await status.wait(3)
    assert frames.messages == []
    body.demand("microphones", math.inf)
    await frames.wait(2)
    await body.stop()
    assert frames.messages[0].samples[0, 0] == 0, "a file stands still meanwhile"


async def test_it_stands_still_and_says_so(tmp_path: Path) -> None:
    body = link(CameraConfig(source=str(picture_file(tmp_path, "a.png", 100))))
    odometry, status = Collected(body, "odometry"), Collected(body, "status")
    await body.start()
    poses = await odometry.wait(2)
    said: LinkStatus = (await status.wait(1))[0]
    body.e_stop("the button")
    stopped = (await status.wait(len(status.messages) + 1))[-1]
    await body.stop()
    assert poses[0].X_OB == poses[1].X_OB
    assert (said.guard, said.reason, said.e_stopped) == ("idle", "This body has no wheels.", False)
    assert (stopped.guard, stopped.reason, stopped.e_stopped) == ("e_stopped", "the button", True)


async def test_one_sense_is_enough_but_none_is_a_failure(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    picture = CameraConfig(source=str(picture_file(tmp_path, "a.png", 100)))
    missing = SoundInputConfig(source="gone.wav")
    half = link(picture, missing)
    await half.start()
    await half.stop()
    assert "there is no file gone.wav" in caplog.text
    with pytest.raises(LinkFailed, match=r"A desk can neither see nor hear: there is no file .*gone.mp4; there is no"):
        await link(CameraConfig(source="gone.mp4"), missing).start()


async def test_positions_that_do_not_fit_the_file_are_refused(tmp_path: Path) -> None:
    path = sound_file(tmp_path, ramp(100, 2))
    body = link(microphones=SoundInputConfig(source=str(path), positions=((0, 0, 0),)))
    with pytest.raises(LinkFailed, match="has 2 channels, but 1 positions"):
        await body.start()


async def test_a_stream_it_has_not_is_refused_by_name() -> None:
    with pytest.raises(KeyError, match="no stream 'kinect'; it has odometry, joints, status"):
        link().attach("kinect", lambda _: None)


async def test_a_busy_loop_loses_the_newest_instead_of_queueing_without_bound() -> None:
    class Endless:
        live = True

        def __init__(self) -> None:
            self.count = 0

        def read(self) -> int:
            self.count += 1
            if self.count > 50:
                enough.set()
            return self.count

        def skip(self) -> None: ...

        def close(self) -> None: ...

    import threading

    enough = threading.Event()
    taken: list[int] = []
    source = Endless()
    reader = InputReader("endless", lambda: source, taken.append, pause_s=lambda: 0.0, most_waiting=3)
    assert await reader.start() == ""
    reader.want(True)
    assert enough.wait(PATIENCE_S), "blocks the loop on purpose"
    reader.want(False)
    await reader.stop()
    assert taken[:3] == [1, 2, 3]
    assert reader.dropped > 40


@pytest.mark.parametrize("missing", ["", "sound cards need the library PortAudio"])
async def test_a_computer_without_sound_cards_makes_a_mute_body(
    missing: str, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """Or the page would record a voice that is never played."""
    monkeypatch.setattr("app.robots.devices.senses.no_sound_card", lambda: missing)
    config = DevicesConfig(kind="devices", name="A desk", model=MODEL, loudspeaker=SpeakerConfig())
    body = DevicesLink(config, DESK, 0.0)
    assert body.description.loudspeaker == (not missing)
    # A command that only looks at the body, as `hbba check` does, does not ask about this computer.
    assert caplog.messages == []
    monkeypatch.setattr("app.robots.devices.senses.Player.start", lambda _: None)
    await body.start()
    await body.stop()
    assert caplog.messages == ([f"A desk is mute: {missing}"] if missing else [])
