"""What must hold of the page in every state: each control can be pressed, and axe finds no violation."""

from __future__ import annotations

import pytest
from playwright.sync_api import Page, expect

from app.base.paths import checkout_dir

#: What each control's middle is covered by, if not by itself. Controls out of sight in a list are scrolled to first.
_COVERED = """
() => {
  const found = [];
  const controls = "button, a[href], input, select, textarea, [role=button], [role=tab], [role=separator]";
  for (const control of document.querySelectorAll(controls)) {
    const style = getComputedStyle(control);
    if (control.disabled || style.visibility === "hidden" || style.pointerEvents === "none") continue;
    if (control.closest(".skips, details:not([open]) > :not(summary)")) continue; // seen with the focus, or opened
    control.scrollIntoView({ block: "nearest", inline: "nearest" });
    const box = control.getBoundingClientRect();
    if (box.width < 2 || box.height < 2) continue;
    const [x, y] = [box.left + box.width / 2, box.top + box.height / 2];
    const name = control.dataset.testid || control.getAttribute("aria-label") || control.textContent.trim();
    const top = document.elementFromPoint(x, y);
    const own = top && (control.contains(top) || [...(control.labels ?? [])].some((label) => label.contains(top)));
    const over = top?.closest(".notice")?.textContent || top?.dataset.testid || top?.className || top?.tagName;
    if (!own) found.push(`${name}: ${over ?? "outside the window"}`);
  }
  if (document.documentElement.scrollWidth > innerWidth) found.push("the page is wider than the window");
  return found;
}
"""
_AXE = """
async () => (await axe.run({
  runOnly: ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"],
  rules: { region: { enabled: false } }, // separators lie between the page's landmarks
})).violations.map(({ id, nodes }) => `${id}: ${nodes.map((node) => node.target.join(" ")).join(", ")}`)
"""


def covered_controls(page: Page) -> list[str]:
    """The controls whose middle lies under something else, with what lies there.

    What a busy computer stops for a moment is said in the page's middle, over everything: that is waited for. So is the
    end of notices, which go by themselves.
    """
    while True:
        for passing in ("banner", "notice"):
            expect(page.get_by_test_id(passing)).to_have_count(0)
        found: list[str] = page.evaluate(_COVERED)
        if not found or page.get_by_test_id("banner").or_(page.get_by_test_id("notice")).count() == 0:
            return found


def axe_script() -> str:
    """The script of axe-core; skips the test where it is not installed."""
    root = checkout_dir()
    assert root is not None
    file = root / "web" / "node_modules" / "axe-core" / "axe.min.js"
    if not file.is_file():
        pytest.skip("axe-core is not installed: npm ci in web/")
    return file.read_text(encoding="utf-8")


def violations(page: Page, axe: str) -> list[str]:
    """What axe (``axe``: its script) finds wrong with the page as it is."""
    page.evaluate(axe)
    found: list[str] = page.evaluate(_AXE)
    return found
