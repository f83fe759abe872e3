"""A week of tours, one a day: the robot comes to expect the question that visitors usually ask."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass
from pathlib import Path

import pytest

from app.messages import MemoryState
from app.runtime.clock import in_virtual_time
from app.tours.model import Tour
from tests.modules.motivations.episodic_memory.week import RememberingLab
from tests.modules.motivations.tour_guide.lab_tour import PLACES
from tests.modules.motivations.tour_guide.led_lab import Visitor
from tests.modules.motivations.tour_guide.run import LAB, WAIT, say, stop

QUESTION = "word heavy"
DAY_S = 86_400.0
#: On these days, from 1, visitors ask nothing.
SILENT = (4,)


@dataclass(frozen=True, slots=True)
class Day:
    """One tour: when (s after the arrival at the second stop) the question was expected first, when words were listened
    for first, by memory's desire and by the guide's, and when it was asked; None: not at all."""

    recognized: float | None
    expected: float | None
    memory_listens: float | None
    guide_listens: float | None
    asked: float | None
    episodes: int

    def row(self, number: int) -> str:
        """A line of the table."""
        values = (self.recognized, self.expected, self.memory_listens, self.guide_listens, self.asked)
        cells = ["–" if value is None else f"{value:.1f}" for value in values]
        return f"| {number} | " + " | ".join(cells) + f" | {self.episodes} |"


def expects(state: MemoryState) -> bool:
    """Whether the question is among what is anticipated."""
    return any(item.item == QUESTION for each in state.anticipated for item in each.event.items)


async def day(folder: Path, tour: Tour, *, asks: bool) -> Day:
    """The robot is started in the morning, leads a tour, and is switched off."""
    lab = await asyncio.to_thread(RememberingLab, folder, tour, PLACES)
    async with lab:
        lab.visitors = [Visitor(1.5, 0.5), Visitor(1.5, -0.5)]
        lab.start()
        await lab.until("confirming")
        lab.hear("yes")
        await lab.until("presenting")
        assert lab.progress.stop == "one"
        await lab.until("leading")
        await lab.until("turning", "presenting")
        assert lab.progress.stop == "two"
        arrived, asked, began = lab.bench.clock.now(), None, len(lab.remembered)
        listens: dict[bool, float] = {}

        def look() -> None:
            for desire in lab.workspace.desires():
                if desire.cls == "ListenForWords" and desire.params["words"].startswith("next"):
                    listens.setdefault(desire.source.name != "Tested", lab.bench.clock.now() - arrived)

        await lab.until("listening", each=look)
        await lab.live(1.0)
        look()
        await lab.live(2.0)
        if asks:
            asked = lab.bench.clock.now() - arrived
            lab.hear("heavy")
            await lab.until("answering")
            await lab.until("listening")
        lab.hear("next")
        await lab.until("idle")
        lab.visitors = []
        await lab.live(60.0)
        states = lab.remembered[began:]
        after = [state for state in states if asked is None or state.stamp - arrived < asked]
        recognized = [s.stamp - arrived for s in after if s.recognized is not None]
        expected = [s.stamp - arrived for s in after if expects(s)]
        return Day(
            max(recognized[0], 0.0) if recognized else None,
            max(expected[0], 0.0) if expected else None,
            listens.get(True),
            listens.get(False),
            asked,
            lab.remembered[-1].episode_count,
        )


@pytest.mark.slow
@in_virtual_time
async def test_in_a_week_of_tours_the_usual_question_comes_to_be_expected(tmp_path: Path) -> None:
    question = LAB.stops[1].questions[0].model_dump()
    second = stop("two", do=[say("This is two. It is an arm. It is orange."), WAIT], questions=[question])
    tour = LAB.model_validate(LAB.model_dump(by_alias=True) | {"stops": [stop("one"), second]})
    days = []
    for number in range(1, 8):
        days.append(await day(tmp_path, tour, asks=number not in SILENT))
        await asyncio.sleep(DAY_S)
    print("\n| day | recognized | expected | memory listens | guide listens | asked | episodes |")
    for number, each in enumerate(days, 1):
        print(each.row(number))
    first, *others = days
    assert (first.recognized, first.expected, first.memory_listens) == (None, None, None)
    assert first.guide_listens is not None
    assert first.asked is not None
    for each in others:
        assert each.expected is not None
        assert each.memory_listens is not None
        assert each.guide_listens is not None
        assert each.expected < each.guide_listens
        assert each.memory_listens < each.guide_listens - 3.0, "words are listened for before the robot has spoken"
        assert each.asked is None or each.expected < each.asked - 3.0
    assert len({each.episodes for each in days[4:]}) == 1, "usual tours are no new episodes"
