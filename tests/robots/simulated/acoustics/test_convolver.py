"""Partitioned convolution is convolution; a change of kernel is a cross-fade."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from app.robots.simulated.acoustics.convolver import Partitions, Tail, finish, transform


def run(
    partitions: Partitions, sound: NDArray[np.float32], change: tuple[int, NDArray[np.complex64]] | None = None
) -> NDArray[np.float32]:
    block = partitions.block
    out = []
    for number in range(sound.size // block):
        if change is not None and number == change[0]:
            partitions.set_kernel(change[1])
        partitions.feed(sound[number * block : (number + 1) * block])
        before = np.zeros((2, block + 1), dtype=np.complex64)
        after = np.zeros_like(before)
        out.append(finish(before, after, partitions.add_to(before, after)))
    return np.concatenate(out, axis=1)


@settings(max_examples=20, deadline=None)
@given(st.integers(1, 200), st.integers(0, 2**32 - 1))
def test_partitions_convolve(length: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    kernel = rng.standard_normal((2, length)).astype(np.float32)
    sound = rng.standard_normal(640).astype(np.float32)
    partitions = Partitions(2, 64, -(-length // 64))
    partitions.set_kernel(transform(kernel, 64, partitions.count))
    expected = np.stack([np.convolve(sound, row)[: sound.size] for row in kernel])
    np.testing.assert_allclose(run(partitions, sound), expected, atol=2e-4 * length**0.5)


def test_a_change_of_kernel_goes_from_one_to_the_other_over_one_block() -> None:
    one, other = np.zeros((2, 64), dtype=np.float32), np.zeros((2, 64), dtype=np.float32)
    one[:, 0], other[:, 0] = 1.0, 3.0
    partitions = Partitions(2, 64, 1)
    partitions.set_kernel(transform(one, 64, 1))
    heard = run(partitions, np.ones(256, dtype=np.float32), (2, transform(other, 64, 1)))
    np.testing.assert_allclose(heard[:, :128], 1.0, atol=1e-6)
    np.testing.assert_allclose(heard[:, 192:], 3.0, atol=1e-6)
    assert np.all(np.diff(heard[:, 127:193]) > 0)


@pytest.mark.parametrize("step", [1, 2, 4])
def test_a_tail_comes_exactly_its_delay_later(step: int) -> None:
    rng = np.random.default_rng(3)
    kernel = rng.standard_normal((2, 200)).astype(np.float32)
    sound = rng.standard_normal(32 * 30).astype(np.float32)
    tail = Tail(2, 32, step, -(-200 // (32 * step)))
    tail.set_kernel(tail.kernel(kernel))
    heard = np.concatenate([tail.process(sound[i : i + 32]).copy() for i in range(0, sound.size, 32)], axis=1)
    expected = np.stack([np.convolve(sound, row)[: sound.size] for row in kernel])
    np.testing.assert_allclose(heard[:, tail.delay :], expected[:, : -tail.delay], atol=1e-3)
    assert not heard[:, : tail.delay].any()


def test_it_knows_when_nothing_is_left_to_come() -> None:
    partitions = Partitions(2, 32, 3)
    assert partitions.silent
    partitions.feed(np.ones(32, dtype=np.float32))
    for _ in range(3):
        partitions.feed(np.zeros(32, dtype=np.float32))
        assert not partitions.silent
    partitions.feed(np.zeros(32, dtype=np.float32))
    assert partitions.silent
