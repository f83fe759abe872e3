"""Recordings from the page: made, listed, downloaded, deleted; and replayed, with the page following."""

from __future__ import annotations

import io
import time
import urllib.request
from pathlib import Path

import pytest
from mcap.reader import make_reader
from playwright.sync_api import Locator, Page, TimeoutError, expect

from tests.browser.held_keys import press_until
from tests.browser.running import Robot

#: Whole seconds of the robot, which a busy computer takes longer for.
RECORD_S = 3
PICTURES = "/kinect/color/compressed"
#: Until so many pictures have been shown, of which a busy robot has few.
_PICTURES = """
(least) => new Promise((done) => {
  let [shown, count] = [undefined, 0];
  const look = () => {
    const { stamp } = document.querySelector("[data-testid=camera]").dataset;
    if (stamp !== shown) count += 1;
    shown = stamp;
    if (count > least) done();
    else requestAnimationFrame(look);
  };
  look();
})
"""
_LEAST_PICTURES = 6


def recorder(page: Page, state: str) -> Locator:
    """What the bar shows while the Recorder is in ``state``."""
    return page.locator(f"[data-testid=record][data-state={state}]")


def record(page: Page, name: str) -> None:
    """Record a few seconds and pictures under ``name``, and wait until it is listed as complete."""
    page.get_by_test_id("tab-recordings").click()

    def start() -> None:
        page.get_by_test_id("recording-name-field").fill(name)
        page.get_by_test_id("recording-start").click()

    press_until(start, recorder(page, "recording"))
    page.wait_for_function(
        """least => {
            const [minutes, seconds] = document.querySelector("[data-testid=record-time]").textContent.split(":");
            return 60 * minutes + +seconds >= least;
        }""",
        arg=RECORD_S,
    )
    page.evaluate(_PICTURES, _LEAST_PICTURES)
    page.get_by_test_id("record").click()
    recorder(page, "idle").wait_for()
    page.locator(f"[data-testid=recording][data-name={name}][data-state=complete]").wait_for()


def test_a_recording_is_made_listed_downloaded_and_deleted(robot: Robot, page: Page, tmp_path: Path) -> None:
    """What is downloaded is an MCAP file with the sensors' messages in it; deleted, it is gone from the robot."""
    began = time.monotonic()
    record(page, "kept")
    most_s = time.monotonic() - began
    row = page.locator("[data-testid=recording][data-name=kept]")
    assert RECORD_S - 0.5 < float(row.get_attribute("data-duration") or 0) < most_s
    size = int(row.get_attribute("data-bytes") or 0)
    with page.expect_download() as download:
        row.get_by_test_id("recording-download").click()
    assert download.value.suggested_filename == "kept.mcap"
    file = tmp_path / "kept.mcap"
    download.value.save_as(file)
    assert file.stat().st_size == size
    with file.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    assert summary.statistics is not None
    counts = {
        channel.topic: summary.statistics.channel_message_counts.get(number, 0)
        for number, channel in summary.channels.items()
    }
    assert max(counts.values()) > 10 * RECORD_S
    row.get_by_test_id("recording-delete").click()
    row.get_by_test_id("recording-delete-confirm").click()
    row.wait_for(state="detached")
    assert "kept" not in [each["name"] for each in robot.get("/recordings")["recordings"]]


def position(page: Page) -> float:
    """Seconds from the recording's beginning, as the transport has it."""
    transport = page.get_by_test_id("transport")
    return float(transport.get_attribute("data-position") or 0) - float(transport.get_attribute("data-begin") or 0)


def pictures(robot: Robot, name: str) -> list[float]:
    """When the camera's pictures of a recording came, in seconds from its beginning."""
    with urllib.request.urlopen(f"{robot.url}/api/v1/recordings/{name}") as answer:
        reader = make_reader(io.BytesIO(answer.read()))
    summary = reader.get_summary()
    assert summary is not None
    assert summary.statistics is not None
    begin = summary.statistics.message_start_time
    return [(message.log_time - begin) / 1e9 for _, _, message in reader.iter_messages(topics=[PICTURES])]


