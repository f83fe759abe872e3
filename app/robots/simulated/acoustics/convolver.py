"""Block convolution with changing impulse responses: partitioned, by FFT, with cross-fades.

Uniform partitions with overlap-save (G. Garcia, "Optimal filter partition for efficient convolution with short
input/output delay", AES 113th Convention, 2002); one inverse FFT serves all sums before it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Samples = NDArray[np.float32]
Spectra = NDArray[np.complex64]


class Partitions:
    """One mono input through M responses of up to ``count`` blocks of ``block`` samples; the caller sums them."""

    def __init__(self, outputs: int, block: int, count: int) -> None:
        self.block, self.count = block, count
        self._history: Spectra = np.zeros((count, block + 1), dtype=np.complex64)
        self._last: Samples = np.zeros(block, dtype=np.float32)
        self._kernel: Spectra = np.zeros((outputs, count, block + 1), dtype=np.complex64)
        self._products = np.empty_like(self._kernel)
        self._next: Spectra | None = None
        self._silent_blocks = count + 1

    def set_kernel(self, kernel: Spectra) -> None:
        """Cross-fade to ``kernel`` (of :func:`transform`) during the next block; at once before the first sound."""
        if not self.silent:
            self._next = kernel
        else:
            self._kernel = kernel

    @property
    def silent(self) -> bool:
        """Whether no output is left."""
        return self._silent_blocks > self.count

    def feed(self, samples: Samples) -> None:
        """Take the next ``block`` samples."""
        self._silent_blocks = 0 if samples.any() else self._silent_blocks + 1
        self._history[1:] = self._history[:-1]
        self._history[0] = np.fft.rfft(np.concatenate([self._last, samples]))
        self._last = samples

    def add_to(self, before: Spectra, after: Spectra) -> bool:
        """Add this block's spectra to ``before`` and ``after`` (M, block + 1) a change of kernel; True at a change."""
        product = self._convolve()
        before += product
        if self._next is None:
            after += product
            return False
        self._kernel, self._next = self._next, None
        after += self._convolve()
        return True

    def _convolve(self) -> Spectra:
        # Three times as fast as einsum
        np.multiply(self._history, self._kernel, out=self._products)
        convolved: Spectra = self._products.sum(axis=1)
        return convolved


def transform(impulses: Samples, block: int, count: int) -> Spectra:
    """The spectra (M, count, block + 1) of responses (M, up to count * block)."""
    padded = np.zeros((impulses.shape[0], count, 2 * block), dtype=np.float32)
    whole = np.zeros((impulses.shape[0], count * block), dtype=np.float32)
    whole[:, : impulses.shape[1]] = impulses[:, : count * block]
    padded[:, :, :block] = whole.reshape(impulses.shape[0], count, block)
    spectra: Spectra = np.fft.rfft(padded, axis=-1).astype(np.complex64, copy=False)
    return spectra


def finish(before: Spectra, after: Spectra, faded: bool) -> Samples:
    """The block (M, block) of the summed spectra, cross-faded from ``before`` to ``after`` where ``faded``."""
    block = before.shape[1] - 1
    end: Samples = np.fft.irfft(after, axis=-1)[:, block:].astype(np.float32, copy=False)
    if not faded:
        return end
    begin = np.fft.irfft(before, axis=-1)[:, block:]
    share = ((np.arange(block, dtype=np.float32) + 0.5) / block).astype(np.float32)
    mixed: Samples = begin + (end - begin) * share
    return mixed


class Tail:
    """A long response computed in larger blocks of ``step`` frames, started early enough to be on time.

    Its kernel begins ``step * frame`` samples after the input. Feed one frame, take one frame.
    """

    def __init__(self, outputs: int, frame: int, step: int, count: int) -> None:
        self._frame, self._step = frame, step
        self._partitions = Partitions(outputs, frame * step, count)
        self._waiting: list[Samples] = []
        self._ready = np.zeros((outputs, frame * step), dtype=np.float32)

    @property
    def delay(self) -> int:
        """Samples between the input and the kernel's beginning."""
        return self._frame * self._step

    @property
    def count(self) -> int:
        """Blocks of ``delay`` samples that the kernel has."""
        return self._partitions.count

    def kernel(self, impulses: Samples) -> Spectra:
        """The response ``impulses`` (M, up to count * delay) in the form of :meth:`set_kernel`."""
        return transform(impulses, self._partitions.block, self._partitions.count)

    def set_kernel(self, kernel: Spectra) -> None:
        """Change to ``kernel`` with the next large block."""
        self._partitions.set_kernel(kernel)

    def process(self, samples: Samples) -> Samples:
        """The next frame (M, frame) of output for the next frame (frame,) of input."""
        at = len(self._waiting) * self._frame
        out = self._ready[:, at : at + self._frame]
        self._waiting.append(samples)
        if len(self._waiting) == self._step:
            self._partitions.feed(np.concatenate(self._waiting))
            self._waiting = []
            before = np.zeros((self._ready.shape[0], self._partitions.block + 1), dtype=np.complex64)
            after = np.zeros_like(before)
            faded = self._partitions.add_to(before, after)
            self._ready = finish(before, after, faded)
        return out
