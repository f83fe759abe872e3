"""A slot for the provider of a service: none, one, and one that is replaced."""

from __future__ import annotations

import pytest

from app.base.service_slot import ServiceSlot


def test_a_slot_without_a_provider_says_so() -> None:
    slot: ServiceSlot[str] = ServiceSlot(lambda: LookupError("nothing provides it"))
    assert not slot.available
    with pytest.raises(LookupError, match="nothing provides it"):
        _ = slot.provider


def test_a_provider_is_there_until_it_detaches() -> None:
    slot: ServiceSlot[str] = ServiceSlot(LookupError)
    detach = slot.attach("one")
    assert slot.available
    assert slot.provider == "one"
    detach()
    detach()
    assert not slot.available


def test_a_provider_that_was_replaced_detaches_without_effect() -> None:
    slot: ServiceSlot[list[int]] = ServiceSlot(LookupError)
    former, newer = [1], [1]
    detach = slot.attach(former)
    slot.attach(newer)
    detach()
    assert slot.provider is newer
