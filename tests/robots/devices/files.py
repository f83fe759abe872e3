"""Pictures, videos and sounds on disk, standing for devices."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import soundfile
from numpy.typing import NDArray

from app.base.kinematic_model import load_model
from app.robots.devices.config import CameraConfig, DevicesConfig, SoundInputConfig
from app.robots.devices.link import DevicesLink

MODEL = Path(__file__).parents[3] / "config" / "robots" / "desk.urdf"
DESK = load_model(MODEL)
RATE = 16000


def grey(level: int) -> NDArray[np.uint8]:
    return np.full((48, 64, 3), level, np.uint8)


def picture_file(folder: Path, name: str, level: int) -> Path:
    cv2.imwrite(str(folder / name), grey(level))
    return folder / name


def video_file(folder: Path, levels: list[int], fps: float = 50.0) -> Path:
    path = folder / "film.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), fps, (64, 48))
    for level in levels:
        writer.write(grey(level))
    writer.release()
    return path


def ramp(length: int, channels: int = 2) -> NDArray[np.int16]:
    """Samples that contain their own number, in every channel but for its sign."""
    up = np.arange(length, dtype=np.int16)
    return np.stack([up if channel % 2 == 0 else -up for channel in range(channels)], axis=1)


def sound_file(folder: Path, samples: NDArray[np.int16], name: str = "sound.wav") -> Path:
    soundfile.write(str(folder / name), samples, RATE, subtype="PCM_16")
    return folder / name


def link(camera: CameraConfig | None = None, microphones: SoundInputConfig | None = None) -> DevicesLink:
    config = DevicesConfig(kind="devices", name="A desk", model=MODEL, camera=camera, microphones=microphones)
    return DevicesLink(config, DESK, 0.0)
