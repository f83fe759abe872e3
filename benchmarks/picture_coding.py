"""What a picture for one page costs to make and takes on the link, as VP9 and as a smaller JPEG (the peer).

The pictures are those of the lab's camera, 15 a second, which come as JPEG while the robot drives a curve. ``CPU`` is
that of the thread that encodes them again, decoding included; ``decoding`` that of OpenCV for the JPEG made and of
FFmpeg's VP9 decoder (a browser's is libvpx). ``PSNR`` is of what is shown against the picture as it came.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Sequence

from app.robots.simulated.gl import gl_environment

os.environ.update(gl_environment())  # read when MuJoCo is imported

import av
import cv2
import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose3
from app.base.paths import config_dir
from app.console.live.picture_budget import RUNGS, VIDEO_RUNGS, Form
from app.console.live.picture_coder import recoded
from app.console.live.video_encoder import VideoEncoder
from app.messages import EncodedImage, Image
from app.robots.config import load_robot_config
from app.robots.factory import simulated_parts
from app.robots.simulated import link_protocol
from app.robots.simulated.lockstep_world import LockstepWorld
from benchmarks.report import Row, benchmark_main, row

TURN_S = 0.004
START_S = 1.0
RATE_HZ = 15
#: The width of the pictures (px), and the rung of the budget by which both are made.
CASES = ((640, 1), (480, 3), (320, 5))


def camera_pictures(seconds: float) -> list[EncodedImage]:
    """What the camera gives to people while the robot drives a curve through the lab."""
    robot, lab, scenario = simulated_parts(load_robot_config(config_dir() / "robots" / "irl1_tr.yaml"))
    pictures: list[EncodedImage] = []

    def take(stream: str, message: object) -> None:
        if isinstance(message, Image):
            bgr = np.ascontiguousarray(message.color[..., ::-1])
            jpeg = cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, 80])[1].tobytes()
            height, width = bgr.shape[:2]
            pictures.append(EncodedImage(message.stamp, message.frame, jpeg, width, height, Pose3.identity()))

    world = LockstepWorld(robot, lab, scenario, take)
    world.accept(link_protocol.Demand("kinect", RATE_HZ))
    for turn in range(round(seconds / TURN_S)):
        now = START_S + turn * TURN_S
        if turn % 10 == 0:
            world.accept(link_protocol.DriveRequest(now, 0.2, 0.3))
        world.lockstep(now, START_S)
    world.close()
    return pictures


def psnr(shown: NDArray[np.uint8], picture: EncodedImage) -> float:
    """Of ``shown`` (H, W, 3) BGR against ``picture`` at that size, in dB."""
    source = cv2.imdecode(np.frombuffer(picture.jpeg, np.uint8), cv2.IMREAD_COLOR)
    assert source is not None
    height, width = shown.shape[:2]
    if width != picture.width:
        source = cv2.resize(source, (width, height), interpolation=cv2.INTER_AREA)
    return float(10 * np.log10(255**2 / max(1e-9, ((shown.astype(float) - source) ** 2).mean())))


def as_jpeg(pictures: Sequence[EncodedImage], form: Form) -> tuple[float, float, float, float]:
    """CPU (ms), bytes, decoding's CPU (ms) and PSNR (dB), of a picture in the mean."""
    began = time.thread_time()
    made = [recoded(picture, form) for picture in pictures]
    coded = time.thread_time()
    shown = [cv2.imdecode(np.frombuffer(each.jpeg, np.uint8), cv2.IMREAD_COLOR) for each in made]
    decoded = time.thread_time()
    quality = [psnr(np.asarray(s, np.uint8), p) for s, p in zip(shown, pictures, strict=True) if s is not None]
    count = len(pictures)
    size = sum(len(each.jpeg) for each in made) / count
    return 1e3 * (coded - began) / count, size, 1e3 * (decoded - coded) / count, float(np.mean(quality))


def as_vp9(pictures: Sequence[EncodedImage], form: Form) -> tuple[float, float, float, float]:
    """The same of VP9."""
    encoder, decoder = VideoEncoder(), av.VideoCodecContext.create("vp9", "r")
    decoder.thread_count = 1
    began = time.thread_time()
    made = [encoder.encode(picture.jpeg, form) for picture in pictures]
    coded = time.thread_time()
    packets = [each.data for each in made if each is not None]
    frames = [frame for packet in packets for frame in decoder.decode(av.Packet(packet))]
    decoded = time.thread_time()
    quality = [
        psnr(np.asarray(f.to_ndarray(format="bgr24"), np.uint8), p) for f, p in zip(frames, pictures, strict=True)
    ]
    count = len(pictures)
    return (
        1e3 * (coded - began) / count,
        sum(map(len, packets)) / count,
        1e3 * (decoded - coded) / count,
        float(np.mean(quality)),
    )


def measure(quick: bool) -> list[Row]:
    """Each size, both ways, in rounds one after the other."""
    cv2.setNumThreads(1)
    rounds, seconds = (2, 6.0) if quick else (5, 20.0)
    pictures = camera_pictures(seconds)
    rows = [row("picture_coding", "as it comes", "bytes", "kB", [1e-3 * len(each.jpeg) for each in pictures])]
    for width, rung in CASES:
        jpeg = Form(width, RUNGS[rung][1])
        vp9 = Form(width, bits=VIDEO_RUNGS[rung - 1][1])
        ours, peers = [], []
        for _ in range(rounds):
            ours.append(as_vp9(pictures, vp9))
            peers.append(as_jpeg(pictures, jpeg))
        figures = (("CPU", "ms", 1.0), ("bytes", "kB", 1e-3), ("decoding", "ms", 1.0), ("PSNR", "dB", 1.0))
        for at, (name, unit, scale) in enumerate(figures):
            mine, other = ([scale * each[at] for each in side] for side in (ours, peers))
            rows.append(row("picture_coding", f"{width} px", name, unit, mine, other, f"JPEG, quality {jpeg.quality}"))
    return rows


if __name__ == "__main__":
    sys.exit(benchmark_main(__doc__, measure))
