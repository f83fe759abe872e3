"""The microphones of a running robot: frames without a gap, and a clap from where the stage says it was."""

from __future__ import annotations

import asyncio
import math
import os
import signal
import time
from pathlib import Path

import numpy as np
import psutil
import pytest
import soundfile
from numpy.typing import NDArray

from app.link import LinkFailed
from app.messages import Audio, GroundTruth, LinkStatus, SceneTruth
from app.robots.config import RobotConfig
from app.robots.simulated.acoustics.diffraction import SPEED_OF_SOUND_MPS
from app.robots.simulated.link import SimulatedLink
from app.robots.simulated.scenery.scenario_config import ScenarioConfig
from app.robots.simulated.world_config import WorldConfig
from tests.patience import PATIENCE_S

OFFSET = time.time() - time.monotonic()

pytestmark = pytest.mark.slow

CLAPPING = ScenarioConfig.model_validate(
    {
        "name": "claps",
        "sounds": [
            {"name": "clap", "kind": "clap", "clip": "clap", "at": [12.5, 11.5, 1.3], "begin_s": 0.5, "every_s": 0.7}
        ],
    }
)


def deaf_but_for_sound(robot: RobotConfig) -> RobotConfig:
    """No cameras, no laser, in the hall's middle."""
    start = robot.start.model_copy(update={"x": 10.0, "y": 10.0, "heading_deg": 20.0})
    streams = robot.streams.model_copy(update={"kinect": None, "panorama": None, "hokuyo": None})
    return robot.model_copy(update={"streams": streams, "start": start, "scenario": None})


def delays(samples: NDArray[np.int16], first: int, second: int, rate: int) -> float:
    """Delay (s) of the second channel after the first by GCC-PHAT."""
    spectra = np.fft.rfft(samples[:, [first, second]].astype(float), 4 * len(samples), axis=0)
    f = np.fft.rfftfreq(4 * len(samples), 1 / rate)
    cross = spectra[:, 1] * np.conj(spectra[:, 0])
    cross = np.where((f > 500) & (f < 9000), cross / np.maximum(np.abs(cross), 1e-12), 0)
    correlation = np.fft.irfft(cross, 8 * 4 * len(samples))
    lag = int(np.argmax(correlation))
    lag -= len(correlation) if lag > len(correlation) // 2 else 0
    return lag / (8 * rate)


async def test_frames_follow_one_another_and_a_clap_comes_from_its_place(robot: RobotConfig, hall: WorldConfig) -> None:
    link = SimulatedLink(deaf_but_for_sound(robot), hall, OFFSET, CLAPPING)
    frames: list[Audio] = []
    scenes: list[SceneTruth] = []
    poses: list[GroundTruth] = []
    statuses: list[LinkStatus] = []
    enough = asyncio.Event()

    def hear(audio: Audio) -> None:
        frames.append(audio)
        if len(frames) == 188:
            enough.set()

    link.attach("microphones", hear)
    link.attach("scene_truth", scenes.append)
    link.attach("ground_truth", poses.append)
    link.attach("status", statuses.append)
    await link.start()
    try:
        for stream in ("microphones", "scene_truth", "ground_truth"):
            link.demand(stream, math.inf)
        async with asyncio.timeout(PATIENCE_S):
            await enough.wait()
        children = psutil.Process(link.process_id).children()
        assert len(children) == 1
    finally:
        await link.stop()
    assert not children[0].is_running()
    assert link.description.loudspeaker

    assert frames[0].samples.shape == (512, 8)
    assert frames[0].samples.dtype == np.int16
    assert frames[0].p_BM.shape == (8, 3)
    assert not frames[0].samples.flags.writeable
    firsts = np.array([frame.first_sample for frame in frames])
    whole = np.flatnonzero(np.diff(firsts) != 512)
    assert whole.size <= 2  # a busy computer may lose frames, and says so
    stamps = np.array([frame.stamp for frame in frames])
    assert np.all(np.diff(stamps) > 0)
    assert abs(stamps[-1] - statuses[-1].stamp) < 0.5

    # A clap whose beginning and end arrived without a gap
    began = next(
        s.began for scene in scenes for s in scene.sounds if stamps[2] < s.began < stamps[-30] and s.kind == "clap"
    )
    sound = next(s for scene in scenes for s in scene.sounds if s.began == began)
    start = int(np.searchsorted(stamps, began)) - 1
    heard = np.concatenate([frame.samples for frame in frames[start : start + 4]])
    X_WB = min(poses, key=lambda pose: abs(pose.stamp - began)).X_WB
    p_WM = X_WB.to_pose3().transform(frames[0].p_BM)
    ways = np.linalg.norm(p_WM - np.array(sound.p_WS), axis=1)
    arrival = stamps[start] + np.argmax(np.abs(heard[:, 0]) > 0.3 * np.abs(heard[:, 0]).max()) / 48000
    assert arrival == pytest.approx(began + ways[0] / SPEED_OF_SOUND_MPS, abs=0.003)
    onset = int((began + ways.min() / SPEED_OF_SOUND_MPS - stamps[start]) * 48000)
    piece = heard[max(0, onset - 64) : onset + 320]
    near = np.argsort(ways)[:3]  # those in the light hear it straight
    for other in near[1:]:
        expected = (ways[other] - ways[near[0]]) / SPEED_OF_SOUND_MPS
        assert delays(piece, int(near[0]), int(other), 48000) == pytest.approx(expected, abs=1.0 / 48000)


@pytest.mark.skipif(not hasattr(os, "pidfd_open"), reason="needs Linux")
async def test_the_microphones_process_ends_with_the_link_s_however_that_ends(
    robot: RobotConfig, hall: WorldConfig
) -> None:
    link = SimulatedLink(deaf_but_for_sound(robot), hall, OFFSET)
    heard, ended = asyncio.Event(), asyncio.Event()
    link.attach("microphones", lambda _: heard.set())
    await link.start()
    try:
        link.demand("microphones", math.inf)
        async with asyncio.timeout(PATIENCE_S):
            await heard.wait()
            assert link.process_id is not None
            (child,) = psutil.Process(link.process_id).children()
            descriptor = os.pidfd_open(child.pid)
            asyncio.get_running_loop().add_reader(descriptor, ended.set)
            os.kill(link.process_id, signal.SIGKILL)
            await ended.wait()
    finally:
        asyncio.get_running_loop().remove_reader(descriptor)
        os.close(descriptor)
        await link.stop()


async def test_a_sound_that_would_be_cut_off_is_refused(
    robot: RobotConfig, hall: WorldConfig, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    file = tmp_path / "long.wav"
    soundfile.write(file, np.zeros(130 * 8000, np.int16), 8000)
    sound = {"name": "radio", "kind": "music", "clip": str(file), "at": [12.5, 11.5, 1.3]}
    scenario = ScenarioConfig.model_validate({"name": "radio", "sounds": [sound]})
    with pytest.raises(LinkFailed, match=r"long.wav' lasts 130 s; 120 s are the most without a loop"):
        await SimulatedLink(deaf_but_for_sound(robot), hall, OFFSET, scenario).start()
    assert not caplog.records