def wait_position(page: Page, least: float, most: float) -> None:
    """Until the recording is between ``least`` and ``most`` seconds from its beginning."""
    try:
        page.wait_for_function(
            """([least, most]) => {
                const { position, begin, phase } = document.querySelector("[data-testid=transport]").dataset;
                return phase !== "seeking" && position - begin >= least && position - begin <= most;
            }""",
            arg=[least, most],
        )
    except TimeoutError as error:
        is_at = page.get_by_test_id("transport").evaluate("element => ({ ...element.dataset })")
        raise AssertionError(f"not from {least} s to {most} s: {is_at}") from error


def pause(page: Page) -> None:
    """Pause the recording, unless it has come to its end by itself."""
    transport = page.get_by_test_id("transport")
    if transport.get_attribute("data-playing") == "true":
        page.keyboard.press("Space")
    expect(transport).to_have_attribute("data-playing", "false")


def test_a_recording_is_replayed_in_a_tab_of_its_own(robot: Robot, page: Page) -> None:
    """It plays, pauses, steps, jumps and runs faster; camera and lanes follow its time; nothing can be driven."""
    record(page, "before")
    came = pictures(robot, "before")
    row = page.locator("[data-testid=recording][data-name=before]")
    with page.context.expect_page() as opened:
        row.get_by_test_id("recording-replay").click()
    row.locator("[data-testid=replay-state][data-state=running]").wait_for()
    replay = opened.value
    transport = replay.get_by_test_id("transport")
    transport.wait_for()
    replay.locator("[data-testid=connection][data-phase=live]").wait_for()
    expect(replay.get_by_test_id("recording-marker")).to_contain_text("Recording of IRL-1/TR")
    assert replay.get_by_test_id("drive-pad").count() == replay.get_by_test_id("estop").count() == 0

    # From the end, or from wherever it is by now: to the beginning, paused.
    pause(replay)
    replay.keyboard.press("Home")
    wait_position(replay, 0, 0.2)
    expect(transport).to_have_attribute("data-phase", "paused")
    stood = position(replay)
    replay.keyboard.press("Period")
    # The next picture may have come right after where it paused.
    there = [at for at in came if at > stood][:2]
    wait_position(replay, stood + 1e-5, there[-1] + 1e-3)
    replay.keyboard.press("KeyW")
    replay.keyboard.press("Escape")
    # A paused recording says nothing new for longer than a robot may, and is not called stale.
    replay.wait_for_timeout(1_000)
    expect(replay.get_by_test_id("page")).to_have_attribute("data-phase", "live")
    assert position(replay) <= there[-1] + 1e-3

    # Half speed from the middle, where the timeline was clicked.
    replay.get_by_test_id("playback-speed").select_option("0.5")
    expect(transport).to_have_attribute("data-speed", "0.5")
    box = replay.get_by_test_id("timeline").bounding_box()
    assert box is not None
    replay.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    middle = float(replay.get_by_test_id("timeline").get_attribute("max") or 0) / 2
    wait_position(replay, middle - 0.3, middle + 0.3)
    camera = replay.get_by_test_id("camera")
    replay.wait_for_function(
        """() => {
            const { position, begin } = document.querySelector("[data-testid=transport]").dataset;
            const { stamp } = document.querySelector("[data-testid=camera]").dataset;
            return stamp && stamp - position < 0.05;
        }"""
    )
    shown = float(camera.get_attribute("data-stamp") or 0)
    replay.keyboard.press("Space")
    wait_position(replay, middle + 0.4, 2 * middle)
    pause(replay)
    # A busy computer may have recorded nothing for a while: camera and lanes follow with their next message.
    followed = """shown => {
        const { position } = document.querySelector("[data-testid=transport]").dataset;
        const { newest } = document.querySelector("[data-testid=lane-canvas]").dataset;
        const { stamp } = document.querySelector("[data-testid=camera]").dataset;
        return newest > shown && newest - position < 0.05 && stamp > shown && stamp - position < 0.05;
    }"""
    for _ in range(30):
        try:
            replay.wait_for_function(followed, arg=shown, timeout=10_000)
            break
        except TimeoutError:
            replay.keyboard.press("Period")
    else:
        pytest.fail("camera and lanes did not follow the recording's time")
    assert replay.get_by_test_id("lane-FindQRCodes").get_attribute("data-intensity")
    row.get_by_test_id("replay-end").click()
    row.get_by_test_id("replay-state").wait_for(state="detached")
