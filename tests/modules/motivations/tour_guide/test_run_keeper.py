"""What of a run is written, and how often: writing a tour out takes 20 ms of the event loop."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from pathlib import Path

import pytest

from app.modules.motivations.tour_guide import guided_run
from app.modules.motivations.tour_guide.guided_run import GuidedRun
from app.modules.motivations.tour_guide.kept import read_kept
from app.modules.motivations.tour_guide.progress import Pressed
from app.modules.motivations.tour_guide.run_keeper import KEEP_S, RunKeeper
from app.runtime.clock import in_virtual_time
from app.tours.model import Tour
from app.tours.run_library import RunLibrary
from app.tours.tour_file import digest
from tests.modules.motivations.tour_guide.run import LAB, Run


@in_virtual_time
async def test_a_run_is_written_as_it_changes_and_its_tour_is_digested_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    digested: list[Tour] = []

    def counted(tour: Tour) -> str:
        digested.append(tour)
        return digest(tour)

    monkeypatch.setattr(guided_run, "digest", counted)
    library, writes = RunLibrary(tmp_path), 0

    async def behind(function: Callable[..., None], *args: object) -> None:
        nonlocal writes
        writes += 1
        await asyncio.to_thread(function, *args)

    keeper, tried = RunKeeper(library, behind, logging.getLogger()), Run()
    run = GuidedRun(LAB, tried.scene, waits=False)
    await keeper.save(100.0, run)
    assert writes == 0, "no tour is under way"
    run.see(tried.see(Pressed("start")).view)
    for beat in range(100):
        await keeper.save(100.0 + 0.2 * beat, run)
    assert writes == 1
    await keeper.save(100.0 + KEEP_S, run)
    assert writes == 2, "so that a restart knows how long the program was away"
    assert len(digested) == 1
    data = await asyncio.to_thread(library.kept)
    assert data is not None
    found = read_kept(data)
    assert (found.digest, found.progress.state) == (digest(run.scene.tour), "inviting")
