"""Data of devices as messages of the body's streams."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Generic, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import CameraModel, Pose3
from app.messages import Audio, Image, read_only
from app.robots.devices.config import CameraConfig, SoundInputConfig
from app.robots.devices.image_inputs import ImageInput, InputUnavailable, Picture, PlaybackTimer, open_pictures
from app.robots.devices.sound import Samples, SoundInput, open_sound

InputT = TypeVar("InputT", ImageInput, SoundInput)


class _Frames(Generic[InputT]):
    """An input that is opened, with its items as messages of a stream."""

    def __init__(self) -> None:
        self._input: InputT | None = None
        self._pace = PlaybackTimer(1.0)
        self.live = False

    def _opened(self, source: InputT, rate_hz: float) -> Self:
        self._input, self.live, self._pace = source, source.live, PlaybackTimer(rate_hz)
        return self

    def skip(self) -> None:
        if self._input is not None:
            self._input.skip()

    def close(self) -> None:
        if self._input is not None:
            self._input.close()

    def pause_s(self) -> float:
        return self._pace.wait_s(time.monotonic())


class ImageFrames(_Frames[ImageInput]):
    """Images of an image input, as Image messages."""

    def __init__(self, config: CameraConfig, X_BC: Pose3, now: Callable[[], float]) -> None:
        super().__init__()
        self._config = config
        self._X_BC = X_BC
        self._now = now

    def open(self) -> ImageFrames:
        pictures = open_pictures(self._config)
        return self._opened(pictures, pictures.rate_hz)

    def read(self) -> Image | None:
        assert self._input is not None
        picture = self._input.read()
        return None if picture is None else self._image(picture)

    def _image(self, picture: Picture) -> Image:
        height, width = picture.shape[:2]
        # Square pixels: the vertical field of view follows.
        f = 0.5 * width / math.tan(0.5 * math.radians(self._config.horizontal_fov_deg))
        camera = CameraModel(width, height, fx=f, fy=f, cx=0.5 * (width - 1), cy=0.5 * (height - 1))
        return Image(
            self._now(), self._config.link, color=read_only(picture), depth=None, camera=camera, X_BC=self._X_BC
        )


class AudioFrames(_Frames[SoundInput]):
    """Sound of a sound input, as Audio messages."""

    def __init__(self, config: SoundInputConfig, X_BL: Pose3, now: Callable[[], float]) -> None:
        super().__init__()
        self._config = config
        self._X_BL = X_BL
        self._now = now
        self._first = 0
        self._ended: float | None = None
        self._skipped = False
        self._p_BM: NDArray[np.float64] = np.zeros((0, 3))

    def open(self) -> AudioFrames:
        sound = open_sound(self._config)
        positions = self._config.positions
        if positions is not None and len(positions) != sound.channels:
            sound.close()
            raise InputUnavailable(
                f"{self._config.source} has {sound.channels} channels, but {len(positions)} positions of microphones "
                "are configured: one for each channel, or none"
            )
        places = np.array(positions if positions is not None else [(0.0, 0.0, 0.0)] * sound.channels, np.float64)
        self._p_BM = read_only(np.asarray(self._X_BL.transform(places), np.float64))
        return self._opened(sound, sound.rate / self._config.frame_samples)

    def read(self) -> Audio | None:
        assert self._input is not None
        count = self._config.frame_samples
        samples = self._input.read(count)
        return None if samples is None else self._frame(samples)

    def skip(self) -> None:
        super().skip()
        self._skipped = True

    def _frame(self, samples: Samples) -> Audio:
        assert self._input is not None
        rate, end = self._input.rate, self._now()
        lasts_s = len(samples) / rate
        # Samples not read for lack of demand, or read too late, are missing: the sample numbers show it.
        if self._ended is not None:
            missing = round((end - self._ended - lasts_s) * rate)
            if self._skipped or self._input.gap:
                self._first += max(1, missing)
            elif missing > rate:
                self._first += missing
        self._ended, self._skipped = end, False
        frame = Audio(
            end - lasts_s,
            self._config.link,
            samples=read_only(samples),
            rate=rate,
            first_sample=self._first,
            p_BM=self._p_BM,
        )
        self._first += len(samples)
        return frame
