"""The graph of modules: what is at work is a box in it, and a pressed box says what it takes in, and how often."""

from __future__ import annotations

import re

from playwright.sync_api import Page, expect


def test_a_pressed_box_shows_its_channels_and_rates(page: Page) -> None:
    page.set_viewport_size({"width": 1440, "height": 900})
    page.get_by_test_id("tab-graph").click()
    sensor, perception = page.get_by_test_id("graph-Kinect"), page.get_by_test_id("graph-QRCodeDetector")
    for box, column in ((sensor, "Sensors"), (perception, "Perception")):
        expect(box).to_be_visible()
        expect(page.locator(".graph-column", has_text=column)).to_be_visible()
    perception.click()
    explained = page.get_by_test_id("graph-explained")
    expect(explained).to_contain_text("QRCodeDetector: perception, running")
    expect(explained).to_contain_text(re.compile(r"% of a core.*At work for Find QR codes"))
    camera = explained.get_by_role("listitem").filter(has_text="from Kinect")
    expect(camera).to_have_text(re.compile(r"^from Kinect: camera: .+ \(\d+(\.\d+)? a second come\)$"))
    perception.press("Enter")
    expect(explained).to_have_count(0)
    sensor.press("Enter")
    expect(explained.locator("p").last).to_contain_text(re.compile("^to .*"))
