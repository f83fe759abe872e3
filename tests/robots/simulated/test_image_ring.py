"""The image ring: what is read is whole, or said to be gone."""

from __future__ import annotations

import os
from collections.abc import Iterator

import numpy as np
import psutil
import pytest

from app.robots.simulated.image_ring import (
    SLOTS,
    ImageRing,
    ImageRings,
    PictureFormat,
    create_memory,
    memory_bytes,
)
from tests.robots.simulated.shared_memory import shared_memory

WIDTH, HEIGHT = 32, 24
FORMATS = {
    "kinect": PictureFormat(WIDTH, HEIGHT, has_depth=True),
    "panorama": PictureFormat(2 * WIDTH + 1, HEIGHT, has_depth=False),
}


@pytest.fixture
def both() -> Iterator[tuple[ImageRings, ImageRings]]:
    """Two views of one memory, as writer and reader have."""
    memory = create_memory(memory_bytes(FORMATS))
    writer, reader = ImageRings(memory, FORMATS), ImageRings(memory, FORMATS)
    os.close(memory)
    yield writer, reader
    writer.close()
    reader.close()


@pytest.fixture
def rings(both: tuple[ImageRings, ImageRings]) -> tuple[ImageRing, ImageRing]:
    """The ring of the camera with depth, as writer and reader have it."""
    return both[0].rings["kinect"], both[1].rings["kinect"]


def write(ring: ImageRing, number: int) -> tuple[int, int]:
    slot = number % SLOTS
    color, depth = ring.begin(slot)
    color[:] = number
    if depth is not None:
        depth[:] = 1000 + number
    ring.finish(slot, 2 * number)
    return slot, 2 * number


def test_what_was_written_is_read_as_read_only_copies(rings: tuple[ImageRing, ImageRing]) -> None:
    writer, reader = rings
    slot, sequence = write(writer, 7)
    pictures = reader.read(slot, sequence)
    assert pictures is not None
    color, depth = pictures
    assert depth is not None
    assert color.shape == (HEIGHT, WIDTH, 3)
    assert (color == 7).all()
    assert depth.dtype == np.uint16
    assert (depth == 1007).all()
    assert not color.flags.writeable
    assert not depth.flags.writeable
    write(writer, 7 + SLOTS)
    assert (color == 7).all()  # a copy: later pictures do not touch it


def test_an_overwritten_picture_is_said_to_be_gone(rings: tuple[ImageRing, ImageRing]) -> None:
    writer, reader = rings
    slot, sequence = write(writer, 1)
    write(writer, 1 + SLOTS)
    assert reader.read(slot, sequence) is None


def test_a_picture_being_written_is_not_read(rings: tuple[ImageRing, ImageRing]) -> None:
    writer, reader = rings
    slot, sequence = write(writer, 2)
    writer.begin(slot)
    assert reader.read(slot, sequence) is None


def test_slots_do_not_touch_each_other(rings: tuple[ImageRing, ImageRing]) -> None:
    writer, reader = rings
    written = [write(writer, number) for number in range(10, 10 + SLOTS)]
    for number, (slot, sequence) in zip(range(10, 10 + SLOTS), written, strict=True):
        pictures = reader.read(slot, sequence)
        assert pictures is not None
        color, depth = pictures
        assert depth is not None
        assert (color == number).all()
        assert (depth == 1000 + number).all()


def test_each_camera_has_slots_of_its_own(both: tuple[ImageRings, ImageRings]) -> None:
    writer, reader = both
    written = {stream: [write(ring, number) for number in range(SLOTS)] for stream, ring in writer.rings.items()}
    for stream, ring in reader.rings.items():
        for number, (slot, sequence) in enumerate(written[stream]):
            pictures = ring.read(slot, sequence)
            assert pictures is not None
            assert pictures[0].shape == (FORMATS[stream].height, FORMATS[stream].width, 3)
            assert (pictures[0] == number).all()
            assert (pictures[1] is None) == (stream == "panorama")
    assert reader.read("panorama", *written["panorama"][1]) is not None


def test_the_memory_has_no_name_and_goes_with_its_last_user() -> None:
    process = psutil.Process()
    before = shared_memory(process)
    memory = create_memory(memory_bytes(FORMATS))
    rings = ImageRings(memory, FORMATS)
    assert shared_memory(process) == before
    os.close(memory)
    rings.close()
