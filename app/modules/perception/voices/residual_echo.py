"""Residual echo: is what the canceller leaves only the rest of the robot's own voice, or another sound, too?

The canceller does not reach late reverberation, and while the robot drives the room's reflections change faster than it
learns: of the echo's power a thirtieth is left, at rest a thousandth. So the level alone does not say who speaks. But
the rest has its power where the echo has, and fades as reverberation does; another voice has it at other moments and
frequencies. Cf. Enzner, Martin and Vary (2002) on the power spectrum of the residual echo. Pure; knows no clock and no
channel.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from app.modules.perception.voices.spectral_mask import SpectralMask

Sound = NDArray[np.float32]

#: Compared frequencies (Hz): most of a voice's power, and of what loudspeakers play.
_LOWEST_HZ, _HIGHEST_HZ = 200.0, 4000.0
#: So many microphones are enough.
_MICROPHONES = 4
#: The echo falls by so many dB a second: as in a large room.
_FALL_DB_S = 62.0
#: A frequency is another sound's while more than this (dB), of the echo, is left of it.
_ANOTHER_DB = -4.0


class ResidualEcho:
    """Judges what the canceller leaves, block by block of ``block`` samples at ``rate`` (Hz, from 8,000 up)."""

    def __init__(self, block: int, rate: int) -> None:
        spacing_hz = rate / (2 * block)
        self._used = slice(round(_LOWEST_HZ / spacing_hz), round(_HIGHEST_HZ / spacing_hz))
        self._window = np.hanning(2 * block + 1)[:-1].astype(np.float32)
        self._fall = np.float32(10 ** (-_FALL_DB_S * block / rate / 10))
        bins = self._used.stop - self._used.start
        self._background = SpectralMask(bins, block / rate, tail=0.0, tail_s=block / rate, floor=0.0)
        self._expected = np.zeros(bins, np.float32)
        self._before = np.zeros((0, block), np.float32)

    def forget_past(self) -> None:
        """The next block does not follow the last."""
        self._expected[:] = 0
        self._before = self._before[:0]
        self._background.reset()

    def others(self, echo: Sound, left: Sound) -> float:
        """Share (0 to 1) of the frequencies that are another sound's in ``left`` (M, block), which the canceller left
        when it removed ``echo`` (M, block); both follow the block before."""
        chosen = slice(None, None, max(1, len(left) // _MICROPHONES))
        both = np.concatenate([echo[chosen], left[chosen]])
        before = self._before if self._before.shape == both.shape else np.zeros_like(both)
        spectra = fft.rfft(np.concatenate([before, both], axis=1) * self._window, axis=-1)[:, self._used]
        self._before = both
        echo_power, power = _smoothed((spectra.real**2 + spectra.imag**2).reshape(2, -1, spectra.shape[1]).mean(axis=1))
        self._expected = np.maximum(echo_power, self._fall * self._expected)
        self._background.weigh(power)
        others = power > np.float32(10 ** (_ANOTHER_DB / 10)) * self._expected
        return float((others & (self._background.background < 1)).mean())


def _smoothed(powers: Sound) -> Sound:
    """Each of ``powers`` (..., B) with its neighbours' mean."""
    smooth = powers.copy()
    smooth[..., 1:-1] = (powers[..., :-2] + powers[..., 1:-1] + powers[..., 2:]) / 3
    return smooth
