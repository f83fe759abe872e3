"""A listener that is too slow: it hears what sounds now, not what sounded a second ago, and says so once."""

from __future__ import annotations

import numpy as np
import pytest

from app.messages import Audio
from app.modules.perception.overruns import QUIET_S
from app.runtime.clock import run_virtual
from tests.modules.fakes import Bench

LISTENERS = (
    "app.modules.perception.loud_noise_detector:LoudNoiseDetector",
    "app.modules.perception.audio_stream:AudioStream",
)


def frame(number: int, stamp: float) -> Audio:
    return Audio(stamp, "base_link", np.zeros((512, 2), np.int16), 48_000, 512 * number, np.zeros((2, 3)))


@pytest.mark.parametrize("listener", LISTENERS)
def test_a_backlog_is_thrown_away_and_reported_once(listener: str, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level("INFO", "hbba")

    async def main() -> None:
        async with Bench(listener, inputs={"audio": Audio}) as b:
            inbox = b.slot.context.inputs["audio"].subscription
            for storm in range(3):
                for number in range(200):  # all at once: the listener has no turn in between
                    b.feed("audio", frame(1000 * storm + number, b.clock.now()))
                await b.settle()
                assert inbox.statistics().depth == 0
                # At most the frame that was being waited for is taken of a storm.
                assert inbox.statistics().taken <= storm + 1
            assert not b.problem
            for beat in range(8):
                await b.clock.sleep(1.0)
                b.feed("audio", frame(5000 + beat, b.clock.now()))
                await b.settle()

    run_virtual(main())
    said = [record.getMessage() for record in caplog.records if "sound" in record.getMessage()]
    assert len(said) == 2
    assert "listening begins afresh" in said[0]
    assert said[1] == "hears all sound again"
    assert QUIET_S < 8
