"""Exported video in a real browser: it plays, lasts as long as it took, and shows at each moment what was seen then."""

from __future__ import annotations

import base64
import importlib.util
from pathlib import Path

import pytest
from playwright.sync_api import Browser

from app.log_tools.export import mp4
from app.log_tools.export.exporter import Wish, export
from tests.log_tools.export.test_pictures import WRITERS, log_of

SHOW = """async ([data, moments]) => {
  const video = document.createElement('video');
  video.muted = true;
  await new Promise((done, failed) => {
    video.onloadeddata = done;
    video.onerror = () => failed(new Error(video.error.message));
    video.src = data;
  });
  const canvas = new OffscreenCanvas(video.videoWidth, video.videoHeight);
  const context = canvas.getContext('2d');
  const reds = [];
  for (const moment of moments) {
    // On a busy computer a seek ends before its picture is there to be drawn; one that stays may not be recognized.
    const shown = new Promise(done => video.requestVideoFrameCallback(done));
    await new Promise(done => { video.onseeked = done; video.currentTime = moment; });
    await Promise.race([shown, new Promise(done => setTimeout(done, 1000))]);
    context.drawImage(video, 0, 0);
    reds.push(context.getImageData(canvas.width / 2, canvas.height / 2, 1, 1).data[0]);
  }
  return [video.duration, video.videoWidth, video.videoHeight, reds];
}"""


@pytest.mark.parametrize("writer", list(WRITERS))
def test_a_browser_plays_it_at_its_true_time(
    writer: str, browser: Browser, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if writer == "exact" and importlib.util.find_spec("av") is None:
        pytest.skip("PyAV, the extra `video`, is not installed")
    monkeypatch.setattr(mp4, "open_video", lambda path, size, rate: WRITERS[writer](path, size, rate or 30.0))
    # After four images nothing for a second.
    export(log_of([0.0, 0.1, 0.2, 0.3, 1.3, 1.4, 1.5], size=(96, 128)), Wish("mp4", tmp_path))
    data = base64.b64encode((tmp_path / "camera.mp4").read_bytes()).decode("ascii")
    page = browser.new_page()
    try:
        duration, width, height, reds = page.evaluate(SHOW, [f"data:video/mp4;base64,{data}", [0.05, 0.35, 1.25, 1.45]])
    finally:
        page.close()
    assert (width, height) == (128, 96)
    assert duration == pytest.approx(1.6, abs=0.11)
    assert reds == pytest.approx([0, 30, 30, 50], abs=8)
